//! Masks, rate, expiry, hold, giving up and take-over, on a clock that only moves when told to.

use super::*;

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

fn going(speed_m_s: f64) -> LocalSetpoint {
    LocalSetpoint {
        position: Some(LocalPositionNed::new(1.0, 2.0, -3.0)),
        velocity: Some(VelocityNed::new(speed_m_s, 0.0, 0.0)),
        yaw_rad: Some(0.5),
        ..LocalSetpoint::default()
    }
}

fn place() -> HoldPlace {
    HoldPlace {
        position: Some(LocalPositionNed::new(7.0, 8.0, -9.0)),
        yaw_rad: Some(1.5),
    }
}

/// With times: what was sent, and what changed.
type Log = (Vec<(f64, LocalSetpoint)>, Vec<(f64, StreamState)>);

/// Offers at `offer_hz` until `offers_end`, polls every 20 ms until `end`; gives what was sent and what changed, with times.
fn run(stream: &mut SetpointStream, offer_hz: f64, offers_end: f64, end: f64) -> Log {
    let settings = LinkSettings::default();
    let (mut sent, mut changed) = (Vec::new(), Vec::new());
    let mut note = |t: f64, action: StreamAction| {
        sent.extend(action.send.map(|setpoint| (t, setpoint)));
        changed.extend(action.changed.map(|state| (t, state)));
    };
    let (mut next_offer, mut t) = (10.0, 10.0);
    while t < end {
        if t >= next_offer - 1e-9 && t < offers_end {
            next_offer += 1.0 / offer_hz;
            note(t, stream.offer(at(t), going(5.0), at(t + 0.25), &settings));
        }
        if ((t * 1000.0).round() as u64).is_multiple_of(20) {
            note(t, stream.poll(at(t), place, &settings));
        }
        t += 0.001;
    }
    (sent, changed)
}

#[test]
fn an_expired_setpoint_becomes_a_hold_and_then_nothing() {
    let mut stream = SetpointStream::default();
    let (sent, changed) = run(&mut stream, 50.0, 12.0, 30.0);
    let states: Vec<StreamState> = changed.iter().map(|(_, state)| *state).collect();
    assert_eq!(
        states,
        [StreamState::Fresh, StreamState::HoldingExpired, StreamState::GivenUp]
    );
    let (hold_from, given_up) = (changed[1].0, changed[2].0);
    assert!(
        (hold_from - 12.23).abs() < 0.03 && (given_up - hold_from - 5.0).abs() < 0.03,
        "{changed:?}"
    );
    for (t, setpoint) in &sent {
        if *t < hold_from {
            assert_eq!(*setpoint, going(5.0));
        } else {
            assert_eq!(setpoint.position, place().position, "where it was at that moment");
            assert_eq!(setpoint.velocity, Some(VelocityNed::default()), "no stale velocity");
            assert_eq!(
                (setpoint.yaw_rad, setpoint.acceleration),
                (Some(0.5), None),
                "yaw is kept"
            );
        }
        assert!(*t < given_up, "nothing after giving up");
    }
    let largest_gap = sent.windows(2).map(|pair| pair[1].0 - pair[0].0).fold(0.0, f64::max);
    assert!(largest_gap < 0.1, "{largest_gap}");
    let settings = LinkSettings::default();
    let late = stream.offer(at(31.0), going(5.0), at(32.0), &settings);
    assert_eq!(
        late,
        StreamAction::default(),
        "after giving up PX4 has left OFFBOARD: setpoints would bring it back"
    );
    stream.unbar();
    assert!(stream.offer(at(31.1), going(5.0), at(32.0), &settings).send.is_some());
}

#[test]
fn the_rate_is_what_is_configured_whoever_is_faster_or_slower() {
    for (offer_hz, expected_hz) in [(50.0, 50.0), (200.0, 50.0), (45.0, 45.0), (20.0, 20.0)] {
        let mut stream = SetpointStream::default();
        let (sent, _) = run(&mut stream, offer_hz, 20.0, 20.0);
        let rate_hz = sent.len() as f64 / 10.0;
        assert!(
            (rate_hz - expected_hz).abs() < 1.5,
            "offered at {offer_hz} Hz, sent at {rate_hz}"
        );
        let measured = f64::from(stream.rate_hz(at(20.0)));
        assert!((measured - expected_hz).abs() < 3.0, "measured {measured}");
    }
    let mut stream = SetpointStream::default();
    let (sent, changed) = run(&mut stream, 5.0, 20.0, 20.0);
    assert!(sent.len() > 150, "a valid one is repeated: {}", sent.len());
    assert_eq!(changed.len(), 1);
}

#[test]
fn a_take_over_stops_it_until_offboard_is_back_or_asked_for() {
    let settings = LinkSettings::default();
    let mut stream = SetpointStream::default();
    stream.offer(at(1.0), going(1.0), at(1.5), &settings);
    assert_eq!(stream.taken_over().changed, Some(StreamState::Stopped));
    assert_eq!(
        stream.offer(at(1.1), going(1.0), at(1.6), &settings),
        StreamAction::default()
    );
    assert_eq!(stream.poll(at(9.0), place, &settings), StreamAction::default());
    stream.stop();
    assert_eq!(
        stream.offer(at(1.2), going(1.0), at(1.7), &settings),
        StreamAction::default(),
        "stopping changes nothing"
    );
    stream.handed_back();
    assert!(stream.offer(at(1.3), going(1.0), at(1.8), &settings).send.is_some());
    stream.taken_over();
    stream.unbar();
    assert!(stream.offer(at(1.4), going(1.0), at(1.9), &settings).send.is_some());
}

#[test]
fn it_has_run_only_while_fresh_and_since_its_last_start() {
    let settings = LinkSettings::default();
    let mut stream = SetpointStream::default();
    assert!(!stream.has_run(at(1.0), 0.5));
    for i in 0..30 {
        let t = 1.0 + f64::from(i) * 0.02;
        stream.offer(at(t), going(1.0), at(t + 0.1), &settings);
        assert_eq!(stream.has_run(at(t), 0.5), t - 1.0 >= 0.5 - 1e-9, "{t}");
    }
    stream.poll(at(2.0), place, &settings);
    assert!(
        !stream.has_run(at(2.0), 0.5),
        "a hold is not what OFFBOARD is entered with"
    );
    stream.offer(at(2.1), going(1.0), at(2.2), &settings);
    assert!(!stream.has_run(at(2.15), 0.5));
    assert_eq!(stream.stop().changed, Some(StreamState::Stopped));
    assert_eq!(stream.stop().changed, None);
}

#[test]
fn without_a_position_it_is_told_to_stop_and_nonsense_is_never_sent() {
    let settings = LinkSettings::default();
    let mut stream = SetpointStream::default();
    stream.offer(
        at(1.0),
        LocalSetpoint {
            yaw_rad: None,
            ..going(3.0)
        },
        at(1.2),
        &settings,
    );
    let hold = stream
        .poll(
            at(1.3),
            || HoldPlace {
                position: None,
                yaw_rad: Some(1.5),
            },
            &settings,
        )
        .send
        .unwrap();
    assert_eq!(
        (hold.position, hold.velocity, hold.yaw_rad),
        (None, Some(VelocityNed::default()), Some(1.5))
    );
    let mut stream = SetpointStream::default();
    for wrong in [
        LocalSetpoint::default(),
        LocalSetpoint {
            yaw_rad: Some(f64::NAN),
            ..going(1.0)
        },
        LocalSetpoint {
            velocity: Some(VelocityNed::new(f64::INFINITY, 0.0, 0.0)),
            ..going(1.0)
        },
        // Finite here, infinite in the single precision that autopilots read.
        LocalSetpoint {
            velocity: Some(VelocityNed::new(1e308, 0.0, 0.0)),
            ..going(1.0)
        },
    ] {
        assert_eq!(
            stream.offer(at(1.0), wrong, at(2.0), &settings),
            StreamAction::default()
        );
    }
    assert_eq!(
        stream.offer(at(3.0), going(1.0), at(2.9), &settings),
        StreamAction::default(),
        "expired on arrival"
    );
}
