//! The budget over time.

use super::*;

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

fn budget(bytes_per_s: f64) -> Budget {
    let settings = BudgetSettings {
        bytes_per_s,
        burst_bytes: 4000.0,
    };
    Budget::new(settings, at(0.0))
}

#[test]
fn in_the_long_run_no_more_than_the_rate_is_spent() {
    let mut budget = budget(1000.0);
    let mut spent = 0;
    for step in 0..10_000 {
        let now = at(f64::from(step) * 0.01);
        while budget.allows(now, Class::State, 100) {
            budget.spend(now, 100);
            spent += 100;
        }
    }
    assert!(
        (100_000..=104_100).contains(&spent),
        "{spent} bytes in 100 s, and one burst"
    );
}

#[test]
fn bulk_leaves_room_and_a_command_goes_even_if_nothing_is_left() {
    let mut budget = budget(1000.0);
    while budget.allows(at(0.0), Class::Bulk, 500) {
        budget.spend(at(0.0), 500);
    }
    assert!(
        budget.allows(at(0.0), Class::State, 1500),
        "bulk left half of the burst"
    );
    while budget.allows(at(0.0), Class::State, 500) {
        budget.spend(at(0.0), 500);
    }
    assert!(!budget.allows(at(0.0), Class::Query, 500) && budget.allows(at(0.0), Class::Command, 500));
    while budget.allows(at(0.0), Class::Command, 500) {
        budget.spend(at(0.0), 500);
    }
    let again = at(4.5);
    assert!(
        !budget.allows(at(4.49), Class::State, 500),
        "the debt of a burst is paid first"
    );
    assert!(budget.allows(again, Class::State, 500) && !budget.allows(again, Class::Bulk, 500));
}

#[test]
fn without_a_rate_nothing_is_promised() {
    let mut none = budget(0.0);
    none.spend(at(0.0), 4000);
    assert!(!none.allows(at(1e6), Class::State, 100));
    let mut unknown = budget(f64::NAN);
    unknown.spend(at(0.0), 4000);
    let _allowed = unknown.allows(at(5.0), Class::State, 100);
}

#[test]
fn the_mean_rate_follows_what_goes_over_the_link() {
    let mut traffic = Traffic::default();
    for step in 0..1000 {
        traffic.count(at(f64::from(step) * 0.01), Class::State, 50);
    }
    let rate = traffic.rate_bytes_per_s(at(9.99));
    assert!((rate - 5000.0).abs() < 100.0, "{rate}");
    assert!(traffic.rate_bytes_per_s(at(30.0)) < 1.0);
    assert_eq!(
        (traffic.total_bytes(), traffic.datagrams[Class::State as usize]),
        (50_000, 1000)
    );
}
