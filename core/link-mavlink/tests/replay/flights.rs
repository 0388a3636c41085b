//! The facts of three flights, as the link saw them.

use crate::replay::fly;
use mavlink::dialects::common::COMMAND_LONG_DATA;
use mavlink::{MavlinkVersion, MessageData};
use skein_domain::FlightMode::{Hold, Land, Offboard, Return, TakeOff};
use skein_domain::link::StreamState;
use skein_domain::{AutopilotCommand, Geodetic, GnssFix, LandedState, LocalFrame, Refusal};

const DENIED_IN_AIR: &str = "Disarming denied: not landed";

fn rejected(text: &str) -> Result<(), Refusal> {
    Err(Refusal::Autopilot {
        result: "temporarily_rejected".to_owned(),
        text: text.to_owned(),
    })
}

#[track_caller]
fn assert_near(actual: f64, expected: f64, tolerance: f64) {
    assert!(
        (actual - expected).abs() <= tolerance,
        "{actual} is not {expected} within {tolerance}"
    );
}

#[test]
fn a_plain_flight() {
    let flight = fly("plain-flight", 1, &[], &[]);
    assert_eq!(flight.armed(), [(21.3, true), (49.9, false)]);
    let modes = [
        (22.3, Hold, TakeOff, true),
        (29.5, TakeOff, Hold, true),
        (31.6, Hold, Offboard, true),
        (36.6, Offboard, Land, true),
        // After the landing PX4 shows OFFBOARD again, by itself.
        (49.9, Land, Offboard, false),
    ];
    assert_eq!(flight.modes(), modes);
    // Each is done when the state that follows is seen, not when it is acknowledged.
    for (asked, done) in [(20.395, 21.322), (21.329, 22.336), (31.342, 31.552), (36.051, 36.647)] {
        let (at, outcome) = flight.outcome(asked);
        assert_eq!(outcome, Ok(()), "asked at {asked}");
        assert_near(at, done, 0.002);
    }
    let texts = [
        "Armed by external command",
        "Takeoff detected",
        "Landing at current position",
        "Landing detected",
        "Disarmed by landing",
    ];
    assert_eq!(flight.texts(), texts);
    // The stream runs out 0.5 s after the last recorded setpoint and holds until the end of the hold; nobody took it over.
    let stream = [
        (30.4, StreamState::Fresh),
        (37.0, StreamState::HoldingExpired),
        (42.0, StreamState::GivenUp),
    ];
    assert_eq!(flight.stream(), stream);

    // The ground station had read 489.43 m off the screen.
    let take_off = flight.sent.iter().find_map(|(_, id, payload)| {
        let data = COMMAND_LONG_DATA::deser(MavlinkVersion::V2, payload)
            .ok()
            .filter(|_| *id == COMMAND_LONG_DATA::ID)?;
        (data.command as u32 == 22).then_some(data)
    });
    let take_off = take_off.unwrap();
    assert_near(f64::from(take_off.param7), 494.43, 0.05);
    assert!(take_off.param4.is_nan() && take_off.param5.is_nan() && take_off.param6.is_nan());
}

#[test]
fn telemetry_on_the_way() {
    let flight = fly("plain-flight", 1, &[], &[]);
    let (early, ..) = flight.at(2.5);
    assert_eq!(early.ready_to_arm, Some(false), "the estimator is not ready yet");
    let (ready, health, failsafe) = flight.at(10.0);
    assert_eq!(
        (ready.ready_to_arm, ready.landed, ready.armed),
        (Some(true), LandedState::OnGround, false)
    );
    assert_eq!((ready.gnss.fix, failsafe), (GnssFix::ThreeD, false));
    assert!(ready.gnss.satellites >= 10);
    assert_near(f64::from(ready.battery.voltage_v.unwrap()), 16.2, 0.2);
    assert_near(f64::from(ready.battery.remaining.unwrap()), 1.0, 0.02);
    assert_near(ready.home.unwrap().altitude_amsl_m, 489.43, 0.05);
    assert!(health.connected && health.loss == 0.0, "{health:?}");
    assert_near(f64::from(health.receive_rate_hz), 400.0, 30.0);
    let (flying, health, _) = flight.at(35.3);
    let local = flying.local.unwrap();
    assert_near(local.north_m, 10.0, 0.5);
    assert_near(local.east_m, 0.0, 0.3);
    assert_near(local.down_m, -4.7, 0.3);
    assert_eq!(flying.landed, LandedState::InAir);
    assert_near(f64::from(health.setpoint_rate_hz), 20.0, 3.0);
    assert!(health.loss < 0.001, "{health:?}");
    // Both positions say the same place, in the frame the autopilot gave.
    let frame = flying.local_frame.unwrap();
    let apart = frame.position(&flying.global.unwrap()).vector() - local.vector();
    assert!(apart.norm() < 0.3, "{apart:?}");
    let landed = flight.at(75.0).0;
    assert_eq!(
        (landed.landed, landed.armed, landed.mode),
        (LandedState::OnGround, false, Offboard)
    );
}

#[test]
fn how_well_it_knows_where_it_is() {
    let flight = fly("plain-flight", 1, &[], &[]);
    let (early, ..) = flight.at(1.5);
    assert!(
        early
            .estimator
            .is_none_or(|estimator| !estimator.is_position_good(false))
    );
    let (flying, ..) = flight.at(35.3);
    assert_eq!(flying.gnss_healthy, Some(true));
    let estimator = flying.estimator.unwrap();
    assert!(estimator.is_position_good(false), "{estimator:?}");
    assert!(estimator.horizontal_accuracy_m.unwrap() < 1.0 && estimator.position_ratio < 0.5);
    let frame = flying.local_frame.unwrap();
    let apart = frame.position(&flying.gnss_place.unwrap()).vector() - flying.local.unwrap().vector();
    assert!(apart.xy().norm() < 3.0 && apart.z.abs() < 5.0, "{apart:?}");
    // One receiver, and no estimation of the drag: nothing is made up.
    assert_eq!((flying.gnss2_place, flying.wind), (None, None));
    assert!(
        flying.battery_use.consumed_ah.is_some_and(|used| used < 0.5),
        "{:?}",
        flying.battery_use
    );
    let heard = flying.heard;
    assert!(heard.estimator > heard.gnss2 && heard.gnss > heard.wind);
}

#[test]
fn the_frame_is_found_without_being_told() {
    let said = Geodetic {
        latitude_deg: 47.397_743_3,
        longitude_deg: 8.545_594_2,
        altitude_amsl_m: 489.443,
    };
    let told = fly("plain-flight", 1, &[], &[]);
    assert_eq!(told.at(5.0).0.local_frame, Some(LocalFrame { origin: said }));
    const GPS_GLOBAL_ORIGIN: u32 = 49;
    let found = fly("plain-flight", 1, &[], &[GPS_GLOBAL_ORIGIN]);
    for second in [5.0, 25.0, 35.0, 74.0] {
        let apart = found.at(second).0.local_frame.unwrap().position(&said);
        assert!(apart.norm() < 0.25, "{second}: {apart:?}");
    }
    // It was asked for, several times but not for ever.
    let asked = found.sent.iter().filter(|(_, id, payload)| {
        *id == COMMAND_LONG_DATA::ID && {
            let data = COMMAND_LONG_DATA::deser(MavlinkVersion::V2, payload).unwrap();
            data.command as u32 == 512 && data.param1 == 49.0
        }
    });
    assert!((2..=40).contains(&asked.count()));
}

#[test]
fn refusals_carry_the_autopilots_words() {
    // At 49.733 the ground station asks for OFFBOARD again; the link is at it since 46.726, and waits for the stream.
    let flight = fly("refusals-flight", 2, &[46.726], &[]);
    for asked in [26.727, 30.658, 30.702, 31.734, 36.270, 59.813] {
        let (at, outcome) = flight.outcome(asked);
        assert_eq!(outcome, rejected(DENIED_IN_AIR), "asked at {asked}");
        assert!(at - asked < 0.3, "known at {at}");
    }
    assert_eq!(
        flight.outcome(33.756).1,
        rejected("Switching to Position is currently not available")
    );
    assert_eq!(
        flight.outcome(37.304).1,
        rejected("Switching to Mission is currently not available")
    );
    let (at, outcome) = flight.outcome(20.142);
    assert!(
        matches!(outcome, Err(Refusal::TimedOut { .. })),
        "OFFBOARD without a stream: {outcome:?}"
    );
    assert_near(at - 20.142, 3.0, 0.15);
    assert!(
        matches!(flight.outcome(39.344).1, Err(Refusal::NotPermitted { .. })),
        "take-off in the air"
    );
    for asked in [
        9.430, 21.659, 23.170, 24.181, 25.198, 26.218, 31.222, 35.257, 36.291, 38.325, 49.733, 63.337,
    ] {
        let (_, outcome) = flight.outcome(asked);
        assert_eq!(outcome, Ok(()), "asked at {asked}");
    }
    assert_eq!(
        flight.armed(),
        [(10.1, true), (21.3, false), (22.3, true), (76.5, false)]
    );
    let modes = [
        (24.4, Hold, TakeOff, true),
        (25.4, TakeOff, Hold, true),
        // The ground station's own take-off, which the link had refused to send.
        (39.7, Hold, TakeOff, false),
        (44.8, TakeOff, Hold, false),
        (49.9, Hold, Offboard, true),
        // DO_REPOSITION by another: out of our control.
        (61.1, Offboard, Hold, false),
        (63.2, Hold, Offboard, true),
        (64.2, Offboard, Land, true),
        (76.5, Land, Offboard, false),
    ];
    assert_eq!(flight.modes(), modes);
    let chunked = "SET_POSITION_TARGET_LOCAL_NED coordinate frame 7 unsupported";
    assert_eq!(flight.texts().iter().filter(|text| **text == chunked).count(), 6);
    assert!(
        flight.stream().contains(&(61.1, StreamState::Stopped)),
        "{:?}",
        flight.stream()
    );
}

#[test]
fn offboard_lost_and_back_by_itself() {
    let flight = fly("setpoint-loss-flight", 3, &[], &[]);
    let modes = [
        (22.3, Hold, TakeOff, true),
        (29.5, TakeOff, Hold, true),
        (31.6, Hold, Offboard, true),
        (37.7, Offboard, Return, false),
        (40.7, Return, Offboard, false),
        (43.8, Offboard, Land, true),
        (64.3, Land, Offboard, false),
    ];
    assert_eq!(flight.modes(), modes);
    assert!(flight.texts().contains(&"Failsafe activated"));
    assert!(
        flight
            .texts()
            .contains(&"RTL: start return at 520 m (30 m above destination)")
    );
    assert!(
        !flight.at(36.5).2 && flight.at(38.0).2 && !flight.at(41.5).2,
        "the failsafe shows while it acts"
    );
    let stream = [
        (30.4, StreamState::Fresh),
        (36.5, StreamState::HoldingExpired),
        // The autopilot has left OFFBOARD: nothing is sent until it is there again, be it by others' setpoints.
        (37.7, StreamState::Stopped),
        (40.7, StreamState::Fresh),
        (44.6, StreamState::HoldingExpired),
        (49.7, StreamState::GivenUp),
    ];
    let actual = flight.stream();
    assert_eq!(
        actual.iter().map(|(_, s)| *s).collect::<Vec<_>>(),
        stream.map(|(_, s)| s),
        "{actual:?}"
    );
    for ((at, _), (expected, _)) in actual.iter().zip(stream) {
        assert_near(*at, expected, 0.15);
    }
    let setpoints = |from: f64, to: f64| {
        flight
            .sent
            .iter()
            .filter(|(t, id, _)| *id == 84 && *t > from && *t < to)
            .count()
    };
    assert_eq!(setpoints(37.7, 40.7), 0, "nothing that could bring it back");
    assert!(setpoints(36.6, 37.6) > 30, "the hold is sent at full rate");
    assert_eq!(
        flight
            .requests
            .iter()
            .filter(|(_, c)| *c == AutopilotCommand::EnterOffboard)
            .count(),
        2
    );
    for asked in [20.369, 21.341, 31.380, 42.679, 43.690] {
        assert_eq!(flight.outcome(asked).1, Ok(()), "asked at {asked}");
    }
}

#[test]
fn damaged_frames_in_between_change_nothing() {
    let clean = fly("refusals-flight", 2, &[46.726], &[]);
    let mut n = 0_u64;
    // Before each frame, the same one with a bit turned or its end cut off.
    let noisy = crate::replay::fly_with("refusals-flight", 2, &[46.726], &[], |bytes| {
        n = n
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let mut damaged = bytes.to_vec();
        let at = (n >> 33) as usize % damaged.len();
        if n >> 32 & 1 == 0 {
            damaged.truncate(at);
        } else if !(7..10).contains(&at) {
            // A message id that is not known cannot be told from a damaged one.
            damaged[at] ^= 1 << (n >> 60 & 7);
        } else {
            damaged.clear();
        }
        damaged
    });
    assert_eq!(noisy.modes(), clean.modes());
    assert_eq!(noisy.armed(), clean.armed());
    assert_eq!(noisy.texts(), clean.texts());
    assert_eq!(noisy.at(70.0).1.loss, 0.0);
}
