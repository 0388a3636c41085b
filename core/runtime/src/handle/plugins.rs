//! What the node's handle can do about plugins at run time: list, look again, exchange for a newer version, roll back, remove, take an
//! upload, restart, and command, attach and detach payloads.
//!
//! Must never do: touch a vehicle's link, or leave a version active that an instance of it did not come up with.

mod carried;
mod uploads;
mod versions;

use super::NodeHandle;
use crate::fleet::FleetMessage;
use serde::Serialize;
use skein_domain::exchange::{FaultDrill, Severity};
use skein_domain::{Refusal, VehicleId};
use skein_plugin_host::Plugin;
use skein_state::PayloadMessage;
use skein_state::VehicleMessage;
use skein_view::{EventKind, RestartRecord, Restored};
use std::path::PathBuf;
use std::sync::Arc;
use thiserror::Error;
use versions::Holder;

/// What can be told the plugin of a vehicle or payload.
pub(crate) enum PluginOrder {
    Drill(FaultDrill),
    Kill,
    Reset,
}

/// A plugin that was found, for screens.
#[derive(Debug, Clone, PartialEq, Serialize, ts_rs::TS, schemars::JsonSchema)]
pub struct PluginInfo {
    /// Its name.
    pub name: String,
    /// The active version.
    pub version: String,
    /// What it is.
    pub kind: String,
    /// What it is for.
    pub description: String,
    /// The file it was loaded from.
    pub path: String,
    /// SHA-256 of the file, in hexadecimal.
    pub sha256: String,
    /// The effects it may return.
    pub effects: Vec<String>,
    /// JSON Schema of its configuration, as text.
    pub config_schema_json: String,
    /// JSON Schema of its commands, as text.
    pub command_schema_json: Option<String>,
    /// JSON Schema of the state it reports, as text.
    pub state_schema_json: Option<String>,
    /// JSON Schema of the events it tells, as text.
    pub event_schema_json: Option<String>,
    /// All loaded versions, oldest first.
    pub versions: Vec<String>,
    /// A loaded version that is not active yet.
    pub candidate: Option<String>,
    /// The version that a roll back would go to.
    pub previous: Option<String>,
    /// Names of the instances it has in the supervision tree.
    pub instances: Vec<String>,
}

/// Why something could not be done about a plugin.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PluginRefusal {
    /// No plugin has this name.
    #[error("there is no plugin \"{name}\"")]
    Unknown {
        /// The name asked for.
        name: String,
    },
    /// There is no newer version.
    #[error("no other version of \"{name}\" was found in the plugin directories")]
    NothingNewer {
        /// The plugin.
        name: String,
    },
    /// There is no version to go back to.
    #[error("there is no former version of \"{name}\" to go back to")]
    NothingBefore {
        /// The plugin.
        name: String,
    },
    /// It is used.
    #[error("\"{name}\" is in use by {}", by.join(", "))]
    InUse {
        /// The plugin.
        name: String,
        /// Instances, or adoption rules.
        by: Vec<String>,
    },
    /// The configuration does not permit it.
    #[error("{detail}")]
    NotPermitted {
        /// What and why.
        detail: String,
    },
    /// What was uploaded is no plugin, or could not be kept.
    #[error("{detail}")]
    BadUpload {
        /// Why.
        detail: String,
    },
}

/// What became of one instance in an exchange of versions.
#[derive(Debug, Clone, PartialEq, Serialize, ts_rs::TS, schemars::JsonSchema)]
pub struct InstanceUpgrade {
    /// Its name in the supervision tree.
    pub name: String,
    /// Whether it has its former state; absent if it did not come up.
    pub restored: Option<Restored>,
    /// Why it did not come up; the old version flies on then.
    pub error: Option<String>,
}

/// What became of an exchange of versions.
#[derive(Debug, Clone, PartialEq, Serialize, ts_rs::TS, schemars::JsonSchema)]
pub struct UpgradeReceipt {
    /// The plugin.
    pub name: String,
    /// The version before.
    pub from: String,
    /// The version asked for.
    pub to: String,
    /// Its instances.
    pub instances: Vec<InstanceUpgrade>,
    /// One did not come up: all are back to the version before.
    pub rolled_back: bool,
}

impl NodeHandle {
    /// Plugins found, by name.
    #[must_use]
    pub fn plugins(&self) -> Vec<PluginInfo> {
        let found = self.shared.plugins.catalog.plugins();
        found.iter().map(|plugin| self.info(plugin)).collect()
    }

    /// The program that is started with `plugin-host` for an instance in a child process; this one unless it is told. For programs
    /// that are not `skein` but run a node, such as tests.
    pub fn set_plugin_host_program(&self, program: PathBuf) {
        self.shared.plugins.set_host_program(program);
    }

    fn info(&self, plugin: &Arc<Plugin>) -> PluginInfo {
        let manifest = plugin.manifest();
        let catalog = &self.shared.plugins.catalog;
        let version = |p: &Arc<Plugin>| p.manifest().version.clone();
        PluginInfo {
            name: manifest.name.clone(),
            version: manifest.version.clone(),
            kind: manifest.kind.to_string(),
            description: manifest.description.clone(),
            path: plugin.path().display().to_string(),
            sha256: plugin.sha256().to_owned(),
            effects: manifest.effects.iter().map(ToString::to_string).collect(),
            config_schema_json: manifest.config_schema_json.clone(),
            command_schema_json: manifest.command_schema_json.clone(),
            state_schema_json: manifest.state_schema_json.clone(),
            event_schema_json: manifest.event_schema_json.clone(),
            versions: catalog.versions(&manifest.name).iter().map(version).collect(),
            candidate: catalog.candidate(&manifest.name).as_ref().map(version),
            previous: catalog.previous(&manifest.name).as_ref().map(version),
            instances: self.holders(&manifest.name).iter().map(Holder::name).collect(),
        }
    }

    /// Files in the plugin directories that were not taken, and why.
    #[must_use]
    pub fn plugin_problems(&self) -> Vec<String> {
        let problems = self.shared.plugins.catalog.problems();
        problems.iter().map(ToString::to_string).collect()
    }

    /// The restarts of plugin instances that are kept, oldest first.
    #[must_use]
    pub fn restarts(&self) -> Vec<RestartRecord> {
        self.shared.plugins.restarts()
    }

    /// Looks for new and changed libraries. A new plugin can be used at once; a new version of a known one waits for
    /// [`Self::upgrade_plugin`].
    pub async fn rescan_plugins(&self) -> Vec<PluginInfo> {
        let shared = self.shared.clone();
        // Loading runs constructors of libraries, for milliseconds each.
        let found = tokio::task::spawn_blocking(move || shared.plugins.catalog.rescan()).await;
        let found = found.unwrap_or_default();
        for plugin in &found {
            let manifest = plugin.manifest();
            self.tell(
                &manifest.name,
                Severity::Info,
                format!("plugin {} {} found", manifest.name, manifest.version),
            );
        }
        found.iter().map(|plugin| self.info(plugin)).collect()
    }

    /// Starts the plugin instance of a vehicle or of its payload anew and forgets its failures.
    ///
    /// # Errors
    /// When there is no such vehicle or payload.
    pub fn restart_plugin(&self, vehicle: VehicleId, payload: Option<&str>) -> Result<(), Refusal> {
        match self.to_plugin(vehicle, payload, PluginOrder::Reset) {
            // Its actor itself was given up: the fleet starts another one.
            Err(Refusal::NotRunning { .. }) => {
                let again = match payload {
                    None => FleetMessage::Restart(vehicle),
                    Some(name) => FleetMessage::RestartPayload((vehicle, name.to_owned())),
                };
                let fleet = self.parts.fleet.load_full();
                fleet
                    .filter(|fleet| fleet.cast(again).is_ok())
                    .map(|_| ())
                    .ok_or_else(|| not_running(vehicle, payload))
            }
            other => other,
        }
    }

    pub(crate) fn to_plugin(
        &self,
        vehicle: VehicleId,
        payload: Option<&str>,
        order: PluginOrder,
    ) -> Result<(), Refusal> {
        let record = self.shared.vehicles.known(vehicle)?;
        let sent = match payload {
            None => record.actor.get().map(|actor| {
                actor
                    .cast(match order {
                        PluginOrder::Drill(drill) => VehicleMessage::Drill(drill),
                        PluginOrder::Kill => VehicleMessage::Kill,
                        PluginOrder::Reset => VehicleMessage::Reset,
                    })
                    .is_ok()
            }),
            Some(name) => record.known_payload(name)?.actor.get().map(|actor| {
                actor
                    .cast(match order {
                        PluginOrder::Drill(drill) => PayloadMessage::Drill(drill),
                        PluginOrder::Kill => PayloadMessage::Kill,
                        PluginOrder::Reset => PayloadMessage::Reset,
                    })
                    .is_ok()
            }),
        };
        sent.filter(|sent| *sent)
            .map(|_| ())
            .ok_or_else(|| not_running(vehicle, payload))
    }

    fn tell(&self, plugin: &str, severity: Severity, text: String) {
        let kind = EventKind::Plugin {
            plugin: plugin.to_owned(),
        };
        self.shared.events.record(self.now(), None, severity, kind, text);
    }
}

fn not_running(vehicle: VehicleId, payload: Option<&str>) -> Refusal {
    Refusal::not_running(match payload {
        None => format!("actor of vehicle {vehicle}"),
        Some(payload) => format!("payload {payload} of vehicle {vehicle}"),
    })
}
