//! The faults of `--faults`. Of actors: once the formation flies its route, one vehicle's plugin panics, another's actor is killed, then
//! the coordinator, each some seconds after the other. Of plugins: during the whole flight a random one is ended, twice a second.

use crate::args::FaultPlan;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use skein_domain::{FlightState, VehicleId};
use skein_node::tell;
use skein_runtime::{Fault, NodeHandle};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use tokio::task::JoinHandle;

/// Time between two drills of actors.
const APART: Duration = Duration::from_secs(4);
/// Time between two ends of plugins, on average.
const PLUGIN_EVERY: Duration = Duration::from_millis(500);

/// Drills under way.
pub struct Drills {
    task: JoinHandle<()>,
    injected: Arc<AtomicU64>,
}

impl Drills {
    /// Starts them in the background.
    pub fn start(plan: FaultPlan, node: NodeHandle, seed: u64) -> Self {
        let injected = Arc::new(AtomicU64::new(0));
        let task = match plan {
            FaultPlan::Actors => tokio::spawn(actors(node, injected.clone())),
            FaultPlan::Plugins => tokio::spawn(plugins(node, seed, injected.clone())),
            // Cut where the vehicles are, not in the node.
            FaultPlan::Links => tokio::spawn(async {}),
        };
        Self { task, injected }
    }

    /// Ends them; gives how many faults were injected.
    pub fn stop(self) -> u64 {
        self.task.abort();
        self.injected.load(Ordering::Relaxed)
    }
}

async fn actors(node: NodeHandle, injected: Arc<AtomicU64>) {
    while node.snapshot().formation.as_ref().is_none_or(|f| f.route.is_none()) {
        tokio::time::sleep(Duration::from_millis(200)).await;
    }
    let ids: Vec<VehicleId> = node.snapshot().vehicles.iter().map(|v| v.id).collect();
    let leader = node.snapshot().vehicles.iter().find(|v| v.is_leader).map(|v| v.id);
    let follower = |i: usize| ids.iter().copied().filter(|id| Some(*id) != leader).nth(i);
    let panic = |vehicle| Fault::PluginPanic { vehicle, payload: None };
    let faults = [
        follower(0).map(panic),
        follower(1)
            .or(follower(0))
            .map(|vehicle| Fault::VehicleActor { vehicle }),
        Some(Fault::Coordinator),
        leader.map(panic),
    ];
    for fault in faults.into_iter().flatten() {
        tokio::time::sleep(APART).await;
        match node.inject_fault(fault.clone()).await {
            Ok(()) => {
                injected.fetch_add(1, Ordering::Relaxed);
                tell(format_args!("          fault injected: {fault:?}"));
            }
            Err(refusal) => tell(format_args!("          fault {fault:?} not injected: {refusal}")),
        }
    }
}

/// From the first take-off to the last landing.
async fn plugins(node: NodeHandle, seed: u64, injected: Arc<AtomicU64>) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    loop {
        tokio::time::sleep(PLUGIN_EVERY.mul_f64(random.random_range(0.5..1.5))).await;
        let fleet = node.snapshot();
        let flies = |state: FlightState| !matches!(state, FlightState::Idle | FlightState::Arming);
        if !fleet.vehicles.iter().any(|v| flies(v.flight_state)) {
            continue;
        }
        let instances: Vec<(VehicleId, Option<String>)> = fleet
            .vehicles
            .iter()
            .flat_map(|v| {
                let payloads = v.payloads.iter().map(|payload| (v.id, Some(payload.name.clone())));
                std::iter::once((v.id, None)).chain(payloads)
            })
            .collect();
        let Some((vehicle, payload)) = instances.get(random.random_range(0..instances.len().max(1))).cloned() else {
            continue;
        };
        // One that is just being restarted is not there to be ended.
        if node.inject_fault(Fault::PluginKill { vehicle, payload }).await.is_ok() {
            injected.fetch_add(1, Ordering::Relaxed);
        }
    }
}
