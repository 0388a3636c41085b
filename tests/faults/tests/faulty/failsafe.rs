//! The failsafe policy in flight: each trigger is brought about in the simulator, and what the node then does is told by its events and
//! seen in the truth. No step comes before the time that deploy/docs/src/failsafe-policy.md gives it; that none comes late is judged in simulated time, for
//! every row of the table (core/safety, `every_row_reacts_at_its_time`).

use skein_domain::failsafe::{FailsafeStep, TriggerMode};
use skein_domain::fence::{AltitudeReference, BreachAction, FencePlan, FenceZone, ZoneKind, ZoneOutline};
use skein_domain::{
    FailsafeEvent, FailsafeEventKind, FlightMode, FlightState, FormationRequest, PositionNed, Reaction, Shape, Trigger,
    VehicleCommand, VehicleId,
};
use skein_runtime::{Fault as NodeFault, NodeHandle, Targets};
use skein_sim::{Fault, Receiver};
use skein_testkit::Swarm;
use skein_view::EventKind;
use std::time::Duration;

fn failsafe_events(node: &NodeHandle, vehicle: u16) -> Vec<FailsafeEvent> {
    node.events_after(0)
        .iter()
        .filter(|e| e.vehicle == Some(VehicleId(vehicle)))
        .filter_map(|e| match &e.kind {
            EventKind::Failsafe { event } => Some(event.clone()),
            _ => None,
        })
        .collect()
}

/// Waits for a reaction to a trigger, and tells how long after the trigger's beginning it was ordered.
async fn ordered(swarm: &Swarm, vehicle: u16, trigger: Trigger, reaction: Reaction, within: Duration) -> f64 {
    let node = swarm.node();
    let fits =
        |e: &FailsafeEvent| e.kind == FailsafeEventKind::Ordered && e.trigger == trigger && e.reaction == reaction;
    let what = format!("{reaction} of vehicle {vehicle} because of {trigger}");
    swarm
        .until(&what, within, |_| failsafe_events(&node, vehicle).iter().any(fits))
        .await;
    let found = failsafe_events(&node, vehicle).into_iter().find(|e| fits(e));
    let found = found.expect("was there just now");
    found.at.seconds_since(found.since)
}

/// The step did not come before its time.
fn not_early(trigger: Trigger, reacted_s: f64, step_s: f64) {
    println!("{trigger}: {reacted_s:.2} s after it began (step at {step_s} s)");
    assert!(
        reacted_s > step_s - 0.1,
        "{trigger}: ordered after {reacted_s:.2} s, the step is at {step_s} s"
    );
}

async fn flies(swarm: &Swarm, vehicle: u16, what: &str, seen: impl Fn(FlightState, FlightMode) -> bool) {
    swarm
        .until(what, Duration::from_secs(20), |fleet| {
            let found = fleet.vehicles.iter().find(|v| v.id == VehicleId(vehicle));
            found.is_some_and(|v| seen(v.flight_state, v.mode) || !v.armed)
        })
        .await;
}

fn holds(state: FlightState, mode: FlightMode) -> bool {
    matches!(state, FlightState::Holding) || matches!(mode, FlightMode::Hold | FlightMode::Descend)
}

#[tokio::test(flavor = "multi_thread")]
async fn faults_of_vehicles_are_answered_step_by_step_and_not_early() {
    let swarm = Swarm::start_with(7, |_, sim| {
        sim.second_gnss = true;
        sim.spacing_m = 8.0;
    })
    .await;
    swarm.take_off(6.0).await;
    let inflict = |id: u8, fault: Fault| swarm.simulation().inflict(id, fault).expect("is simulated");
    let lost = Fault::GnssLost {
        receiver: Receiver::All,
        lost: true,
    };
    let away = Fault::GnssOffset {
        receiver: Receiver::Second,
        offset_m: nalgebra::Vector3::new(9.0, 0.0, 0.0),
    };
    for (id, fault) in [
        (1, lost),
        (2, away),
        (3, Fault::EstimateStopped(true)),
        (4, Fault::ClockStep(0.6)),
        (5, Fault::Silent(true)),
        (6, Fault::BatteryCharge(0.05)),
    ] {
        inflict(id, fault);
    }
    let within = Duration::from_secs(15);
    let expected = [
        (1, Trigger::GnssLoss, Reaction::Hold, 3.0),
        (2, Trigger::GnssDisagreement, Reaction::Hold, 2.0),
        (3, Trigger::StaleEstimate, Reaction::Hold, 0.5),
        (4, Trigger::ClockFault, Reaction::Hold, 0.5),
        (5, Trigger::LinkLoss, Reaction::Release, 5.0),
        (6, Trigger::Energy, Reaction::Land, 1.0),
    ];
    for (id, trigger, reaction, step_s) in expected {
        not_early(trigger, ordered(&swarm, id, trigger, reaction, within).await, step_s);
    }
    // What was ordered is seen: a hold, a stream that has ended, a landing.
    flies(&swarm, 1, "the one without satellites holds or is brought down", holds).await;
    flies(&swarm, 2, "the one in disagreement holds", holds).await;
    flies(&swarm, 6, "the empty one lands", |state, mode| {
        state == FlightState::Landing || mode == FlightMode::Land
    })
    .await;
    swarm
        .until(
            "the one without an estimate is left to its autopilot",
            within,
            |fleet| {
                let three = fleet.vehicles.iter().find(|v| v.id == VehicleId(3));
                three.is_some_and(|v| v.mode != FlightMode::Offboard)
            },
        )
        .await;
    // Nobody is touched who has nothing.
    assert_eq!(failsafe_events(&swarm.node(), 7), []);
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn one_that_does_not_go_where_it_is_told_holds() {
    let swarm = Swarm::start_with(1, |_, sim| sim.wind.mean_north_m_s = 3.0).await;
    swarm.take_off(6.0).await;
    swarm.simulation().inflict(1, Fault::Stuck(true)).expect("is simulated");
    let reacted_s = ordered(
        &swarm,
        1,
        Trigger::TrackingError,
        Reaction::Hold,
        Duration::from_secs(40),
    )
    .await;
    not_early(Trigger::TrackingError, reacted_s, 3.0);
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn whoever_is_suddenly_outside_of_a_fence_does_what_the_fence_says() {
    let swarm = Swarm::start_with(2, |_, sim| sim.spacing_m = 20.0).await;
    let fleet = swarm.take_off(6.0).await;
    let at = fleet.vehicles[1].kinematics.expect("is placed").position;
    let zone = |name: &str, kind, centre_m, radius_m, action| FenceZone {
        name: name.into(),
        kind,
        outline: ZoneOutline::LocalCircle { centre_m, radius_m },
        floor_m: None,
        ceiling_m: None,
        altitude_reference: AltitudeReference::Origin,
        action,
    };
    let plan = FencePlan {
        zones: vec![
            zone("field", ZoneKind::Inclusion, [0.0, 0.0], 200.0, BreachAction::Hold),
            zone(
                "closed",
                ZoneKind::Exclusion,
                [at.north_m, at.east_m],
                4.0,
                BreachAction::Land,
            ),
        ],
        breach_return: None,
    };
    let answer = swarm.node().set_fences(plan).await.expect("can be placed");
    assert_eq!(answer.outside, [VehicleId(2)]);
    let within = Duration::from_secs(15);
    let reacted_s = ordered(&swarm, 2, Trigger::FenceBreach, Reaction::Land, within).await;
    not_early(Trigger::FenceBreach, reacted_s, 0.2);
    flies(&swarm, 2, "it lands", |state, mode| {
        state == FlightState::Landing || mode == FlightMode::Land
    })
    .await;
    assert_eq!(failsafe_events(&swarm.node(), 1), []);
    // A goal in there is refused with the zone's name, one behind it is flown to around it.
    let go_to = |north_m: f64, east_m: f64| VehicleCommand::GoTo {
        position: PositionNed::new(north_m, east_m, at.down_m),
        yaw_rad: None,
        speed_m_s: None,
    };
    let one = Targets::Vehicles(vec![VehicleId(1)]);
    let refused = swarm.node().command(&one, go_to(at.north_m, at.east_m)).await;
    let why = refused[0].refusal.as_ref().expect("is refused").to_string();
    assert!(why.contains("closed"), "{why}");
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn without_coordinator_or_operator_the_members_hold_after_their_time() {
    let swarm = Swarm::start_with(3, |config, _| {
        let failsafe = &mut config.safety.failsafe;
        failsafe.coordinator_loss.steps = vec![step(1.0, Reaction::Warn), step(2.0, Reaction::Hold)];
        failsafe.operator_dead_man.mode = TriggerMode::React;
        failsafe.operator_dead_man.steps = vec![step(1.0, Reaction::Warn), step(3.0, Reaction::Return)];
    })
    .await;
    let alive = {
        let node = swarm.node();
        tokio::spawn(async move {
            loop {
                node.hear_operator();
                tokio::time::sleep(Duration::from_millis(200)).await;
            }
        })
    };
    swarm.take_off(6.0).await;
    swarm
        .node()
        .set_formation(FormationRequest::new(Shape::Line, 5.0))
        .await
        .expect("is flown");
    swarm
        .until("all fly in it", Duration::from_secs(10), |fleet| {
            let followers = fleet
                .vehicles
                .iter()
                .filter(|v| v.flight_state == FlightState::Following);
            followers.count() == 2
        })
        .await;
    let away = NodeFault::CoordinatorAway { away: true };
    swarm.node().inject_fault(away).await.expect("is permitted");
    let within = Duration::from_secs(15);
    for id in 1..=3 {
        let reacted_s = ordered(&swarm, id, Trigger::CoordinatorLoss, Reaction::Hold, within).await;
        not_early(Trigger::CoordinatorLoss, reacted_s, 2.0);
    }
    let back = NodeFault::CoordinatorAway { away: false };
    swarm.node().inject_fault(back).await.expect("is permitted");
    alive.abort();
    for id in 1..=3 {
        let reacted_s = ordered(&swarm, id, Trigger::OperatorDeadMan, Reaction::Return, within).await;
        not_early(Trigger::OperatorDeadMan, reacted_s, 3.0);
    }
    flies(&swarm, 2, "they return", |state, _| state == FlightState::Returning).await;
    swarm.stop().await;
}

fn step(after_s: f64, reaction: Reaction) -> FailsafeStep {
    FailsafeStep { after_s, reaction }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_landing_is_finished_whatever_the_clock_does() {
    let swarm = Swarm::start(2).await;
    swarm.take_off(8.0).await;
    let receipts = swarm.node().command(&Targets::All, VehicleCommand::Land).await;
    assert!(receipts.iter().all(|receipt| receipt.refusal.is_none()), "{receipts:?}");
    for id in [1, 2] {
        let fault = Fault::ClockStep(0.6);
        swarm.simulation().inflict(id, fault).expect("is simulated");
    }
    swarm
        .until("both landed", Duration::from_secs(30), |fleet| {
            fleet
                .vehicles
                .iter()
                .all(|v| !v.armed && v.flight_state == FlightState::Idle)
        })
        .await;
    for id in [1, 2] {
        let events = failsafe_events(&swarm.node(), id);
        let only_told = |e: &&FailsafeEvent| e.trigger == Trigger::ClockFault && e.reaction == Reaction::Hold;
        assert!(events.iter().any(|e| only_told(&e)), "it was noticed: {events:?}");
        let ordered: Vec<_> = events.iter().filter(|e| e.kind == FailsafeEventKind::Ordered).collect();
        assert!(ordered.is_empty(), "{ordered:?}");
    }
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_emergency_stop_takes_two_steps_and_stops_motors_in_flight() {
    let swarm = Swarm::start(2).await;
    swarm.take_off(6.0).await;
    let node = swarm.node();
    let both = Targets::Vehicles(vec![VehicleId(1)]);
    assert!(
        node.emergency_stop("00000000", &both).await.is_err(),
        "without the first step"
    );
    let unlocked = node.unlock_emergency_stop();
    let receipts = node.emergency_stop(&unlocked.key, &both).await.expect("is unlocked");
    assert!(receipts.iter().all(|r| r.refusal.is_none()));
    swarm
        .until("its motors stand still", Duration::from_secs(10), |fleet| {
            let one = fleet.vehicles.iter().find(|v| v.id == VehicleId(1));
            one.is_some_and(|v| !v.armed && v.stopped)
        })
        .await;
    let truth = swarm.truth_now().await;
    assert!(!truth.vehicle(1).expect("is simulated").armed);
    assert!(
        truth.vehicle(2).expect("is simulated").height_m > 4.0,
        "the other flies on"
    );
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "long: part of `cargo xtask test faults`"]
async fn several_return_at_heights_of_their_own_and_land_at_home() {
    let swarm = Swarm::start(4).await;
    swarm.take_off(6.0).await;
    let fleet = swarm.node().snapshot();
    for vehicle in &fleet.vehicles {
        let place = vehicle.kinematics.expect("is placed").position;
        let command = VehicleCommand::GoTo {
            position: PositionNed::new(place.north_m + 90.0, place.east_m, place.down_m),
            yaw_rad: None,
            speed_m_s: Some(8.0),
        };
        let one = Targets::Vehicles(vec![vehicle.id]);
        assert_eq!(swarm.node().command(&one, command).await[0].refusal, None);
    }
    swarm
        .until("all out there", Duration::from_secs(30), |fleet| {
            let out = |v: &skein_view::VehicleSnapshot| v.kinematics.is_some_and(|k| k.position.north_m > 80.0);
            fleet
                .vehicles
                .iter()
                .all(|v| v.flight_state == FlightState::Holding && out(v))
        })
        .await;
    swarm.command_all(VehicleCommand::Return).await;
    let heights = |fleet: &skein_view::FleetSnapshot| -> Vec<f64> {
        let places = fleet.vehicles.iter().filter_map(|v| v.kinematics);
        let mut heights: Vec<f64> = places.map(|k| -k.position.down_m).collect();
        heights.sort_by(f64::total_cmp);
        heights
    };
    swarm
        .until("all at heights of their own", Duration::from_secs(40), |fleet| {
            let apart = heights(fleet).windows(2).all(|pair| pair[1] - pair[0] > 3.0);
            apart && fleet.vehicles.iter().all(|v| v.flight_state == FlightState::Returning)
        })
        .await;
    let smallest = std::cell::Cell::new(f64::INFINITY);
    swarm
        .until("all landed", Duration::from_secs(90), |fleet| {
            if let Some(distance_m) = swarm.simulation().truth().smallest_distance_m() {
                smallest.set(smallest.get().min(distance_m));
            }
            fleet.vehicles.iter().all(|v| !v.armed)
        })
        .await;
    assert!(smallest.get() >= 2.0, "they came within {:.2} m", smallest.get());
    swarm.stop().await;
}
