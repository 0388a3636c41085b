//! The rules above the rows of the table: strongest wins, seen to take effect, who may end it, what cannot be done.

use super::*;
use skein_domain::{EnergyLevel, EnergyState, PositionNed, Refusal, VehicleCommand};

fn go_to() -> VehicleCommand {
    VehicleCommand::GoTo {
        position: PositionNed::default(),
        yaw_rad: None,
        speed_m_s: None,
    }
}

fn off_course(health: &mut Health, _t_s: f64) {
    health.tracking_error_m = Some(9.0);
}

#[test]
fn of_several_triggers_the_strongest_is_ordered_and_all_are_reported() {
    let mut rig = Rig::new();
    rig.run(1.0, |_, _| ());
    rig.run(4.5, |h, t| {
        off_course(h, t);
        h.clock_offset_s = Some(f64::NAN);
        h.breach = Some(FenceBreach {
            reaction: Reaction::Return,
            outside_m: 2.0,
            zone: "field".into(),
        });
    });
    assert_eq!(
        rig.orders().iter().map(|(r, _)| *r).collect::<Vec<_>>(),
        [Reaction::Return]
    );
    let alarms = rig.failsafe.state(&rig.settings).alarms;
    let triggers: Vec<_> = alarms.iter().map(|a| (a.trigger, a.reaction)).collect();
    assert_eq!(
        triggers,
        [
            (Trigger::TrackingError, Reaction::Hold),
            (Trigger::ClockFault, Reaction::Hold),
            (Trigger::FenceBreach, Reaction::Return)
        ]
    );
}

/// What was measured before this computer stood still is all that there is of a vehicle, as long as nothing newer was read.
fn unread_since(at: NodeTime) -> impl Fn(&mut Health, f64) {
    move |health, _| health.position_time = Some(at)
}

#[test]
fn what_was_said_while_this_computer_stood_still_is_read_before_anybody_is_judged() {
    let mut rig = Rig::new();
    rig.run(1.0, |_, _| ());
    let before = rig.now;
    rig.now = rig.now.plus_seconds(2.1);
    rig.run(0.4, unread_since(before));
    rig.run(1.0, |_, _| ());
    assert_eq!(rig.events, []);
}

#[test]
fn who_stays_silent_after_a_stall_of_this_computer_is_judged_and_a_computer_that_is_always_late_judges_too() {
    let mut rig = Rig::new();
    rig.run(1.0, |_, _| ());
    let before = rig.now;
    rig.now = rig.now.plus_seconds(2.1);
    rig.run(0.6, unread_since(before));
    assert_eq!(rig.order(), Some(Reaction::Release));

    let mut rig = Rig::new();
    rig.run(1.0, |_, _| ());
    let before = rig.now;
    while rig.now.seconds_since(before) < 4.0 {
        rig.now = rig.now.plus_seconds(0.3);
        rig.run(PERIOD_S, unread_since(before));
    }
    assert_eq!(rig.order(), Some(Reaction::Release));
}

fn bad_clock(health: &mut Health) {
    health.clock_offset_s = Some(f64::NAN);
}

#[test]
fn a_vehicle_that_lands_is_not_called_back() {
    let mut rig = Rig::new();
    rig.run(1.0, |_, _| ());
    // Commanded, and not begun by the autopilot yet; then begun.
    for mode in [FlightMode::Offboard, FlightMode::Land] {
        rig.run(5.0, |h, _| {
            bad_clock(h);
            (h.lands, h.mode, h.state) = (true, mode, FlightState::Landing);
        });
        assert_eq!(rig.orders(), []);
        let alarms = rig.failsafe.state(&rig.settings).alarms;
        let told: Vec<_> = alarms.iter().map(|a| (a.trigger, a.report_only)).collect();
        assert_eq!(told, [(Trigger::ClockFault, Some(ReportOnly::Landing))]);
    }
    // The landing was broken off.
    rig.run(PERIOD_S, |h, _| {
        bad_clock(h);
        h.state = FlightState::GoingTo;
    });
    assert_eq!(rig.order(), Some(Reaction::Hold));
}

#[test]
fn a_vehicle_that_lands_unheard_is_left_to_its_autopilot() {
    let mut rig = Rig::new();
    rig.run(1.0, |_, _| ());
    rig.run(6.0, |h, t| {
        silent(h, t);
        h.lands = true;
    });
    assert_eq!(rig.order(), Some(Reaction::Release));
}

#[test]
fn what_was_ordered_stays_until_somebody_takes_the_vehicle_up() {
    let mut rig = Rig::new();
    rig.run(4.0, off_course);
    assert_eq!(rig.order(), Some(Reaction::Hold));
    assert!(matches!(
        rig.failsafe.take_up(TakenUpBy::Coordinator),
        Err(Refusal::NotPermitted { .. })
    ));
    rig.run(60.0, |_, _| ());
    let order = *rig.failsafe.order().expect("in force");
    assert!(order.recovered && order.effective_at.is_some(), "{order:?}");
    assert_eq!(rig.of(FailsafeEventKind::Cleared).len(), 1);
    let event = rig
        .failsafe
        .take_up(TakenUpBy::Coordinator)
        .expect("may")
        .expect("told");
    assert_eq!(event.kind, FailsafeEventKind::TakenUp);
    assert_eq!(rig.order(), None);
    let told = rig.events.len();
    rig.run(5.0, |_, _| ());
    assert_eq!(rig.events.len(), told);
}

#[test]
fn the_coordinator_takes_nobody_up_who_returns_or_was_released() {
    for (fault_s, reaction) in [(11.0, Reaction::Return), (31.0, Reaction::Land)] {
        let mut rig = Rig::new();
        rig.run(fault_s, off_course);
        rig.run(10.0, |_, _| ());
        assert_eq!(rig.order(), Some(reaction));
        assert!(rig.failsafe.take_up(TakenUpBy::Coordinator).is_err());
        assert!(rig.failsafe.take_up(TakenUpBy::Operator).is_ok());
    }
}

#[test]
fn an_operator_overrules_a_step_but_not_the_next_one() {
    let mut rig = Rig::new();
    rig.run(4.0, off_course);
    assert_eq!(rig.order(), Some(Reaction::Hold));
    assert!(rig.failsafe.permits(&go_to()).is_ok());
    rig.failsafe.take_up(TakenUpBy::Operator).expect("may");
    rig.run(5.0, |h, t| off_course(h, t + 4.0));
    assert_eq!(rig.order(), None);
    let alarms = rig.failsafe.state(&rig.settings).alarms;
    assert_eq!(alarms[0].report_only, Some(ReportOnly::Overruled));
    rig.run(2.0, |h, t| off_course(h, t + 9.0));
    assert_eq!(rig.order(), Some(Reaction::Return));
}

#[test]
fn nothing_that_needs_a_position_is_permitted_while_it_is_in_doubt() {
    let mut rig = Rig::new();
    assert!(rig.failsafe.permits(&go_to()).is_ok());
    rig.run(1.0, stale);
    for flies in [go_to(), VehicleCommand::Steer] {
        assert!(
            matches!(rig.failsafe.permits(&flies), Err(Refusal::NotPermitted { .. })),
            "{flies:?}"
        );
    }
    for always in [VehicleCommand::Hold, VehicleCommand::Return, VehicleCommand::Land] {
        assert!(rig.failsafe.permits(&always).is_ok(), "{always:?}");
    }
}

#[test]
fn what_has_no_effect_is_followed_by_the_next_stronger_up_to_release() {
    let mut rig = Rig::new();
    rig.obeys_after_s = None;
    rig.run(20.0, |h, t| {
        if t > 2.0 {
            off_course(h, t);
        }
    });
    let within_s = rig.settings.reaction_within_s;
    let orders = rig.orders();
    let reactions: Vec<_> = orders.iter().map(|(r, _)| *r).take(4).collect();
    assert_eq!(
        reactions,
        [Reaction::Hold, Reaction::Return, Reaction::Land, Reaction::Release]
    );
    for pair in orders.windows(2) {
        let apart_s = pair[1].1 - pair[0].1;
        assert!((apart_s - within_s).abs() < 2.0 * PERIOD_S, "{orders:?}");
    }
    // A stream that does not stop is said again and again.
    assert!(rig.of(FailsafeEventKind::Ineffective).len() >= 5);
}

#[test]
fn an_order_that_is_carried_out_late_but_within_its_bound_is_enough() {
    let mut rig = Rig::new();
    rig.obeys_after_s = Some(rig.settings.reaction_within_s - 0.1);
    rig.run(8.0, off_course);
    assert_eq!(rig.orders().len(), 1);
    let effective = rig.of(FailsafeEventKind::Effective);
    assert_eq!(effective.len(), 1, "{:?}", rig.events);
}

#[test]
fn a_vehicle_that_leaves_its_hold_by_itself_is_sent_home() {
    let mut rig = Rig::new();
    rig.run(5.0, off_course);
    assert_eq!(rig.order(), Some(Reaction::Hold));
    rig.ordered = None;
    rig.health.mode = FlightMode::Offboard;
    rig.obeys_after_s = None;
    rig.run(3.0, |h, t| off_course(h, t + 5.0));
    assert_eq!(rig.order(), Some(Reaction::Return));
}

#[test]
fn a_setpoint_means_nothing_while_the_autopilot_flies_by_itself() {
    for mode in [FlightMode::TakeOff, FlightMode::Return, FlightMode::Land] {
        let mut rig = Rig::new();
        rig.health.mode = mode;
        rig.run(40.0, off_course);
        assert_eq!(rig.events, [], "{mode}");
    }
}

#[test]
fn a_pilot_is_only_told_and_keeps_the_vehicle() {
    let mut rig = Rig::new();
    rig.run(4.0, off_course);
    assert_eq!(rig.order(), Some(Reaction::Hold));
    rig.health.pilot_in_control = true;
    rig.health.mode = FlightMode::Position;
    rig.ordered = None;
    rig.run(60.0, |h, t| {
        off_course(h, t);
        no_fix(h, t);
    });
    assert_eq!(rig.of(FailsafeEventKind::Ended).len(), 1);
    assert_eq!(rig.orders().len(), 1);
    assert_eq!(rig.order(), None);
    let gnss = rig
        .events
        .iter()
        .find(|e| e.trigger == Trigger::GnssLoss)
        .expect("told");
    assert_eq!(gnss.report_only, Some(ReportOnly::PilotInControl));
    // Given back, the steps count anew: no reaction out of the blue.
    let given_back_s = rig.t();
    rig.health.pilot_in_control = false;
    rig.health.mode = FlightMode::Offboard;
    rig.run(5.0, off_course);
    let (reaction, at_s) = rig.orders()[1];
    assert_eq!(reaction, Reaction::Hold);
    assert!((at_s - given_back_s - 3.0).abs() < 3.0 * PERIOD_S, "{at_s}");
}

#[test]
fn a_released_vehicle_stays_released_under_a_pilots_control() {
    let mut rig = Rig::new();
    rig.run(3.0, stale);
    assert_eq!(rig.order(), Some(Reaction::Release));
    rig.health.pilot_in_control = true;
    rig.run(5.0, |_, _| ());
    rig.health.pilot_in_control = false;
    rig.run(5.0, |_, _| ());
    assert_eq!(rig.order(), Some(Reaction::Release));
    assert!(rig.failsafe.take_up(TakenUpBy::Coordinator).is_err());
    assert!(rig.failsafe.take_up(TakenUpBy::Operator).is_ok());
}

#[test]
fn on_the_ground_it_is_only_reported() {
    let mut rig = Rig::new();
    rig.health.airborne = false;
    rig.run(200.0, |h, t| {
        silent(h, t);
        off_course(h, t);
    });
    assert!(rig.orders().is_empty());
    let raised: Vec<_> = rig.events.iter().map(|e| (e.kind, e.report_only)).collect();
    assert_eq!(raised.len(), 2, "{:?}", rig.events);
    assert!(
        raised
            .iter()
            .all(|e| *e == (FailsafeEventKind::Raised, Some(ReportOnly::OnGround)))
    );
}

#[test]
fn landing_ends_what_was_in_force() {
    let mut rig = Rig::new();
    rig.run(11.0, off_course);
    assert_eq!(rig.order(), Some(Reaction::Return));
    rig.health.airborne = false;
    rig.run(1.0, |h, _| h.tracking_error_m = None);
    assert_eq!(rig.order(), None);
    assert_eq!(rig.of(FailsafeEventKind::Ended).len(), 1);
}

#[test]
fn warn_only_reports_and_off_is_silent() {
    let mut rig = Rig::new();
    rig.settings.tracking_error.mode = TriggerMode::WarnOnly;
    rig.settings.gnss_loss.mode = TriggerMode::Off;
    rig.run(40.0, |h, t| {
        off_course(h, t);
        no_fix(h, t);
    });
    assert!(rig.orders().is_empty());
    assert!(rig.events.iter().all(|e| e.trigger == Trigger::TrackingError));
    assert_eq!(rig.events[0].report_only, Some(ReportOnly::WarnOnly));
}

#[test]
fn link_loss_and_stale_estimates_are_reported_whatever_is_configured() {
    let mut rig = Rig::new();
    for (mode, steps) in [
        (&mut rig.settings.link_loss.mode, &mut rig.settings.link_loss.steps),
        (
            &mut rig.settings.stale_estimate.mode,
            &mut rig.settings.stale_estimate.steps,
        ),
    ] {
        *mode = TriggerMode::Off;
        steps.clear();
    }
    rig.run(10.0, silent);
    rig.run(10.0, stale);
    let raised = rig.events.iter().filter(|e| e.kind == FailsafeEventKind::Raised);
    let raised: Vec<_> = raised.map(|e| e.trigger).collect();
    assert_eq!(raised, [Trigger::LinkLoss, Trigger::StaleEstimate]);
}

/// The first frame after a silence makes everything else look old that came with others.
#[test]
fn what_could_not_be_said_in_a_silence_is_not_missing_after_it() {
    let of_others = [Trigger::GnssLoss, Trigger::StaleEstimate];
    let told = |rig: &Rig| rig.events.iter().filter(|e| of_others.contains(&e.trigger)).count();
    let before = NodeTime::from_seconds(START_S);
    let without_fix = |h: &mut Health, _: f64| {
        h.position_time = Some(before);
        h.gnss.as_mut().unwrap().heard = before;
    };
    let mut rig = Rig::new();
    rig.run(50.0, |h, t| {
        without_fix(h, t);
        h.last_heard = before;
    });
    rig.run(0.25, without_fix);
    rig.run(5.0, |_, _| {});
    assert_eq!(told(&rig), 0, "{:?}", rig.events);
    // What stays missing is, from then on.
    let mut rig = Rig::new();
    rig.run(50.0, |h, t| {
        without_fix(h, t);
        h.last_heard = before;
    });
    rig.run(20.0, without_fix);
    let raised = |trigger| {
        let mut raised = rig
            .events
            .iter()
            .filter(|e| e.trigger == trigger && e.kind == FailsafeEventKind::Raised);
        raised.next().map(|e| e.at.seconds_since(before))
    };
    for trigger in of_others {
        let at_s = raised(trigger).unwrap_or_else(|| panic!("{trigger:?}: {:?}", rig.events));
        assert!(at_s > 50.0 && at_s < 60.0, "{trigger:?} at {at_s} s");
    }
}

#[test]
fn a_return_without_a_way_home_is_a_landing() {
    let return_now = |h: &mut Health| {
        h.energy = Some(EnergyState {
            needed_home: Some(0.3),
            level: EnergyLevel::ReturnNow,
            ..EnergyState::default()
        });
    };
    let without_home = |h: &mut Health| h.home_known = false;
    let out_of_reach = |h: &mut Health| {
        if let Some(energy) = &mut h.energy {
            energy.needed_home = None;
        }
    };
    let without_position = |h: &mut Health| h.holds_position = false;
    for cannot in [without_home, out_of_reach, without_position] as [fn(&mut Health); 3] {
        let mut rig = Rig::new();
        rig.run(2.0, |h, _| {
            return_now(h);
            cannot(h);
        });
        assert_eq!(rig.order(), Some(Reaction::Land));
    }
    // On the way home the fix is lost.
    let mut rig = Rig::new();
    rig.run(5.0, |h, _| return_now(h));
    assert_eq!(rig.order(), Some(Reaction::Return));
    rig.run(2.5, |h, t| {
        return_now(h);
        no_fix(h, t);
    });
    assert_eq!(
        rig.order(),
        Some(Reaction::Return),
        "a gap in the fix is no reason to land"
    );
    rig.run(1.0, |h, t| {
        return_now(h);
        no_fix(h, t + 2.5);
    });
    assert_eq!(rig.order(), Some(Reaction::Land));
}

#[test]
fn feasible_is_never_weaker_and_always_possible() {
    for reaction in Reaction::ALL {
        for bits in 0..16_u8 {
            let means = Means {
                reachable: bits & 1 != 0,
                holds_position: bits & 2 != 0,
                finds_home: bits & 4 != 0,
                pays_for_home: bits & 8 != 0,
            };
            let chosen = feasible(*reaction, means);
            assert!(chosen >= *reaction);
            assert!(chosen != Reaction::Hold || means.holds_position);
            assert!(chosen != Reaction::Return || (means.finds_home && means.pays_for_home));
            let next = next_after(*reaction, means);
            assert!(next > *reaction || next == Reaction::Release);
            assert!(means.reachable || next == Reaction::Release);
        }
    }
}

#[test]
fn a_vehicle_that_is_not_heard_is_left_to_its_autopilot_when_it_does_not_obey() {
    let mut rig = Rig::new();
    rig.settings.stale_estimate.mode = TriggerMode::WarnOnly;
    rig.settings.link_loss.mode = TriggerMode::WarnOnly;
    rig.obeys_after_s = None;
    rig.run(10.0, |h, t| {
        silent(h, t);
        h.breach = Some(FenceBreach {
            reaction: Reaction::Hold,
            outside_m: 1.0,
            zone: "field".into(),
        });
    });
    let reactions: Vec<_> = rig.orders().iter().map(|(r, _)| *r).take(2).collect();
    assert_eq!(reactions, [Reaction::Hold, Reaction::Release]);
}
