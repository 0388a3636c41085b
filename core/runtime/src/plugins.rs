//! What the node's handle can do about plugins at run time: list, look again, exchange for a newer version, roll back, remove, take an
//! upload, restart, and command, attach and detach payloads.
//!
//! Must never do: touch a vehicle's link, or leave a version active that an instance of it did not come up with.

use crate::board::VehicleCell;
use crate::fleet::FleetMessage;
use crate::handle::{CommandReceipt, NodeHandle};
use crate::payload::{Asker, PayloadCell, PayloadMessage};
use crate::snapshot::{EventKind, RestartRecord, Restored};
use crate::vehicle::VehicleMessage;
use ractor::rpc::CallResult;
use serde::Serialize;
use skein_config::PayloadRule;
use skein_domain::exchange::{FaultDrill, Severity};
use skein_domain::payload::Track;
use skein_domain::{CommandId, Refusal, VehicleId};
use skein_plugin_host::{Frame, Plugin};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use thiserror::Error;

/// Longest wait for a payload's answer: its plugin may have to be started for it.
const ANSWER_WITHIN: Duration = Duration::from_secs(3);

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

/// One instance of a plugin.
enum Holder {
    Model(Arc<VehicleCell>),
    Payload(Arc<PayloadCell>),
}

impl Holder {
    fn name(&self) -> String {
        match self {
            Self::Model(cell) => cell.model.health.lock().name.clone(),
            Self::Payload(cell) => cell.life.health.lock().name.clone(),
        }
    }

    async fn exchange(&self, plugin: Arc<Plugin>) -> Result<Restored, String> {
        let gone = || "its actor is not running".to_owned();
        let answer = match self {
            Self::Model(cell) => {
                let actor = cell.actor.load_full().ok_or_else(gone)?;
                actor
                    .call(|reply| VehicleMessage::Exchange(plugin, reply), Some(ANSWER_WITHIN))
                    .await
                    .map_err(|e| e.to_string())?
            }
            Self::Payload(cell) => {
                let actor = cell.actor.load_full().ok_or_else(gone)?;
                actor
                    .call(|reply| PayloadMessage::Exchange(plugin, reply), Some(ANSWER_WITHIN))
                    .await
                    .map_err(|e| e.to_string())?
            }
        };
        match answer {
            CallResult::Success(outcome) => outcome,
            CallResult::Timeout => Err("its actor did not answer in time".into()),
            CallResult::SenderError => Err(gone()),
        }
    }
}

impl NodeHandle {
    /// Plugins found, by name.
    #[must_use]
    pub fn plugins(&self) -> Vec<PluginInfo> {
        self.board
            .catalog
            .plugins()
            .iter()
            .map(|plugin| self.info(plugin))
            .collect()
    }

    /// The program that is started with `plugin-host` for an instance in a child process; this one unless it is told. For programs
    /// that are not `skein` but run a node, such as tests.
    pub fn set_plugin_host_program(&self, program: PathBuf) {
        self.board.runners.set_host_program(program);
    }

    fn info(&self, plugin: &Arc<Plugin>) -> PluginInfo {
        let manifest = plugin.manifest();
        let catalog = &self.board.catalog;
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
        self.board.catalog.problems().iter().map(ToString::to_string).collect()
    }

    /// The restarts of plugin instances that are kept, oldest first.
    #[must_use]
    pub fn restarts(&self) -> Vec<RestartRecord> {
        self.board.restarts.lock().iter().cloned().collect()
    }

    /// All instances of a plugin.
    fn holders(&self, plugin: &str) -> Vec<Holder> {
        let mut holders = Vec::new();
        for cell in self.board.cells() {
            for payload in cell.payloads() {
                if payload.life.plugin.load().manifest().name == plugin {
                    holders.push(Holder::Payload(payload));
                }
            }
            if cell.model.plugin.load().manifest().name == plugin {
                holders.push(Holder::Model(cell));
            }
        }
        holders
    }

    /// Looks for new and changed libraries. A new plugin can be used at once; a new version of a known one waits for
    /// [`Self::upgrade_plugin`].
    pub async fn rescan_plugins(&self) -> Vec<PluginInfo> {
        let board = self.board.clone();
        // Loading runs constructors of libraries, for milliseconds each.
        let found = tokio::task::spawn_blocking(move || board.catalog.rescan()).await;
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

    /// Exchanges all instances of a plugin for its newest version, each with its state. If one does not come up, all go back.
    ///
    /// # Errors
    /// When there is no such plugin or no other version.
    pub async fn upgrade_plugin(&self, name: &str) -> Result<UpgradeReceipt, PluginRefusal> {
        self.rescan_plugins().await;
        let unknown = || PluginRefusal::Unknown { name: name.to_owned() };
        let old = self.board.catalog.get(name).ok_or_else(unknown)?;
        let new = self
            .board
            .catalog
            .candidate(name)
            .ok_or_else(|| PluginRefusal::NothingNewer { name: name.to_owned() })?;
        Ok(self.go_over(name, &old, &new).await)
    }

    /// Exchanges all instances of a plugin for the version that was active before.
    ///
    /// # Errors
    /// When there is no such plugin or no former version.
    pub async fn roll_back_plugin(&self, name: &str) -> Result<UpgradeReceipt, PluginRefusal> {
        let unknown = || PluginRefusal::Unknown { name: name.to_owned() };
        let old = self.board.catalog.get(name).ok_or_else(unknown)?;
        let new = self
            .board
            .catalog
            .previous(name)
            .ok_or_else(|| PluginRefusal::NothingBefore { name: name.to_owned() })?;
        Ok(self.go_over(name, &old, &new).await)
    }

    async fn go_over(&self, name: &str, old: &Arc<Plugin>, new: &Arc<Plugin>) -> UpgradeReceipt {
        let mut instances = Vec::new();
        let mut exchanged = Vec::new();
        let mut failed = false;
        for holder in self.holders(name) {
            let outcome = holder.exchange(new.clone()).await;
            failed = outcome.is_err();
            instances.push(InstanceUpgrade {
                name: holder.name(),
                restored: outcome.as_ref().ok().copied(),
                error: outcome.err(),
            });
            if failed {
                break;
            }
            exchanged.push(holder);
        }
        let (from, to) = (old.manifest().version.clone(), new.manifest().version.clone());
        if failed {
            for holder in exchanged {
                if let Err(error) = holder.exchange(old.clone()).await {
                    let text = format!("{} could not go back to {from}: {error}", holder.name());
                    self.tell(name, Severity::Critical, text);
                }
            }
            self.tell(
                name,
                Severity::Warning,
                format!("plugin {name} {to} did not come up; {from} stays"),
            );
        } else {
            self.board.catalog.activate(name, new);
            self.tell(
                name,
                Severity::Advisory,
                format!("plugin {name}: {to} instead of {from}"),
            );
        }
        UpgradeReceipt {
            name: name.to_owned(),
            from,
            to,
            instances,
            rolled_back: failed,
        }
    }

    /// Forgets a plugin. Its library stays loaded, as every library does, but no instance is made of it any more.
    ///
    /// # Errors
    /// When there is no such plugin, or something uses it.
    pub fn remove_plugin(&self, name: &str) -> Result<(), PluginRefusal> {
        let mut by: Vec<String> = self.holders(name).iter().map(Holder::name).collect();
        for rule in &self.board.config.adopt {
            if rule.model == name || rule.payloads.iter().any(|payload| payload.plugin == name) {
                by.push(format!("the adoption rule \"{}\"", rule.name));
            }
        }
        if !by.is_empty() {
            return Err(PluginRefusal::InUse {
                name: name.to_owned(),
                by,
            });
        }
        if !self.board.catalog.remove(name) {
            return Err(PluginRefusal::Unknown { name: name.to_owned() });
        }
        self.tell(name, Severity::Advisory, format!("plugin {name} removed"));
        Ok(())
    }

    /// Starts the plugin instance of a vehicle or of its payload anew and forgets its failures.
    ///
    /// # Errors
    /// When there is no such vehicle or payload.
    pub fn restart_plugin(&self, vehicle: VehicleId, payload: Option<&str>) -> Result<(), Refusal> {
        self.to_plugin(vehicle, payload, PluginOrder::Reset)
    }

    pub(crate) fn to_plugin(
        &self,
        vehicle: VehicleId,
        payload: Option<&str>,
        order: PluginOrder,
    ) -> Result<(), Refusal> {
        let cell = self.board.cell(vehicle).ok_or(Refusal::UnknownVehicle { vehicle })?;
        let sent = match payload {
            None => cell.actor.load_full().map(|actor| {
                actor
                    .cast(match order {
                        PluginOrder::Drill(drill) => VehicleMessage::Drill(drill),
                        PluginOrder::Kill => VehicleMessage::Kill,
                        PluginOrder::Reset => VehicleMessage::Reset,
                    })
                    .is_ok()
            }),
            Some(name) => self.payload(&cell, name)?.actor.load_full().map(|actor| {
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

    fn payload(&self, cell: &VehicleCell, name: &str) -> Result<Arc<PayloadCell>, Refusal> {
        cell.payload(name).ok_or_else(|| Refusal::UnknownPayload {
            vehicle: cell.id,
            payload: name.to_owned(),
        })
    }

    /// Gives a command to a payload; it has to fit the command schema of the payload's plugin.
    pub async fn command_payload(
        &self,
        vehicle: VehicleId,
        payload: &str,
        command: &serde_json::Value,
    ) -> CommandReceipt {
        let id = self.board.next_command_id();
        let refusal = match self.ask_payload(id, vehicle, payload, command).await {
            Ok(receipt) => return receipt,
            Err(refusal) => Some(refusal),
        };
        CommandReceipt { vehicle, id, refusal }
    }

    async fn ask_payload(
        &self,
        id: CommandId,
        vehicle: VehicleId,
        payload: &str,
        command: &serde_json::Value,
    ) -> Result<CommandReceipt, Refusal> {
        let cell = self.board.cell(vehicle).ok_or(Refusal::UnknownVehicle { vehicle })?;
        let actor = self.payload(&cell, payload)?.actor.load_full();
        let actor = actor.ok_or_else(|| not_running(vehicle, Some(payload)))?;
        let command_json = command.to_string();
        let message = |reply| PayloadMessage::Command {
            id,
            command_json,
            asker: Asker::Operator(reply),
        };
        match actor.call(message, Some(ANSWER_WITHIN)).await {
            Ok(CallResult::Success(receipt)) => Ok(receipt),
            Ok(CallResult::Timeout) => Err(Refusal::TimedOut {
                what: format!("payload {payload} of vehicle {vehicle}"),
                after_s: ANSWER_WITHIN.as_secs_f64(),
            }),
            _ => Err(not_running(vehicle, Some(payload))),
        }
    }

    /// Puts a payload on a vehicle.
    ///
    /// # Errors
    /// When there is no such vehicle, or the rule cannot be.
    pub async fn attach_payload(&self, vehicle: VehicleId, rule: PayloadRule) -> Result<(), Refusal> {
        self.ask_fleet(|reply| FleetMessage::Attach(vehicle, Box::new(rule), reply))
            .await
    }

    /// Takes a payload off a vehicle.
    ///
    /// # Errors
    /// When there is no such vehicle or payload.
    pub async fn detach_payload(&self, vehicle: VehicleId, payload: String) -> Result<(), Refusal> {
        self.ask_fleet(|reply| FleetMessage::Detach(vehicle, payload, reply))
            .await
    }

    async fn ask_fleet(
        &self,
        message: impl FnOnce(ractor::RpcReplyPort<Result<(), Refusal>>) -> FleetMessage,
    ) -> Result<(), Refusal> {
        let gone = || Refusal::NotRunning {
            what: "the fleet".into(),
        };
        let fleet = self.parts.fleet.load_full().ok_or_else(gone)?;
        match fleet.call(message, Some(ANSWER_WITHIN)).await {
            Ok(CallResult::Success(answer)) => answer,
            _ => Err(gone()),
        }
    }

    /// Keeps an uploaded library, switched off.
    ///
    /// # Errors
    /// When the configuration takes no uploads, the name is none of a library, or it cannot be written.
    pub fn keep_upload(&self, file: &str, bytes: &[u8]) -> Result<(), PluginRefusal> {
        let path = self.upload_path(file)?;
        let off = path.with_extension("so.off");
        let partly = path.with_extension("so.part");
        // Renamed when it is whole, so that nobody ever enables half a library.
        std::fs::write(&partly, bytes)
            .and_then(|()| std::fs::rename(&partly, &off))
            .map_err(|e| PluginRefusal::BadUpload { detail: e.to_string() })?;
        self.tell(
            file,
            Severity::Advisory,
            format!("{file} was uploaded; it is off until it is enabled"),
        );
        Ok(())
    }

    /// Switches an uploaded library on: the next look at the directories finds it.
    ///
    /// # Errors
    /// As [`Self::keep_upload`], and when there is no such upload.
    pub fn enable_upload(&self, file: &str) -> Result<(), PluginRefusal> {
        let path = self.upload_path(file)?;
        std::fs::rename(path.with_extension("so.off"), &path).map_err(|e| PluginRefusal::BadUpload {
            detail: format!("{file} cannot be enabled: {e}"),
        })
    }

    fn upload_path(&self, file: &str) -> Result<PathBuf, PluginRefusal> {
        let Some(directory) = &self.board.config.plugins.upload_directory else {
            return Err(PluginRefusal::NotPermitted {
                detail: "this node takes no uploads (plugins.upload_directory)".into(),
            });
        };
        let stem = file.strip_prefix("lib").and_then(|rest| rest.strip_suffix(".so"));
        let letter = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if !stem.is_some_and(|stem| !stem.is_empty() && stem.len() <= 64 && stem.chars().all(letter)) {
            return Err(PluginRefusal::BadUpload {
                detail: format!("{file:?} is not the name of a library, such as libgimbal_plugin.so"),
            });
        }
        Ok(directory.join(file))
    }

    /// The last frame of a payload.
    #[must_use]
    pub fn payload_frame(&self, vehicle: VehicleId, payload: &str) -> Option<Arc<Frame>> {
        self.board.cell(vehicle)?.payload(payload)?.frame.load_full()
    }

    /// Replaces what is tracked. Models and payloads are told with their next batch.
    ///
    /// # Errors
    /// When a number is not finite, or one track is there twice.
    pub fn set_tracks(&self, tracks: Vec<Track>) -> Result<(), Refusal> {
        let mut seen = std::collections::BTreeSet::new();
        for track in &tracks {
            if !track.position.is_finite() || !track.velocity.is_finite() {
                return Err(Refusal::InvalidValue {
                    detail: format!("track {} is not finite", track.track),
                });
            }
            if !seen.insert(track.track) {
                return Err(Refusal::InvalidValue {
                    detail: format!("track {} is there twice", track.track),
                });
            }
        }
        self.board.tracks.store(Arc::new(tracks));
        Ok(())
    }

    fn tell(&self, plugin: &str, severity: Severity, text: String) {
        let kind = EventKind::Plugin {
            plugin: plugin.to_owned(),
        };
        self.board.events.record(self.now(), None, severity, kind, text);
    }
}

fn not_running(vehicle: VehicleId, payload: Option<&str>) -> Refusal {
    Refusal::NotRunning {
        what: match payload {
            None => format!("actor of vehicle {vehicle}"),
            Some(payload) => format!("payload {payload} of vehicle {vehicle}"),
        },
    }
}
