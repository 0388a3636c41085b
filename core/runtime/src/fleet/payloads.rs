//! Payloads under the fleet's control: put on a vehicle by its adoption rule or at run time, their actors supervised beside the vehicle's.
//!
//! They are the fleet's children and not their vehicle's: ractor ends children with their parent, and the end of a vehicle's actor
//! must not take its gimbal along.

use super::{Child, FleetMessage, FleetState};
use crate::payload::{Payload, PayloadArguments, escalate};
use ractor::{Actor, ActorRef};
use skein_config::PayloadRule;
use skein_domain::exchange::Severity;
use skein_domain::payload::PayloadKind;
use skein_domain::{Incarnation, Refusal, VehicleId};
use skein_plugin_host::PluginKind;
use skein_state::restart::{Decision, PAYLOAD_LIMITS, RestartHistory, fraction};
use skein_state::{PayloadRecord, PluginIdentity, PluginRecord, SharedState, VehicleRecord};
use skein_view::{ActorStatus, EventKind};
use std::sync::Arc;
use std::time::Duration;

/// A payload of the fleet: vehicle and name.
pub(super) type PayloadKey = (VehicleId, String);

/// Failures of one payload's actor.
#[derive(Default)]
pub(super) struct SupervisedPayload {
    incarnation: Incarnation,
    history: RestartHistory,
}

/// What a plugin of this kind is on a vehicle.
pub fn payload_kind(kind: PluginKind) -> Option<PayloadKind> {
    match kind {
        PluginKind::GIMBAL => Some(PayloadKind::Gimbal),
        PluginKind::CAMERA => Some(PayloadKind::Camera),
        PluginKind::RADIO => Some(PayloadKind::Radio),
        PluginKind::DETECTOR => Some(PayloadKind::Detector),
        _ => None,
    }
}

/// A payload as its rule describes it, for a vehicle.
///
/// # Errors
/// What of the rule cannot be, in a sentence.
pub fn payload_record(
    shared: &SharedState,
    vehicle: &VehicleRecord,
    rule: &PayloadRule,
) -> Result<PayloadRecord, Refusal> {
    let invalid = |detail: String| Refusal::invalid(format!("payload {:?}: {detail}", rule.name));
    rule.check().map_err(invalid)?;
    let plugin = (shared.plugins.catalog.get(&rule.plugin))
        .ok_or_else(|| invalid(format!("the plugin \"{}\" is not among those found", rule.plugin)))?;
    let kind = payload_kind(plugin.manifest().kind).ok_or_else(|| {
        invalid(format!(
            "the plugin \"{}\" is a {}",
            rule.plugin,
            plugin.manifest().kind
        ))
    })?;
    let config_json = rule.config_json();
    plugin
        .manifest()
        .check_config(&config_json)
        .map_err(|e| invalid(format!("config: {e}")))?;
    let transport = rule
        .transport
        .as_ref()
        .map(|text| text.parse().map_err(|e| invalid(format!("transport: {e}"))))
        .transpose()?;
    let identity = PluginIdentity {
        name: format!("payload-{}-{}", vehicle.id, rule.name),
        label: format!("{}: {}", vehicle.name, rule.name),
        vehicle: vehicle.id,
        payload: Some(rule.name.clone()),
        system_id: vehicle.system_id,
    };
    let life = PluginRecord::new(identity, plugin, config_json, rule.isolation);
    Ok(PayloadRecord::new(rule.clone(), kind, life, transport))
}

impl FleetState {
    /// Puts a payload on a vehicle and starts it.
    pub(super) async fn attach(
        &mut self,
        myself: &ActorRef<FleetMessage>,
        vehicle: VehicleId,
        rule: &PayloadRule,
    ) -> Result<(), Refusal> {
        let record = self.shared.vehicles.known(vehicle)?;
        if record.payload(&rule.name).is_some() {
            return Err(Refusal::invalid(format!(
                "vehicle {vehicle} has a payload \"{}\" already",
                rule.name
            )));
        }
        let payload = Arc::new(payload_record(&self.shared, &record, rule)?);
        record.attach(payload);
        self.tell(
            &record,
            &rule.name,
            Severity::Info,
            &format!("attached, plugin {}", rule.plugin),
        );
        self.start_payload(myself, (vehicle, rule.name.clone())).await;
        Ok(())
    }

    /// Takes a payload off its vehicle and ends it.
    pub(super) fn detach(&mut self, vehicle: VehicleId, name: &str) -> Result<(), Refusal> {
        let record = self.shared.vehicles.known(vehicle)?;
        let payload = record.detach(name).ok_or_else(|| Refusal::UnknownPayload {
            vehicle,
            payload: name.to_owned(),
        })?;
        self.supervised_payloads.remove(&(vehicle, name.to_owned()));
        if let Some(actor) = payload.actor.end() {
            self.children.remove(&actor.get_id());
            actor.stop(Some("detached".into()));
        }
        self.tell(&record, name, Severity::Info, "detached");
        Ok(())
    }

    /// Starts the payloads of a vehicle that have no actor.
    pub(super) async fn start_payloads(&mut self, myself: &ActorRef<FleetMessage>, record: &VehicleRecord) {
        for payload in record.payloads() {
            let key = (record.id, payload.name.clone());
            self.supervised_payloads.entry(key.clone()).or_default().incarnation = payload.state().actor.incarnation;
            self.start_payload(myself, key).await;
        }
    }

    /// Starts the next incarnation of a payload's actor.
    pub(super) async fn start_payload(&mut self, myself: &ActorRef<FleetMessage>, key: PayloadKey) {
        let Some(vehicle) = self.shared.vehicles.record(key.0) else {
            return;
        };
        let Some(record) = vehicle.payload(&key.1) else { return };
        let supervised = self.supervised_payloads.entry(key.clone()).or_default();
        supervised.incarnation = supervised.incarnation.next();
        let arguments = PayloadArguments {
            shared: self.shared.clone(),
            vehicle,
            record,
            incarnation: supervised.incarnation,
        };
        match Payload::spawn_linked(None, Payload, arguments, myself.get_cell()).await {
            Ok((actor, _)) => {
                self.children.insert(actor.get_id(), Child::Payload(key));
            }
            Err(error) => self.payload_ended(myself, key, &error.to_string()),
        }
    }

    /// A payload's actor ended by itself.
    pub(super) fn payload_ended(&mut self, myself: &ActorRef<FleetMessage>, key: PayloadKey, error: &str) {
        let Some(vehicle) = self.shared.vehicles.record(key.0) else {
            return;
        };
        let Some(record) = vehicle.payload(&key.1) else { return };
        let now = self.shared.now();
        record.actor.end();
        let supervised = self.supervised_payloads.entry(key.clone()).or_default();
        let decision = supervised.history.decide(&PAYLOAD_LIMITS, now, fraction(now));
        let (status, severity, text) = match decision {
            Decision::RestartAfter(_) => (
                ActorStatus::Restarting,
                Severity::Warning,
                format!("actor ended ({error}); restarting"),
            ),
            Decision::GiveUp => (
                ActorStatus::GivenUp,
                Severity::Critical,
                format!("actor failed too often ({error})"),
            ),
        };
        {
            let mut published = record.change_state();
            published.actor.status = status;
            published.actor.last_error = error.to_owned();
            published.actor.since = now;
            if published.report.take().is_some() {
                published.revision += 1;
            }
        }
        self.tell(&vehicle, &key.1, severity, &text);
        match decision {
            Decision::RestartAfter(delay_s) => {
                myself.send_after(Duration::from_secs_f64(delay_s), move || {
                    FleetMessage::RestartPayload(key)
                });
            }
            Decision::GiveUp => escalate(&self.shared, &vehicle, &record, error),
        }
    }

    fn tell(&self, vehicle: &VehicleRecord, payload: &str, severity: Severity, text: &str) {
        let kind = EventKind::Payload {
            payload: payload.to_owned(),
        };
        let text = format!("{}: {payload} {text}", vehicle.name);
        self.shared
            .events
            .record(self.shared.now(), Some(vehicle.id), severity, kind, text);
    }
}
