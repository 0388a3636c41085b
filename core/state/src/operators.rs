//! What operators tell this node, and what is known of them: control authority, sticks for other nodes' vehicles, red items that somebody takes
//! upon himself, the key of the emergency stop, signs of life.
//!
//! Must never do: judge who may do what (that is the control table's, the preflight report's and the API's), or stop anything.

use crate::by_hand::Relays;
use parking_lot::{Mutex, MutexGuard};
use skein_domain::NodeTime;
use skein_domain::preflight::PreflightOverride;
use skein_safety::control::ControlTable;
use std::ops::Deref;
use std::sync::atomic::{AtomicU64, Ordering};

/// What operators have told.
#[derive(Default)]
pub struct Operators {
    /// Sticks on their way to vehicles of other nodes that are flown by hand.
    pub relays: Relays,
    control: Mutex<ControlTable>,
    /// Red items that somebody takes upon himself, here or at another node.
    overrides: Mutex<Vec<PreflightOverride>>,
    /// Those that other nodes are to be told of.
    overrides_here: Mutex<Vec<PreflightOverride>>,
    /// The key of the emergency stop, and until when it is good.
    emergency_key: Mutex<Option<(String, NodeTime)>>,
    /// The last sign of life at this node, in microseconds of node time; 0 if there was none.
    heard_us: AtomicU64,
    /// The same at another node of the swarm.
    heard_elsewhere_us: AtomicU64,
}

impl Operators {
    /// With who had control authority before a restart.
    pub(crate) fn new(control: ControlTable) -> Self {
        Self {
            control: Mutex::new(control),
            ..Self::default()
        }
    }

    /// Which console has control authority over which vehicles, to be read.
    pub fn control(&self) -> impl Deref<Target = ControlTable> {
        self.control.lock()
    }

    /// The same, for consoles that are heard or change it, and for what other nodes tell. Held from the question who has a vehicle to the answer
    /// who has it now, so that no other console comes between.
    pub fn change_control(&self) -> MutexGuard<'_, ControlTable> {
        self.control.lock()
    }

    /// Red items that somebody takes upon himself now.
    pub fn overrides(&self, now: NodeTime) -> Vec<PreflightOverride> {
        let all = self.overrides.lock();
        all.iter().filter(|given| holds(given, now)).cloned().collect()
    }

    /// An operator takes red items upon himself. What does not hold any more is forgotten; other nodes are told of it only if there are some.
    pub fn override_items(&self, given: &PreflightOverride, in_swarm: bool, now: NodeTime) {
        let mut all = self.overrides.lock();
        all.retain(|given| holds(given, now));
        all.push(given.clone());
        drop(all);
        if in_swarm {
            self.overrides_here.lock().push(given.clone());
        }
    }

    /// What other nodes are to be told of.
    pub fn overrides_here(&self) -> Vec<PreflightOverride> {
        self.overrides_here.lock().clone()
    }

    /// What another node tells of its operators, by this node's clock.
    pub fn hear_overrides(&self, told: impl Iterator<Item = PreflightOverride>) {
        let mut all = self.overrides.lock();
        for given in told {
            let known = |o: &PreflightOverride| {
                let same = (&o.operator, &o.items, o.vehicle) == (&given.operator, &given.items, given.vehicle);
                // The measured offset of the clocks wavers a little.
                same && o.given_at.seconds_since(given.given_at).abs() < 1.0
            };
            if !all.iter().any(known) {
                all.push(given);
            }
        }
    }

    /// The first step of the emergency stop: this key is good for the second until then.
    pub fn unlock_emergency_stop(&self, key: String, until: NodeTime) {
        *self.emergency_key.lock() = Some((key, until));
    }

    /// Whether a key is that of a first step which is not too long ago.
    pub fn is_emergency_key(&self, key: &str, now: NodeTime) -> bool {
        let unlocked = self.emergency_key.lock();
        unlocked
            .as_ref()
            .is_some_and(|(good, until)| good == key && now <= *until)
    }

    /// An operator gives a sign of life.
    pub fn hear(&self, now: NodeTime) {
        self.heard_us.store(now.0.max(1), Ordering::Relaxed);
    }

    /// An operator gave a sign of life at another node.
    pub fn hear_elsewhere(&self, at: NodeTime) {
        self.heard_elsewhere_us.fetch_max(at.0, Ordering::Relaxed);
    }

    /// When an operator last gave a sign of life at this node, if ever.
    pub fn heard_here(&self) -> Option<NodeTime> {
        let heard_us = self.heard_us.load(Ordering::Relaxed);
        (heard_us > 0).then_some(NodeTime(heard_us))
    }

    /// When an operator last gave a sign of life, if ever.
    pub fn heard(&self) -> Option<NodeTime> {
        let elsewhere_us = self.heard_elsewhere_us.load(Ordering::Relaxed);
        let heard_us = self.heard_us.load(Ordering::Relaxed).max(elsewhere_us);
        (heard_us > 0).then_some(NodeTime(heard_us))
    }
}

fn holds(given: &PreflightOverride, now: NodeTime) -> bool {
    now.seconds_since(given.given_at) <= given.valid_s
}
