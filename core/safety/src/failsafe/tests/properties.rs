//! Whatever happens to a vehicle: no weaker reaction replaces a stronger one, nothing is waited for without a bound, noise makes no
//! chatter, and nothing panics.

use super::*;
use proptest::prelude::*;
use skein_domain::{EnergyLevel, EnergyState};

/// A fault of some kind, from some time on, for so long.
#[derive(Debug, Clone, Copy)]
struct Fault {
    kind: u8,
    from_s: f64,
    lasts_s: f64,
    size: f64,
}

fn faults() -> impl Strategy<Value = Vec<Fault>> {
    let fault = (0..10_u8, 0.0..40.0, 0.05..40.0, 0.0..60.0).prop_map(|(kind, from_s, lasts_s, size)| Fault {
        kind,
        from_s,
        lasts_s,
        size,
    });
    prop::collection::vec(fault, 1..7)
}

impl Fault {
    fn apply(&self, h: &mut Health, t_s: f64) {
        let since_s = t_s - self.from_s;
        if !(0.0..self.lasts_s).contains(&since_s) {
            return;
        }
        match self.kind {
            0 => silent(h, since_s),
            1 => no_fix(h, since_s),
            2 => h.disagreement_m = Some(self.size),
            3 => h.tracking_error_m = Some(self.size),
            4 => stale(h, since_s),
            5 => h.clock_offset_s = h.clock_offset_s.map(|o| o + self.size * 0.01),
            6 => {
                h.breach = Some(FenceBreach {
                    reaction: Reaction::ALL[self.size as usize % 4],
                    outside_m: self.size * since_s,
                    zone: "field".into(),
                });
            }
            7 => h.coordinator_heard = h.coordinator_heard.map(|now| old(now, since_s * 5.0)),
            8 => h.operator_heard = h.operator_heard.map(|now| old(now, since_s * 5.0)),
            _ => {
                let levels = [EnergyLevel::ReplanSoon, EnergyLevel::ReturnNow, EnergyLevel::LandNow];
                h.energy = Some(EnergyState {
                    needed_home: Some(0.2),
                    level: levels[self.size as usize % 3],
                    ..EnergyState::default()
                });
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn no_weaker_reaction_replaces_a_stronger_one(
        faults in faults(),
        obeys_after_s in prop::option::of(0.0..4.0),
        pilot_from_s in 0.0..200.0,
        take_up_every in 50..4000_u32,
    ) {
        let mut rig = Rig::new();
        rig.obeys_after_s = obeys_after_s;
        let mut in_force = Reaction::Warn;
        for period in 0..3000_u32 {
            let t_s = f64::from(period) * PERIOD_S;
            if period % take_up_every == take_up_every - 1
                && rig.failsafe.take_up(TakenUpBy::Operator).expect("an operator may").is_some()
            {
                in_force = Reaction::Warn;
            }
            rig.health.pilot_in_control = (pilot_from_s..pilot_from_s + 5.0).contains(&t_s);
            let seen = rig.events.len();
            rig.run(PERIOD_S, |h, _| faults.iter().for_each(|f| f.apply(h, t_s)));
            for event in &rig.events[seen..] {
                match event.kind {
                    FailsafeEventKind::Ordered => {
                        prop_assert!(!rig.health.pilot_in_control, "{event:?}");
                        prop_assert!(event.reaction > Reaction::Warn);
                        prop_assert!(
                            event.reaction > in_force || event.reaction == Reaction::Release,
                            "{event:?} while {in_force}"
                        );
                        in_force = event.reaction;
                    }
                    FailsafeEventKind::Ended => in_force = Reaction::Warn,
                    _ => {}
                }
                prop_assert!(event.since <= event.at && event.at == rig.now, "{event:?}");
            }
            prop_assert_eq!(rig.order().unwrap_or(Reaction::Warn), in_force);
        }
    }

    /// A vehicle with a lasting fault is, at any time, doing what its step asks for or something stronger; or that was ordered
    /// less than the bound ago.
    #[test]
    fn every_step_is_bounded(
        kind in 0..10_u8,
        size in 12.0..60.0,
        obeys_after_s in prop::option::of(0.0..10.0),
    ) {
        let fault = Fault { kind, from_s: 0.0, lasts_s: f64::INFINITY, size };
        let mut rig = Rig::new();
        rig.obeys_after_s = obeys_after_s;
        let bound_s = rig.settings.reaction_within_s;
        for period in 1..2500_u32 {
            let t_s = f64::from(period) * PERIOD_S;
            rig.run(PERIOD_S, |h, _| fault.apply(h, t_s));
            let state = rig.failsafe.state(&rig.settings);
            let wanted = state.alarms.iter().map(|a| a.reaction).max().unwrap_or_default();
            let Some(order) = state.order else {
                prop_assert!(wanted < Reaction::Hold);
                continue;
            };
            prop_assert!(order.reaction >= wanted);
            let waited_s = rig.now.seconds_since(order.ordered_at);
            let settled = is_effective(order.reaction, &rig.health);
            prop_assert!(settled || order.recovered || waited_s <= bound_s + 2.0 * PERIOD_S, "{order:?}");
        }
    }

    #[test]
    fn noise_at_the_limit_makes_no_chatter(seed in any::<u64>(), noise_m in 0.0..0.9, mean_m in 0.0..8.0) {
        let mut rig = Rig::new();
        // Who lands has no setpoint to be away from any more.
        rig.settings.tracking_error.steps.retain(|s| s.reaction < Reaction::Land);
        let mut noise = noise_of(seed);
        rig.run(120.0, |h, _| h.tracking_error_m = Some(mean_m + noise_m * noise()));
        let count = |kind| rig.of(kind).len();
        prop_assert!(count(FailsafeEventKind::Raised) <= 1);
        prop_assert_eq!(count(FailsafeEventKind::Cleared), 0);
        prop_assert!(count(FailsafeEventKind::Ordered) <= 3);
    }

    /// Noise of any size: a trigger comes back no more often than it can recover.
    #[test]
    fn chatter_is_bounded_by_the_time_to_recover(seed in any::<u64>(), noise_m in 0.0..50.0, gap in 1..200_u32) {
        let mut rig = Rig::new();
        let mut noise = noise_of(seed);
        let mut period = 0;
        rig.run(120.0, |h, _| {
            period += 1;
            let bad = (period / gap) % 2 == 0;
            h.tracking_error_m = Some(if bad { noise_m * noise().abs() } else { 0.0 });
        });
        let at_most = 1 + (120.0 / rig.settings.recovered_after_s) as usize;
        prop_assert!(rig.of(FailsafeEventKind::Raised).len() <= at_most);
        prop_assert!(rig.orders().len() <= 3, "without a take-up the orders only get stronger");
    }

    #[test]
    fn nothing_panics_on_numbers_that_are_none(values in prop::collection::vec(any::<f64>(), 8), times in any::<[u64; 6]>()) {
        let mut failsafe = FailsafePolicy::new();
        let mut settings = FailsafeSettings {
            reaction_within_s: values[0],
            recovered_after_s: values[1],
            ..FailsafeSettings::default()
        };
        settings.clock_fault.clear_s = values[2];
        settings.tracking_error.steps[0].after_s = values[3];
        for at in times {
            let mut health = healthy(NodeTime(times[0]));
            health.last_heard = NodeTime(times[1]);
            health.position_time = Some(NodeTime(times[2]));
            health.coordinator_heard = Some(NodeTime(times[3]));
            health.tracking_error_m = Some(values[4]);
            health.disagreement_m = Some(values[5]);
            health.clock_offset_s = Some(values[6]);
            health.breach = Some(FenceBreach { reaction: Reaction::Hold, outside_m: values[7], zone: String::new() });
            failsafe.step(NodeTime(at), &health, &settings);
        }
    }
}

/// Numbers from -1 to 1 of a seed.
fn noise_of(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}
