//! The faults of `--faults`: once the formation flies its route, one vehicle's plugin panics, another's actor is killed, then the
//! coordinator, each some seconds after the other.

use skein_domain::VehicleId;
use skein_runtime::{Fault, NodeHandle};
use std::time::Duration;
use tokio::task::JoinHandle;

/// Time between two drills.
const APART: Duration = Duration::from_secs(4);

/// Starts the drills in the background. They wait for the first route.
pub fn start(node: NodeHandle) -> JoinHandle<()> {
    tokio::spawn(async move {
        while node.snapshot().formation.as_ref().is_none_or(|f| f.route.is_none()) {
            tokio::time::sleep(Duration::from_millis(200)).await;
        }
        let ids: Vec<VehicleId> = node.snapshot().vehicles.iter().map(|v| v.id).collect();
        let leader = node.snapshot().vehicles.iter().find(|v| v.is_leader).map(|v| v.id);
        let follower = |i: usize| ids.iter().copied().filter(|id| Some(*id) != leader).nth(i);
        let faults = [
            follower(0).map(|vehicle| Fault::PluginPanic { vehicle, payload: None }),
            follower(1)
                .or(follower(0))
                .map(|vehicle| Fault::VehicleActor { vehicle }),
            Some(Fault::Coordinator),
            leader.map(|vehicle| Fault::PluginPanic { vehicle, payload: None }),
        ];
        for fault in faults.into_iter().flatten() {
            tokio::time::sleep(APART).await;
            match node.inject_fault(fault.clone()).await {
                Ok(()) => println!("          fault injected: {fault:?}"),
                Err(refusal) => println!("          fault {fault:?} not injected: {refusal}"),
            }
        }
    })
}
