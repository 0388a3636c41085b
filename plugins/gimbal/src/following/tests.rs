//! When a gimbal counts as not following, and when it does again.

use super::*;

const BOUNDS: Bounds = Bounds {
    tolerance_rad: 0.087,
    after_s: 2.0,
};

/// Looks at it twenty times a second; the first changes, with their times.
fn changes(look: impl Fn(f64) -> Option<(f64, f64)>, seconds: f64) -> Vec<(f64, Change)> {
    let mut following = Following::default();
    let times = (0..(seconds * 20.0) as u32).map(|n| f64::from(n) * 0.05);
    times
        .filter_map(|t_s| {
            let look = look(t_s).map(|(wanted_yaw, off_rad)| Look {
                wanted: Vector3::new(wanted_yaw.cos(), wanted_yaw.sin(), 0.0),
                off_rad,
            });
            let change = following.look(NodeTime::from_seconds(50.0 + t_s), look, BOUNDS)?;
            Some((t_s, change))
        })
        .collect()
}

#[test]
fn one_that_stands_is_told_of_after_two_seconds_and_one_that_is_on_its_way_is_not() {
    assert_eq!(changes(|_| Some((0.0, 0.3)), 10.0), [(2.0, Change::Stays)]);
    // Slow, but it comes: three degrees per second.
    let on_its_way = |t_s: f64| Some((0.0, (1.0 - 0.052 * t_s).max(0.0)));
    assert_eq!(changes(on_its_way, 30.0), []);
    assert_eq!(changes(|_| Some((0.0, 0.08)), 10.0), [], "within its tolerance");
    assert_eq!(changes(|_| None, 10.0), [], "nothing is wanted of it");
    // It trembles where it is.
    let trembles = |t_s: f64| Some((0.0, 0.5 + 0.02 * (t_s * 20.0).sin()));
    assert_eq!(changes(trembles, 10.0).len(), 1);
}

#[test]
fn one_that_comes_late_follows_again_and_one_that_goes_away_does_not() {
    let late = |t_s: f64| Some((0.0, if t_s < 4.0 { 0.6 } else { (0.6 - (t_s - 4.0)).max(0.01) }));
    let told = changes(late, 10.0);
    assert_eq!(
        told.iter().map(|(_, change)| *change).collect::<Vec<_>>(),
        [Change::Stays, Change::Follows]
    );
    assert!((told[1].0 - 4.55).abs() < 0.06, "{told:?}");
    let leaves = |t_s: f64| Some((0.0, 0.1 * t_s));
    assert_eq!(changes(leaves, 10.0).len(), 1);
}

#[test]
fn behind_a_direction_that_moves_it_may_lag_but_not_stand() {
    // Half a radian per second; a filter of 0.3 s lags by 0.15.
    assert_eq!(changes(|t_s| Some((0.5 * t_s, 0.15)), 10.0), []);
    let stands = |t_s: f64| Some((0.5 * t_s, 0.5 * t_s));
    assert_eq!(changes(stands, 6.0).len(), 1);
    // One jump of what is wanted is no movement.
    let jumps = |t_s: f64| Some((if t_s < 3.0 { 0.0 } else { 2.0 }, 0.4));
    assert_eq!(changes(jumps, 10.0), [(2.0, Change::Stays)]);
}

#[test]
fn what_is_wanted_anew_gets_its_time_anew() {
    let mut following = Following::default();
    let look = Look {
        wanted: Vector3::x(),
        off_rad: 1.0,
    };
    for tenth in 0..100 {
        if tenth % 15 == 0 {
            following.restart();
        }
        let now = NodeTime::from_seconds(10.0 + f64::from(tenth) * 0.1);
        assert_eq!(following.look(now, Some(look), BOUNDS), None);
    }
}
