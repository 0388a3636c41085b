//! Which stalls lie in the time that the simulation has come to.

use super::*;

/// It began ten seconds ago and has not moved since. What the probe notes from now on comes after all that is asked for here.
fn runner() -> Runner {
    let (_, inbox) = std::sync::mpsc::channel();
    let probe = StallProbe::start().expect("starts");
    let mut runner = Runner::new(&SimSettings::default(), Vec::new(), None, inbox, Arc::default(), probe);
    runner.zero -= Duration::from_secs(10);
    runner
}

fn stalled_at(runner: &mut Runner, time_s: f64) -> f64 {
    runner.time_s = time_s;
    runner.stalled_until_now_s()
}

fn stand_still(runner: &Runner, from_s: f64, to_s: f64) {
    let at = |s: f64| runner.zero + Duration::from_secs_f64(s);
    runner.stalls.add(at(from_s), at(to_s));
}

fn is(found_s: f64, wanted_s: f64) {
    assert!((found_s - wanted_s).abs() < 1e-6, "{found_s} instead of {wanted_s}");
}

#[test]
fn while_it_catches_up_a_stall_grows_with_its_own_time() {
    let mut runner = runner();
    stand_still(&runner, 2.0, 2.5);
    is(stalled_at(&mut runner, 2.0), 0.0);
    is(stalled_at(&mut runner, 2.2), 0.2);
    is(stalled_at(&mut runner, 3.0), 0.5);
}

#[test]
fn time_that_was_let_go_excuses_nothing_after_it() {
    let mut runner = runner();
    stand_still(&runner, 1.0, 1.1);
    stand_still(&runner, 3.0, 5.0);
    is(stalled_at(&mut runner, 2.9), 0.1);
    runner.time_s = 3.0;
    runner.let_go(Duration::from_secs(2));
    is(runner.stalled_until_now_s(), 0.1);
    is(stalled_at(&mut runner, 4.0), 0.1);
}

#[test]
fn every_step_asks_anew() {
    let mut runner = runner();
    stand_still(&runner, 1.0, 2.0);
    runner.time_s = 1.3;
    runner.step(0.2);
    is(runner.stalled_s, 0.5);
}
