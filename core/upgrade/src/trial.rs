//! A version on trial looks at itself: what it sees of vehicles and swarm, and whether it goes on at all.
//!
//! Must never do: end while a vehicle of the node is armed, unless nothing of it goes on any more.

use crate::rules::{Expectations, Seen};
use skein_domain::VehicleId;
use skein_failover::LeaderState;
use skein_state::SharedState;
use skein_view::{UpgradeRefusal, airborne};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// A version on trial that has shown no sign of life for so long hangs. Longer than any computer stands still.
const HANGS_AFTER: Duration = Duration::from_secs(90);
/// How often it is looked.
const LOOK: Duration = Duration::from_secs(1);
/// Another node is there that was heard within this, in seconds.
const HEARD_S: f64 = 2.0;

/// What is seen of vehicles and swarm now.
pub fn seen(shared: &SharedState) -> Seen {
    let now = shared.now();
    let records = shared.vehicles.records();
    let heard = records.iter().filter(|record| record.link().read(now).1.connected);
    let swarm = shared.swarm.as_ref();
    let role = swarm.map(|swarm| swarm.role());
    Seen {
        vehicles: heard.map(|record| record.id).collect(),
        others: swarm.is_some_and(|swarm| swarm.picture().nodes.iter().any(|node| node.heard_s < HEARD_S)),
        led: role.is_some_and(|role| role.acting.is_some() || matches!(role.leader_state, LeaderState::Led { .. })),
    }
}

/// What the next version has to see again.
pub fn expectations(shared: &SharedState) -> Expectations {
    let Seen { vehicles, others, led } = seen(shared);
    Expectations { vehicles, others, led }
}

/// An armed vehicle of this node, if there is one.
pub fn armed(shared: &SharedState) -> Option<VehicleId> {
    let now = shared.now();
    let records = shared.vehicles.records();
    let is_armed = |id: &VehicleId| {
        let record = records.iter().find(|record| record.id == *id);
        record.is_some_and(|record| {
            let telemetry = record.link().read(now).0;
            telemetry.armed || airborne(&telemetry)
        })
    };
    records.iter().map(|record| record.id).find(is_armed)
}

/// Whether another version may be started now: no vehicle of this node armed or unheard, and none of the swarm armed where this node coordinates.
///
/// # Errors
/// Which vehicle stands against it.
pub fn may_swap(shared: &SharedState) -> Result<(), UpgradeRefusal> {
    if let Some(vehicle) = armed(shared) {
        return Err(UpgradeRefusal::Armed { vehicle });
    }
    let now = shared.now();
    let records = shared.vehicles.records();
    if let Some(lost) = records.iter().find(|record| !record.link().read(now).1.connected) {
        return Err(UpgradeRefusal::NotHeard { vehicle: lost.id });
    }
    if shared.coordinates() {
        let peers = shared.peers();
        if let Some(entry) = peers.entries.iter().find(|entry| entry.telemetry.armed) {
            return Err(UpgradeRefusal::Coordinates { vehicle: entry.id });
        }
    }
    Ok(())
}

/// Ends the process if it hangs: the service manager then starts the version before. Where the service manager has a watchdog of its own, that one
/// is quicker.
#[derive(Debug)]
pub struct HangGuard(Arc<AtomicU64>);

impl HangGuard {
    /// Watches from now on, until it is dropped.
    #[must_use]
    pub fn start() -> Self {
        let beats = Arc::new(AtomicU64::new(0));
        let weak = Arc::downgrade(&beats);
        // Not of the runtime: it must go on when that does not.
        std::thread::spawn(move || {
            let (mut known, mut looks) = (0, 0_u32);
            while let Some(beats) = weak.upgrade() {
                let now = beats.load(Ordering::Relaxed);
                drop(beats);
                looks = if now == known { looks + 1 } else { 0 };
                known = now;
                if LOOK * looks >= HANGS_AFTER {
                    eprintln!("skein: this version hangs on its trial; it ends, so that the one before is started");
                    std::process::abort();
                }
                std::thread::sleep(LOOK);
            }
        });
        Self(beats)
    }

    /// It goes on.
    pub fn beat(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}
