//! Leading and following, and how tasks, commands and states outrank each other.

use super::autopilot::PERIOD_S;
use super::rig::Rig;
use skein_domain::exchange::{Effect, Event};
use skein_domain::{
    AccelerationNed, AnchorReference, FlightState, FormationHeading, NodeTime, OffsetFrd, PositionNed, Refusal, Route,
    SlotMove, Task, VehicleCommand, VehicleId, VelocityNed,
};
use skein_flight::follow;

pub const COURSE: FormationHeading = FormationHeading::Course { max_rate_rad_s: 0.5 };

pub fn lead(route: Option<Route>) -> Task {
    Task::Lead { route, heading: COURSE }
}

pub fn slot(right_m: f64) -> SlotMove {
    let to = OffsetFrd::new(-5.0, right_m, 0.0);
    SlotMove {
        from: to,
        to,
        detour_up_m: 0.0,
        start: NodeTime(0),
        duration_s: 0.0,
    }
}

pub fn follow(right_m: f64) -> Task {
    Task::Follow {
        leader: Some(VehicleId(1)),
        slot: slot(right_m),
    }
}

/// The anchor of a leader for whom the rig's vehicle is about in its slot.
pub fn leader_anchor(rig: &Rig, position: PositionNed) -> AnchorReference {
    AnchorReference {
        position: position.moved([5.0, 0.0, 0.0].into()),
        time: rig.now.plus_seconds(PERIOD_S),
        ..Default::default()
    }
}

fn route(rig: &Rig, legs: &[[f64; 3]]) -> Route {
    let waypoints = legs.iter().map(|leg| rig.here().moved((*leg).into())).collect();
    Route {
        waypoints,
        speed_m_s: 5.0,
        corner_radius_m: 8.0,
    }
}

fn anchors(effects: &[Effect]) -> Vec<AnchorReference> {
    let of = |effect: &Effect| match effect {
        Effect::Anchor(anchor) => Some(*anchor),
        _ => None,
    };
    effects.iter().filter_map(of).collect()
}

/// A leader that flies north at a steady speed.
struct Leader {
    anchor: AnchorReference,
}

impl Leader {
    fn ahead_of(rig: &Rig, speed_m_s: f64) -> Self {
        let position = rig.here().moved([5.0, 0.0, 0.0].into());
        let velocity = VelocityNed::new(speed_m_s, 0.0, 0.0);
        Self {
            anchor: AnchorReference {
                position,
                velocity,
                time: rig.now,
                ..Default::default()
            },
        }
    }

    /// Moves on by one period and hands the anchor to the vehicle, one period old as in a node.
    fn fly(&mut self, rig: &mut Rig) -> Vec<Effect> {
        let anchor = AnchorReference {
            time: rig.now,
            ..self.anchor
        };
        rig.anchor(anchor);
        self.anchor.position = self.anchor.position.after(&self.anchor.velocity, PERIOD_S);
        rig.tick()
    }

    fn run(&mut self, rig: &mut Rig, seconds: f64) {
        for _ in 0..(seconds / PERIOD_S).round() as u32 {
            self.fly(rig);
        }
    }
}

#[test]
fn a_leader_flies_its_route_and_publishes_its_anchor() {
    let mut rig = Rig::holding(10.0);
    let start = rig.now;
    let way = route(&rig, &[[60.0, 0.0, 0.0], [60.0, 60.0, -5.0]]);
    let end = way.waypoints[1];
    rig.task(lead(Some(way)));
    let effects = rig.tick();
    let [anchor] = anchors(&effects)[..] else {
        panic!("one anchor per period: {effects:?}")
    };
    assert!(anchor.position.distance_m(&rig.here()) < 0.01 && anchor.time == rig.now);
    assert!(
        (anchor.heading_rad - rig.autopilot.yaw_rad).abs() < 0.02,
        "it begins with its own yaw"
    );
    rig.run_until("at the end", 60.0, |rig| {
        rig.log.iter().any(|(_, e)| *e == Effect::RouteFinished)
    });
    rig.run(5.0);
    assert_eq!(
        rig.log.iter().filter(|(_, e)| *e == Effect::RouteFinished).count(),
        1,
        "it is told once"
    );
    assert_eq!(rig.state, FlightState::Leading, "it goes on leading");
    assert!(rig.here().distance_m(&end) < 0.1);
    rig.assert_no_jump_since(start);
    let effects = rig.tick();
    let [anchor] = anchors(&effects)[..] else {
        panic!("still one anchor: {effects:?}")
    };
    assert!(
        (anchor.heading_rad - std::f64::consts::FRAC_PI_2).abs() < 0.05,
        "heading {}",
        anchor.heading_rad
    );
    // The anchor's heading turned no faster than it may, and smoothly.
    let all: Vec<_> = rig
        .log
        .iter()
        .flat_map(|(_, e)| anchors(std::slice::from_ref(e)))
        .collect();
    for pair in all.windows(2) {
        let turned = pair[1].heading_rad - pair[0].heading_rad;
        assert!(turned.abs() <= 0.5 * PERIOD_S + 1e-9 && (turned - pair[1].heading_rate_rad_s * PERIOD_S).abs() < 1e-9);
    }
}

#[test]
fn a_leader_without_a_route_holds() {
    let mut rig = Rig::holding(10.0);
    let place = rig.here();
    rig.task(lead(None));
    rig.run(5.0);
    assert!(rig.state == FlightState::Leading && rig.here().distance_m(&place) < 0.05);
    assert!(!rig.log.iter().any(|(_, e)| *e == Effect::RouteFinished));
}

#[test]
fn a_changed_route_goes_on_from_the_present_reference() {
    let mut rig = Rig::holding(10.0);
    let start = rig.now;
    rig.task(lead(Some(route(&rig, &[[100.0, 0.0, 0.0]]))));
    rig.run(8.0);
    assert!(rig.autopilot.velocity.norm() > 4.5);
    rig.task(lead(Some(route(&rig, &[[0.0, 60.0, 0.0]]))));
    rig.run(1.0);
    // Straight on, as an operator who adds a leg means it: it does not stop for that.
    rig.task(lead(Some(route(&rig, &[[60.0, 60.0, 0.0]]))));
    rig.run(10.0);
    rig.task(lead(None));
    rig.run(6.0);
    assert!(rig.autopilot.velocity.norm() < 0.1);
    rig.assert_no_jump_since(start);
}

#[test]
fn a_leader_told_the_same_route_again_flies_on() {
    let mut rig = Rig::holding(10.0);
    let start = rig.now;
    let way = route(&rig, &[[40.0, 0.0, 0.0], [40.0, 40.0, 0.0]]);
    let end = way.waypoints[1];
    rig.task(lead(Some(way.clone())));
    rig.run(11.0);
    let heading = FormationHeading::Course { max_rate_rad_s: 0.2 };
    rig.task(Task::Lead {
        route: Some(way),
        heading,
    });
    rig.run_until("at the end", 15.0, |rig| {
        rig.log.iter().any(|(_, e)| *e == Effect::RouteFinished)
    });
    assert!(rig.here().distance_m(&end) < 0.5);
    rig.assert_no_jump_since(start);
}

#[test]
fn a_fixed_heading_is_taken_at_once_at_first_and_turned_to_later() {
    let fixed = |heading_rad| Task::Lead {
        route: None,
        heading: FormationHeading::Fixed {
            heading_rad,
            max_rate_rad_s: None,
        },
    };
    let mut rig = Rig::holding(10.0);
    rig.task(fixed(1.0));
    assert!(anchors(&rig.tick()).iter().all(|a| (a.heading_rad - 1.0).abs() < 1e-9));
    rig.task(fixed(1.5));
    let effects = rig.tick();
    assert!(
        anchors(&effects).iter().all(|a| (a.heading_rad - 1.0).abs() < 0.01),
        "the formation hangs on it: {effects:?}"
    );
    rig.run(12.0);
    assert!(anchors(&rig.tick()).iter().all(|a| (a.heading_rad - 1.5).abs() < 0.01));
}

#[test]
fn a_route_that_cannot_be_flown_is_told_and_held() {
    let mut rig = Rig::holding(10.0);
    let bad = Route {
        waypoints: vec![],
        speed_m_s: 5.0,
        corner_radius_m: 8.0,
    };
    rig.task(lead(Some(bad)));
    rig.run(1.0);
    assert_eq!(rig.state, FlightState::Leading);
    assert!(
        rig.notices().iter().any(|text| text.contains("cannot be flown")),
        "{:?}",
        rig.notices()
    );
}

#[test]
fn a_follower_keeps_its_slot() {
    let mut rig = Rig::holding(10.0);
    let start = rig.now;
    let mut leader = Leader::ahead_of(&rig, 5.0);
    rig.task(follow(0.0));
    leader.run(&mut rig, 15.0);
    assert_eq!(rig.state, FlightState::Following);
    let slot = leader.anchor.position.moved([-5.0, 0.0, 0.0].into());
    assert!(
        rig.here().distance_m(&slot) < 0.2,
        "{} m off",
        rig.here().distance_m(&slot)
    );
    rig.assert_no_jump_since(start);
    let (_, last) = rig.setpoints().pop().expect("streams");
    assert!(
        (last.velocity.expect("has one").north_m_s - 5.0).abs() < 0.01,
        "feed-forward"
    );
}

#[test]
fn a_follower_far_from_its_slot_catches_up_without_haste() {
    let mut rig = Rig::holding(10.0);
    let start = rig.now;
    let mut leader = Leader::ahead_of(&rig, 3.0);
    rig.task(follow(40.0));
    leader.run(&mut rig, 60.0);
    let slot = leader.anchor.position.moved([-5.0, 40.0, 0.0].into());
    assert!(rig.here().distance_m(&slot) < 0.2);
    rig.assert_no_jump_since(start);
    let fastest = rig
        .setpoints()
        .iter()
        .filter_map(|(_, s)| s.velocity)
        .map(|v| v.norm())
        .fold(0.0, f64::max);
    // The formation's 3 m/s and four tenths of what they leave of 12 m/s.
    assert!(fastest < 6.7, "{fastest} m/s");
}

#[test]
fn without_an_anchor_a_follower_holds_and_says_so() {
    let mut rig = Rig::holding(10.0);
    let start = rig.now;
    let mut leader = Leader::ahead_of(&rig, 5.0);
    rig.task(follow(0.0));
    leader.run(&mut rig, 10.0);
    rig.run(6.0);
    assert!(rig.autopilot.velocity.norm() < 0.1 && rig.state == FlightState::Following);
    assert!(rig.detail.contains("holding"), "{}", rig.detail);
    assert_eq!(
        rig.notices().iter().filter(|text| text.contains("leader")).count(),
        1,
        "{:?}",
        rig.notices()
    );
    // It comes back, well ahead by now.
    leader.anchor.position.north_m += 30.0;
    leader.anchor.velocity = VelocityNed::default();
    leader.run(&mut rig, 30.0);
    assert!(rig.detail.is_empty());
    assert!(
        rig.here()
            .distance_m(&leader.anchor.position.moved([-5.0, 0.0, 0.0].into()))
            < 0.2
    );
    rig.assert_no_jump_since(start);
}

/// Another leads, who is so far off where its predecessor's slot had it; its anchor comes in the very batch of the change at first, from
/// before it.
fn led_by_another(off_m: [f64; 3]) {
    let mut rig = Rig::holding(10.0);
    let start = rig.now;
    let mut leader = Leader::ahead_of(&rig, 5.0);
    rig.task(follow(0.0));
    leader.run(&mut rig, 5.0);
    leader.anchor.position = leader.anchor.position.moved([0.0, 20.0, 0.0].into());
    leader.anchor.position = leader.anchor.position.moved(off_m.into());
    rig.task(Task::Follow {
        leader: Some(VehicleId(2)),
        slot: slot(-20.0),
    });
    leader.run(&mut rig, 5.0);
    rig.assert_no_jump_since(start);
    let expected = leader.anchor.position.moved([-5.0, 0.0, 0.0].into());
    let expected = expected.moved([0.0, -20.0, 0.0].into());
    let off_m = rig.here().distance_m(&expected);
    assert!(off_m < 0.3, "{off_m} m");
}

#[test]
fn a_slot_is_flown_only_with_an_anchor_of_its_own_time() {
    // The leader changes: the new slot belongs to the new leader's anchor, the old one to the old leader's.
    led_by_another([0.0, 0.0, 0.0]);
}

#[test]
fn a_successor_that_is_not_where_its_slot_was_moves_nobody_at_once() {
    led_by_another([-1.5, 0.8, 0.4]);
}

#[test]
fn a_follower_that_becomes_leader_keeps_the_formations_heading() {
    let mut rig = Rig::holding(10.0);
    let mut leader = Leader::ahead_of(&rig, 0.0);
    leader.anchor.heading_rad = 2.0;
    rig.task(follow(0.0));
    leader.run(&mut rig, 10.0);
    rig.autopilot.yaw_rad = 1.8; // It lags.
    rig.task(lead(None));
    assert!(anchors(&rig.tick()).iter().all(|a| (a.heading_rad - 2.0).abs() < 1e-9));
}

#[test]
fn an_operators_command_outranks_the_task_until_a_newer_one_comes() {
    let mut rig = Rig::holding(10.0);
    let mut leader = Leader::ahead_of(&rig, 0.0);
    rig.task(follow(0.0));
    leader.run(&mut rig, 1.0);
    assert_eq!(rig.state, FlightState::Following);
    let hold = rig.command(VehicleCommand::Hold);
    leader.run(&mut rig, 5.0);
    assert!(rig.is_done(hold) && rig.state == FlightState::Holding);
    let go = rig.command(VehicleCommand::GoTo {
        position: PositionNed::new(500.0, 0.0, -20.0),
        yaw_rad: None,
        speed_m_s: None,
    });
    leader.run(&mut rig, 1.0);
    rig.task(follow(3.0));
    leader.run(&mut rig, 1.0);
    assert_eq!(
        (rig.state, rig.refusal(go)),
        (FlightState::Following, Some(Refusal::Superseded))
    );
}

#[test]
fn only_a_newer_version_is_taken_up() {
    let mut rig = Rig::holding(10.0);
    rig.inbox.push(Event::Task(skein_domain::VehicleTask {
        version: 10,
        task: lead(None),
    }));
    rig.run(1.0);
    for version in [10, 9, 1] {
        rig.inbox.push(Event::Task(skein_domain::VehicleTask {
            version,
            task: Task::Hold,
        }));
        rig.run(0.5);
        assert_eq!(rig.state, FlightState::Leading);
    }
    rig.inbox.push(Event::Task(skein_domain::VehicleTask {
        version: 11,
        task: Task::Hold,
    }));
    rig.run(0.5);
    assert_eq!(rig.state, FlightState::Holding);
}

#[test]
fn a_task_that_comes_in_the_climb_is_taken_up_at_the_top() {
    let mut rig = Rig::idle();
    rig.task(lead(None)); // Older than the command: outranked.
    rig.tick();
    let id = rig.command(VehicleCommand::TakeOff { height_m: 6.0 });
    rig.run_until("taken off", 30.0, |rig| rig.is_done(id));
    rig.run(2.0);
    assert_eq!(rig.state, FlightState::Holding);

    let mut rig = Rig::idle();
    let id = rig.command(VehicleCommand::TakeOff { height_m: 6.0 });
    rig.run(1.0);
    rig.task(lead(None));
    rig.run_until("taken off", 30.0, |rig| rig.is_done(id));
    rig.run(0.1);
    assert_eq!(rig.state, FlightState::Leading);
}

#[test]
fn a_task_to_hold_ends_the_formation_but_no_command_to_hold() {
    let mut rig = Rig::holding(10.0);
    rig.task(lead(Some(route(&rig, &[[100.0, 0.0, 0.0]]))));
    rig.run(6.0);
    let start = rig.now;
    rig.task(Task::Hold);
    rig.run(1.0);
    assert_eq!(rig.state, FlightState::Holding);
    assert!(anchors(&rig.tick()).is_empty(), "who does not lead publishes no anchor");
    rig.run(5.0);
    rig.assert_no_jump_since(start);
    let hold = rig.command(VehicleCommand::Hold);
    rig.task(Task::Hold);
    rig.run(2.0);
    assert!(rig.is_done(hold));
}

#[test]
fn a_leader_that_is_not_heard_publishes_nothing() {
    let mut rig = Rig::holding(10.0);
    rig.task(lead(None));
    rig.run(1.0);
    rig.autopilot.link_connected = false;
    let effects = rig.tick();
    assert!(
        anchors(&effects).is_empty() && effects.iter().any(|e| matches!(e, Effect::Setpoint(_))),
        "{effects:?}"
    );
}

#[test]
fn the_anchor_of_a_leader_fallen_silent_is_carried_on_and_not_stopped() {
    let mut rig = Rig::holding(10.0);
    rig.task(lead(Some(route(&rig, &[[40.0, 0.0, 0.0]]))));
    rig.run(4.0);
    rig.autopilot.last_heard = rig.autopilot.own_state(rig.now).kinematics;
    let mut expected: Option<AnchorReference> = None;
    for _ in 0..60 {
        let anchor = *anchors(&rig.tick()).last().expect("an anchor");
        let here = anchor
            .position
            .after(&anchor.velocity, rig.now.seconds_since(anchor.time));
        if let Some(before) = expected {
            let there = before.position.after(&before.velocity, PERIOD_S);
            assert!(here.distance_m(&there) < 0.01, "{here:?} after {there:?}");
        }
        expected = Some(AnchorReference {
            position: here,
            ..anchor
        });
    }
}

#[test]
fn a_leader_held_back_by_the_gate_waits_and_goes_on() {
    let mut rig = Rig::holding(10.0);
    let way = route(&rig, &[[60.0, 0.0, 0.0]]);
    let end = way.waypoints[0];
    rig.task(lead(Some(way)));
    rig.run(5.0);
    rig.gate = Some(Refusal::TooClose {
        other: VehicleId(3),
        distance_m: 1.0,
        limit_m: 2.0,
    });
    rig.run(10.0);
    assert_eq!(rig.state, FlightState::Leading);
    assert!(
        rig.notices().iter().any(|text| text.contains("held back")),
        "{:?}",
        rig.notices()
    );
    rig.gate = None;
    let start = rig.now.plus_seconds(0.1);
    rig.run_until("at the end", 30.0, |rig| {
        rig.log.iter().any(|(_, e)| *e == Effect::RouteFinished)
    });
    assert!(rig.here().distance_m(&end) < 0.5);
    rig.assert_no_jump_since(start);
}

#[test]
fn numbers_that_are_not_finite_reach_no_setpoint() {
    let mut rig = Rig::holding(10.0);
    let mut leader = Leader::ahead_of(&rig, 1.0);
    rig.task(follow(0.0));
    leader.run(&mut rig, 1.0);
    for broken in [
        AnchorReference {
            position: PositionNed::new(f64::NAN, 0.0, 0.0),
            ..leader.anchor
        },
        AnchorReference {
            acceleration: AccelerationNed::new(0.0, f64::INFINITY, 0.0),
            ..leader.anchor
        },
        AnchorReference {
            heading_rad: f64::NAN,
            ..leader.anchor
        },
    ] {
        rig.anchor(AnchorReference {
            time: rig.now,
            ..broken
        });
        rig.tick();
    }
    let mut broken = slot(0.0);
    broken.to.forward_m = f64::NAN;
    rig.task(Task::Follow {
        leader: Some(VehicleId(1)),
        slot: broken,
    });
    leader.run(&mut rig, 1.0);
    assert!(rig.setpoints().iter().all(|(_, setpoint)| setpoint.is_well_formed()));
    // The reference functions are the ones flown elsewhere.
    assert!(follow::setpoint(&leader.anchor, &slot(0.0), rig.now).is_well_formed());
}

#[test]
fn followers_are_told_the_reference_of_a_leader_that_is_near_it_and_else_where_it_is() {
    let mut rig = Rig::holding(10.0);
    rig.task(lead(Some(route(&rig, &[[60.0, 0.0, 0.0], [60.0, 60.0, 0.0]]))));
    rig.run(4.0);
    let told = |rig: &mut Rig| {
        let anchor = *anchors(&rig.tick()).last().expect("an anchor");
        let (_, setpoint) = *rig.setpoints().last().expect("a setpoint");
        let at = setpoint.position.expect("has one");
        (
            anchor,
            anchor.position.distance_m(&at),
            anchor.position.distance_m(&rig.here()),
        )
    };
    let (before, off_reference_m, _) = told(&mut rig);
    assert!(off_reference_m < 1e-9, "{off_reference_m}");
    // Pushed off by more than it can be said to be at its reference: it fades, without a jump.
    rig.autopilot.position.y += 3.0;
    let mut last = before;
    for _ in 0..20 {
        let (anchor, ..) = told(&mut rig);
        let expected = last.position.after(&last.velocity, PERIOD_S);
        assert!(anchor.position.distance_m(&expected) < 0.2, "{anchor:?} after {last:?}");
        last = anchor;
    }
    // Held back by the gate it is told where it is.
    rig.gate = Some(Refusal::TooFast {
        speed_m_s: 9.0,
        limit_m_s: 8.0,
    });
    rig.run(2.5);
    let (_, _, off_measured_m) = told(&mut rig);
    assert!(off_measured_m < 0.05, "{off_measured_m}");
}
