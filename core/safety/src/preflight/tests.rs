//! A vehicle and a swarm with which all is well, and one thing at a time that is not: the item, its value and its limit, and whether it
//! keeps from arming.

use super::*;
use skein_domain::preflight::{LONGEST_OVERRIDE_S, NEVER_OVERRIDDEN, PreflightSettings};
use skein_domain::telemetry::EstimatorHealth;
use skein_domain::{
    FlightMode, Geodetic, Gnss, GnssFix, LandedState, LinkHealth, LocalPositionNed, PositionNed, Telemetry, VehicleId,
    VelocityNed,
};

fn now() -> NodeTime {
    NodeTime::from_seconds(50.0)
}

fn good_vehicle() -> VehicleChecks {
    VehicleChecks {
        vehicle: VehicleId(3),
        connected: true,
        loss: Some(0.01),
        mode: FlightMode::Hold,
        ready_to_arm: Some(true),
        not_ready_because: None,
        position_age_s: Some(0.05),
        estimator_good: Some(true),
        gnss_fix: GnssFix::ThreeD,
        satellites: Some(12),
        disagreement_m: Some(0.6),
        battery: Some(0.97),
        flight_needs: Some(0.6),
        home_known: true,
        inside_fence: Some(true),
        has_fence: true,
        landed: LandedState::OnGround,
        airborne: false,
        speed_m_s: Some(0.03),
        clock_error_s: Some(0.004),
        model: Some(NamedRunning {
            name: "generic-uav".into(),
            running: true,
        }),
        payloads: vec![NamedRunning {
            name: "gimbal".into(),
            running: true,
        }],
        limits_known: Some(true),
        system_id: SystemIdUse::Alone,
        alarms: Some(Vec::new()),
    }
}

fn good_swarm() -> SwarmChecks {
    SwarmChecks {
        frame_known: true,
        on_ground: (0..5)
            .map(|i| (VehicleId(i), PositionNed::new(0.0, f64::from(i) * 3.0, 0.0)))
            .collect(),
        clock_offsets_s: vec![(VehicleId(1), 0.001), (VehicleId(2), -0.004)],
        coordinator_running: true,
        coordinator_capable: 2,
        fences: Some(1),
        homes_outside: Vec::new(),
        homes_unknown: Vec::new(),
    }
}

fn vehicle(change: impl FnOnce(&mut VehicleChecks)) -> PreflightReport {
    let mut checks = good_vehicle();
    change(&mut checks);
    vehicle_report(&checks, &PreflightSettings::default(), now())
}

fn swarm(change: impl FnOnce(&mut SwarmChecks)) -> PreflightReport {
    let mut checks = good_swarm();
    change(&mut checks);
    swarm_report(&checks, &PreflightSettings::default(), now())
}

/// Exactly this item is not green, and stands so.
fn assert_only(report: &PreflightReport, id: &str, status: ItemStatus) {
    let found: Vec<_> = report
        .items
        .iter()
        .filter(|i| i.status != ItemStatus::Green)
        .map(|i| (i.id.as_str(), i.status))
        .collect();
    assert_eq!(found, [(id, status)], "{report:#?}");
    let arms = may_arm(report, &[], now());
    match status {
        ItemStatus::Red => {
            let items = vec![id.to_owned()];
            assert_eq!(arms, Err(Refusal::Preflight { items }));
        }
        _ => assert_eq!(arms, Ok(())),
    }
}

#[test]
fn all_is_green_and_every_item_says_what_and_why() {
    for report in [vehicle(|_| ()), swarm(|_| ())] {
        assert_eq!(report.worst(), ItemStatus::Green, "{report:#?}");
        assert_eq!(may_arm(&report, &[], now()), Ok(()));
        let mut ids: Vec<_> = report.items.iter().map(|i| i.id.clone()).collect();
        ids.sort();
        ids.dedup();
        assert_eq!(ids.len(), report.items.len(), "ids are unique");
        for item in &report.items {
            assert!(
                !item.title.is_empty() && !item.value.is_empty() && !item.why.is_empty(),
                "{item:?}"
            );
            assert_eq!(item.number.is_some(), item.limit.is_some(), "{item:?}");
        }
    }
}

#[test]
fn each_thing_that_is_wrong_with_a_vehicle_is_its_own_item() {
    type Change = fn(&mut VehicleChecks);
    let wrong: &[(&str, ItemStatus, Change)] = &[
        ("link", ItemStatus::Red, |c| c.connected = false),
        ("link_loss", ItemStatus::Amber, |c| c.loss = Some(0.1)),
        ("link_loss", ItemStatus::Red, |c| c.loss = Some(0.31)),
        ("link_loss", ItemStatus::Red, |c| c.loss = Some(f64::NAN)),
        ("ready_to_arm", ItemStatus::Red, |c| c.ready_to_arm = Some(false)),
        ("ready_to_arm", ItemStatus::Red, |c| c.ready_to_arm = None),
        ("ready_to_arm", ItemStatus::Amber, |c| {
            (c.mode, c.ready_to_arm) = (FlightMode::Offboard, Some(false));
        }),
        ("ready_to_arm", ItemStatus::Red, |c| {
            (c.mode, c.ready_to_arm) = (FlightMode::Offboard, None);
        }),
        ("position", ItemStatus::Red, |c| c.position_age_s = None),
        ("position", ItemStatus::Red, |c| c.position_age_s = Some(1.01)),
        ("position", ItemStatus::Red, |c| c.estimator_good = Some(false)),
        ("gnss_fix", ItemStatus::Red, |c| c.gnss_fix = GnssFix::TwoD),
        ("gnss_satellites", ItemStatus::Red, |c| c.satellites = Some(5)),
        ("gnss_agreement", ItemStatus::Red, |c| c.disagreement_m = Some(3.1)),
        ("battery", ItemStatus::Red, |c| {
            (c.battery, c.flight_needs) = (None, None);
        }),
        ("battery", ItemStatus::Amber, |c| {
            (c.battery, c.flight_needs) = (Some(0.4), None);
        }),
        ("battery_for_flight", ItemStatus::Red, |c| c.flight_needs = Some(0.98)),
        ("home", ItemStatus::Red, |c| c.home_known = false),
        ("inside_fence", ItemStatus::Red, |c| c.inside_fence = Some(false)),
        ("inside_fence", ItemStatus::Red, |c| c.inside_fence = None),
        ("on_ground", ItemStatus::Red, |c| c.landed = LandedState::Unknown),
        ("not_moving", ItemStatus::Red, |c| c.speed_m_s = Some(0.6)),
        ("not_moving", ItemStatus::Red, |c| c.speed_m_s = None),
        ("clock", ItemStatus::Red, |c| c.clock_error_s = None),
        ("clock", ItemStatus::Red, |c| c.clock_error_s = Some(0.06)),
        ("model", ItemStatus::Red, |c| c.model = None),
        ("model", ItemStatus::Red, |c| {
            if let Some(model) = &mut c.model {
                model.running = false;
            }
        }),
        ("payloads", ItemStatus::Red, |c| c.payloads[0].running = false),
        ("limits", ItemStatus::Red, |c| c.limits_known = Some(false)),
        ("limits", ItemStatus::Amber, |c| c.limits_known = None),
        ("duplicate_system_id", ItemStatus::Red, |c| {
            c.system_id = SystemIdUse::Shared
        }),
        ("alarms", ItemStatus::Red, |c| c.alarms = None),
        ("alarms", ItemStatus::Red, |c| {
            c.alarms = Some(vec!["clocks jumped or drift".to_owned()]);
        }),
    ];
    for (id, status, change) in wrong {
        assert_only(&vehicle(change), id, *status);
    }
    let ids: Vec<_> = vehicle(|_| ()).items.iter().map(|i| i.id.clone()).collect();
    for id in ids {
        assert!(wrong.iter().any(|(wrong, ..)| *wrong == id), "{id} is not tested");
    }
}

#[test]
fn another_sender_of_its_system_id_elsewhere_is_told_and_grounds_nobody() {
    let report = vehicle(|c| c.system_id = SystemIdUse::Elsewhere);
    assert_only(&report, "duplicate_system_id", ItemStatus::Amber);
}

#[test]
fn nothing_is_asked_of_the_ground_in_flight() {
    let flying = vehicle(|c| {
        (c.airborne, c.landed, c.speed_m_s) = (true, LandedState::InAir, Some(7.0));
    });
    for id in ["on_ground", "not_moving"] {
        let item = flying.items.iter().find(|i| i.id == id).expect("is there");
        assert_eq!(
            (item.status, item.number),
            (ItemStatus::NotApplicable, None),
            "{item:?}"
        );
    }
    assert_eq!(may_arm(&flying, &[], now()), Ok(()));
    // Whoever is not known to fly is asked.
    let unknown = vehicle(|c| c.landed = LandedState::InAir);
    assert_eq!(
        unknown.blocking().map(|i| i.id.as_str()).collect::<Vec<_>>(),
        ["on_ground"]
    );
}

#[test]
fn each_thing_that_is_wrong_with_the_swarm_is_its_own_item() {
    type Change = fn(&mut SwarmChecks);
    let wrong: &[(&str, ItemStatus, Change)] = &[
        ("swarm_frame", ItemStatus::Red, |c| c.frame_known = false),
        ("ground_distance", ItemStatus::Red, |c| c.on_ground[2].1.east_m = 3.9),
        ("ground_distance", ItemStatus::Red, |c| {
            c.on_ground[2].1.east_m = f64::NAN
        }),
        ("clock_spread", ItemStatus::Red, |c| c.clock_offsets_s[0].1 = 0.2),
        ("clock_spread", ItemStatus::Red, |c| c.clock_offsets_s[0].1 = f64::NAN),
        ("clock_spread", ItemStatus::Amber, |c| c.clock_offsets_s.clear()),
        ("coordinator", ItemStatus::Red, |c| c.coordinator_running = false),
        ("fences", ItemStatus::Red, |c| c.fences = None),
        ("fences", ItemStatus::Amber, |c| c.fences = Some(0)),
        ("homes_inside", ItemStatus::Red, |c| c.homes_outside.push(VehicleId(4))),
        ("homes_inside", ItemStatus::Amber, |c| {
            c.homes_unknown.push(VehicleId(4))
        }),
    ];
    for (id, status, change) in wrong {
        assert_only(&swarm(change), id, *status);
    }
}

#[test]
fn what_is_asked_for_in_the_settings_is_red_when_it_is_missing() {
    let settings = PreflightSettings {
        require_fence: true,
        require_coordinator_vehicle: true,
        ..PreflightSettings::default()
    };
    let without = SwarmChecks {
        fences: Some(0),
        coordinator_capable: 0,
        ..good_swarm()
    };
    let report = swarm_report(&without, &settings, now());
    let red: Vec<_> = report.blocking().map(|i| i.id.as_str()).collect();
    assert_eq!(red, ["coordinator_vehicle", "fences"]);
    assert_eq!(swarm(|c| c.coordinator_capable = 0).worst(), ItemStatus::Green);

    let indoors = PreflightSettings {
        require_gnss: false,
        ..PreflightSettings::default()
    };
    let checks = VehicleChecks {
        gnss_fix: GnssFix::Unknown,
        satellites: None,
        ..good_vehicle()
    };
    assert_eq!(vehicle_report(&checks, &indoors, now()).worst(), ItemStatus::Amber);
    assert_eq!(
        vehicle_report(&checks, &PreflightSettings::default(), now()).worst(),
        ItemStatus::Red
    );
}

#[test]
fn values_are_shown_with_unit_and_held_against_their_limit() {
    let report = vehicle(|c| c.disagreement_m = Some(4.26));
    let item = report.blocking().next().expect("red");
    assert_eq!(
        (item.value.as_str(), item.number, item.unit.as_str()),
        ("4.3 m", Some(4.26), "m")
    );
    assert_eq!(item.limit, Some(3.0));
    let report = swarm(|c| c.on_ground[2].1.east_m = 3.5);
    let item = report.blocking().next().expect("red");
    assert_eq!(item.value, "0.5 m between 1 and 2");
    let report = vehicle(|c| c.ready_to_arm = Some(false));
    assert_eq!(report.blocking().next().expect("red").value, "not ready");
}

fn override_of(item: &str) -> PreflightOverride {
    PreflightOverride {
        operator: "ada".into(),
        reason: "compared with a map".into(),
        items: vec![item.into()],
        vehicle: Some(VehicleId(3)),
        given_at: now().plus_seconds(-10.0),
        valid_s: 60.0,
    }
}

#[test]
fn an_override_covers_its_items_of_its_vehicle_for_its_time() {
    let report = vehicle(|c| {
        c.disagreement_m = Some(9.0);
        c.satellites = Some(5);
    });
    let one = [override_of("gnss_agreement")];
    let left = vec!["gnss_satellites".to_owned()];
    assert_eq!(may_arm(&report, &one, now()), Err(Refusal::Preflight { items: left }));
    let both = [
        override_of("gnss_agreement"),
        override_of("gnss_satellites"),
        override_of("home"),
    ];
    assert_eq!(may_arm(&report, &both, now()), Ok(()));
    let used: Vec<_> = used_overrides(&report, &both, now())
        .iter()
        .map(|o| o.items[0].clone())
        .collect();
    assert_eq!(
        used,
        ["gnss_agreement", "gnss_satellites"],
        "what is made use of is recorded"
    );

    let report = vehicle(|c| c.disagreement_m = Some(9.0));
    let good = override_of("gnss_agreement");
    assert_eq!(may_arm(&report, std::slice::from_ref(&good), now()), Ok(()));
    type Change = fn(&mut PreflightOverride);
    let useless: [Change; 8] = [
        |o| o.vehicle = Some(VehicleId(4)),
        |o| o.vehicle = None,
        |o| o.valid_s = 5.0,
        |o| o.valid_s = f64::INFINITY,
        |o| o.given_at = now().plus_seconds(1.0),
        |o| o.reason = "  ".into(),
        |o| o.operator.clear(),
        |o| o.items = vec!["gnss".into()],
    ];
    for change in useless {
        let mut o = good.clone();
        change(&mut o);
        assert!(may_arm(&report, std::slice::from_ref(&o), now()).is_err(), "{o:?}");
    }
}

#[test]
fn some_items_are_never_overridden() {
    let report = vehicle(|c| {
        c.position_age_s = None;
        c.system_id = SystemIdUse::Shared;
        c.model = None;
    });
    let all: Vec<_> = report.blocking().map(|i| override_of(&i.id)).collect();
    assert_eq!(all.len(), NEVER_OVERRIDDEN.len());
    for o in &all {
        assert!(matches!(o.check(), Err(Refusal::NotPermitted { .. })), "{o:?}");
    }
    let items = report.blocking().map(|i| i.id.clone()).collect();
    assert_eq!(may_arm(&report, &all, now()), Err(Refusal::Preflight { items }));
}

#[test]
fn an_override_without_name_reason_items_or_end_is_refused() {
    assert_eq!(override_of("battery").check(), Ok(()));
    type Change = fn(&mut PreflightOverride);
    let wrong: [Change; 6] = [
        |o| o.operator = " ".into(),
        |o| o.reason.clear(),
        |o| o.items.clear(),
        |o| o.valid_s = 0.0,
        |o| o.valid_s = f64::NAN,
        |o| o.valid_s = LONGEST_OVERRIDE_S + 1.0,
    ];
    for change in wrong {
        let mut o = override_of("battery");
        change(&mut o);
        assert!(matches!(o.check(), Err(Refusal::InvalidValue { .. })), "{o:?}");
    }
}

#[test]
fn an_old_or_an_empty_report_arms_nobody() {
    let report = vehicle(|_| ());
    let nobody = Err(Refusal::Preflight {
        items: vec!["report".into()],
    });
    assert_eq!(may_arm(&report, &[], now().plus_seconds(REPORT_VALID_S + 0.1)), nobody);
    assert_eq!(may_arm(&report, &[], now().plus_seconds(-1.0)), nobody);
    let empty = PreflightReport {
        items: Vec::new(),
        ..report
    };
    assert_eq!(may_arm(&empty, &[], now()), nobody);
    assert_eq!(empty.worst(), ItemStatus::Red);
}

#[test]
fn items_of_plugins_count_like_all_others() {
    let mut report = vehicle(|_| ());
    report.items.push(PreflightItem {
        id: "camera/storage".into(),
        status: ItemStatus::Red,
        ..PreflightItem::default()
    });
    assert!(may_arm(&report, &[], now()).is_err());
    assert_eq!(may_arm(&report, &[override_of("camera/storage")], now()), Ok(()));
}

#[test]
fn nothing_known_is_nothing_good() {
    let checks = VehicleChecks::observed(VehicleId(1), &Telemetry::default(), &LinkHealth::default(), now());
    let report = vehicle_report(&checks, &PreflightSettings::default(), now());
    let red: Vec<_> = report.blocking().map(|i| i.id.as_str()).collect();
    for id in [
        "link",
        "position",
        "gnss_fix",
        "battery",
        "home",
        "on_ground",
        "not_moving",
        "clock",
        "model",
    ] {
        assert!(red.contains(&id), "{id} is not red: {red:?}");
    }
    assert!(swarm_report(&SwarmChecks::default(), &PreflightSettings::default(), now()).worst() == ItemStatus::Red);
}

/// What a vehicle that is ready to fly tells of itself, and its link.
fn telemetry_of_one_that_is_ready() -> (Telemetry, LinkHealth) {
    let place = Geodetic {
        latitude_deg: 47.4,
        longitude_deg: 8.5,
        altitude_amsl_m: 480.0,
    };
    let mut telemetry = Telemetry {
        landed: LandedState::OnGround,
        ready_to_arm: Some(true),
        global: Some(place),
        local: Some(LocalPositionNed::default()),
        position_time: now().plus_seconds(-0.02),
        velocity: Some(VelocityNed::default()),
        home: Some(place),
        gnss: Gnss {
            fix: GnssFix::ThreeD,
            satellites: 14,
            horizontal_accuracy_m: None,
        },
        ..Telemetry::default()
    };
    telemetry.battery.remaining = Some(0.95);
    let link = LinkHealth {
        connected: true,
        round_trip_s: Some(0.02),
        clock_offset_s: Some(-40.0),
        ..LinkHealth::default()
    };
    (telemetry, link)
}

/// The checks of such a one.
fn checks_of(telemetry: &Telemetry, link: &LinkHealth) -> VehicleChecks {
    VehicleChecks {
        model: good_vehicle().model,
        limits_known: Some(true),
        alarms: Some(Vec::new()),
        ..VehicleChecks::observed(VehicleId(1), telemetry, link, now())
    }
}

#[test]
fn telemetry_of_a_vehicle_that_is_ready_is_green() {
    let (telemetry, link) = telemetry_of_one_that_is_ready();
    let checks = checks_of(&telemetry, &link);
    assert!((checks.clock_error_s.expect("known") - 0.01).abs() < 1e-6);
    let report = vehicle_report(&checks, &PreflightSettings::default(), now());
    assert_eq!(report.worst(), ItemStatus::Green, "{report:#?}");
}

/// What PX4 says of itself at rest, with and without satellites; in the air the first of them is a vehicle that has lost its way.
#[test]
fn a_position_is_judged_by_the_flags_that_matter_on_the_ground_and_in_the_air() {
    let (mut telemetry, link) = telemetry_of_one_that_is_ready();
    let at_rest = 1023;
    let without = at_rest & !(EstimatorHealth::POSITION_ABSOLUTE | EstimatorHealth::POSITION_ABSOLUTE_PREDICTED);
    let mut blocking = |flags: u16, in_air: bool| {
        telemetry.estimator = Some(EstimatorHealth {
            flags,
            ..EstimatorHealth::default()
        });
        telemetry.armed = in_air;
        telemetry.landed = if in_air {
            LandedState::InAir
        } else {
            LandedState::OnGround
        };
        let report = vehicle_report(&checks_of(&telemetry, &link), &PreflightSettings::default(), now());
        report.blocking().any(|i| i.id == "position")
    };
    assert!(
        !blocking(at_rest, false),
        "a vehicle that stands still says that it does not move"
    );
    assert!(blocking(without, false), "no position on Earth");
    assert!(blocking(EstimatorHealth::CONSTANT_POSITION, false));
    assert!(blocking(at_rest, true), "in the air it moves");
    assert!(!blocking(at_rest & !EstimatorHealth::CONSTANT_POSITION, true));
    assert!(blocking(at_rest | EstimatorHealth::ACCELEROMETER_ERROR, false));
}
