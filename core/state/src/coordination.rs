//! What the coordinator wants, and what its next incarnation or its successor needs to go on.
//!
//! Must never do: decide anything. What is read here is of one moment; who changes it says so by name.

use arc_swap::ArcSwap;
use parking_lot::{Mutex, MutexGuard};
use skein_coordination::{AnchorKeeper, Coordination, References};
use skein_domain::{AnchorReference, Intent, NodeTime};
use skein_safety::Fences;
use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Intent and coordination of a node.
#[derive(Default)]
pub struct SharedCoordination {
    intent: ArcSwap<Intent>,
    state: Mutex<Coordination>,
    anchor: Mutex<AnchorKeeper>,
    /// When the coordinator last looked at its formation, in microseconds of node time.
    seen_us: AtomicU64,
    /// A drill: the coordinator is not started again as long as this is set.
    is_away: AtomicBool,
}

impl SharedCoordination {
    /// What is wanted of this node's vehicles.
    pub fn intent(&self) -> Arc<Intent> {
        self.intent.load_full()
    }

    /// Other intent from now on: by the coordinator, or by the swarm's actor on a node that hears no coordinator.
    pub fn publish(&self, intent: Intent) {
        self.intent.store(Arc::new(intent));
    }

    /// The swarm's actor takes up what the coordinator of another node wants, and what this node needs to succeed it.
    pub fn obey(&self, intent: Intent, coordination: Coordination) {
        *self.state.lock() = coordination;
        self.publish(intent);
    }

    /// What the coordinator must find again, to be read.
    pub fn read(&self) -> impl Deref<Target = Coordination> {
        self.state.lock()
    }

    /// The same, for the coordinator, and for going on after a restart where it has nothing to do yet. Held from what is read of it to what follows,
    /// so that what is decided is decided on what there is.
    pub fn change(&self) -> MutexGuard<'_, Coordination> {
        self.state.lock()
    }

    /// The control loop works out the anchor of a formation that follows no vehicle, once a period. Second: whether the formation waits at a fence,
    /// if that has changed.
    pub fn work_out_anchor(
        &self,
        led: Option<&AnchorReference>,
        references: &References,
        fences: &Fences,
        now: NodeTime,
    ) -> (Option<AnchorReference>, Option<bool>) {
        let intent = self.intent();
        let mut keeper = self.anchor.lock();
        let was_held = keeper.is_held();
        let anchor = keeper.at(intent.anchor.as_ref(), led, references, fences, now);
        let is_held = keeper.is_held();
        (anchor, (is_held != was_held).then_some(is_held))
    }

    /// The coordinator of this node gives a sign of life.
    pub fn see_coordinator(&self, now: NodeTime) {
        self.seen_us.store(now.0, Ordering::Relaxed);
    }

    /// When it last gave one.
    pub(crate) fn coordinator_seen(&self) -> NodeTime {
        NodeTime(self.seen_us.load(Ordering::Relaxed))
    }

    /// A drill keeps the coordinator from being started again, or ends.
    pub fn drill_absence(&self, away: bool) {
        self.is_away.store(away, Ordering::Release);
    }

    /// Whether a drill keeps it from being started.
    pub fn is_coordinator_away(&self) -> bool {
        self.is_away.load(Ordering::Acquire)
    }
}
