//! What is known of one plugin instance beyond the life of its actor: who it is, its version, its last snapshot, its failures.
//!
//! Must never do: call the plugin.

use crate::restart::{Decision, RestartHistory, RestartLimits};
use arc_swap::ArcSwap;
use parking_lot::{Mutex, MutexGuard};
use skein_config::Isolation;
use skein_domain::{NodeTime, SystemId, VehicleId};
use skein_plugin_host::Plugin;
use skein_view::PluginHealth;
use std::ops::Deref;
use std::sync::Arc;

/// What is known of an instance beyond its actor's life.
pub struct PluginRecord {
    /// The vehicle it belongs to.
    pub vehicle: VehicleId,
    /// The payload's name on the vehicle; none for its UAV model.
    pub payload: Option<String>,
    /// How it is called in events, for example `uav-3: gimbal`.
    pub label: String,
    /// The vehicle's system id on its link.
    pub system_id: SystemId,
    /// Configuration of the instance as JSON text.
    pub config_json: String,
    /// Where it runs.
    pub isolation: Isolation,
    /// The version that is, or will be, running.
    plugin: ArcSwap<Plugin>,
    /// Its last snapshot.
    snapshot: Mutex<Option<Vec<u8>>>,
    /// Its health.
    health: Mutex<PluginHealth>,
    /// Its failures.
    history: Mutex<RestartHistory>,
}

impl PluginRecord {
    /// Of an instance that was never started. `name` is its name in the supervision tree, `label` that in events.
    #[must_use]
    pub fn new(identity: PluginIdentity, plugin: Arc<Plugin>, config_json: String, isolation: Isolation) -> Self {
        let health = PluginHealth {
            name: identity.name,
            plugin: plugin.manifest().name.clone(),
            version: plugin.manifest().version.clone(),
            isolation,
            ..PluginHealth::default()
        };
        Self {
            vehicle: identity.vehicle,
            payload: identity.payload,
            label: identity.label,
            system_id: identity.system_id,
            config_json,
            isolation,
            plugin: ArcSwap::new(plugin),
            snapshot: Mutex::new(None),
            health: Mutex::new(health),
            history: Mutex::default(),
        }
    }

    /// The version that is, or will be, running.
    #[must_use]
    pub fn plugin(&self) -> Arc<Plugin> {
        self.plugin.load_full()
    }

    /// Another version is to run from now on; gives the one before.
    pub fn exchange(&self, plugin: Arc<Plugin>) -> Arc<Plugin> {
        self.plugin.swap(plugin)
    }

    /// Its last snapshot.
    #[must_use]
    pub fn snapshot(&self) -> Option<Vec<u8>> {
        self.snapshot.lock().clone()
    }

    /// It gave a snapshot, or starts anew without one.
    pub fn keep_snapshot(&self, snapshot: Option<Vec<u8>>) {
        *self.snapshot.lock() = snapshot;
    }

    /// Its health, to be read.
    pub fn health(&self) -> impl Deref<Target = PluginHealth> {
        self.health.lock()
    }

    /// The same, for the actor that supervises it.
    pub fn change_health(&self) -> MutexGuard<'_, PluginHealth> {
        self.health.lock()
    }

    /// It has failed: what to do about it. `random` is 0..1.
    pub fn note_failure(&self, limits: &RestartLimits, now: NodeTime, random: f64) -> Decision {
        self.history.lock().decide(limits, now, random)
    }

    /// Forgets all failures, after an operator's reset.
    pub fn forget_failures(&self) {
        self.history.lock().reset();
    }
}

/// Who an instance is.
pub struct PluginIdentity {
    /// Name in the supervision tree.
    pub name: String,
    /// Name in events.
    pub label: String,
    /// The vehicle.
    pub vehicle: VehicleId,
    /// The payload's name; none for a UAV model.
    pub payload: Option<String>,
    /// The vehicle's system id.
    pub system_id: SystemId,
}
