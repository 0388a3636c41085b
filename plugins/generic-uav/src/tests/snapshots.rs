//! Restarts: a restored instance goes on as if nothing had happened.

use super::autopilot::PERIOD_S;
use super::keeping::{keep_beside, peer, trajectory_from};
use super::rig::{Rig, create, setpoints_of};
use super::tasks::{COURSE, lead, slot};
use proptest::prelude::*;
use skein_domain::exchange::{Effect, Event, EventBatch};
use skein_domain::{
    AnchorReference, FlightState, PositionNed, Route, Stick, Task, VehicleCommand, VehicleId, VelocityNed,
};
use skein_plugin_sdk::{Effects, UavModel};

/// A whole flight with everything in it, as the batches that the model was given and the effects it answered with.
fn flight() -> (Vec<EventBatch>, Vec<Vec<Effect>>) {
    let mut rig = Rig::idle();
    rig.command(VehicleCommand::TakeOff { height_m: 6.0 });
    rig.run_until("taken off", 30.0, |rig| rig.state == FlightState::Holding);
    let far = PositionNed::new(40.0, 0.0, -10.0);
    let go = rig.command(VehicleCommand::GoTo {
        position: far,
        yaw_rad: Some(0.3),
        speed_m_s: None,
    });
    rig.run(3.0);
    rig.gate = Some(skein_domain::Refusal::TooFast {
        speed_m_s: 9.0,
        limit_m_s: 8.0,
    });
    rig.run(0.6);
    rig.gate = None;
    rig.run_until("there", 60.0, |rig| rig.is_done(go));
    let waypoints = vec![far.moved([20.0, 0.0, 0.0].into()), far.moved([20.0, 20.0, -2.0].into())];
    rig.task(lead(Some(Route {
        waypoints: waypoints.clone(),
        speed_m_s: 5.0,
        corner_radius_m: 6.0,
    })));
    rig.run(5.0);
    let heading = COURSE;
    let other = Route {
        waypoints: waypoints.into_iter().rev().collect(),
        speed_m_s: 4.0,
        corner_radius_m: 6.0,
    };
    rig.task(Task::Lead {
        route: Some(other),
        heading,
    });
    rig.run(6.0);
    rig.task(Task::Follow {
        leader: Some(VehicleId(1)),
        slot: slot(4.0),
    });
    let mut anchor = AnchorReference {
        position: rig.here().moved([8.0, 0.0, 0.0].into()),
        velocity: VelocityNed::new(2.0, 1.0, 0.0),
        heading_rad: 0.3,
        heading_rate_rad_s: 0.1,
        ..Default::default()
    };
    for _ in 0..200 {
        anchor.time = rig.now;
        rig.anchor(anchor);
        rig.tick();
        anchor.position = anchor.position.after(&anchor.velocity, PERIOD_S);
    }
    rig.run(2.0); // The leader is lost.
    among_neighbours_and_along_a_trajectory(&mut rig);
    by_hand(&mut rig);
    end_of_flight(&mut rig);

    // What it answered, batch by batch, from a straight run over what it was given.
    let mut model = create(None, 1, rig.given[0].now);
    let answers = rig.given.iter().map(|batch| answer(&mut model, batch)).collect();
    (rig.given, answers)
}

fn among_neighbours_and_along_a_trajectory(rig: &mut Rig) {
    rig.task(keep_beside(rig.now));
    let beside = rig.here().moved([0.0, 8.0, 0.0].into());
    for _ in 0..150 {
        rig.inbox.push(peer(beside, VelocityNed::default(), rig.now));
        rig.tick();
    }
    let task = trajectory_from(rig, [[15.0, 0.0, 0.0], [15.0, 10.0, 0.0]], 0.3);
    rig.task(task);
    for _ in 0..30 {
        rig.inbox.push(peer(beside, VelocityNed::default(), rig.now));
        rig.tick();
    }
    rig.run(5.0);
}

/// By hand, with a stick in every period, and then let go.
fn by_hand(rig: &mut Rig) {
    rig.command(VehicleCommand::Steer);
    for _ in 0..150 {
        rig.inbox.push(Event::Stick(Stick {
            forward_m_s: 3.0,
            up_m_s: 0.5,
            yaw_rate_rad_s: 0.3,
            ..Stick::default()
        }));
        rig.tick();
    }
    // The last says to stand: what a stick said is not saved.
    rig.inbox.push(Event::Stick(Stick::default()));
    rig.run(12.0);
}

/// A hold, a pilot, the way home, and a second take-off.
fn end_of_flight(rig: &mut Rig) {
    rig.command(VehicleCommand::Hold);
    rig.run(2.0);
    rig.autopilot.change_mode(skein_domain::FlightMode::Position, false);
    rig.run(1.0);
    rig.command(VehicleCommand::Return);
    rig.run_until("home", 90.0, |rig| {
        rig.state == FlightState::Idle && !rig.autopilot.armed
    });
    let begin = rig.now.plus_seconds(1.0);
    rig.command_at(VehicleCommand::TakeOff { height_m: 3.0 }, begin);
    rig.run(10.0);
}

fn answer(model: &mut impl UavModel, batch: &EventBatch) -> Vec<Effect> {
    let mut effects = Effects::default();
    model.handle(batch.now, &batch.events, &mut effects);
    let mut answers = effects.take();
    // Every new instance says them first.
    answers.retain(|effect| !matches!(effect, Effect::Limits(_)));
    answers
}

#[test]
fn a_restored_instance_gives_the_same_effects_from_any_moment_on() {
    let (given, answers) = flight();
    assert!(given.len() > 3000);
    // From every 37th moment (a prime, so that all phases of everything periodic are met) for four seconds on.
    let mut model = create(None, 1, given[0].now);
    for (at, batch) in given.iter().enumerate() {
        if at % 37 == 0 {
            let snapshot = model.snapshot();
            let mut restored = create(Some(snapshot.clone()), 2, batch.now);
            assert_eq!(restored.snapshot(), snapshot, "at {at}: nothing is lost or added");
            for later in at..given.len().min(at + 200) {
                let got = answer(&mut restored, &given[later]);
                assert_eq!(
                    got,
                    answers[later],
                    "restored at {at}, batch {later} of {}",
                    given.len()
                );
            }
        }
        assert_eq!(answer(&mut model, batch), answers[at]);
    }
}

#[test]
fn the_snapshot_is_small() {
    let (given, _) = flight();
    let mut model = create(None, 1, given[0].now);
    let mut largest = 0;
    for batch in &given {
        answer(&mut model, batch);
        largest = largest.max(model.snapshot().len());
    }
    assert!(largest < 1500, "{largest} bytes");
}

#[test]
fn a_restart_in_flight_goes_on_without_a_jump() {
    // A second of nothing: the link stops the vehicle meanwhile.
    for pause_s in [0.1, 0.2, 0.3, 1.0] {
        let mut rig = Rig::holding(10.0);
        let to = PositionNed::new(80.0, -20.0, -11.5);
        let id = rig.command(VehicleCommand::GoTo {
            position: to,
            yaw_rad: None,
            speed_m_s: None,
        });
        rig.run(6.0);
        let snapshot = rig.model.snapshot();
        let here = rig.here();
        for _ in 0..(pause_s / PERIOD_S) as u32 {
            rig.now = rig.now.plus_seconds(PERIOD_S);
            rig.autopilot.stream(skein_domain::Setpoint::hold(here, None));
            rig.autopilot.step();
        }
        rig.model = create(Some(snapshot), 2, rig.now);
        let restarted = rig.now.plus_seconds(PERIOD_S / 2.0);
        let effects = rig.tick();
        let first = setpoints_of(&effects.into_iter().map(|e| (rig.now, e)).collect::<Vec<_>>());
        assert_eq!(first.len(), 1, "the first tick gives a setpoint");
        let off_m = first[0].1.position.expect("has one").distance_m(&rig.here());
        assert!(off_m < 1.6, "after {pause_s} s the first setpoint is {off_m} m away");
        assert_eq!(rig.state, FlightState::GoingTo);
        rig.run_until("there", 60.0, |rig| rig.is_done(id));
        rig.assert_no_jump_since(restarted);
    }
}

#[test]
fn a_snapshot_of_another_version_starts_from_what_the_vehicle_does() {
    let mut rig = Rig::holding(10.0);
    rig.command(VehicleCommand::GoTo {
        position: PositionNed::new(80.0, 0.0, -12.0),
        yaw_rad: None,
        speed_m_s: None,
    });
    rig.run(4.0);
    let mut snapshot = rig.model.snapshot();
    assert_eq!(snapshot[1], 1, "the version");
    snapshot[1] = 9;
    rig.model = create(Some(snapshot), 2, rig.now);
    let start = rig.now.plus_seconds(PERIOD_S / 2.0);
    rig.run(5.0);
    assert_eq!(rig.state, FlightState::Holding);
    assert!(rig.autopilot.velocity.norm() < 0.1);
    rig.assert_no_jump_since(start);
    // Requests of the new incarnation are not mistaken for the old one's.
    rig.command(VehicleCommand::Land);
    rig.run(0.1);
    let request = rig.log.iter().rev().find_map(|(_, e)| match e {
        Effect::Autopilot { request, .. } => Some(request.0),
        _ => None,
    });
    assert_eq!(request, Some(2 << 16));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn garbage_is_no_snapshot_and_no_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..300),
        damage in any::<(prop::sample::Index, u8)>(),
        damaged in any::<bool>(),
    ) {
        let mut rig = Rig::holding(5.0);
        let mut snapshot = rig.model.snapshot();
        if damaged {
            let at = damage.0.index(snapshot.len());
            snapshot[at] = damage.1;
        } else {
            snapshot = bytes;
        }
        rig.model = create(Some(snapshot), 2, rig.now);
        rig.run(1.0);
        prop_assert!(rig.setpoints().iter().all(|(_, setpoint)| setpoint.is_well_formed()));
        if !damaged {
            prop_assert_eq!(rig.state, FlightState::Holding);
        }
    }
}

#[test]
fn events_of_a_drill_are_not_the_models() {
    let mut rig = Rig::holding(5.0);
    rig.inbox
        .push(Event::FaultDrill(skein_domain::exchange::FaultDrill::Panic));
    rig.run(0.1);
    assert_eq!(rig.state, FlightState::Holding);
}
