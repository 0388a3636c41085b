//! Properties of the rules, for drawn histories of a node: starts, crashes, power cuts, packages exchanged.

use super::*;
use proptest::prelude::*;

fn slot(number: u8) -> Version {
    Version::Slot {
        version: format!("0.{number}.0"),
        digest: format!("{number:064x}"),
    }
}

fn package(number: u8) -> Package {
    Package {
        version: format!("0.0.{number}"),
        bytes: 1,
        changed_ns: i128::from(number),
    }
}

#[derive(Debug, Clone)]
enum Happening {
    /// An operator wants this version.
    Try(u8),
    /// The service manager starts the program.
    Start,
    /// What runs confirms itself, if it is on trial.
    Confirm,
    /// What runs gives itself up, if it is on trial.
    GiveUp,
    /// Another package is installed.
    Install(u8),
}

fn happening() -> impl Strategy<Value = Happening> {
    prop_oneof![
        (0..4_u8).prop_map(Happening::Try),
        Just(Happening::Start),
        Just(Happening::Start),
        Just(Happening::Confirm),
        Just(Happening::GiveUp),
        (0..3_u8).prop_map(Happening::Install),
    ]
}

proptest! {
    #[test]
    fn only_what_has_confirmed_itself_is_started_twice(history in prop::collection::vec(happening(), 0..60)) {
        let mut versions = Versions::default();
        let mut installed = 0;
        let mut runs = Start { version: Version::Package, on_trial: false };
        let mut confirmed = vec![Version::Package];
        // Starts on trial of each version since an operator last asked for it.
        let mut tried: Vec<(Version, u32)> = Vec::new();
        for happens in history {
            match happens {
                Happening::Try(number) => {
                    let wanted = slot(number);
                    // As the upgrader does: only while nothing is on trial.
                    if versions.trial.is_none() && versions.try_next(wanted.clone(), Expectations::default()) {
                        tried.retain(|(version, _)| *version != wanted);
                        tried.push((wanted, 0));
                    }
                }
                Happening::Start => {
                    let exchanged = versions.package.as_ref().is_some_and(|known| *known != package(installed));
                    runs = versions.start(package(installed));
                    if exchanged {
                        prop_assert_eq!(&runs, &Start { version: Version::Package, on_trial: false });
                    }
                    if runs.on_trial {
                        let count = tried.iter_mut().find(|(version, _)| *version == runs.version).expect("asked for");
                        count.1 += 1;
                        prop_assert_eq!(count.1, 1, "{:?} is tried again", runs.version);
                    } else {
                        prop_assert!(confirmed.contains(&runs.version), "{:?} has never confirmed itself", runs.version);
                    }
                }
                Happening::Confirm if runs.on_trial && versions.trial.as_ref().is_some_and(|t| t.begun) => {
                    versions.confirm();
                    prop_assert_eq!(&versions.confirmed, &runs.version);
                    confirmed.push(runs.version.clone());
                    runs.on_trial = false;
                }
                Happening::GiveUp if runs.on_trial && versions.trial.as_ref().is_some_and(|t| t.begun) => {
                    let before = versions.confirmed.clone();
                    versions.give_up("tried in vain");
                    prop_assert_eq!(&versions.confirmed, &before);
                    prop_assert_eq!(versions.start(package(installed)).on_trial, false);
                    runs = versions.start(package(installed));
                }
                Happening::Install(number) => installed = number,
                Happening::Confirm | Happening::GiveUp => {}
            }
            // What is started next without a word of anybody is there on the disk.
            let mut ahead = versions.clone();
            let next = ahead.start(package(installed));
            prop_assert!(next.version == Version::Package || versions.kept().any(|kept| *kept == next.version));
            // Over the disk and back it is the same.
            let stored = serde_json::to_vec(&versions).expect("can be written");
            prop_assert_eq!(serde_json::from_slice::<Versions>(&stored).expect("can be read"), versions.clone());
        }
    }

    #[test]
    fn a_version_on_trial_never_goes_back_while_a_vehicle_is_armed(
        since_start_s in 0.0..1e4_f64, limit_s in 1.0..600.0_f64, well_for_s in prop::option::of(0.0..1e4_f64),
    ) {
        let well = well_for_s.ok_or("something is missing");
        let verdict = judge(since_start_s, limit_s, well, true);
        prop_assert!(!matches!(verdict, Verdict::GoBack(_)));
        // On the ground the only way not to know is to wait no longer than the limit.
        let verdict = judge(since_start_s, limit_s, well, false);
        prop_assert!(verdict != Verdict::Wait || since_start_s < limit_s || well_for_s.is_some_and(|s| s < WELL_FOR_S));
    }

    #[test]
    fn each_node_has_one_turn_the_coordinator_and_this_one_at_the_end(
        nodes in prop::collection::btree_set(1..40_u64, 1..12), coordinator in 0..40_u64, me in 0..40_u64,
    ) {
        let mut waiting: Vec<NodeId> = nodes.iter().copied().map(NodeId).collect();
        let mut turns = Vec::new();
        while let Some(next) = next_node(&waiting, Some(NodeId(coordinator)), NodeId(me)) {
            waiting.retain(|node| *node != next);
            turns.push(next.0);
        }
        let place = |node: u64| turns.iter().position(|turn| *turn == node);
        prop_assert_eq!(turns.len(), nodes.len());
        if let Some(mine) = place(me) {
            prop_assert_eq!(mine, turns.len() - 1);
        }
        if let Some(last) = place(coordinator).filter(|_| coordinator != me) {
            let others_after = turns.iter().skip(last + 1).any(|node| *node != me);
            prop_assert!(!others_after);
        }
    }
}

#[test]
fn a_version_that_ended_on_trial_is_told_of() {
    let mut versions = Versions::default();
    let _ = versions.start(package(0));
    assert!(versions.try_next(slot(1), Expectations::default()));
    assert!(versions.start(package(0)).on_trial);
    let start = versions.start(package(0));
    assert_eq!(
        start,
        Start {
            version: Version::Package,
            on_trial: false
        }
    );
    let back = versions.gone_back.expect("it is told of");
    assert_eq!(back.from.digest, Some(format!("{:064x}", 1)));
}

#[test]
fn after_a_confirmation_the_way_back_is_the_version_before() {
    let mut versions = Versions::default();
    let _ = versions.start(package(0));
    assert!(versions.try_next(slot(1), Expectations::default()));
    let _ = versions.start(package(0));
    versions.confirm();
    assert_eq!(
        (versions.confirmed.clone(), versions.before.clone()),
        (slot(1), Some(Version::Package))
    );
    assert!(!versions.try_next(slot(1), Expectations::default()), "it runs already");
    assert!(versions.try_next(Version::Package, Expectations::default()));
    assert!(versions.start(package(0)).on_trial);
    versions.confirm();
    assert_eq!(
        (versions.confirmed.clone(), versions.before),
        (Version::Package, Some(slot(1)))
    );
}

#[test]
fn a_file_of_a_later_version_is_read_as_far_as_it_is_known() {
    let text = r#"{"confirmed": {"slot": {"version": "9.0.0", "digest": "ab"}}, "invented_later": 7}"#;
    let versions: Versions = serde_json::from_str(text).expect("is read");
    assert!(matches!(versions.confirmed, Version::Slot { .. }));
}

#[test]
fn what_is_missing_is_named() {
    let expects = Expectations {
        vehicles: vec![VehicleId(3)],
        others: true,
        led: true,
    };
    let mut seen = Seen::default();
    assert!(
        expects
            .missing(&seen)
            .is_some_and(|missing| missing.contains("vehicle 3"))
    );
    seen.vehicles = vec![VehicleId(3), VehicleId(4)];
    assert!(expects.missing(&seen).is_some_and(|missing| missing.contains("node")));
    (seen.others, seen.led) = (true, true);
    assert_eq!(expects.missing(&seen), None);
    assert_eq!(Expectations::default().missing(&Seen::default()), None);
}

#[test]
fn a_roll_out_stops_where_a_version_did_not_stay() {
    let label = |digest: Option<&str>| VersionLabel {
        version: "1".into(),
        digest: digest.map(str::to_owned),
    };
    let mut told = NodeVersions {
        architecture: "x86_64".into(),
        runs: label(None),
        on_trial: false,
        pending: Some(label(Some("new"))),
        before: None,
        gone_back: None,
        broken_off: None,
        confirm_within_s: 60.0,
    };
    let wanted = label(Some("new"));
    assert_eq!(progress(&wanted, &told), NodeUpgradeState::Starting);
    assert!(!knows_nothing_of(&wanted, &told));
    told.pending = None;
    assert!(knows_nothing_of(&wanted, &told));
    assert!(
        !goes_on(&progress(&wanted, &told)),
        "a trial that nobody knows of any more is none that went well"
    );
    told.broken_off = Some(skein_view::UpgradeRefusal::NothingBefore);
    assert!(goes_on(&progress(&wanted, &told)));
    told.gone_back = Some(GoneBack {
        from: wanted.clone(),
        why: "it ended".into(),
    });
    assert!(!goes_on(&progress(&wanted, &told)));
    (told.runs, told.on_trial) = (wanted.clone(), true);
    assert_eq!(progress(&wanted, &told), NodeUpgradeState::OnTrial);
    told.on_trial = false;
    assert_eq!(progress(&wanted, &told), NodeUpgradeState::Confirmed);
}
