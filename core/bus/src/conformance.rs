//! What every transport must pass under the bus: the same scenes over each of them.
//!
//! Must never do: know a transport; ask more of one than the poorest of them keeps. A scene fails by panicking, as a test does.
//!
//! A [`Rig`] makes transports and moves time: simulated for those that take time as an argument, real for those that go through the system.

use crate::bus::{Bus, BusSettings, Event, pump};
use crate::envelope::{Boot, SwarmKey};
use crate::latest::Key;
use crate::transport::{Class, Datagram, SendError, To, Transport, Wake};
use skein_domain::{NodeId, NodeTime};
use std::collections::BTreeMap;

mod scenes;

/// The surroundings of one kind of transport.
pub trait Rig {
    /// The transport.
    type Transport: Transport;

    /// Brings a node to the others, or brings it back under the same id after its transport was dropped.
    fn join(&mut self, node: NodeId) -> Self::Transport;

    /// Lets some hundredths of a second go by at most; gives the time.
    fn step(&mut self) -> NodeTime;
}

/// How long a scene may take, in seconds of the rig's time. Far longer than any needs: it ends those that hang.
const PATIENCE_S: f64 = 60.0;
const SECRET: &[u8] = b"a secret that only the swarm has";
const A: NodeId = NodeId(0xa1);
const B: NodeId = NodeId(0xb2);
const C: NodeId = NodeId(0xc3);

/// One scene over a rig of its own.
type OneScene<R> = fn(&mut R);

/// All scenes, by name.
fn scenes<R: Rig>() -> [(&'static str, OneScene<R>); 10] {
    [
        (
            "datagrams go where they are meant to",
            scenes::datagrams_go_where_they_are_meant_to,
        ),
        ("who waits is woken", scenes::who_waits_is_woken),
        ("the newest state is known", scenes::the_newest_state_is_known),
        (
            "who joins late learns what is so",
            scenes::who_joins_late_learns_what_is_so,
        ),
        (
            "commands come once and in order",
            scenes::commands_come_once_and_in_order,
        ),
        (
            "who starts again is served again",
            scenes::who_starts_again_is_served_again,
        ),
        ("questions have one end", scenes::questions_have_one_end),
        (
            "bulk comes whole and is in nobody's way",
            scenes::bulk_comes_whole_and_is_in_nobodys_way,
        ),
        ("strangers are not heard", scenes::strangers_are_not_heard),
        ("what was recorded is of no use", scenes::what_was_recorded_is_of_no_use),
    ]
}

/// Runs all scenes, each over a rig of its own.
pub fn all<R: Rig>(rig: impl Fn() -> R) {
    for (name, scene) in scenes() {
        println!("  {name}");
        scene(&mut rig());
    }
}

/// Runs all scenes at once, each on a thread of its own: for rigs of real time, of which most is waiting.
pub fn all_at_once<R: Rig>(rig: impl Fn() -> R + Sync) {
    std::thread::scope(|threads| {
        for (name, scene) in scenes() {
            let rig = &rig;
            let thread = std::thread::Builder::new().name(name.to_owned());
            let begun = thread.spawn_scoped(threads, move || scene(&mut rig()));
            assert!(begun.is_ok(), "{begun:?}");
        }
    });
}

/// One node on the bus, with what has happened to it.
struct Party<T> {
    bus: Bus,
    transport: T,
    events: Vec<Event>,
    /// All that its transport handed out, for scenes that send it again.
    recorded: Vec<Datagram>,
}

struct Scene<'r, R: Rig> {
    rig: &'r mut R,
    now: NodeTime,
    parties: BTreeMap<NodeId, Party<R::Transport>>,
    boots: u64,
}

impl<'r, R: Rig> Scene<'r, R> {
    fn new(rig: &'r mut R, nodes: &[NodeId]) -> Self {
        let now = rig.step();
        let parties = BTreeMap::new();
        let mut scene = Self {
            rig,
            now,
            parties,
            boots: 0,
        };
        for node in nodes {
            scene.join(*node, SECRET);
        }
        scene
    }

    /// Lets a node begin, or begin again.
    fn join(&mut self, node: NodeId, secret: &[u8]) {
        self.parties.remove(&node);
        self.boots += 1;
        let transport = self.rig.join(node);
        let settings = BusSettings {
            datagram_bytes: transport.largest_bytes().min(1200),
            ..BusSettings::default()
        };
        let key = SwarmKey::derive("conformance", secret);
        let key = key.unwrap_or_else(|weak| panic!("{weak}"));
        let bus = Bus::new(settings, key, node, Boot(self.boots << 8 | node.0), self.now);
        let party = Party {
            bus,
            transport,
            events: Vec::new(),
            recorded: Vec::new(),
        };
        self.parties.insert(node, party);
    }

    fn step(&mut self) {
        self.now = self.rig.step();
        for party in self.parties.values_mut() {
            let Party {
                bus,
                transport,
                events,
                recorded,
            } = party;
            let mut tap = Tap {
                inner: transport,
                recorded,
            };
            let happened = pump(bus, &mut tap, self.now);
            events.extend(happened.unwrap_or_else(|error| panic!("{error}")));
        }
    }

    fn until(&mut self, what: &str, mut done: impl FnMut(&Self) -> bool) {
        let begun = self.now;
        while !done(self) {
            let took_s = self.now.seconds_since(begun);
            assert!(took_s < PATIENCE_S, "after {took_s} s it was still not so that {what}");
            self.step();
        }
    }

    fn run(&mut self, for_s: f64) {
        let begun = self.now;
        while self.now.seconds_since(begun) < for_s {
            self.step();
        }
    }

    fn bus(&mut self, node: NodeId) -> &mut Bus {
        &mut self.party(node).bus
    }

    fn party(&mut self, node: NodeId) -> &mut Party<R::Transport> {
        self.parties
            .get_mut(&node)
            .unwrap_or_else(|| panic!("{node} is not there"))
    }

    fn events(&self, node: NodeId) -> &[Event] {
        self.parties.get(&node).map_or(&[], |party| &party.events)
    }

    fn saw(&self, node: NodeId, event: impl Fn(&Event) -> bool) -> bool {
        self.events(node).iter().any(event)
    }

    fn commands(&self, at: NodeId, of: NodeId) -> Vec<u32> {
        let bodies = self.events(at).iter().filter_map(|event| match event {
            Event::Command { from, body } if *from == of => Some(number(body)),
            _ => None,
        });
        bodies.collect()
    }

    /// Everyone has proven itself to everyone.
    fn meet(&mut self) {
        let now = self.now;
        for (node, party) in &mut self.parties {
            let told = party.bus.tell(now, Key(0), node.0.to_be_bytes().to_vec());
            assert_eq!(told, Ok(()));
        }
        self.until("all know each other's present run", |scene| {
            let knows =
                |bus: &Bus, other: &Bus| other.node() == bus.node() || bus.run_of(other.node()) == Some(other.boot());
            let mut parties = scene.parties.values();
            parties.all(|party| scene.parties.values().all(|other| knows(&party.bus, &other.bus)))
        });
    }
}

/// Keeps a copy of all that comes through it.
struct Tap<'t, T> {
    inner: &'t mut T,
    recorded: &'t mut Vec<Datagram>,
}

impl<T: Transport> Transport for Tap<'_, T> {
    fn node(&self) -> NodeId {
        self.inner.node()
    }

    fn largest_bytes(&self) -> usize {
        self.inner.largest_bytes()
    }

    fn send(&mut self, now: NodeTime, to: To, class: Class, bytes: &[u8]) -> Result<(), SendError> {
        self.inner.send(now, to, class, bytes)
    }

    fn receive(&mut self, now: NodeTime) -> Option<Datagram> {
        let datagram = self.inner.receive(now);
        self.recorded.extend(datagram.clone());
        datagram
    }

    fn wake_on_arrival(&mut self, wake: Wake) {
        self.inner.wake_on_arrival(wake);
    }

    fn overflowed(&self) -> u64 {
        self.inner.overflowed()
    }
}

fn number(body: &[u8]) -> u32 {
    body.iter().fold(0, |value, byte| value << 8 | u32::from(*byte))
}

fn body(number: u32) -> Vec<u8> {
    number.to_be_bytes().to_vec()
}

#[cfg(test)]
mod tests;
