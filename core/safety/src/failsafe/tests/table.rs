//! Every row of the written table: the fault is injected, and its reactions come at their times and no other ones do.

use super::*;
use skein_domain::{EnergyLevel, EnergyState};

type Fault = Box<dyn FnMut(&mut Health, f64)>;

struct Row {
    trigger: Trigger,
    fault: Fault,
    /// How long the fault lasts before the trigger's condition is met.
    lead_s: f64,
    /// Reactions and their times from then on, by the default settings.
    steps: &'static [(Reaction, f64)],
    /// The orders that follow, where they are not the steps above a warning.
    orders: Option<&'static [(Reaction, f64)]>,
}

fn row(trigger: Trigger, steps: &'static [(Reaction, f64)], fault: impl FnMut(&mut Health, f64) + 'static) -> Row {
    Row {
        trigger,
        fault: Box::new(fault),
        lead_s: 0.0,
        steps,
        orders: None,
    }
}

fn charge(level: EnergyLevel) -> EnergyState {
    EnergyState {
        remaining: 0.4,
        needed_home: Some(0.2),
        reserve: 0.15,
        margin: 0.05,
        level,
        ..EnergyState::default()
    }
}

fn breach(reaction: Reaction, outside_m: f64) -> Option<FenceBreach> {
    Some(FenceBreach {
        reaction,
        outside_m,
        zone: "field".to_owned(),
    })
}

const WARN: Reaction = Reaction::Warn;
const HOLD: Reaction = Reaction::Hold;
const RETURN: Reaction = Reaction::Return;
const LAND: Reaction = Reaction::Land;
const RELEASE: Reaction = Reaction::Release;

fn receiver_rows() -> Vec<Row> {
    vec![
        row(Trigger::GnssLoss, &[(WARN, 1.0), (HOLD, 3.0), (LAND, 20.0)], no_fix),
        row(Trigger::GnssLoss, &[(WARN, 1.0), (HOLD, 3.0), (LAND, 20.0)], |h, _| {
            if let Some(gnss) = &mut h.gnss {
                gnss.satellites = 3;
            }
        }),
        // A receiver that says nothing any more, its last word being a good one.
        row(Trigger::GnssLoss, &[(WARN, 1.0), (HOLD, 3.0), (LAND, 20.0)], |h, t| {
            if let Some(gnss) = &mut h.gnss {
                gnss.heard = old(gnss.heard, t);
            }
        }),
        row(
            Trigger::GnssDisagreement,
            &[(WARN, 0.5), (HOLD, 2.0), (LAND, 20.0)],
            |h, _| h.disagreement_m = Some(5.1),
        ),
        row(
            Trigger::GnssDisagreement,
            &[(WARN, 0.5), (HOLD, 2.0), (LAND, 20.0)],
            |h, _| h.disagreement_m = Some(f64::NAN),
        ),
    ]
}

fn clock_rows() -> Vec<Row> {
    let steps: &[(Reaction, f64)] = &[(WARN, 0.0), (HOLD, 0.5), (RETURN, 60.0)];
    let over_s = 0.1 / (0.01 - 0.0005);
    vec![
        // A clock that runs one percent too fast is beyond 0.1 s after ten seconds and a half.
        Row {
            lead_s: over_s,
            ..row(Trigger::ClockFault, steps, |h, t| {
                h.clock_offset_s = h.clock_offset_s.map(|o| o + 0.01 * t);
            })
        },
        // One that jumps to and fro never settles.
        row(Trigger::ClockFault, steps, |h, t| {
            let to = if (t / 2.0) as i64 % 2 == 0 { 0.5 } else { 0.9 };
            h.clock_offset_s = h.clock_offset_s.map(|o| o + to);
        }),
        row(Trigger::ClockFault, steps, |h, _| h.clock_offset_s = Some(f64::NAN)),
        // Positions from the future.
        row(Trigger::ClockFault, steps, |h, _| {
            h.position_time = h.position_time.map(|at| at.plus_seconds(3.0));
        }),
    ]
}

fn link_rows() -> Vec<Row> {
    vec![
        row(
            Trigger::StaleEstimate,
            &[(WARN, 0.3), (HOLD, 0.5), (RELEASE, 2.0)],
            stale,
        ),
        row(Trigger::LinkLoss, &[(WARN, 1.5), (RELEASE, 5.0)], silent),
        row(
            Trigger::CoordinatorLoss,
            &[(WARN, 2.0), (HOLD, 20.0), (RETURN, 120.0)],
            |h, t| h.coordinator_heard = h.coordinator_heard.map(|now| old(now, t)),
        ),
        row(
            Trigger::OperatorDeadMan,
            &[(WARN, 20.0), (HOLD, 30.0), (RETURN, 90.0)],
            |h, t| h.operator_heard = h.operator_heard.map(|now| old(now, t)),
        ),
    ]
}

fn flight_rows() -> Vec<Row> {
    vec![
        row(
            Trigger::TrackingError,
            &[(WARN, 1.0), (HOLD, 3.0), (RETURN, 10.0), (LAND, 30.0)],
            |h, _| h.tracking_error_m = Some(5.2),
        ),
        row(Trigger::FenceBreach, &[(WARN, 0.2)], |h, _| {
            h.breach = breach(WARN, 400.0)
        }),
        row(Trigger::FenceBreach, &[(HOLD, 0.2), (RETURN, 30.4)], |h, _| {
            h.breach = breach(HOLD, 3.0);
        }),
        row(Trigger::FenceBreach, &[(RETURN, 0.2)], |h, _| {
            h.breach = breach(RETURN, 3.0)
        }),
        row(Trigger::FenceBreach, &[(LAND, 0.2)], |h, _| {
            h.breach = breach(LAND, 3.0)
        }),
        // Further and further out, at 10 m/s: 30 m after the hold began it returns, 30 m after that it lands.
        row(
            Trigger::FenceBreach,
            &[(HOLD, 0.2), (RETURN, 3.4), (LAND, 6.6)],
            |h, t| h.breach = breach(HOLD, 10.0 * t),
        ),
        row(Trigger::Energy, &[(WARN, 1.0)], |h, _| {
            h.energy = Some(charge(EnergyLevel::ReplanSoon));
        }),
        row(Trigger::Energy, &[(RETURN, 1.0)], |h, _| {
            h.energy = Some(charge(EnergyLevel::ReturnNow));
        }),
        row(Trigger::Energy, &[(LAND, 1.0)], |h, _| {
            h.energy = Some(charge(EnergyLevel::LandNow));
        }),
        // Through all levels: each counts from when it came.
        row(Trigger::Energy, &[(WARN, 1.0), (RETURN, 11.0), (LAND, 21.0)], |h, t| {
            h.energy = Some(charge(match t {
                t if t < 10.0 => EnergyLevel::ReplanSoon,
                t if t < 20.0 => EnergyLevel::ReturnNow,
                _ => EnergyLevel::LandNow,
            }));
        }),
    ]
}

fn rows() -> Vec<Row> {
    let mut all = link_rows();
    all.extend(receiver_rows());
    all.extend(clock_rows());
    all.extend(flight_rows());
    all
}

/// Times are met within a few of the periods in which things are looked at.
fn assert_times(what: &str, found: &[(Reaction, f64)], expected: &[(Reaction, f64)], from_s: f64) {
    let reactions = |list: &[(Reaction, f64)]| list.iter().map(|(r, _)| *r).collect::<Vec<_>>();
    assert_eq!(reactions(found), reactions(expected), "{what}: {found:?}");
    for (i, ((reaction, at_s), (_, after_s))) in found.iter().zip(expected).enumerate() {
        let late_s = at_s - from_s - after_s;
        // Steps that count from the one before are late with it.
        let allowed_s = (3.0 + i as f64) * PERIOD_S;
        assert!(
            (-1e-6..=allowed_s).contains(&late_s),
            "{what}: {reaction} at {at_s:.3} s, expected {after_s:.3} s after {from_s:.3} s"
        );
    }
}

#[test]
fn every_row_reacts_at_its_time() {
    for row in rows() {
        let mut rig = Rig::new();
        rig.run(5.0, |_, _| ());
        assert!(rig.events.is_empty(), "{:?}", rig.events);
        let mut fault = row.fault;
        let lasts_s = row.steps.last().map_or(0.0, |(_, after_s)| after_s + row.lead_s + 8.0);
        rig.run(lasts_s, &mut fault);

        let start = NodeTime::from_seconds(START_S);
        let steps: Vec<_> = rig
            .events
            .iter()
            .filter(|e| matches!(e.kind, FailsafeEventKind::Raised | FailsafeEventKind::Escalated))
            .filter(|e| e.trigger == row.trigger)
            .map(|e| (e.reaction, e.at.seconds_since(start)))
            .collect();
        let what = format!("{} {:?}", row.trigger, row.steps);
        let from_s = 5.0 + row.lead_s;
        assert_times(&what, &steps, row.steps, from_s);
        let above: Vec<_> = row.steps.iter().filter(|(r, _)| *r > WARN).copied().collect();
        assert_times(&what, &rig.orders(), row.orders.unwrap_or(&above), from_s);
        for event in &rig.events {
            assert!(!event.reason.is_empty() && event.report_only.is_none(), "{event:?}");
        }
    }
}

#[test]
fn every_trigger_has_a_row() {
    for trigger in Trigger::ALL {
        assert!(rows().iter().any(|r| r.trigger == *trigger), "{trigger}");
    }
}

#[test]
fn a_link_that_is_heard_but_for_its_positions_is_not_lost() {
    let mut rig = Rig::new();
    rig.run(10.0, stale);
    let triggers: Vec<_> = rig.events.iter().map(|e| e.trigger).collect();
    assert!(triggers.iter().all(|t| *t == Trigger::StaleEstimate), "{triggers:?}");
}

#[test]
fn a_silent_link_alone_releases_the_vehicle_after_five_seconds() {
    let mut rig = Rig::new();
    rig.run(8.0, silent);
    assert_times("link", &rig.orders(), &[(RELEASE, 5.0)], 0.0);
    // Receiver and position are no older than the last frame: they are not blamed for the link.
    assert!(
        rig.events.iter().all(|e| e.trigger == Trigger::LinkLoss),
        "{:?}",
        rig.events
    );
}

#[test]
fn a_clock_that_jumped_once_is_believed_again_when_it_runs_on_evenly() {
    let mut rig = Rig::new();
    rig.run(5.0, |_, _| ());
    rig.run(20.0, |h, _| h.clock_offset_s = h.clock_offset_s.map(|o| o + 4.0));
    assert_eq!(rig.order(), Some(HOLD));
    let cleared = rig.of(FailsafeEventKind::Cleared);
    let after_s = 5.0 + rig.settings.clock_fault.settled_after_s + rig.settings.recovered_after_s;
    assert!(
        matches!(cleared.as_slice(), [(_, at_s)] if (after_s..after_s + 0.2).contains(at_s)),
        "{cleared:?}"
    );
}

#[test]
fn the_slightest_drift_that_is_no_clocks_nature_is_found() {
    let drifting = |drift_s_per_s: f64| {
        let mut rig = Rig::new();
        rig.run(400.0, |h, t| {
            h.clock_offset_s = h.clock_offset_s.map(|o| o + drift_s_per_s * t)
        });
        rig.order()
    };
    assert_eq!(drifting(0.0004), None);
    for drift_s_per_s in [0.001, -0.001, 0.0015, 0.003, 0.01] {
        assert!(drifting(drift_s_per_s) >= Some(HOLD), "{drift_s_per_s}");
    }
}

#[test]
fn a_simulated_clock_may_go_at_half_or_one_and_a_half_of_the_pace_and_unevenly() {
    for drift_s_per_s in [-0.45, -0.02, 0.45] {
        let mut rig = Rig::new();
        rig.run(60.0, |h, t| {
            h.simulated = true;
            // It stands still for 0.2 s every three seconds.
            let stood_s = 0.2 * (t / 3.0).floor();
            h.clock_offset_s = h.clock_offset_s.map(|o| o + drift_s_per_s * t - stood_s);
        });
        assert_eq!(rig.order(), None, "{drift_s_per_s}: {:?}", rig.events);
    }
}

#[test]
fn a_jump_of_a_simulated_clock_and_one_that_runs_away_are_still_found() {
    let faulty: [fn(f64) -> f64; 2] = [|t| if t < 5.0 { 0.0 } else { 2.0 }, |t| 0.9 * t];
    for offset_s in faulty {
        let mut rig = Rig::new();
        rig.run(12.0, |h, t| {
            h.simulated = true;
            h.clock_offset_s = h.clock_offset_s.map(|o| o + offset_s(t));
        });
        let orders = rig.orders();
        assert!(
            orders.first().is_some_and(|(reaction, _)| *reaction == HOLD),
            "{orders:?}"
        );
    }
}

#[test]
fn a_clock_that_stood_still_as_long_as_this_node_did_has_no_fault() {
    // The node did not look for two seconds; a moment later the link has measured what became of the vehicle's clock.
    let ordered = |behind_s: f64| {
        let mut rig = Rig::new();
        rig.run(5.0, |_, _| ());
        rig.now = rig.now.plus_seconds(2.0);
        rig.run(12.0, |h, t| {
            let stepped_s = if t < 0.3 { 0.0 } else { -behind_s };
            h.clock_offset_s = h.clock_offset_s.map(|o| o + stepped_s);
        });
        !rig.orders().is_empty()
    };
    assert!(!ordered(0.0), "it went on while the node did not");
    assert!(!ordered(2.03) && !ordered(1.7), "it stood still as long");
    assert!(ordered(1.0) && ordered(3.0) && ordered(-2.0), "it did something else");
}

#[test]
fn a_restarted_autopilot_has_a_clock_of_its_own() {
    let drifts =
        |h: &mut Health, from_s: f64, t: f64| h.clock_offset_s = h.clock_offset_s.map(|o| o + from_s - 0.015 * t);
    for told in [true, false] {
        let mut rig = Rig::new();
        let simulated = |h: &mut Health| h.simulated = true;
        rig.run(5.0, |h, t| (simulated(h), drifts(h, 0.0, t)).1);
        if told {
            rig.failsafe.autopilot_restarted();
        }
        rig.run(5.0, |h, t| (simulated(h), drifts(h, -400.0, t)).1);
        assert_eq!(rig.order().is_none(), told, "{:?}", rig.events);
    }
}

#[test]
fn what_would_act_in_the_air_is_known_on_the_ground() {
    let mut rig = Rig::new();
    rig.run(2.0, |h, _| h.airborne = false);
    assert_eq!(rig.failsafe.would_act(&rig.settings), Vec::<String>::new());
    rig.run(2.0, |h, _| {
        h.airborne = false;
        h.clock_offset_s = h.clock_offset_s.map(|o| o + 4.0);
        h.energy = Some(charge(EnergyLevel::ReturnNow));
        // Said by the check of the place where it stands, and by whoever gives the command.
        h.breach = breach(RETURN, 3.0);
        h.operator_heard = None;
    });
    assert_eq!(rig.order(), None, "on the ground nothing is ordered");
    let standing = rig.failsafe.would_act(&rig.settings);
    assert_eq!(standing.len(), 2, "{standing:?}");
    assert!(
        standing[0].starts_with("clocks jumped or drift (4.00 s"),
        "{standing:?}"
    );
    // Soon is not now, and what is set to warn only does no more in the air.
    rig.settings.clock_fault.mode = TriggerMode::WarnOnly;
    rig.run(0.2, |h, _| {
        h.airborne = false;
        h.energy = Some(charge(EnergyLevel::ReplanSoon));
    });
    assert_eq!(rig.failsafe.would_act(&rig.settings), Vec::<String>::new());
}

#[test]
fn time_that_goes_backwards_is_a_clock_fault() {
    let mut rig = Rig::new();
    rig.run(5.0, |_, _| ());
    rig.now = rig.now.plus_seconds(-0.5);
    rig.run(1.0, |_, _| ());
    let raised = rig
        .events
        .iter()
        .find(|e| e.trigger == Trigger::ClockFault)
        .expect("raised");
    assert_eq!(raised.kind, FailsafeEventKind::Raised);
    assert!((raised.value - 0.5).abs() < 0.05, "{raised:?}");
}
