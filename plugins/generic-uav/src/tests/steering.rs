//! Flights by hand: where the stick points, within the limits, and to a stand as soon as it is let go.

use super::autopilot::{Autopilot, PERIOD_S};
use super::rig::{Rig, create};
use super::tasks::{COURSE, follow, lead};
use crate::Settings;
use proptest::prelude::*;
use skein_domain::exchange::{CommandProgress, Effect, Event};
use skein_domain::frames::wrap_angle_rad;
use skein_domain::stick::STICK_GOOD_S;
use skein_domain::{
    AnchorReference, CommandId, FlightState, PositionNed, Refusal, Route, Setpoint, Stick, Task, VehicleCommand,
};
use skein_plugin_sdk::UavModel;

/// A stick comes with every third period.
const STICK_EVERY: u32 = 3;

fn forward(forward_m_s: f64) -> Stick {
    Stick {
        forward_m_s,
        ..Stick::default()
    }
}

/// Holds the stick so for some seconds.
fn hold_stick(rig: &mut Rig, stick: Stick, seconds: f64) {
    for period in 0..(seconds / PERIOD_S).round() as u32 {
        if period % STICK_EVERY == 0 {
            rig.inbox.push(Event::Stick(stick));
        }
        rig.tick();
    }
}

/// Holding at ten metres, then steered.
fn steered() -> (Rig, CommandId) {
    let mut rig = Rig::holding(10.0);
    let id = rig.command(VehicleCommand::Steer);
    rig.run(0.2);
    assert_eq!((rig.state, rig.detail.as_str()), (FlightState::GoingTo, "by hand"));
    (rig, id)
}

fn last(rig: &Rig) -> Setpoint {
    rig.setpoints().last().expect("a setpoint").1
}

#[test]
fn it_goes_where_the_stick_points() {
    for (stick, forward_m, right_m, up_m) in [
        (forward(4.0), 4.0, 0.0, 0.0),
        (
            Stick {
                right_m_s: -3.0,
                ..Stick::default()
            },
            0.0,
            -3.0,
            0.0,
        ),
        (
            Stick {
                up_m_s: 1.5,
                ..Stick::default()
            },
            0.0,
            0.0,
            1.5,
        ),
        (
            Stick {
                up_m_s: -1.0,
                ..forward(2.0)
            },
            2.0,
            0.0,
            -1.0,
        ),
    ] {
        let (mut rig, id) = steered();
        let (start, yaw_rad) = (rig.now, rig.autopilot.yaw_rad);
        hold_stick(&mut rig, stick, 4.0);
        let (sin, cos) = yaw_rad.sin_cos();
        let v = rig.autopilot.velocity;
        let got = [v.x * cos + v.y * sin, -v.x * sin + v.y * cos, -v.z];
        for (got, wanted) in got.into_iter().zip([forward_m, right_m, up_m]) {
            assert!((got - wanted).abs() < 0.1, "{stick:?}: {got} is not {wanted}");
        }
        assert_eq!(rig.progress(id), [CommandProgress::Executing]);
        assert!(
            wrap_angle_rad(rig.autopilot.yaw_rad - yaw_rad).abs() < 1e-9,
            "it does not turn"
        );
        rig.assert_no_jump_since(start);
    }
}

#[test]
fn without_a_stick_it_stands() {
    let (mut rig, id) = steered();
    let here = rig.here();
    rig.run(5.0);
    assert!(rig.here().distance_m(&here) < 0.05);
    assert_eq!(rig.progress(id), [CommandProgress::Executing]);
}

#[test]
fn a_stick_that_ends_is_good_for_half_a_second_and_then_it_brakes_to_a_stand() {
    let (mut rig, id) = steered();
    let start = rig.now;
    hold_stick(&mut rig, forward(4.0), 4.0);
    let (let_go_at, let_go) = (rig.here(), rig.now);
    rig.run(STICK_GOOD_S - 0.1);
    assert!(
        rig.autopilot.velocity.norm() > 3.9,
        "one that is late by a little changes nothing"
    );
    // The rest of the half second, 4 m/s at 2 m/s², and the last of it fades out.
    rig.run(0.1 + 2.0 + 1.5);
    assert!(rig.autopilot.velocity.norm() < 0.1, "{}", rig.autopilot.velocity.norm());
    let way_m = rig.here().distance_m(&let_go_at);
    // 2 m on, 4 m of braking, and a metre of fading out.
    assert!((5.0..8.0).contains(&way_m), "{way_m} m");
    rig.assert_no_jump_since(start);
    assert_eq!(rig.progress(id), [CommandProgress::Executing]);
    // It can be taken up again.
    hold_stick(&mut rig, forward(2.0), 3.0);
    assert!((rig.autopilot.velocity.norm() - 2.0).abs() < 0.1);
    assert!(rig.now.seconds_since(let_go) < 10.0);
}

#[test]
fn who_is_gone_for_ten_seconds_steers_no_more() {
    let (mut rig, id) = steered();
    hold_stick(&mut rig, forward(2.0), 2.0);
    rig.run(9.8);
    assert_eq!((rig.is_done(id), rig.state), (false, FlightState::GoingTo));
    rig.run(0.4);
    assert_eq!((rig.is_done(id), rig.state), (true, FlightState::Holding));
    let here = rig.here();
    hold_stick(&mut rig, forward(3.0), 2.0);
    assert!(
        rig.here().distance_m(&here) < 0.2,
        "a stick that nobody asked for moves nothing"
    );
    assert_eq!(rig.state, FlightState::Holding);
}

#[test]
fn it_turns_at_the_asked_rate_and_no_faster_than_it_can() {
    for (asked, flown) in [(0.5, 0.5), (-0.3, -0.3), (4.0, 0.8)] {
        let (mut rig, _) = steered();
        let stick = Stick {
            yaw_rate_rad_s: asked,
            ..Stick::default()
        };
        hold_stick(&mut rig, stick, 1.0);
        let (yaw_rad, here) = (rig.autopilot.yaw_rad, rig.here());
        hold_stick(&mut rig, stick, 2.0);
        let turned = wrap_angle_rad(rig.autopilot.yaw_rad - yaw_rad);
        assert!((turned - 2.0 * flown).abs() < 0.01, "{turned} for {asked}");
        assert!((last(&rig).yaw_rate_rad_s.expect("a rate") - flown).abs() < 1e-9);
        assert!(rig.here().distance_m(&here) < 0.05, "it turns on the spot");
        // Let go, it stops turning too.
        rig.run(1.5);
        let yaw_rad = rig.autopilot.yaw_rad;
        rig.run(1.0);
        assert!((rig.autopilot.yaw_rad - yaw_rad).abs() < 1e-9);
        assert_eq!(last(&rig).yaw_rate_rad_s, Some(0.0));
    }
}

#[test]
fn forward_turns_with_the_nose() {
    let (mut rig, _) = steered();
    let start = rig.now;
    let stick = Stick {
        yaw_rate_rad_s: 0.4,
        ..forward(3.0)
    };
    hold_stick(&mut rig, stick, 12.0);
    let v = rig.autopilot.velocity;
    // The velocity comes a little after the nose: a quarter of a second at 0.4 rad/s, and what the vehicle lags behind.
    let slip = wrap_angle_rad(v.y.atan2(v.x) - rig.autopilot.yaw_rad);
    assert!((-0.4..0.0).contains(&slip), "{slip}");
    rig.assert_no_jump_since(start);
}

#[test]
fn what_is_too_fast_or_no_number_is_not_flown() {
    let (mut rig, _) = steered();
    let start = rig.now;
    let stick = Stick {
        forward_m_s: 40.0,
        right_m_s: 40.0,
        up_m_s: -30.0,
        ..Stick::default()
    };
    rig.autopilot.position.z -= 200.0;
    rig.run(0.5);
    hold_stick(&mut rig, stick, 9.0);
    let settings = Settings::default();
    let velocity = last(&rig).velocity.expect("a velocity");
    assert!((velocity.north_m_s.hypot(velocity.east_m_s) - settings.max_speed_m_s).abs() < 0.7);
    assert!((velocity.down_m_s - settings.descent_m_s).abs() < 0.01);
    within_limits(&rig, start).expect("the limits are kept");
    let here = rig.autopilot.velocity.norm();
    hold_stick(&mut rig, forward(f64::NAN), 8.0);
    assert!(
        here > 10.0 && rig.autopilot.velocity.norm() < 0.1,
        "no number is no stick"
    );
}

/// No setpoint is faster than the limits, or changes its velocity faster than they allow.
fn within_limits(rig: &Rig, since: skein_domain::NodeTime) -> Result<(), String> {
    let settings = Settings::default();
    let setpoints: Vec<_> = rig.setpoints().into_iter().filter(|(at, _)| *at > since).collect();
    for (at, setpoint) in &setpoints {
        let v = setpoint.velocity.ok_or("no velocity")?;
        let level_m_s = v.north_m_s.hypot(v.east_m_s);
        if level_m_s > settings.max_speed_m_s + 1e-6
            || v.down_m_s > settings.descent_m_s + 1e-6
            || v.down_m_s < -settings.climb_m_s - 1e-6
        {
            return Err(format!("{v:?} at {:.2} s", at.as_seconds()));
        }
        let acceleration = setpoint.acceleration.ok_or("no acceleration")?;
        if acceleration.norm() > settings.acceleration_m_s2 + 1e-6 {
            return Err(format!("{acceleration:?} at {:.2} s", at.as_seconds()));
        }
    }
    Ok(())
}

#[test]
fn what_holds_it_back_does_not_wind_the_reference_up() {
    let (mut rig, _) = steered();
    hold_stick(&mut rig, forward(4.0), 3.0);
    // As at a fence: it does not go on.
    let wall = rig.autopilot.position;
    for period in 0..500 {
        if period % STICK_EVERY == 0 {
            rig.inbox.push(Event::Stick(forward(4.0)));
        }
        rig.autopilot.position = wall;
        rig.autopilot.velocity = Default::default();
        rig.tick();
        let ahead_m = last(&rig)
            .position
            .expect("a place")
            .distance_m(&PositionNed::from(wall));
        assert!(period < 50 || ahead_m < 3.0, "{ahead_m} m");
    }
    // Turned round, it comes away at once: not after it has unwound ten seconds of four metres.
    let (from, start) = (rig.here(), rig.now.plus_seconds(0.1));
    hold_stick(&mut rig, forward(-4.0), 4.0);
    let (sin, cos) = rig.autopilot.yaw_rad.sin_cos();
    let back = rig.here().vector() - from.vector();
    let back_m = -(back.x * cos + back.y * sin);
    assert!(back_m > 5.0, "{back_m} m");
    rig.assert_no_jump_since(start);
}

#[test]
fn what_the_gate_refuses_stays_where_it_is() {
    let (mut rig, id) = steered();
    hold_stick(&mut rig, forward(4.0), 3.0);
    rig.gate = Some(Refusal::OutsideFence {
        detail: "north".to_owned(),
    });
    hold_stick(&mut rig, forward(4.0), 6.0);
    let ahead_m = last(&rig).position.expect("a place").distance_m(&rig.here());
    assert!(ahead_m < 1.0, "{ahead_m} m");
    assert_eq!(
        rig.progress(id),
        [CommandProgress::Executing],
        "a fence does not end it"
    );
    assert_eq!(last(&rig).yaw_rate_rad_s, Some(0.0));
    rig.gate = None;
    let (from, start) = (rig.here(), rig.now.plus_seconds(0.1));
    hold_stick(&mut rig, forward(-4.0), 4.0);
    assert!(rig.here().distance_m(&from) > 6.0);
    rig.assert_no_jump_since(start);
}

#[test]
fn a_new_instance_goes_on_but_not_with_the_stick_from_before() {
    let (mut rig, id) = steered();
    hold_stick(&mut rig, forward(4.0), 4.0);
    rig.inbox.push(Event::Stick(forward(4.0)));
    rig.tick();
    rig.model = create(Some(rig.model.snapshot()), 2, rig.now);
    let start = rig.now;
    rig.run(0.3);
    assert!(rig.autopilot.velocity.norm() < 3.9, "it brakes at once");
    rig.run(3.5);
    assert!(rig.autopilot.velocity.norm() < 0.1);
    assert_eq!(rig.state, FlightState::GoingTo);
    hold_stick(&mut rig, forward(3.0), 3.0);
    assert!(
        (rig.autopilot.velocity.norm() - 3.0).abs() < 0.1,
        "sticks that come now are flown"
    );
    rig.assert_no_jump_since(start.plus_seconds(PERIOD_S / 2.0));
    rig.run(10.5);
    assert!(rig.is_done(id));
}

#[test]
fn any_other_command_ends_it_and_so_does_a_pilot_and_a_task() {
    let (mut rig, id) = steered();
    hold_stick(&mut rig, forward(4.0), 3.0);
    let start = rig.now;
    let hold = rig.command(VehicleCommand::Hold);
    hold_stick(&mut rig, forward(4.0), 5.0);
    assert_eq!(rig.refusal(id), Some(Refusal::Superseded));
    assert!(rig.is_done(hold) && rig.autopilot.velocity.norm() < 0.1);
    rig.assert_no_jump_since(start);

    let (mut rig, id) = steered();
    rig.autopilot.change_mode(skein_domain::FlightMode::Position, false);
    rig.run(0.2);
    let streamed = rig.setpoints().len();
    hold_stick(&mut rig, forward(4.0), 2.0);
    assert_eq!(rig.refusal(id), Some(Refusal::PilotInControl));
    assert_eq!(
        (rig.state, rig.setpoints().len()),
        (FlightState::PilotControl, streamed)
    );

    let (mut rig, id) = steered();
    rig.task(follow(0.0));
    rig.run(0.2);
    assert_eq!(
        (rig.refusal(id), rig.state),
        (Some(Refusal::Superseded), FlightState::Following)
    );
}

#[test]
fn a_stick_is_nothing_to_a_vehicle_that_is_not_steered() {
    let mut rig = Rig::holding(10.0);
    let here = rig.here();
    hold_stick(&mut rig, forward(4.0), 3.0);
    assert!(rig.here().distance_m(&here) < 0.05);
    // Nor is it kept for one that is steered later.
    rig.inbox.push(Event::Stick(forward(4.0)));
    rig.command(VehicleCommand::Steer);
    rig.run(2.0);
    assert!(rig.here().distance_m(&here) < 0.05);

    let mut rig = Rig::new(Autopilot::default());
    hold_stick(&mut rig, forward(4.0), 1.0);
    assert!(rig.setpoints().is_empty());
}

fn anchors(rig: &Rig) -> Vec<AnchorReference> {
    let of = |effect: &Effect| match effect {
        Effect::Anchor(anchor) => Some(*anchor),
        _ => None,
    };
    rig.log.iter().filter_map(|(_, effect)| of(effect)).collect()
}

fn route_ahead(rig: &Rig) -> Route {
    Route {
        waypoints: vec![rig.here().moved([80.0, 0.0, 0.0].into())],
        speed_m_s: 4.0,
        corner_radius_m: 8.0,
    }
}

#[test]
fn a_leader_that_is_steered_goes_on_leading() {
    let mut rig = Rig::holding(10.0);
    let start = rig.now;
    rig.task(lead(Some(route_ahead(&rig))));
    rig.run(4.0);
    let id = rig.command(VehicleCommand::Steer);
    rig.run(0.2);
    assert_eq!(
        (rig.state, rig.progress(id)),
        (FlightState::Leading, vec![CommandProgress::Executing])
    );
    let finished = rig.log.iter().filter(|(_, e)| *e == Effect::RouteFinished).count();
    assert_eq!(finished, 1, "its route is over");
    rig.run(4.0);
    let told = anchors(&rig).len();
    let aside = Stick {
        right_m_s: 9.0,
        ..Stick::default()
    };
    let turning = Stick {
        yaw_rate_rad_s: 2.0,
        ..Stick::default()
    };
    hold_stick(&mut rig, aside, 4.0);
    // No faster than its followers can come after.
    assert!(
        (rig.autopilot.velocity.norm() - 5.0).abs() < 0.2,
        "{:?}",
        rig.autopilot.velocity
    );
    hold_stick(&mut rig, turning, 5.0);
    let anchors = anchors(&rig);
    assert_eq!(anchors.len() - told, 450, "one in every period");
    let anchor = anchors.last().expect("an anchor");
    assert!((anchor.heading_rate_rad_s - 0.5).abs() < 1e-9, "{anchor:?}");
    for pair in anchors[told..].windows(2) {
        let turned = wrap_angle_rad(pair[1].heading_rad - pair[0].heading_rad);
        assert!((-1e-9..=0.5 * PERIOD_S + 1e-9).contains(&turned), "{turned}");
    }
    rig.assert_no_jump_since(start);

    // Let go it stands, turned as it is, and leads on; the same task once more changes nothing.
    rig.run(4.0);
    let heading_rad = self::anchors(&rig).last().expect("an anchor").heading_rad;
    rig.run(9.0);
    assert!(rig.is_done(id) && rig.state == FlightState::Leading);
    let here = rig.here();
    hold_stick(&mut rig, forward(3.0), 2.0);
    assert!(
        rig.here().distance_m(&here) < 0.1,
        "a stick that nobody asked for moves no leader"
    );
    let again = Task::Lead {
        route: lead_route(&rig),
        heading: COURSE,
    };
    let here = rig.here();
    rig.task(again);
    rig.run(2.0);
    assert!(rig.here().distance_m(&here) < 0.1 && rig.state == FlightState::Leading);
    assert!((self::anchors(&rig).last().expect("an anchor").heading_rad - heading_rad).abs() < 1e-9);
    // Another route is flown.
    rig.task(lead(Some(route_ahead(&rig))));
    rig.run(5.0);
    assert!(rig.here().distance_m(&here) > 5.0);
}

/// The route that the model was told last.
fn lead_route(rig: &Rig) -> Option<Route> {
    match &rig.model.flight.task.as_ref().expect("a task").task {
        Task::Lead { route, .. } => route.clone(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_steered_leader_keeps_a_task_that_asks_nothing_new_and_obeys_one_that_does() {
    let mut rig = Rig::holding(10.0);
    rig.task(lead(None));
    rig.run(1.0);
    let id = rig.command(VehicleCommand::Steer);
    hold_stick(&mut rig, forward(3.0), 3.0);
    rig.task(lead(None));
    hold_stick(&mut rig, forward(3.0), 2.0);
    assert_eq!(rig.progress(id), [CommandProgress::Executing]);
    assert!((rig.autopilot.velocity.norm() - 3.0).abs() < 0.1);
    rig.task(lead(Some(route_ahead(&rig))));
    rig.run(0.2);
    assert_eq!(rig.refusal(id), Some(Refusal::Superseded));
    assert_eq!(rig.state, FlightState::Leading);
}

fn any_stick() -> impl Strategy<Value = Stick> {
    let number = |most: f64| prop_oneof![8 => -most..most, 1 => Just(f64::NAN), 1 => Just(1e300), 1 => Just(0.0)];
    (number(50.0), number(50.0), number(20.0), number(6.0)).prop_map(
        |(forward_m_s, right_m_s, up_m_s, yaw_rate_rad_s)| Stick {
            forward_m_s,
            right_m_s,
            up_m_s,
            yaw_rate_rad_s,
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 120, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever the sticks say, and however they come: no faster than the limits, no jump, and a stand when they end.
    #[test]
    fn no_stick_is_faster_than_the_limits(sticks in prop::collection::vec((prop::option::of(any_stick()), 1..60u32), 1..40)) {
        let (mut rig, _) = steered();
        rig.autopilot.position.z -= 300.0;
        rig.run(0.5);
        let start = rig.now;
        for (stick, periods) in sticks {
            rig.inbox.extend(stick.map(Event::Stick));
            for _ in 0..periods {
                rig.tick();
            }
        }
        // 12 m/s at 2 m/s², and its fading out.
        rig.run(STICK_GOOD_S + 6.0 + 2.0);
        prop_assert!(rig.autopilot.velocity.norm() < 0.1, "{:?}", rig.autopilot.velocity);
        if let Err(what) = within_limits(&rig, start) {
            prop_assert!(false, "{what}");
        }
        rig.assert_no_jump_since(start.plus_seconds(PERIOD_S / 2.0));
    }
}
