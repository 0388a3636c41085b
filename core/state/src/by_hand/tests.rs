//! One stick per vehicle, the newest, and none that is old.

use super::*;

fn forward(forward_m_s: f64) -> Stick {
    Stick {
        forward_m_s,
        ..Stick::default()
    }
}

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

#[test]
fn only_who_is_steered_takes_sticks_and_of_several_the_newest() {
    let mut hand = Hand::default();
    assert!(!hand.put(forward(1.0), at(1.0)));
    hand.begin(CommandId(5));
    assert_eq!(hand.take(at(1.0)), None, "none from before");
    assert!(hand.put(forward(1.0), at(1.0)) && hand.put(forward(2.0), at(1.01)));
    assert_eq!(hand.take(at(1.02)), Some(forward(2.0)));
    assert_eq!(hand.take(at(1.04)), None);
    hand.end(CommandId(4));
    assert!(
        hand.put(forward(3.0), at(2.0)),
        "another command's end is none of its own"
    );
    hand.end(CommandId(5));
    assert!(!hand.put(forward(3.0), at(2.0)));
    assert_eq!(hand.take(at(2.0)), None);
}

#[test]
fn a_stick_that_nobody_took_up_in_time_is_dropped() {
    let mut hand = Hand::default();
    hand.begin(CommandId(1));
    hand.put(forward(1.0), at(1.0));
    assert_eq!(hand.take(at(1.3)), None);
}

#[test]
fn one_is_on_its_way_at_a_time_and_the_newest_waits() {
    let (relays, vehicle) = (Relays::default(), VehicleId(3));
    assert_eq!(relays.put(vehicle, forward(1.0), at(0.0)), (true, Ok(())));
    assert_eq!(relays.next(vehicle), Some((forward(1.0), at(0.0))));
    assert_eq!(relays.put(vehicle, forward(2.0), at(0.1)), (false, Ok(())));
    assert_eq!(relays.put(vehicle, forward(3.0), at(0.2)), (false, Ok(())));
    assert_eq!(relays.next(vehicle), Some((forward(3.0), at(0.2))));
    assert_eq!(relays.next(vehicle), None);
    assert!(
        relays.put(vehicle, forward(4.0), at(0.3)).0,
        "somebody has to begin again"
    );
    assert!(
        relays.put(VehicleId(4), forward(4.0), at(0.3)).0,
        "each vehicle has its own"
    );
}

#[test]
fn what_the_other_node_refuses_is_told_for_a_while() {
    let (relays, vehicle) = (Relays::default(), VehicleId(3));
    assert_eq!(relays.put(vehicle, forward(1.0), at(0.0)), (true, Ok(())));
    relays.answered(vehicle, Err(Refusal::PilotInControl), at(0.1));
    assert_eq!(
        relays.put(vehicle, forward(1.0), at(0.2)).1,
        Err(Refusal::PilotInControl)
    );
    assert_eq!(relays.put(vehicle, forward(1.0), at(1.3)).1, Ok(()));
    relays.answered(vehicle, Err(Refusal::PilotInControl), at(1.4));
    relays.answered(vehicle, Ok(()), at(1.5));
    assert_eq!(relays.put(vehicle, forward(1.0), at(1.6)).1, Ok(()));
}

#[test]
fn one_that_was_long_on_its_way_is_not_followed() {
    // This node's clock is three seconds ahead.
    let ahead_us = Some(3_000_000);
    assert_eq!(in_time(at(10.0), ahead_us, at(13.1)), Ok(()));
    assert!(matches!(
        in_time(at(10.0), ahead_us, at(13.6)),
        Err(Refusal::TimedOut { .. })
    ));
    for (ahead_us, now) in [(None, at(10.0)), (ahead_us, at(12.0))] {
        assert!(matches!(in_time(at(10.0), ahead_us, now), Err(Refusal::Clock { .. })));
    }
}
