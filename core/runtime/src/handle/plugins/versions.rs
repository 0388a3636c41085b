//! Versions of a plugin exchanged in flight: all instances or none.

use super::super::NodeHandle;
use super::{InstanceUpgrade, PluginRefusal, UpgradeReceipt};
use ractor::rpc::CallResult;
use skein_domain::exchange::Severity;
use skein_plugin_host::Plugin;
use skein_state::VehicleMessage;
use skein_state::VehicleRecord;
use skein_state::{PayloadMessage, PayloadRecord};
use skein_view::Restored;
use std::sync::Arc;
use std::time::Duration;

/// Longest wait for an instance: a child process may have to be started for it.
const ANSWER_WITHIN: Duration = Duration::from_secs(3);

/// What is said of an instance that did not answer in time. It may come up with the new version all the same, later.
const NO_ANSWER: &str = "its actor did not answer in time";

/// One instance of a plugin.
pub(super) enum Holder {
    Model(Arc<VehicleRecord>),
    Payload(Arc<PayloadRecord>),
}

impl Holder {
    pub(super) fn name(&self) -> String {
        match self {
            Self::Model(record) => record.model.health().name.clone(),
            Self::Payload(record) => record.life.health().name.clone(),
        }
    }

    async fn exchange(&self, plugin: Arc<Plugin>) -> Result<Restored, String> {
        let gone = || "its actor is not running".to_owned();
        let answer = match self {
            Self::Model(record) => {
                let actor = record.actor.get().ok_or_else(gone)?;
                actor
                    .call(|reply| VehicleMessage::Exchange(plugin, reply), Some(ANSWER_WITHIN))
                    .await
                    .map_err(|e| e.to_string())?
            }
            Self::Payload(record) => {
                let actor = record.actor.get().ok_or_else(gone)?;
                actor
                    .call(|reply| PayloadMessage::Exchange(plugin, reply), Some(ANSWER_WITHIN))
                    .await
                    .map_err(|e| e.to_string())?
            }
        };
        match answer {
            CallResult::Success(outcome) => outcome,
            CallResult::Timeout => Err(NO_ANSWER.into()),
            CallResult::SenderError => Err(gone()),
        }
    }
}

impl NodeHandle {
    /// All instances of a plugin.
    pub(super) fn holders(&self, plugin: &str) -> Vec<Holder> {
        let mut holders = Vec::new();
        for record in self.shared.vehicles.records() {
            for payload in record.payloads() {
                if payload.life.plugin().manifest().name == plugin {
                    holders.push(Holder::Payload(payload));
                }
            }
            if record.model.plugin().manifest().name == plugin {
                holders.push(Holder::Model(record));
            }
        }
        holders
    }

    /// Exchanges all instances of a plugin for its newest version, each with its state. If one does not come up, all go back.
    ///
    /// # Errors
    /// When there is no such plugin or no other version.
    pub async fn upgrade_plugin(&self, name: &str) -> Result<UpgradeReceipt, PluginRefusal> {
        self.rescan_plugins().await;
        let unknown = || PluginRefusal::Unknown { name: name.to_owned() };
        let catalog = &self.shared.plugins.catalog;
        let old = catalog.get(name).ok_or_else(unknown)?;
        let new = catalog
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
        let catalog = &self.shared.plugins.catalog;
        let old = catalog.get(name).ok_or_else(unknown)?;
        let new = catalog
            .previous(name)
            .ok_or_else(|| PluginRefusal::NothingBefore { name: name.to_owned() })?;
        Ok(self.go_over(name, &old, &new).await)
    }

    async fn go_over(&self, name: &str, old: &Arc<Plugin>, new: &Arc<Plugin>) -> UpgradeReceipt {
        // Two at once would leave each with some of the instances.
        let _alone = self.shared.plugins.exchanging.lock().await;
        let mut instances = Vec::new();
        let mut exchanged = Vec::new();
        let mut failed = false;
        for holder in self.holders(name) {
            let outcome = holder.exchange(new.clone()).await;
            failed = outcome.is_err();
            let unsure = outcome.as_ref().is_err_and(|error| error == NO_ANSWER);
            instances.push(InstanceUpgrade {
                name: holder.name(),
                restored: outcome.as_ref().ok().copied(),
                error: outcome.err(),
            });
            if !failed || unsure {
                exchanged.push(holder);
            }
            if failed {
                break;
            }
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
            self.shared.plugins.catalog.activate(name, new);
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
        for rule in &self.shared.config.adopt {
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
        if !self.shared.plugins.catalog.remove(name) {
            return Err(PluginRefusal::Unknown { name: name.to_owned() });
        }
        self.tell(name, Severity::Advisory, format!("plugin {name} removed"));
        Ok(())
    }
}
