//! The tracker: near what it is told, within its limits, the same for everyone who was told the same, at rest in silence.

use super::*;
use proptest::prelude::*;

const LIMITS: ReferenceLimits = ReferenceLimits {
    speed_m_s: 12.0,
    acceleration_m_s2: 3.0,
    turn_rate_rad_s: 0.5,
    stale_after_s: 2.0,
};

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(10.0 + seconds)
}

fn tracker() -> ReferenceTracker {
    ReferenceTracker::new(LIMITS).unwrap()
}

/// Drives north, then a wide bend to the east, at 6 m/s.
fn truck(t_s: f64) -> (PositionNed, VelocityNed, f64) {
    let (speed, radius_m, straight_s) = (6.0, 60.0, 10.0);
    if t_s < straight_s {
        return (
            PositionNed::new(speed * t_s, 0.0, 0.0),
            VelocityNed::new(speed, 0.0, 0.0),
            0.0,
        );
    }
    let angle = speed * (t_s - straight_s) / radius_m;
    (
        PositionNed::new(
            speed * straight_s + radius_m * angle.sin(),
            radius_m * (1.0 - angle.cos()),
            0.0,
        ),
        VelocityNed::new(speed * angle.cos(), speed * angle.sin(), 0.0),
        angle,
    )
}

#[derive(Debug, Clone)]
struct Telling {
    period_s: f64,
    jitter: Vec<f64>,
    noise: Vec<[f64; 2]>,
    with_velocity: bool,
}

fn telling() -> impl Strategy<Value = Telling> {
    (
        0.1..1.0,
        prop::collection::vec(-0.3..0.3, 300),
        prop::collection::vec(prop::array::uniform2(-0.3..0.3), 300),
        any::<bool>(),
    )
        .prop_map(|(period_s, jitter, noise, with_velocity)| Telling {
            period_s,
            jitter,
            noise,
            with_velocity,
        })
}

impl Telling {
    /// What is told: when, where, how fast.
    fn told(&self, until_s: f64) -> Vec<(f64, PositionNed, Option<VelocityNed>)> {
        let count = (until_s / self.period_s) as usize;
        (0..count)
            .map(|k| {
                let t_s = (k as f64 + 0.5 + self.jitter[k]) * self.period_s;
                let (position, velocity, _) = truck(t_s);
                let [n, e] = self.noise[k];
                let noisy = position.moved(Vector3::new(n, e, 0.0));
                (t_s, noisy, self.with_velocity.then_some(velocity))
            })
            .collect()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn it_stays_near_and_within_its_limits(telling in telling()) {
        let mut tracker = tracker();
        let told = telling.told(30.0);
        let mut next = told.iter().peekable();
        let mut before: Option<AnchorReference> = None;
        for k in 0..1450 {
            let t_s = f64::from(k) * 0.02;
            while let Some((told_s, position, velocity)) = next.next_if(|(told_s, ..)| *told_s <= t_s) {
                tracker.update(*position, *velocity, None, at(*told_s)).unwrap();
            }
            let Some((anchor, stale)) = tracker.anchor(at(t_s)) else { continue };
            prop_assert!(!stale);
            prop_assert!(anchor.velocity.norm() <= LIMITS.speed_m_s + 1e-9);
            prop_assert!(anchor.acceleration.norm() <= LIMITS.acceleration_m_s2 + 1e-9);
            prop_assert!(anchor.heading_rate_rad_s.abs() <= LIMITS.turn_rate_rad_s + 1e-9);
            let (truth, ..) = truck(t_s);
            let off_m = anchor.position.distance_m(&truth);
            // It starts at rest behind something that drives already, and knows of the bend late.
            let most_m = if t_s < 10.0 { 18.0 } else { 4.0 };
            prop_assert!(off_m < most_m, "{off_m} m off at {t_s}");
            if let Some(before) = before {
                let moved = anchor.position.vector() - before.position.vector();
                // From one period to the next as far as its velocity says; what is told late moves it by millimetres.
                prop_assert!((moved - before.velocity.vector() * 0.02).norm() < 0.02, "{moved}");
            }
            before = Some(anchor);
        }
    }

    #[test]
    fn whoever_is_told_the_same_knows_the_same(telling in telling(), asked in prop::collection::vec(0.0..25.0, 1..20)) {
        let (mut one, mut other) = (tracker(), tracker());
        for (told_s, position, velocity) in telling.told(20.0) {
            one.update(position, velocity, None, at(told_s)).unwrap();
            other.update(position, velocity, None, at(told_s)).unwrap();
            // The one is asked all the time, the other never.
            for ahead_s in &asked {
                let _ = one.anchor(at(told_s + ahead_s));
            }
        }
        for t_s in asked {
            prop_assert_eq!(one.anchor(at(20.0 + t_s)), other.anchor(at(20.0 + t_s)));
        }
    }
}

#[test]
fn in_silence_it_brakes_and_says_so() {
    let mut tracker = tracker();
    assert_eq!(tracker.anchor(at(0.0)), None);
    for k in 0..50 {
        let (position, velocity, _) = truck(f64::from(k) * 0.2);
        tracker
            .update(position, Some(velocity), None, at(f64::from(k) * 0.2))
            .unwrap();
    }
    let last_s = 9.8;
    let (driving, stale) = tracker.anchor(at(last_s + 1.9)).unwrap();
    assert!(!stale && (driving.velocity.norm() - 6.0).abs() < 0.1, "{driving:?}");
    let (_, stale) = tracker.anchor(at(last_s + 2.1)).unwrap();
    assert!(stale);
    // From 6 m/s at 3 m/s² two seconds and six metres.
    let (stopped, stale) = tracker.anchor(at(last_s + 2.0 + 2.2)).unwrap();
    assert!(stale && stopped.velocity.norm() < 1e-6, "{stopped:?}");
    let braking_m = stopped.position.north_m - 6.0 * (last_s + 2.0);
    assert!((5.0..7.0).contains(&braking_m), "{braking_m}");
    let (hours_later, stale) = tracker.anchor(at(1e5)).unwrap();
    assert!(stale && hours_later.position.distance_m(&stopped.position) < 1e-6);
    // Told again, it goes there.
    tracker
        .update(PositionNed::new(200.0, 5.0, 0.0), None, None, at(2e5))
        .unwrap();
    let mut farthest_m = 0.0_f64;
    for k in 0..300 {
        let t_s = 2e5 + f64::from(k) * 0.2;
        tracker
            .update(PositionNed::new(200.0, 5.0, 0.0), None, None, at(t_s + 0.1))
            .unwrap();
        farthest_m = farthest_m.max(tracker.anchor(at(t_s + 0.1)).unwrap().0.position.north_m);
    }
    let (there, stale) = tracker.anchor(at(2e5 + 59.9)).unwrap();
    assert!(
        !stale && there.position.distance_m(&PositionNed::new(200.0, 5.0, 0.0)) < 0.05,
        "{there:?}"
    );
    assert!(farthest_m < 201.0, "it went beyond: {farthest_m}");
}

#[test]
fn its_heading_is_the_told_one_or_the_course() {
    let mut told = tracker();
    let mut course = tracker();
    for k in 0..100 {
        let t_s = f64::from(k) * 0.2;
        let (position, velocity, _) = truck(5.0);
        told.update(position, None, Some(2.0), at(t_s)).unwrap();
        let (position_on, ..) = truck(t_s);
        course.update(position_on, Some(velocity), None, at(t_s)).unwrap();
    }
    assert!((told.anchor(at(19.9)).unwrap().0.heading_rad - 2.0).abs() < 1e-3);
    assert!(course.anchor(at(19.9)).unwrap().0.heading_rad.abs() < 1e-6);
}

#[test]
fn what_cannot_be_used_is_refused() {
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let limits = ReferenceLimits {
            stale_after_s: value,
            ..LIMITS
        };
        assert!(matches!(
            ReferenceTracker::new(limits),
            Err(ReferenceError::InvalidLimit {
                limit: "stale_after_s",
                ..
            })
        ));
    }
    let mut tracker = tracker();
    let lost = PositionNed::new(f64::NAN, 0.0, 0.0);
    assert_eq!(
        tracker.update(lost, None, None, at(0.0)),
        Err(ReferenceError::NotFinite)
    );
    let here = PositionNed::default();
    assert_eq!(
        tracker.update(here, None, Some(f64::NAN), at(0.0)),
        Err(ReferenceError::NotFinite)
    );
    tracker.update(here, None, None, at(1.0)).unwrap();
    for late_s in [1.0, 0.5] {
        let refused = tracker.update(here, None, None, at(late_s));
        assert!(matches!(refused, Err(ReferenceError::OutOfOrder { .. })));
    }
}
