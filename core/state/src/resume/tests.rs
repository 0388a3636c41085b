//! Which file is gone on with, and with whom of what it says.

use super::*;
use skein_domain::control::Console;
use skein_domain::{FlightMode, NodeId};
use skein_safety::control::ControlTable;

fn config() -> NodeConfig {
    let mut config = NodeConfig::default();
    config.node.name = "ground".into();
    config
}

const WRITTEN_US: u64 = 1_800_000_000_000_000;

fn after_s(seconds: f64) -> u64 {
    WRITTEN_US.saturating_add_signed((seconds * 1e6) as i64)
}

fn kept(control: &ControlTable) -> Kept {
    Kept {
        node: "ground".into(),
        written_us: WRITTEN_US,
        time: NodeTime::from_seconds(100.0),
        flown: Flown {
            control: control.entries().clone(),
            vehicles: [(VehicleId(1), None), (VehicleId(2), None)].into(),
            ..Flown::default()
        },
    }
}

#[test]
fn a_file_that_is_too_old_of_the_future_or_of_another_node_is_not_gone_on_with() {
    let (config, control) = (config(), ControlTable::new(NodeId(0)));
    let usable = |kept: Kept, seconds| kept.usable(&config, after_s(seconds));
    assert!(usable(kept(&control), 29.9).expect("is young enough").is_some());
    assert!(
        usable(kept(&control), 30.1)
            .expect_err("is too old")
            .contains("30 s are permitted")
    );
    assert!(
        usable(kept(&control), -0.5)
            .expect("clocks are not that exact")
            .is_some()
    );
    assert!(
        usable(kept(&control), -2.0)
            .expect_err("is of the future")
            .contains("future")
    );
    let mut others = kept(&control);
    others.node = "air".into();
    assert!(usable(others, 1.0).expect_err("is of another node").contains("air"));
    let mut nobody = kept(&control);
    nobody.flown.vehicles.clear();
    assert_eq!(usable(nobody, 1e6).expect("nobody was flown"), None);
}

#[test]
fn who_had_control_authority_has_it_again_and_is_present() {
    let mut table = ControlTable::new(NodeId(0));
    let console = Console {
        id: "c1".into(),
        name: "Ada".into(),
    };
    table
        .take(VehicleId(2), &console, NodeTime::from_seconds(90.0))
        .expect("is free");
    let flown = kept(&table)
        .usable(&config(), after_s(3.0))
        .expect("is young")
        .expect("is flown");
    let folder = tempfile::tempdir().expect("a folder");
    let mut config = config();
    config.resume.file = Some(folder.path().join("x"));
    let resume = Resume::open(&config, &EventLog::default(), NodeTime::default());
    resume.state.lock().before = Some(flown);
    let mut after = ControlTable::new(NodeId(0));
    resume.hand_back(&mut after, NodeTime::default());
    let picture = after.picture(NodeTime::from_seconds(1.0));
    assert_eq!((picture[0].vehicle, &picture[0].console), (VehicleId(2), &console));
    assert!(picture[0].is_heard, "nobody may relieve it at once");
    assert_eq!(picture[0].since, NodeTime(0), "before this node's clock began");
}

/// A node that flew 1 and 2 until it ended.
fn restarted(folder: &tempfile::TempDir) -> Resume {
    let mut config = config();
    config.resume.file = Some(folder.path().join("node.resume"));
    let path = config.resume.file.clone().expect("was set");
    let kept = Kept {
        written_us: unix_us(),
        ..kept(&ControlTable::new(NodeId(0)))
    };
    std::fs::write(path, file::encode(&kept).expect("is small")).expect("is written");
    Resume::open(&config, &EventLog::default(), NodeTime::default())
}

#[test]
fn who_is_not_heard_in_time_and_whom_an_operator_commands_is_not_taken_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let resume = restarted(&folder);
    let offboard = SeenVehicle {
        is_heard: true,
        is_placed: true,
        airborne: true,
        mode: FlightMode::Offboard,
        failsafe: false,
    };
    let at = NodeTime::from_seconds;
    assert_eq!(
        resume.look(VehicleId(3), &offboard, at(0.1)),
        None,
        "it was not flown from here"
    );
    assert!(matches!(
        resume.look(VehicleId(1), &offboard, at(0.1)),
        Some(Taking::Holding { .. })
    ));
    assert!(!resume.is_decided(at(1.0)));
    assert!(resume.commanded(VehicleId(1)), "it was held until now");
    assert_eq!(resume.look(VehicleId(1), &offboard, at(1.1)), None);
    assert!(!resume.is_decided(at(HEARD_WITHIN_S - 0.1)));
    assert!(resume.is_decided(at(HEARD_WITHIN_S + 0.1)));
    assert_eq!(resume.taken(), BTreeSet::new());
    assert_eq!(resume.left().len(), 2);
}

#[test]
fn a_damaged_file_is_told_and_a_node_that_was_stopped_leaves_none() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("node.resume");
    restarted(&folder).forget();
    assert!(!path.exists());
    std::fs::write(&path, "skein-resume 1 00000000\n{}").expect("is written");
    let mut config = config();
    config.resume.file = Some(path);
    let events = EventLog::default();
    let resume = Resume::open(&config, &events, NodeTime::default());
    assert_eq!(resume.before(), None);
    assert!(events.after(0)[0].text.contains("damaged"));
}
