//! The monitor in a small swarm whose messages are late, lost, or go one way only. Time is simulated; chance comes from seeds.

use super::*;
use crate::{Handover, LeaderState, Reaction, Unled};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

const STEP_S: f64 = 0.01;
const BEACON_S: f64 = 0.1;

#[derive(Clone, Copy)]
struct Air {
    loss: f64,
    delay_s: f64,
    jitter_s: f64,
}

const GOOD: Air = Air {
    loss: 0.0,
    delay_s: 0.002,
    jitter_s: 0.002,
};
const BAD: Air = Air {
    loss: 0.3,
    delay_s: 0.2,
    jitter_s: 0.05,
};

struct Node {
    id: NodeId,
    leadership: Leadership,
    monitor: LeaderMonitor,
    next_beacon_s: f64,
    up: bool,
}

struct Swarm {
    now_s: f64,
    air: Air,
    rng: ChaCha8Rng,
    nodes: Vec<Node>,
    flying: Vec<(f64, usize, Beacon)>,
    offers: Vec<Handover>,
    deaf: fn(from: usize, to: usize) -> bool,
}

impl Swarm {
    /// Nodes with these priorities, the first of them with id 1.
    fn new(priorities: &[Option<u8>], air: Air, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let node = |(index, priority): (usize, &Option<u8>)| {
            let id = NodeId(index as u64 + 1);
            let mut leadership = Leadership::new(id, None);
            leadership.set_priority(*priority);
            let monitor = LeaderMonitor::new(LeaderMonitorSettings::default(), NodeTime::from_seconds(0.0));
            let next_beacon_s = chance(&mut rng) * BEACON_S;
            Node {
                id,
                leadership,
                monitor,
                next_beacon_s,
                up: true,
            }
        };
        let nodes = priorities.iter().enumerate().map(node).collect();
        Self {
            now_s: 0.0,
            air,
            rng,
            nodes,
            flying: Vec::new(),
            offers: Vec::new(),
            deaf: |_, _| false,
        }
    }

    fn step(&mut self) {
        self.now_s += STEP_S;
        let now = NodeTime::from_seconds(self.now_s);
        let (due, later) = self.flying.drain(..).partition(|(at, ..)| *at <= self.now_s);
        self.flying = later;
        let due: Vec<(f64, usize, Beacon)> = due;
        for node in self.nodes.iter_mut().filter(|node| node.up) {
            node.monitor.look(now);
        }
        for (_, to, beacon) in due {
            if let Some(node) = self.nodes.get_mut(to).filter(|node| node.up) {
                node.leadership.hear(&beacon);
                node.monitor.hear(now, &node.leadership, &beacon);
            }
        }
        for offer in std::mem::take(&mut self.offers) {
            if let Some(heir) = self.nodes.iter_mut().find(|node| node.id == offer.to) {
                heir.leadership.take_over(&offer);
            }
        }
        for from in 0..self.nodes.len() {
            self.act(from, now);
        }
    }

    fn act(&mut self, from: usize, now: NodeTime) {
        let node = &mut self.nodes[from];
        if !node.up {
            return;
        }
        let claimed = match node.monitor.turn(now, &node.leadership) {
            Turn::Claim => node.leadership.claim().is_ok(),
            Turn::Renew => node.leadership.renew().is_ok(),
            Turn::HandOver(to) => {
                let offer = node.leadership.hand_over(to);
                self.offers.extend(offer);
                false
            }
            _ => false,
        };
        if !claimed && self.now_s < node.next_beacon_s {
            return;
        }
        node.next_beacon_s = self.now_s + BEACON_S;
        let beacon = node.monitor.beacon(now, node.id, &node.leadership);
        for to in (0..self.nodes.len()).filter(|to| *to != from) {
            let lost = chance(&mut self.rng) < self.air.loss;
            let late_s = self.air.delay_s + self.air.jitter_s * chance(&mut self.rng);
            if !lost && !(self.deaf)(from, to) {
                self.flying.push((self.now_s + late_s, to, beacon));
            }
        }
    }

    /// Starts again with what it had stored, as after a crash.
    fn restart(&mut self, index: usize, settings: LeaderMonitorSettings) {
        let now = NodeTime::from_seconds(self.now_s);
        let node = &mut self.nodes[index];
        let standing = node.leadership.standing();
        node.leadership = Leadership::new(node.id, node.leadership.obeyed());
        node.leadership.set_priority(standing.map(|standing| standing.priority));
        node.monitor = LeaderMonitor::new(settings, now);
        node.up = true;
    }

    fn run(&mut self, for_s: f64) {
        let end_s = self.now_s + for_s;
        while self.now_s < end_s {
            self.step();
        }
    }

    /// Seconds until all that are up obey the same holder, who is up and acts in another term than `before`.
    fn until_agreed_s(&mut self, before: Option<Term>) -> f64 {
        let start_s = self.now_s;
        while self.agreed().is_none_or(|term| Some(term) == before) {
            assert!(self.now_s - start_s < 10.0, "no agreement");
            self.step();
        }
        self.now_s - start_s
    }

    fn agreed(&self) -> Option<Term> {
        let mut up = self.nodes.iter().filter(|node| node.up);
        let term = up.next()?.leadership.obeyed()?;
        let same = up.all(|node| node.leadership.obeyed() == Some(term));
        let acts = self
            .nodes
            .iter()
            .any(|node| node.up && node.leadership.acting() == Some(term));
        (same && acts).then_some(term)
    }
}

fn chance(rng: &mut ChaCha8Rng) -> f64 {
    rng.random()
}

fn percentile(sorted: &[f64], share: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * share).round() as usize]
}

/// Times from a holder's death to everyone obeying its successor, over so many deaths.
fn failovers_s(air: Air, kills: u64) -> Vec<f64> {
    let mut times: Vec<f64> = (0..kills)
        .map(|seed| {
            let mut swarm = Swarm::new(&[Some(9), Some(5), Some(5), Some(1), None, None], air, seed);
            swarm.until_agreed_s(None);
            swarm.run(1.0 + (seed % 10) as f64 * STEP_S);
            let before = swarm.agreed();
            let holder = before.map(|term| term.holder.node);
            for node in swarm.nodes.iter_mut().filter(|node| Some(node.id) == holder) {
                node.up = false;
            }
            swarm.until_agreed_s(before)
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times
}

#[test]
fn the_best_of_those_who_start_takes_the_first_term() {
    let mut swarm = Swarm::new(&[Some(1), None, Some(7), Some(7)], GOOD, 3);
    swarm.until_agreed_s(None);
    let term = swarm.agreed().unwrap();
    assert_eq!(
        (term.number, term.holder.node),
        (1, NodeId(3)),
        "of two equals the smaller id"
    );
}

#[test]
fn a_dead_holder_is_succeeded_within_a_second() {
    let times = failovers_s(GOOD, 200);
    let (p50, p99) = (percentile(&times, 0.5), percentile(&times, 0.99));
    println!("200 holders killed: successor obeyed by all after {p50:.2} s (p50), {p99:.2} s (p99)");
    assert!(p99 <= 1.0, "{p99}");
}

#[test]
fn nobody_takes_over_while_the_holder_is_there_in_bad_air_too() {
    for seed in 0..20 {
        let mut swarm = Swarm::new(&[Some(9), Some(5), Some(5), None, None, None], BAD, seed);
        swarm.until_agreed_s(None);
        swarm.run(2.0);
        let before = swarm.agreed().unwrap();
        swarm.run(60.0);
        assert_eq!(swarm.agreed(), Some(before), "seed {seed}");
    }
}

#[test]
fn a_holder_that_one_candidate_cannot_hear_is_not_missed() {
    let mut swarm = Swarm::new(&[Some(9), Some(8), None], GOOD, 1);
    swarm.deaf = |from, to| from == 0 && to == 1;
    swarm.until_agreed_s(None);
    let before = swarm.agreed().unwrap();
    swarm.run(20.0);
    assert_eq!(swarm.agreed(), Some(before), "its pulse comes over the third");
}

#[test]
fn two_who_hear_each_other_do_not_keep_a_dead_holder_alive() {
    let times = failovers_s(BAD, 200);
    let (p50, p99) = (percentile(&times, 0.5), percentile(&times, 0.99));
    println!("the same with 30 % loss and 200 to 250 ms: {p50:.2} s (p50), {p99:.2} s (p99)");
    assert!(p99 < 2.5, "two who duel for the next number take longer: {times:?}");
}

#[test]
fn each_part_of_a_divided_swarm_has_a_holder_and_the_whole_has_one_again() {
    let mut swarm = Swarm::new(&[Some(9), None, None, Some(5), None, None], GOOD, 5);
    swarm.until_agreed_s(None);
    let whole = swarm.agreed().unwrap();
    swarm.deaf = |from, to| (from < 3) != (to < 3);
    swarm.run(5.0);
    assert_eq!(
        swarm.nodes[1].leadership.obeyed(),
        Some(whole),
        "the part with the holder goes on"
    );
    let other = swarm.nodes[5].leadership.obeyed().unwrap();
    assert_eq!((other.number, other.holder.node), (2, NodeId(4)));
    swarm.deaf = |_, _| false;
    swarm.run(1.0);
    assert_eq!(swarm.agreed(), Some(other), "the greater number wins");
}

#[test]
fn who_is_cut_off_alone_does_not_take_over() {
    let mut swarm = Swarm::new(&[Some(9), Some(5), None], GOOD, 5);
    swarm.until_agreed_s(None);
    let whole = swarm.agreed().unwrap();
    swarm.deaf = |from, to| from == 1 || to == 1;
    swarm.run(5.0);
    let now = NodeTime::from_seconds(swarm.now_s);
    let alone = &swarm.nodes[1];
    assert_eq!(alone.monitor.turn(now, &alone.leadership), Turn::Alone);
    swarm.deaf = |_, _| false;
    swarm.run(1.0);
    assert_eq!(swarm.agreed(), Some(whole), "and changes nothing when it is back");
}

#[test]
fn a_holder_that_starts_again_is_a_follower_or_takes_a_new_term() {
    let mut swarm = Swarm::new(&[Some(9), Some(5), None], GOOD, 8);
    swarm.until_agreed_s(None);
    let before = swarm.agreed();
    swarm.restart(0, LeaderMonitorSettings::default());
    swarm.until_agreed_s(before);
    assert_eq!(swarm.agreed().unwrap().holder.node, NodeId(2));
    swarm.run(10.0);
    assert_eq!(
        swarm.agreed().unwrap().number,
        2,
        "it does not take back what others hold"
    );
}

#[test]
fn who_obeys_a_dead_holder_of_the_same_number_is_taken_along() {
    let mut swarm = Swarm::new(&[Some(5), None, None], GOOD, 8);
    swarm.until_agreed_s(None);
    let number = swarm.agreed().unwrap().number;
    let dead = Term {
        number,
        holder: Standing {
            priority: 9,
            node: NodeId(77),
        },
    };
    swarm.nodes[2].leadership = Leadership::new(NodeId(3), Some(dead));
    swarm.run(2.0);
    let agreed = swarm.agreed().unwrap();
    assert_eq!((agreed.number, agreed.holder.node), (number + 1, NodeId(1)));
}

#[test]
fn a_half_without_the_holder_takes_over_only_where_every_part_may() {
    let apart = |from: usize, to: usize| (from < 3) != (to < 3);
    let majority = LeaderMonitorSettings {
        apart: Apart::Majority,
        ..LeaderMonitorSettings::default()
    };
    let mut swarm = Swarm::new(&[Some(9), None, None, Some(5), None, None], GOOD, 5);
    for index in 0..6 {
        swarm.restart(index, majority);
    }
    swarm.until_agreed_s(None);
    let whole = swarm.agreed().unwrap();
    swarm.deaf = apart;
    swarm.run(8.0);
    let now = NodeTime::from_seconds(swarm.now_s);
    let candidate = &swarm.nodes[3];
    assert_eq!(candidate.monitor.turn(now, &candidate.leadership), Turn::Minority);
    let unled = Unled {
        after_s: 5.0,
        reaction: Reaction::Hold,
    };
    let of = |index: usize| {
        let node = &swarm.nodes[index];
        node.monitor.leader_state(now, &node.leadership, &unled)
    };
    assert_eq!(of(1), LeaderState::Led { term: whole });
    assert!(
        matches!(of(4), LeaderState::Unled { term, reaction: Reaction::Hold, .. } if term == whole),
        "{:?}",
        of(4)
    );
    swarm.deaf = |_, _| false;
    swarm.run(1.0);
    assert_eq!(swarm.agreed(), Some(whole));
}

#[test]
fn a_majority_succeeds_its_holder() {
    let mut swarm = Swarm::new(&[Some(9), None, Some(5), None, None], GOOD, 6);
    for index in 0..5 {
        let apart = Apart::Majority;
        swarm.restart(
            index,
            LeaderMonitorSettings {
                apart,
                ..LeaderMonitorSettings::default()
            },
        );
    }
    swarm.until_agreed_s(None);
    let before = swarm.agreed();
    swarm.nodes[0].up = false;
    assert!(swarm.until_agreed_s(before) <= 1.0);
}

#[test]
fn a_holder_that_can_go_on_no_longer_hands_over_and_everyone_stays_led() {
    let mut swarm = Swarm::new(&[Some(9), Some(3), Some(5), None], GOOD, 2);
    swarm.until_agreed_s(None);
    swarm.run(1.0);
    let before = swarm.agreed();
    swarm.nodes[0].leadership.set_priority(None);
    while swarm.agreed().is_none_or(|term| Some(term) == before) {
        swarm.step();
        let now = NodeTime::from_seconds(swarm.now_s);
        let led = |node: &Node| node.monitor.leader_state(now, &node.leadership, &Unled::default());
        assert!(
            swarm
                .nodes
                .iter()
                .all(|node| matches!(led(node), LeaderState::Led { .. }))
        );
    }
    assert_eq!(swarm.agreed().unwrap().holder.node, NodeId(3));
}

#[test]
fn nobody_takes_the_leadership_from_a_holder_that_is_heard_unless_it_is_asked_to() {
    let mut swarm = Swarm::new(&[Some(5), Some(3), Some(9), None], GOOD, 4);
    swarm.nodes[2].up = false;
    swarm.until_agreed_s(None);
    let before = swarm.agreed().unwrap();
    swarm.restart(2, LeaderMonitorSettings::default());
    swarm.run(20.0);
    assert_eq!(swarm.agreed(), Some(before), "a better priority alone takes nothing");
    swarm.nodes[2].leadership.claim().unwrap();
    assert!(swarm.until_agreed_s(Some(before)) < 0.3);
    assert_eq!(swarm.agreed().unwrap().holder.node, NodeId(3));
}

#[test]
fn one_late_word_of_a_rival_is_no_reason_for_a_new_term() {
    let mut swarm = Swarm::new(&[Some(5), None, None], GOOD, 8);
    swarm.until_agreed_s(None);
    let agreed = swarm.agreed().unwrap();
    let holder = Standing {
        priority: 9,
        node: NodeId(77),
    };
    let rival = Term { holder, ..agreed };
    let late = Beacon {
        from: NodeId(3),
        obeys: Some(rival),
        pulse: 4,
        standing: None,
    };
    let now = NodeTime::from_seconds(swarm.now_s);
    let node = &mut swarm.nodes[0];
    node.leadership.hear(&late);
    node.monitor.hear(now, &node.leadership, &late);
    swarm.run(5.0);
    assert_eq!(swarm.agreed(), Some(agreed));
}

#[test]
fn a_node_that_stood_still_misses_nobody_for_that_time() {
    let at = NodeTime::from_seconds;
    let mut holder = Leadership::new(NodeId(1), None);
    holder.set_priority(Some(9));
    holder.claim().unwrap();
    let mut sender = LeaderMonitor::new(LeaderMonitorSettings::default(), at(0.0));
    let mut leadership = Leadership::new(NodeId(2), None);
    leadership.set_priority(Some(5));
    let mut monitor = LeaderMonitor::new(LeaderMonitorSettings::default(), at(0.0));
    let mut look_until = |monitor: &mut LeaderMonitor, from_s: f64, until_s: f64, heard: bool| {
        let looks = ((until_s - from_s) / STEP_S).round() as usize;
        for look in 1..=looks {
            let now = at(from_s + look as f64 * STEP_S);
            monitor.look(now);
            if heard && look % 10 == 0 {
                let beacon = sender.beacon(now, NodeId(1), &holder);
                leadership.hear(&beacon);
                monitor.hear(now, &leadership, &beacon);
            }
        }
        monitor.turn(at(until_s), &leadership)
    };
    assert_eq!(look_until(&mut monitor, 0.0, 5.0, true), Turn::Held);
    // Two seconds of nothing, then the first look: the holder is not yet missed, and nobody takes over.
    assert_eq!(look_until(&mut monitor, 6.99, 7.0, false), Turn::Held);
    assert!(monitor.silent_s(at(7.0)).unwrap() < 0.3);
    assert_eq!(monitor.present(at(7.0)).count(), 1);
    // If it stays silent though this node looks, it is missed as always.
    assert_ne!(look_until(&mut monitor, 7.0, 7.5, false), Turn::Held);
}

#[test]
fn a_node_that_is_always_late_misses_a_dead_holder_all_the_same() {
    let at = NodeTime::from_seconds;
    let mut holder = Leadership::new(NodeId(1), None);
    holder.set_priority(Some(9));
    holder.claim().unwrap();
    let mut monitor = LeaderMonitor::new(LeaderMonitorSettings::default(), at(0.0));
    let mut leadership = Leadership::new(NodeId(2), None);
    monitor.look(at(0.0));
    let beacon = LeaderMonitor::new(LeaderMonitorSettings::default(), at(0.0)).beacon(at(0.0), NodeId(1), &holder);
    leadership.hear(&beacon);
    monitor.hear(at(0.0), &leadership, &beacon);
    (1..=4).for_each(|look| monitor.look(at(f64::from(look) * 0.4)));
    assert!(monitor.silent_s(at(1.6)).unwrap() > 0.9);
}

#[test]
fn its_own_beacon_sent_back_keeps_nobody_company() {
    let now = NodeTime::from_seconds(10.0);
    let mut leadership = Leadership::new(NodeId(1), None);
    leadership.set_priority(Some(5));
    let mut monitor = LeaderMonitor::new(LeaderMonitorSettings::default(), NodeTime::from_seconds(0.0));
    let own = monitor.beacon(now, NodeId(1), &leadership);
    monitor.hear(now, &leadership, &own);
    assert_eq!(monitor.turn(now, &leadership), Turn::Alone);
}

/// Crashes, restarts, parts and one-way links at random; then all is well again. Terms only grow all the while, and in the end one holds.
#[test]
fn whatever_has_happened_those_who_hear_each_other_end_with_one_coordinator() {
    const WAYS: [fn(usize, usize) -> bool; 4] = [
        |_, _| false,
        |from, to| (from < 3) != (to < 3),
        |from, to| from % 2 == 0 && to % 2 == 1,
        |from, to| from == 0 || to == 5,
    ];
    let mut longest_s = 0.0_f64;
    for seed in 0..100 {
        let air = if seed % 2 == 0 { GOOD } else { BAD };
        let mut swarm = Swarm::new(&[Some(9), Some(5), None, Some(5), Some(1), None], air, seed);
        let mut numbers = vec![0; swarm.nodes.len()];
        for _ in 0..12 {
            let which = (chance(&mut swarm.rng) * 6.0) as usize;
            swarm.deaf = WAYS[(chance(&mut swarm.rng) * 4.0) as usize];
            match swarm.nodes[which].up {
                true => swarm.nodes[which].up = false,
                false => swarm.restart(which, LeaderMonitorSettings::default()),
            }
            let for_s = chance(&mut swarm.rng) * 3.0;
            swarm.run(for_s);
            for (number, node) in numbers.iter_mut().zip(&swarm.nodes) {
                let now = node.leadership.obeyed().map_or(0, |term| term.number);
                assert!(now >= *number, "seed {seed}: a term went back");
                *number = now;
            }
        }
        swarm.deaf = |_, _| false;
        for which in 0..swarm.nodes.len() {
            if !swarm.nodes[which].up {
                swarm.restart(which, LeaderMonitorSettings::default());
            }
        }
        swarm.until_agreed_s(None);
        swarm.run(3.0);
        longest_s = longest_s.max(swarm.until_agreed_s(None));
        let settled = swarm.agreed();
        swarm.run(10.0);
        assert_eq!(swarm.agreed(), settled, "seed {seed}: and it stays so");
    }
    assert!(longest_s <= 1.0, "{longest_s}");
}
