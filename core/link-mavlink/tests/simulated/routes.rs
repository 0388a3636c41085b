//! Routes put on the vehicle and flown by it.

use crate::rig::Rig;
use skein_domain::link::{LinkEvent, RoutePoint};
use skein_domain::{AutopilotCommand, FlightMode, LinkHealth, PositionNed, Refusal, SwarmFrame};

/// Places about where the vehicle is now: metres north, east, and speed.
fn route(rig: &Rig, points: &[(f64, f64, Option<f64>)]) -> Vec<RoutePoint> {
    let frame = SwarmFrame::new(rig.truth().geodetic);
    let point = |(north, east, speed_m_s): &(f64, f64, Option<f64>)| RoutePoint {
        place: frame.geodetic(&PositionNed::new(*north, *east, 0.0)),
        speed_m_s: *speed_m_s,
    };
    points.iter().map(point).collect()
}

fn reached(rig: &Rig) -> Vec<u16> {
    let index = |(_, event): &(f64, LinkEvent)| match event {
        LinkEvent::RoutePointReached { index } => Some(*index),
        _ => None,
    };
    rig.events.iter().filter_map(index).collect()
}

#[track_caller]
fn upload(rig: &mut Rig, route: &[RoutePoint], within_s: f64) -> Result<(), Refusal> {
    let request = rig.upload(route);
    rig.run_until("uploaded", within_s, |rig| rig.outcome(request).is_some());
    rig.outcome(request).unwrap()
}

#[test]
fn a_route_is_uploaded_and_flown() {
    let mut rig = Rig::new();
    rig.take_off();
    let start = rig.truth().position;
    let points = route(
        &rig,
        &[(20.0, 0.0, Some(4.0)), (20.0, 15.0, Some(4.0)), (0.0, 15.0, None)],
    );
    assert_eq!(upload(&mut rig, &points, 1.0), Ok(()));
    assert_eq!(
        rig.ask(AutopilotCommand::SetMode {
            mode: FlightMode::Mission
        }),
        Ok(())
    );
    rig.stop();
    rig.run_until("flown", 60.0, |rig| reached(rig).len() == 3);
    assert_eq!(reached(&rig), [0, 1, 2], "the speed is no point");
    rig.run(4.0);
    let end = rig.truth().position.vector() - start.vector();
    assert!((end.x).abs() < 0.6 && (end.y - 15.0).abs() < 0.6, "{end:?}");
    assert_eq!(upload(&mut rig, &[], 1.0), Ok(()), "taken away");
    assert_eq!(rig.ask(AutopilotCommand::SetMode { mode: FlightMode::Hold }), Ok(()));
    assert!(matches!(
        rig.ask(AutopilotCommand::SetMode {
            mode: FlightMode::Mission
        }),
        Err(Refusal::Autopilot { .. })
    ));
}

#[test]
fn an_upload_gets_through_losses_and_never_lies_about_its_end() {
    for seed in 0..12_u32 {
        let mut rig = Rig::new();
        rig.run_until("ready", 20.0, Rig::is_ready);
        let loses = move |number: u32| number.wrapping_add(seed).wrapping_mul(2_654_435_761) >> 24 < 64;
        rig.passes_up = Box::new(move |number, _| !loses(number));
        rig.passes_down = Box::new(move |number, _| !loses(number.wrapping_mul(3)));
        let points: Vec<_> = (0..20)
            .map(|i| (f64::from(i) * 3.0, 0.0, Some(2.0 + f64::from(i % 3))))
            .collect();
        let points = route(&rig, &points);
        assert_eq!(upload(&mut rig, &points, 20.0), Ok(()), "a quarter lost, seed {seed}");
        let LinkHealth { connected, .. } = rig.read().1;
        assert!(connected);
    }
}

#[test]
fn a_newer_route_takes_the_place_of_one_under_way() {
    let mut rig = Rig::new();
    rig.run_until("ready", 20.0, Rig::is_ready);
    let long: Vec<_> = (0..100).map(|i| (f64::from(i) * 3.0, 0.0, None)).collect();
    let long = route(&rig, &long);
    let first = rig.upload(&long);
    rig.run(0.1);
    assert_eq!(rig.outcome(first), None, "an item each round trip");
    let points = route(&rig, &[(5.0, 0.0, None), (10.0, 0.0, None)]);
    assert_eq!(upload(&mut rig, &points, 1.0), Ok(()));
    assert_eq!(rig.outcome(first), Some(Err(Refusal::Superseded)));
    assert_eq!(
        items_sent(&rig),
        [(0, 5.0), (1, 10.0)],
        "the last ones are those of the newer route"
    );
}

/// Number and metres north of the last two items that were sent.
fn items_sent(rig: &Rig) -> Vec<(u16, f64)> {
    let start = SwarmFrame::new(rig.truth().geodetic);
    let items = rig.sent.iter().filter(|(_, id, _)| *id == 73).map(|(.., payload)| {
        let number = |at: usize| i32::from_le_bytes(payload[at..at + 4].try_into().unwrap());
        let mut place = rig.truth().geodetic;
        place.latitude_deg = f64::from(number(16)) * 1e-7;
        let seq = u16::from_le_bytes([payload[28], payload[29]]);
        (seq, start.position(&place).north_m.round())
    });
    let items: Vec<_> = items.collect();
    items[items.len() - 2..].to_vec()
}

#[test]
fn an_upload_that_somebody_broke_off_before_does_not_get_into_this_one() {
    for lost_cancels in [0, 1, 2] {
        let mut rig = Rig::new();
        rig.run_until("ready", 20.0, Rig::is_ready);
        let long: Vec<_> = (0..30).map(|i| (100.0 + f64::from(i), 0.0, None)).collect();
        let long = route(&rig, &long);
        // The first is announced, and none of its items arrives.
        rig.passes_up = Box::new(|_, frame| frame.get(7) != Some(&73));
        let first = rig.upload(&long);
        rig.run(0.3);
        assert_eq!(rig.outcome(first), None);
        let mut left = lost_cancels;
        rig.passes_up = Box::new(move |_, frame| {
            let lost = frame.get(7) == Some(&47) && left > 0;
            left -= u32::from(lost);
            !lost
        });
        let points = route(&rig, &[(5.0, 0.0, None), (10.0, 0.0, None)]);
        assert_eq!(upload(&mut rig, &points, 10.0), Ok(()), "{lost_cancels} cancels lost");
        assert_eq!(items_sent(&rig), [(0, 5.0), (1, 10.0)]);
        rig.received.clear();
        rig.run(3.0);
        assert_eq!(rig.received.get(&51), None, "nothing is asked for any more");
    }
}

#[test]
fn what_fails_is_told_with_its_reason() {
    let mut rig = Rig::new();
    rig.run_until("ready", 20.0, Rig::is_ready);
    let bad = route(&rig, &[(5.0, 0.0, Some(-3.0))]);
    let Err(Refusal::InvalidValue { detail }) = upload(&mut rig, &bad, 0.1) else {
        panic!("a speed below zero")
    };
    assert!(detail.contains("point 0"), "{detail}");
    let points = route(&rig, &[(5.0, 0.0, None), (10.0, 0.0, None)]);
    // Nothing of the mission protocol comes through any more.
    rig.passes_up = Box::new(|_, frame| !matches!(frame.get(7), Some(44 | 73)));
    assert!(matches!(upload(&mut rig, &points, 5.0), Err(Refusal::TimedOut { .. })));
    rig.passes_up = Box::new(|_, frame| !matches!(frame.get(7), Some(73)));
    assert!(matches!(upload(&mut rig, &points, 12.0), Err(Refusal::TimedOut { .. })));
    rig.passes_up = Box::new(|_, _| true);
    rig.run(6.0);
    let lost = rig.upload(&points);
    rig.passes_down = Box::new(|_, _| false);
    rig.run_until("lost", 4.0, |rig| rig.outcome(lost).is_some());
    assert!(matches!(
        rig.outcome(lost),
        Some(Err(Refusal::LinkLost { .. }) | Ok(()))
    ));
}
