//! Asked once each, spread out, again when it did not help, never for ever.

use super::*;

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

/// Runs `seconds`, with messages arriving as `rates` says; gives the ids asked for and the times.
fn run(keeper: &mut RateKeeper, from_s: f64, seconds: f64, rates: &[(u32, f64)]) -> Vec<(f64, u32)> {
    let mut asked = Vec::new();
    let steps = (seconds / 0.01) as u32;
    for i in 0..steps {
        let t = from_s + f64::from(i) * 0.01;
        for (id, rate_hz) in rates {
            let period = (100.0 / rate_hz) as u32;
            if i % period == 0 {
                keeper.on_message(*id);
            }
        }
        match keeper.poll(at(t)) {
            Some(Tuning::Rate(id, _)) => asked.push((t, id)),
            Some(Tuning::Copy(id, _)) => keeper.on_copy(id),
            None => {}
        }
    }
    asked
}

const AS_ASKED: [(u32, f64); 12] = [
    (32, 50.0),
    (33, 5.0),
    (0, 4.0),
    (30, 10.0),
    (245, 2.0),
    (1, 1.0),
    (24, 2.0),
    (124, 2.0),
    (230, 1.0),
    (231, 0.5),
    (147, 1.0),
    (242, 0.5),
];

#[test]
fn each_is_asked_for_once_when_it_helps_and_requests_are_spread() {
    let mut keeper = RateKeeper::new(MessageRates::default(), 3, at(10.0));
    let asked = run(&mut keeper, 10.0, 30.0, &AS_ASKED);
    let mut ids: Vec<u32> = asked.iter().map(|(_, id)| *id).collect();
    ids.sort_unstable();
    assert_eq!(ids, [0, 1, 24, 30, 32, 33, 124, 147, 230, 231, 242, 245]);
    assert!(asked.windows(2).all(|pair| pair[1].0 - pair[0].0 >= 0.049), "{asked:?}");
    let mut others = RateKeeper::new(MessageRates::default(), 4, at(10.0));
    let first_of_other = run(&mut others, 10.0, 2.0, &AS_ASKED)[0].0;
    assert!(
        (first_of_other - asked[0].0).abs() > 0.04,
        "two vehicles do not ask at once"
    );
}

#[test]
fn what_does_not_help_is_asked_for_again_but_not_for_ever() {
    let mut keeper = RateKeeper::new(MessageRates::default(), 1, at(0.0));
    let mut rates = AS_ASKED;
    rates[0].1 = 10.0;
    let asked = run(&mut keeper, 0.0, 120.0, &rates);
    let local = asked.iter().filter(|(_, id)| *id == 32).count();
    assert_eq!(local, usize::from(ATTEMPTS_MAX));
    keeper.restart(1, at(120.0));
    assert_eq!(
        run(&mut keeper, 120.0, 3.0, &AS_ASKED).len(),
        AS_ASKED.len(),
        "again after a restart"
    );
}

#[test]
fn what_an_autopilot_may_have_nothing_to_say_in_is_asked_for_once() {
    let mut keeper = RateKeeper::new(MessageRates::default(), 1, at(0.0));
    let rates: Vec<(u32, f64)> = AS_ASKED
        .into_iter()
        .filter(|(id, _)| !MAY_BE_MISSING.contains(id))
        .collect();
    let asked = run(&mut keeper, 0.0, 60.0, &rates);
    for id in MAY_BE_MISSING {
        assert_eq!(asked.iter().filter(|(_, asked)| *asked == id).count(), 1, "{id}");
    }
}

#[test]
fn what_a_payload_wants_stays_on_and_comes_back_when_it_was_off() {
    let interval_us = |tuning: &Tuning| match tuning {
        Tuning::Rate(281, plan) => Some(plan.steps[0].command.parameters[1]),
        _ => None,
    };
    let mut keeper = RateKeeper::new(MessageRates::default(), 1, at(0.0));
    let mut asked = Vec::new();
    let (mut wanted, mut on) = (true, true);
    for i in 0..6000_u32 {
        match i {
            1000 => wanted = false,
            3000 => {
                wanted = true;
                keeper.want(|id| id == 281);
            }
            _ => {}
        }
        if on && i % 20 == 0 {
            if wanted {
                keeper.on_wanted(281)
            } else {
                keeper.on_unused(281)
            }
        }
        if let Some(tuning) = keeper.poll(at(f64::from(i) * 0.01))
            && let Some(interval_us) = interval_us(&tuning)
        {
            asked.push((i / 1000, interval_us));
            on = interval_us >= 0.0;
        }
    }
    assert_eq!(
        asked,
        [(1, -1.0), (3, 0.0)],
        "off when nobody wants it, and back at its own rate"
    );
    keeper.want(|id| id == 281);
    assert_eq!(
        run(&mut keeper, 60.0, 10.0, &AS_ASKED)
            .iter()
            .filter(|(_, id)| *id == 281)
            .count(),
        0
    );
}

#[test]
fn what_nobody_reads_is_turned_off_unless_it_is_not_to_be() {
    let mut rates = AS_ASKED.to_vec();
    rates.extend([(105, 50.0), (331, 30.0), (77, 20.0), (111, 10.0)]);
    let mut keeper = RateKeeper::new(MessageRates::default(), 1, at(0.0));
    let asked = run(&mut keeper, 0.0, 6.0, &rates);
    let off: Vec<u32> = asked.iter().skip(AS_ASKED.len()).map(|(_, id)| *id).collect();
    assert_eq!(off, [105, 331], "acknowledgements have no rate");
    let settings = MessageRates {
        turn_off_unused: false,
        ..MessageRates::default()
    };
    let mut keeper = RateKeeper::new(settings, 1, at(0.0));
    assert_eq!(run(&mut keeper, 0.0, 6.0, &rates).len(), AS_ASKED.len());
    let settings = MessageRates {
        manage: false,
        ..MessageRates::default()
    };
    let mut keeper = RateKeeper::new(settings, 1, at(0.0));
    assert_eq!(run(&mut keeper, 0.0, 6.0, &rates).len(), 0);
}
