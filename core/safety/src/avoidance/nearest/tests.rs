//! The nearest velocity against a slow search, on rows drawn by proptest.

use super::*;
use proptest::prelude::*;

const LIMITS: SpeedLimits = SpeedLimits {
    horizontal_m_s: 12.0,
    up_m_s: 4.0,
    down_m_s: 3.0,
};

fn rows() -> impl Strategy<Value = Vec<Row>> {
    let row = (-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64, -2.0..6.0_f64);
    proptest::collection::vec(row, 0..12).prop_map(|list| {
        list.into_iter()
            .filter_map(|(x, y, z, bound)| {
                let normal = Vector3::new(x, y, z).try_normalize(1e-3)?;
                Some(Row {
                    normal,
                    bound,
                    yields: 1.0,
                })
            })
            .collect()
    })
}

/// Largest excess over rows and limits.
fn worst(rows: &[Row], v: &Vector3<f64>) -> f64 {
    rows.iter()
        .map(|row| row.excess(v))
        .chain([v.x.hypot(v.y) - 12.0, -v.z - 4.0, v.z - 3.0])
        .fold(f64::NEG_INFINITY, f64::max)
}

proptest! {
    #[test]
    fn an_answer_keeps_all_and_nothing_beside_it_is_nearer(
        rows in rows(),
        w in (-15.0..15.0_f64, -15.0..15.0_f64, -6.0..6.0_f64),
        tries in proptest::collection::vec((-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64), 60),
    ) {
        let wanted = Vector3::new(w.0, w.1, w.2);
        let answer = nearest(&wanted, &rows, &LIMITS);
        prop_assert!(answer.velocity.iter().all(|x| x.is_finite()));
        prop_assert!(answer.velocity.x.hypot(answer.velocity.y) <= 12.0 + 1e-6);
        prop_assert!(answer.velocity.z <= 3.0 + 1e-6 && answer.velocity.z >= -4.0 - 1e-6);
        let distance = (answer.velocity - wanted).norm();
        for (x, y, z) in tries {
            // The feasible set is convex, so that a better place far away has a better one near by too.
            for size in [0.02, 0.5, 5.0] {
                let other = answer.velocity + Vector3::new(x, y, z) * size;
                if answer.feasible {
                    prop_assert!(worst(&rows, &other) > 0.0 || (other - wanted).norm() > distance - 2e-2);
                } else {
                    prop_assert!(worst(&rows, &other) > -1e-6, "there is a place that keeps all");
                }
            }
        }
        if answer.feasible {
            prop_assert!(worst(&rows, &answer.velocity) < 1e-5);
        }
    }
}

#[test]
fn contradicting_rows_share_the_violation() {
    let row = |x: f64, bound| Row {
        normal: Vector3::new(x, 0.0, 0.0),
        bound,
        yields: 1.0,
    };
    let answer = nearest(
        &Vector3::new(5.0, 1.0, 0.0),
        &[row(1.0, -1.0), row(-1.0, -1.0)],
        &LIMITS,
    );
    assert!(!answer.feasible);
    assert!(answer.velocity.x.abs() < 0.02, "{answer:?}");
    assert!((answer.velocity.y - 1.0).abs() < 1e-9);
}

#[test]
fn what_is_not_a_number_ends() {
    let row = Row {
        normal: Vector3::new(f64::NAN, 0.0, 0.0),
        bound: f64::NAN,
        yields: 1.0,
    };
    let rows = [row; 5];
    nearest(&Vector3::new(1.0, f64::INFINITY, f64::NAN), &rows, &LIMITS);
}
