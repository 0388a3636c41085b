//! A swarm whose autopilots are as PX4's software in the loop has them: its clock runs slow, its battery is half empty at once, what stands says
//! that it does not move. It is flown as any other; and what is let pass there is found of a vehicle that does not say that it is simulated.

use skein_domain::{FlightState, FormationRequest, Shape};
use skein_sim::SimSettings;
use skein_testkit::{Swarm, eventually, patience};
use std::time::Duration;

/// The battery falls three times as fast as PX4's: so the flight need not be long.
const FALLS_WITHIN_S: f64 = 20.0;
/// A clock at 0.98 of ours is off by more than the permitted 0.1 s after 5 s, and a battery that fell as fast as this one has no way home in it:
/// whoever holds or calls home does so by then.
const FLIGHT_S: f64 = 14.0;

fn software_in_the_loop(settings: &mut SimSettings) {
    *settings = settings.clone().as_software_in_the_loop();
    settings.battery.endurance_s = FALLS_WITHIN_S;
}

#[tokio::test(flavor = "multi_thread")]
async fn it_is_flown_as_any_other() {
    let swarm = Swarm::start_with(3, |_, settings| software_in_the_loop(settings)).await;
    swarm.take_off(6.0).await;
    let request = FormationRequest::new(Shape::Line, 5.0);
    swarm.node().set_formation(request).await.expect("is flown");
    let began_s = swarm.simulation().truth().time_s;
    let flown_s = || swarm.simulation().truth().time_s - began_s;
    let fleet = swarm
        .until("the flight goes on", Duration::from_secs(30), |fleet| {
            for vehicle in &fleet.vehicles {
                let failsafe = vehicle.failsafe.as_ref();
                let calm = failsafe.is_none_or(|failsafe| failsafe.order.is_none());
                assert!(
                    calm,
                    "{} after {:.1} s: {failsafe:?}, {:?}",
                    vehicle.name,
                    flown_s(),
                    vehicle.battery
                );
                let flies = matches!(
                    vehicle.flight_state,
                    FlightState::Holding | FlightState::Leading | FlightState::Following | FlightState::GoingTo
                );
                assert!(flies, "{}: {:?}", vehicle.name, vehicle.flight_state);
            }
            flown_s() > FLIGHT_S
        })
        .await;
    for vehicle in &fleet.vehicles {
        let left = vehicle.battery.remaining.expect("is told");
        assert!(
            (left - 0.5).abs() < 0.02,
            "{}: the battery stops at a half, {left}",
            vehicle.name
        );
    }
    swarm.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn hardware_with_such_a_clock_does_not_take_off() {
    let swarm = Swarm::start_with(1, |_, settings| {
        software_in_the_loop(settings);
        settings.says_simulated = false;
    })
    .await;
    let node = swarm.node();
    let value = eventually(
        patience() + Duration::from_secs(15),
        "the clock's alarm before arming",
        async || {
            let report = node.preflight();
            let items = report.vehicles.iter().flat_map(|vehicle| vehicle.blocking());
            items
                .filter(|item| item.id == "alarms")
                .map(|item| item.value.clone())
                .find(|value| value.contains("clock"))
        },
    )
    .await;
    assert!(value.contains("clock"), "{value}");
    swarm.stop().await;
}
