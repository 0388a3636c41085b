//! Every order of messages, losses, repetitions, crashes, false alarms and operators' wishes in a small swarm, explored.
//!
//! Messages once sent may arrive at any later time, any number of times, or never: so the network is the set of all that was ever sent.
//! A holder may be taken for lost at any moment, so that no timing is assumed. What the model steps is the shipped [`Leadership`].

use skein_domain::NodeId;
use skein_failover::{Beacon, Handover, Leadership, Term};
use stateright::{Checker, Model, Property};
use std::collections::{BTreeMap, BTreeSet};

/// A rule that is broken on purpose, to see that the properties find it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Broken {
    Nothing,
    /// A second holder of the obeyed number is obeyed if it is better suited.
    ObeysTheBetter,
    /// The term is not stored before the node goes on.
    ForgetsOverARestart,
    /// Orders are carried out whatever their term.
    ObeysOldOrders,
    /// Two who hold the same number leave it at that.
    LeavesRivalsAlone,
    /// Who takes the leadership does so under the number that is obeyed already.
    TakesTheSameNumber,
}

#[derive(Clone)]
struct Swarm {
    /// Priority of each node; none for one that can't coordinate.
    nodes: Vec<Option<u8>>,
    greatest_number: u64,
    crashes: u8,
    broken: Broken,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Sent {
    Beacon {
        from: u64,
        obeys: (u64, u8, u64),
    },
    Offer {
        number: u64,
        priority: u8,
        holder: u64,
        to: u64,
    },
    Order {
        number: u64,
        priority: u8,
        holder: u64,
    },
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct State {
    leaderships: Vec<Leadership>,
    up: Vec<bool>,
    sent: BTreeSet<Sent>,
    crashes: u8,
    /// What is checked, kept apart from the code under test: per node and number whom it obeyed, and the greatest number.
    obeyed: Vec<BTreeMap<u64, u64>>,
    faults: BTreeSet<&'static str>,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Action {
    Deliver(usize, Sent),
    /// It misses the holder, or an operator asks it to take the leadership.
    Claim(usize),
    HandOver(usize, u64),
    Order(usize),
    Crash(usize),
    Restart(usize),
}

fn term(number: u64, priority: u8, holder: u64) -> Term {
    let holder = skein_failover::Standing {
        priority,
        node: NodeId(holder),
    };
    Term { number, holder }
}

fn beacon(from: u64, obeys: Option<Term>) -> Beacon {
    Beacon {
        from: NodeId(from),
        obeys,
        pulse: 0,
        standing: None,
    }
}

fn parts(term: Term) -> (u64, u8, u64) {
    (term.number, term.holder.priority, term.holder.node.0)
}

impl Swarm {
    fn leadership(&self, node: usize, obeyed: Option<Term>) -> Leadership {
        let mut leadership = Leadership::new(NodeId(node as u64), obeyed);
        leadership.set_priority(self.nodes[node]);
        leadership
    }

    fn deliver(&self, state: &mut State, node: usize, message: &Sent) {
        let leadership = &mut state.leaderships[node];
        match message {
            Sent::Beacon { from, obeys } => {
                let told = term(obeys.0, obeys.1, obeys.2);
                let better = leadership
                    .obeyed()
                    .is_some_and(|mine| mine.number == told.number && told.holder > mine.holder);
                if self.broken == Broken::ObeysTheBetter && better {
                    *leadership = self.leadership(node, Some(told));
                }
                let beacon = beacon(*from, Some(told));
                self.hear(leadership, &beacon);
            }
            Sent::Offer {
                number,
                priority,
                holder,
                to,
            } => {
                leadership.take_over(&Handover {
                    term: term(*number, *priority, *holder),
                    to: NodeId(*to),
                });
            }
            Sent::Order {
                number,
                priority,
                holder,
            } => {
                let carried_out = leadership.order(term(*number, *priority, *holder)).is_ok();
                let greatest = state.obeyed[node].keys().next_back().copied().unwrap_or(0);
                if (carried_out || self.broken == Broken::ObeysOldOrders) && *number < greatest {
                    state.faults.insert("an order of an old term was carried out");
                }
                if carried_out && state.obeyed[node].get(number).is_some_and(|known| known != holder) {
                    state.faults.insert("an order of a second holder was carried out");
                }
            }
        }
    }

    fn hear(&self, leadership: &mut Leadership, beacon: &Beacon) {
        match (self.broken, beacon.obeys) {
            (Broken::LeavesRivalsAlone, Some(told)) => {
                let _obeyed_or_not = leadership.order(told);
            }
            _ => leadership.hear(beacon),
        }
    }

    /// Looks at the node as it is now, and sends what it tells the others.
    fn settle(&self, state: &mut State, node: usize) {
        let Some(obeyed) = state.leaderships[node].obeyed().filter(|_| state.up[node]) else {
            return;
        };
        let (number, _, holder) = parts(obeyed);
        let known = &mut state.obeyed[node];
        if known.keys().next_back().is_some_and(|greatest| *greatest > number) {
            state.faults.insert("a term went back");
        }
        if *known.entry(number).or_insert(holder) != holder {
            state.faults.insert("two holders of one number were obeyed");
        }
        state.sent.insert(Sent::Beacon {
            from: node as u64,
            obeys: parts(obeyed),
        });
    }
}

impl Model for Swarm {
    type State = State;
    type Action = Action;

    fn init_states(&self) -> Vec<State> {
        vec![State {
            leaderships: (0..self.nodes.len()).map(|node| self.leadership(node, None)).collect(),
            up: vec![true; self.nodes.len()],
            sent: BTreeSet::new(),
            crashes: 0,
            obeyed: vec![BTreeMap::new(); self.nodes.len()],
            faults: BTreeSet::new(),
        }]
    }

    fn actions(&self, state: &State, actions: &mut Vec<Action>) {
        for node in 0..self.nodes.len() {
            if !state.up[node] {
                actions.push(Action::Restart(node));
                continue;
            }
            actions.extend(state.sent.iter().map(|message| Action::Deliver(node, message.clone())));
            actions.push(Action::Claim(node));
            if state.leaderships[node].acting().is_some() {
                actions.push(Action::Order(node));
                actions.extend((0..self.nodes.len() as u64).map(|to| Action::HandOver(node, to)));
            }
            if state.crashes < self.crashes {
                actions.push(Action::Crash(node));
            }
        }
    }

    fn next_state(&self, last: &State, action: Action) -> Option<State> {
        let mut state = last.clone();
        let node = match action {
            Action::Deliver(node, message) => {
                self.deliver(&mut state, node, &message);
                node
            }
            Action::Claim(node) => {
                let before = state.leaderships[node].obeyed();
                let mut claimed = state.leaderships[node].claim().ok()?;
                if let Some(before) = before.filter(|_| self.broken == Broken::TakesTheSameNumber) {
                    claimed.number = before.number;
                    state.leaderships[node] = self.leadership(node, Some(claimed));
                }
                node
            }
            Action::HandOver(node, to) => {
                let offer = state.leaderships[node].hand_over(NodeId(to))?;
                let (number, priority, holder) = parts(offer.term);
                state.sent.insert(Sent::Offer {
                    number,
                    priority,
                    holder,
                    to,
                });
                node
            }
            Action::Order(node) => {
                let (number, priority, holder) = parts(state.leaderships[node].acting()?);
                state.sent.insert(Sent::Order {
                    number,
                    priority,
                    holder,
                });
                node
            }
            Action::Crash(node) => {
                state.up[node] = false;
                state.crashes += 1;
                node
            }
            Action::Restart(node) => {
                let stored = state.leaderships[node]
                    .obeyed()
                    .filter(|_| self.broken != Broken::ForgetsOverARestart);
                state.leaderships[node] = self.leadership(node, stored);
                state.up[node] = true;
                node
            }
        };
        self.settle(&mut state, node);
        (state != *last).then_some(state)
    }

    fn within_boundary(&self, state: &State) -> bool {
        let number = |leadership: &Leadership| leadership.obeyed().map_or(0, |term| term.number);
        state
            .leaderships
            .iter()
            .all(|leadership| number(leadership) <= self.greatest_number)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        vec![
            Property::<Self>::always("no vehicle obeys two holders in one term", |_, state| {
                !state.faults.contains("two holders of one number were obeyed")
                    && !state.faults.contains("an order of a second holder was carried out")
            }),
            Property::<Self>::always("terms only grow", |_, state| !state.faults.contains("a term went back")),
            Property::<Self>::always("no order of an old term is carried out", |_, state| {
                !state.faults.contains("an order of an old term was carried out")
            }),
            Property::<Self>::always("those who hear each other end with one coordinator", settles),
            Property::<Self>::sometimes("two coordinators of one number meet", |_, state| {
                let acting: Vec<Term> = state.leaderships.iter().filter_map(Leadership::acting).collect();
                acting
                    .iter()
                    .any(|a| acting.iter().any(|b| a.number == b.number && a.holder != b.holder))
            }),
            Property::<Self>::sometimes("the leadership is handed over", |_, state| {
                let offered = |s: &Sent| matches!(s, Sent::Offer { .. });
                state.sent.iter().any(offered) && state.leaderships.iter().filter(|o| o.acting().is_some()).count() == 2
            }),
        ]
    }
}

/// From here on everyone is up, hears everyone, and the best suited claims when nobody acts: do they agree within a few rounds?
fn settles(swarm: &Swarm, state: &State) -> bool {
    let mut leaderships: Vec<Leadership> = state.leaderships.clone();
    for (node, leadership) in leaderships.iter_mut().enumerate().filter(|(node, _)| !state.up[*node]) {
        *leadership = swarm.leadership(node, leadership.obeyed());
    }
    for round in 0..6 {
        for from in 0..leaderships.len() {
            let beacon = beacon(from as u64, leaderships[from].obeyed());
            for leadership in &mut leaderships {
                swarm.hear(leadership, &beacon);
            }
        }
        // A holder that has met another holder of its number for some rounds takes the next number, as the monitor would have it.
        let told: Vec<Term> = leaderships.iter().filter_map(Leadership::obeyed).collect();
        let renews = round == 2 && swarm.broken != Broken::LeavesRivalsAlone;
        for leadership in leaderships.iter_mut().filter(|_| renews) {
            let divided = |mine: Term| {
                told.iter()
                    .any(|term| term.number == mine.number && term.holder != mine.holder)
            };
            if leadership.acting().is_some_and(divided) {
                let _term = leadership.renew();
            }
        }
        if !leaderships.iter().any(|leadership| leadership.acting().is_some()) {
            let best = (0..leaderships.len()).max_by_key(|node| leaderships[*node].standing());
            let _term = best.and_then(|best| leaderships[best].claim().ok());
        }
    }
    let acting: Vec<Term> = leaderships.iter().filter_map(Leadership::acting).collect();
    acting.len() == 1
        && leaderships
            .iter()
            .all(|leadership| leadership.obeyed() == acting.first().copied())
}

fn explored(swarm: Swarm) -> impl Checker<Swarm> {
    swarm.checker().threads(2).spawn_bfs().join()
}

fn report(name: &str, checker: &impl Checker<Swarm>) {
    println!(
        "{name}: {} states, {} of them different, {} steps deep",
        checker.state_count(),
        checker.unique_state_count(),
        checker.max_depth()
    );
    for property in checker.model().properties() {
        println!("  {:?}: {}", property.expectation, property.name);
    }
}

fn sound(nodes: Vec<Option<u8>>, greatest_number: u64, crashes: u8) -> Swarm {
    Swarm {
        nodes,
        greatest_number,
        crashes,
        broken: Broken::Nothing,
    }
}

#[test]
fn two_candidates_and_a_vehicle_keep_the_properties() {
    let checker = explored(sound(vec![Some(2), Some(1), None], 2, 1));
    report("two candidates and a vehicle", &checker);
    checker.assert_properties();
}

#[test]
fn more_candidates_more_terms_and_more_of_both_keep_them_too() {
    let swarms = [
        ("three candidates", sound(vec![Some(3), Some(2), Some(1)], 2, 0)),
        (
            "two candidates and a vehicle over three terms",
            sound(vec![Some(2), Some(1), None], 3, 0),
        ),
        ("two candidates over four terms", sound(vec![Some(2), Some(1)], 4, 1)),
    ];
    for (name, swarm) in swarms {
        let checker = explored(swarm);
        report(name, &checker);
        checker.assert_properties();
    }
}

#[test]
fn broken_rules_are_found() {
    let found = [
        (Broken::ObeysTheBetter, "no vehicle obeys two holders in one term"),
        (Broken::ForgetsOverARestart, "no vehicle obeys two holders in one term"),
        (Broken::ObeysOldOrders, "no order of an old term is carried out"),
        (
            Broken::LeavesRivalsAlone,
            "those who hear each other end with one coordinator",
        ),
        (Broken::TakesTheSameNumber, "no vehicle obeys two holders in one term"),
    ];
    for (broken, property) in found {
        let swarm = Swarm {
            broken,
            ..sound(vec![Some(2), Some(1), None], 2, 1)
        };
        let checker = swarm
            .checker()
            .threads(2)
            .finish_when(stateright::HasDiscoveries::AnyFailures)
            .spawn_bfs()
            .join();
        let names: Vec<&str> = checker.discoveries().into_keys().collect();
        assert!(names.contains(&property), "{broken:?} was not found, only {names:?}");
        println!("{broken:?} is found: {property}");
    }
}
