//! The drag: learnt while the vehicle flies, told with its setpoints, and no part of what others are told.

use super::autopilot::PERIOD_S;
use super::rig::Rig;
use super::tasks::lead;
use skein_domain::exchange::{Effect, Event, OwnState};
use skein_domain::{AnchorReference, LandedState, Route};
use skein_flight::drag::DRAG_AT_FIRST_PER_S;

/// Flies a route while its attitude is that of a vehicle with this drag; what it said in each period.
fn fly_route(rig: &mut Rig, drag_per_s: f64, landed: LandedState) -> Vec<Vec<Effect>> {
    let begin = rig.here();
    let corners = [[30.0, 0.0, 0.0], [30.0, 30.0, 0.0], [0.0, 30.0, 0.0], [0.0, 0.0, 0.0]];
    rig.task(lead(Some(Route {
        waypoints: corners.iter().map(|corner| begin.moved((*corner).into())).collect(),
        speed_m_s: 5.0,
        corner_radius_m: 4.0,
    })));
    let mut before = rig.autopilot.velocity;
    let mut effects = Vec::new();
    for _ in 0..(25.0 / PERIOD_S) as u32 {
        let velocity = rig.autopilot.velocity;
        let pull = (velocity - before) / PERIOD_S + velocity * drag_per_s;
        before = velocity;
        let (sin, cos) = rig.autopilot.yaw_rad.sin_cos();
        let level = 1.0 / 9.806_65;
        let (forward, right) = (
            (pull.x * cos + pull.y * sin) * level,
            (pull.y * cos - pull.x * sin) * level,
        );
        let own = OwnState {
            landed,
            pitch_rad: Some((-forward).atan()),
            roll_rad: Some((right * (-forward).atan().cos()).atan()),
            ..rig.autopilot.own_state(rig.now.plus_seconds(PERIOD_S))
        };
        rig.inbox.push(Event::Own(own));
        effects.push(rig.tick());
    }
    effects
}

fn last_drag_per_s(rig: &Rig) -> Option<f64> {
    rig.setpoints().last().and_then(|(_, setpoint)| setpoint.drag_per_s)
}

#[test]
fn it_is_learnt_in_flight_and_told_with_the_setpoints() {
    let mut rig = Rig::holding(10.0);
    assert_eq!(last_drag_per_s(&rig), Some(DRAG_AT_FIRST_PER_S));
    fly_route(&mut rig, 0.8, LandedState::InAir);
    let learnt = last_drag_per_s(&rig).unwrap();
    assert!((learnt - 0.8).abs() < 0.08, "{learnt}");
    // It is known when the next flight begins, too.
    assert_eq!(rig.model.flight.drag.drag_per_s(), learnt);
}

#[test]
fn it_is_not_learnt_from_a_vehicle_that_may_touch_the_ground() {
    let mut rig = Rig::holding(10.0);
    fly_route(&mut rig, 0.8, LandedState::Landing);
    assert_eq!(last_drag_per_s(&rig), Some(DRAG_AT_FIRST_PER_S));
}

#[test]
fn the_acceleration_itself_is_how_the_setpoint_moves() {
    let mut rig = Rig::holding(10.0);
    let begun = rig.now.plus_seconds(0.1);
    let effects = fly_route(&mut rig, 0.8, LandedState::InAir);
    let mut anchors = 0;
    for effect in effects.iter().flatten() {
        // A route of 2 m/s² and its corners of 4 m at 5 m/s, and the blend from the hold.
        if let Effect::Anchor(AnchorReference { acceleration, .. }) = effect {
            anchors += 1;
            assert!(acceleration.norm() < 7.0, "{acceleration:?}");
        }
    }
    assert!(anchors > 1000);
    let route: Vec<_> = rig.setpoints().into_iter().filter(|(time, _)| *time > begun).collect();
    for pair in route.windows(2) {
        let ((_, before), (_, after)) = (pair[0], pair[1]);
        let change = (after.velocity.unwrap().vector() - before.velocity.unwrap().vector()) / PERIOD_S;
        let told = (after.acceleration.unwrap().vector() + before.acceleration.unwrap().vector()) * 0.5;
        // Half of what a corner begins with; the drag at this speed takes more.
        assert!((change - told).norm() < 3.5, "{change:?} {told:?}");
    }
}

#[test]
fn a_leader_tells_how_its_formations_turning_changes() {
    let mut rig = Rig::holding(10.0);
    let anchors: Vec<AnchorReference> = fly_route(&mut rig, 0.3, LandedState::InAir)
        .into_iter()
        .flatten()
        .filter_map(|effect| match effect {
            Effect::Anchor(anchor) => Some(anchor),
            _ => None,
        })
        .collect();
    let mut turned = 0;
    for pair in anchors.windows(2) {
        let change = (pair[1].heading_rate_rad_s - pair[0].heading_rate_rad_s) / PERIOD_S;
        assert!((pair[1].heading_acceleration_rad_s2 - change).abs() < 1e-6, "{pair:?}");
        turned += u32::from(change != 0.0);
    }
    assert!(turned > 100, "{turned}");
}
