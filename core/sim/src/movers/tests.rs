//! Where a mover is when.

use super::*;

fn square(circuit: bool) -> Scripted {
    let mover = Mover {
        path: vec![
            PositionNed::new(0.0, 0.0, 0.0),
            PositionNed::new(10.0, 0.0, 0.0),
            PositionNed::new(10.0, 10.0, -5.0),
        ],
        speed_m_s: 2.0,
        starts_s: 3.0,
        heard_until_s: 20.0,
        circuit,
        ..Mover::default()
    };
    Scripted::new(mover, Geodetic::default())
}

#[test]
fn it_waits_goes_and_stays_or_goes_round() {
    let once = square(false);
    assert_eq!(once.truth(1.0).position, PositionNed::default());
    assert_eq!(once.truth(1.0).velocity, VelocityNed::default());
    let halfway = once.truth(5.0);
    assert!((halfway.position.north_m - 4.0).abs() < 1e-9 && (halfway.velocity.north_m_s - 2.0).abs() < 1e-9);
    let arrived = once.truth(100.0);
    assert_eq!(
        (arrived.position, arrived.velocity),
        (PositionNed::new(10.0, 10.0, -5.0), VelocityNed::default())
    );
    let round = square(true);
    let length_m = 10.0 + 125.0_f64.sqrt() + 15.0;
    let again = round.truth(3.0 + (length_m + 4.0) / 2.0);
    assert!((again.position.north_m - 4.0).abs() < 1e-9, "{again:?}");
}

#[test]
fn it_is_heard_at_its_rate_until_it_falls_silent() {
    let mut mover = square(false);
    let reports = (0..4000)
        .filter(|i| mover.report(f64::from(*i) * 0.01).is_some())
        .count();
    assert!((reports as f64 - 20.0 * 5.0).abs() <= 1.0, "{reports}");
    let mut nowhere = Scripted::new(Mover::default(), Geodetic::default());
    assert_eq!(nowhere.report(1.0), None);
}
