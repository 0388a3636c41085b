//! What a vehicle's telemetry makes of its health.

use super::*;
use skein_domain::fence::BreachAction;
use skein_domain::telemetry::EstimatorHealth;
use skein_domain::{Geodetic, LandedState, LinkHealth, LocalPositionNed, Telemetry};

fn now() -> NodeTime {
    NodeTime::from_seconds(START_S)
}

fn flying() -> (Telemetry, LinkHealth) {
    let mut telemetry = Telemetry {
        mode: FlightMode::Offboard,
        armed: true,
        landed: LandedState::InAir,
        local: Some(LocalPositionNed::default()),
        position_time: now().plus_seconds(-0.03),
        home: Some(Geodetic::default()),
        ..Telemetry::default()
    };
    telemetry.gnss.fix = GnssFix::ThreeD;
    telemetry.gnss.satellites = 11;
    telemetry.heard.gnss = now().plus_seconds(-0.1);
    let link = LinkHealth {
        connected: true,
        last_heard: now(),
        setpoint_rate_hz: 50.0,
        clock_offset_s: Some(3.0),
        ..LinkHealth::default()
    };
    (telemetry, link)
}

fn health(change: impl FnOnce(&mut Telemetry)) -> Health {
    let (mut telemetry, link) = flying();
    change(&mut telemetry);
    Health::observed(&telemetry, &link, now())
}

#[test]
fn a_flying_vehicle_is_healthy() {
    let health = health(|_| ());
    assert!(health.airborne && health.connected && health.streaming && health.holds_position && health.home_known);
    assert!(!health.pilot_in_control);
    assert_eq!(health.position_time, Some(now().plus_seconds(-0.03)));
    assert_eq!(health.gnss.map(|g| g.heard), Some(now().plus_seconds(-0.1)));
    let mut failsafe = FailsafePolicy::new();
    assert_eq!(failsafe.step(now(), &health, &FailsafeSettings::default()), []);
}

#[test]
fn what_is_not_known_to_stand_is_taken_to_fly() {
    assert!(!health(|t| t.landed = LandedState::OnGround).airborne);
    assert!(health(|t| t.landed = LandedState::Unknown).airborne);
    assert!(
        !health(|t| {
            t.landed = LandedState::Unknown;
            t.armed = false;
        })
        .airborne
    );
}

#[test]
fn modes_of_sticks_are_a_pilots() {
    for mode in FlightMode::ALL {
        let of_sticks = matches!(
            mode,
            FlightMode::Manual
                | FlightMode::Altitude
                | FlightMode::Position
                | FlightMode::Acro
                | FlightMode::Stabilized
        );
        assert_eq!(health(|t| t.mode = *mode).pilot_in_control, of_sticks, "{mode}");
    }
}

#[test]
fn who_does_not_know_where_he_is_holds_no_position() {
    let with = |flags| {
        move |t: &mut Telemetry| {
            t.estimator = Some(EstimatorHealth {
                flags,
                ..EstimatorHealth::default()
            });
        }
    };
    assert!(health(with(EstimatorHealth::POSITION_RELATIVE)).holds_position);
    assert!(!health(with(EstimatorHealth::ATTITUDE)).holds_position);
    let constant = EstimatorHealth::POSITION_RELATIVE | EstimatorHealth::CONSTANT_POSITION;
    assert!(!health(with(constant)).holds_position);
    let nowhere = health(|t| t.local = Some(LocalPositionNed::new(f64::NAN, 0.0, 0.0)));
    assert!(!nowhere.holds_position && nowhere.position_time.is_none());
}

#[test]
fn a_vehicle_without_a_receiver_has_no_fix_to_lose() {
    let without = health(|t| t.gnss.fix = GnssFix::Unknown);
    assert_eq!(without.gnss, None);
    let mut failsafe = FailsafePolicy::new();
    let mut told = Vec::new();
    for i in 0..2000_u32 {
        let at = now().plus_seconds(f64::from(i) * PERIOD_S);
        let health = Health {
            last_heard: at,
            position_time: Some(at),
            ..without.clone()
        };
        told.extend(failsafe.step(at, &health, &FailsafeSettings::default()));
    }
    assert_eq!(told, []);
}

#[test]
fn a_fences_action_is_a_reaction_of_the_same_name() {
    for action in [
        BreachAction::Warn,
        BreachAction::Hold,
        BreachAction::Return,
        BreachAction::Land,
    ] {
        assert_eq!(reaction_of(action).word(), action.word());
    }
}
