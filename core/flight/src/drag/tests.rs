//! The drag is found whatever the wind, kept while nothing new is to be seen, and never made of anything but flight.

use super::*;
use proptest::prelude::*;

const PERIOD_S: f64 = 0.02;

/// A vehicle in a wind, whose attitude is what its motion takes.
struct Flyer {
    drag_per_s: f64,
    wind: Vector2<f64>,
    time: NodeTime,
    estimator: DragEstimator,
}

impl Flyer {
    fn new(drag_per_s: f64, wind: Vector2<f64>) -> Self {
        Self {
            drag_per_s,
            wind,
            time: NodeTime(5_000_000),
            estimator: DragEstimator::default(),
        }
    }

    fn look(&self, velocity: &Vector3<f64>, acceleration: &Vector3<f64>, yaw_rad: f64) -> Look {
        let pull = (velocity.xy() - self.wind) * self.drag_per_s;
        let thrust = Vector3::new(
            acceleration.x + pull.x,
            acceleration.y + pull.y,
            acceleration.z - GRAVITY_M_S2,
        );
        let (sin, cos) = yaw_rad.sin_cos();
        let down = -thrust.normalize();
        let (forward, right) = (down.x * cos + down.y * sin, down.y * cos - down.x * sin);
        Look {
            time: self.time,
            velocity: (*velocity).into(),
            roll_rad: (-right).asin(),
            pitch_rad: forward.atan2(down.z),
            yaw_rad,
        }
    }

    /// Flies so that `velocity` is its velocity after so many seconds, with the nose turned steadily.
    fn fly(&mut self, duration_s: f64, velocity: impl Fn(f64) -> Vector3<f64>) {
        for step in 0..(duration_s / PERIOD_S) as u32 {
            let t_s = f64::from(step) * PERIOD_S;
            let h = 1e-4;
            let acceleration = (velocity(t_s + h) - velocity(t_s - h)) / (2.0 * h);
            self.time = self.time.plus_seconds(PERIOD_S);
            let look = self.look(&velocity(t_s), &acceleration, 0.7 + 0.3 * t_s);
            self.estimator.see(look);
        }
    }

    /// Round a circle, and up and down, with some changes of speed.
    fn circle(&mut self, duration_s: f64, speed_m_s: f64) {
        self.fly(duration_s, |t| {
            let speed = speed_m_s * (1.0 - (-0.5 * t).exp() * (1.0 + 0.5 * t));
            Vector3::new(speed * (0.3 * t).cos(), speed * (0.3 * t).sin(), 0.2 * (0.5 * t).sin())
        });
    }

    fn found_per_s(&self) -> f64 {
        self.estimator.drag_per_s()
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn it_is_found_whatever_the_wind(
        drag_per_s in 0.0..1.1_f64, wind in prop::array::uniform2(-3.0..3.0_f64), speed_m_s in 3.0..8.0_f64,
    ) {
        prop_assume!(drag_per_s * (speed_m_s + 4.3) < 6.0);
        let mut flyer = Flyer::new(drag_per_s, wind.into());
        flyer.circle(25.0, speed_m_s);
        prop_assert!((flyer.found_per_s() - drag_per_s).abs() < 0.03, "{} for {drag_per_s}", flyer.found_per_s());
    }

    #[test]
    fn whatever_is_told_the_drag_is_within_its_bounds(
        looks in prop::collection::vec(
            (0.0..0.3_f64, prop::array::uniform3(prop_oneof![-30.0..30.0_f64, any::<f64>()]),
             prop::array::uniform3(prop_oneof![-0.6..0.6_f64, any::<f64>()])), 0..200),
    ) {
        let mut estimator = DragEstimator::default();
        let mut time = NodeTime(1_000_000);
        for (dt_s, velocity, [roll_rad, pitch_rad, yaw_rad]) in looks {
            time = time.plus_seconds(dt_s);
            let velocity = Vector3::from(velocity).into();
            estimator.see(Look { time, velocity, roll_rad, pitch_rad, yaw_rad });
            prop_assert!((0.0..=DRAG_MAX_PER_S).contains(&estimator.drag_per_s()));
        }
    }
}

#[test]
fn before_anything_is_known_it_is_that_of_a_usual_one() {
    assert_eq!(DragEstimator::default().drag_per_s(), DRAG_AT_FIRST_PER_S);
    let mut flyer = Flyer::new(1.0, Vector2::new(3.0, 1.0));
    flyer.fly(60.0, |_| Vector3::zeros());
    assert_eq!(
        flyer.found_per_s(),
        DRAG_AT_FIRST_PER_S,
        "a hover in the wind tells of the wind alone"
    );
}

#[test]
fn long_straight_flights_and_hovers_in_gusts_do_not_unlearn_it() {
    let mut flyer = Flyer::new(0.9, Vector2::new(-2.0, 1.0));
    flyer.circle(20.0, 4.0);
    let learnt = flyer.found_per_s();
    assert!((learnt - 0.9).abs() < 0.05, "{learnt}");
    flyer.fly(300.0, |_| Vector3::new(4.0, 0.0, 0.0));
    assert!((flyer.found_per_s() - 0.9).abs() < 0.05, "{}", flyer.found_per_s());
    // Gusts move the vehicle a little to where they blow, and pull less for it.
    flyer.fly(120.0, |t| Vector3::new((-0.5 * t).exp() * 4.0, 0.0, 0.0));
    for gust in 0..200 {
        let strength = f64::from(gust % 5) - 2.0;
        flyer.wind = Vector2::new(strength, 0.0);
        flyer.fly(1.0, |t| Vector3::new(0.15 * strength * (2.0 * t).sin(), 0.0, 0.0));
    }
    assert!((flyer.found_per_s() - 0.9).abs() < 0.1, "{}", flyer.found_per_s());
}

#[test]
fn another_drag_is_learnt_anew() {
    let mut flyer = Flyer::new(0.9, Vector2::zeros());
    flyer.circle(60.0, 5.0);
    flyer.drag_per_s = 0.2;
    flyer.estimator.interrupt();
    flyer.circle(90.0, 5.0);
    assert!((flyer.found_per_s() - 0.2).abs() < 0.06, "{}", flyer.found_per_s());
}

#[test]
fn an_attitude_that_is_not_told_anew_teaches_nothing() {
    let mut flyer = Flyer::new(0.9, Vector2::zeros());
    for step in 0..2000 {
        flyer.time = flyer.time.plus_seconds(PERIOD_S);
        let t = f64::from(step) * PERIOD_S;
        let velocity = VelocityNed::new(4.0 * (0.4 * t).sin(), 4.0 * (0.4 * t).cos(), 0.0);
        flyer.estimator.see(Look {
            time: flyer.time,
            velocity,
            roll_rad: 0.0,
            pitch_rad: 0.0,
            yaw_rad: 0.1 * t,
        });
    }
    assert_eq!(flyer.found_per_s(), DRAG_AT_FIRST_PER_S);
}

#[test]
fn gaps_and_what_is_not_finite_begin_a_new_span() {
    let mut flyer = Flyer::new(0.6, Vector2::new(1.0, 0.0));
    for leg in 0..40 {
        flyer.circle(5.0, 6.0);
        let bad = Look {
            roll_rad: f64::NAN,
            ..flyer.look(&Vector3::zeros(), &Vector3::zeros(), 0.0)
        };
        match leg % 3 {
            // The next one begins at rest: what would lie between the two is no acceleration that it flew.
            0 => flyer.time = flyer.time.plus_seconds(3.0),
            1 => flyer.estimator.see(bad),
            _ => flyer.time = flyer.time.plus_seconds(-1.0),
        }
        if leg % 3 == 1 {
            assert_eq!(flyer.estimator.span, None);
        }
    }
    assert!((flyer.found_per_s() - 0.6).abs() < 0.06, "{}", flyer.found_per_s());
}

#[test]
fn saved_it_goes_on_as_before() {
    let mut flyer = Flyer::new(0.7, Vector2::new(1.0, -2.0));
    flyer.circle(11.11, 4.0);
    let bytes = minicbor::to_vec(flyer.estimator).unwrap();
    assert!(bytes.len() < 300, "{} bytes", bytes.len());
    let restored: DragEstimator = minicbor::decode(&bytes).unwrap();
    assert_eq!(restored, flyer.estimator);
}

#[test]
fn one_that_was_restored_from_nonsense_heals() {
    let mut flyer = Flyer::new(0.7, Vector2::zeros());
    flyer.estimator = DragEstimator {
        known_s: -4.0,
        spread_m2_per_s: f64::INFINITY,
        together_m2_per_s2: f64::NAN,
        ..DragEstimator::default()
    };
    assert_eq!(flyer.found_per_s(), DRAG_AT_FIRST_PER_S);
    flyer.circle(30.0, 5.0);
    assert!((flyer.found_per_s() - 0.7).abs() < 0.03, "{}", flyer.found_per_s());
}
