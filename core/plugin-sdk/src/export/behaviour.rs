//! What every kind of plugin is behind the entries: one trait, with a wrapper for each trait that an author may implement.

use super::Failure;
use crate::uav_model::manifest;
use crate::{Effects, Payload, UavModel};
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use skein_domain::exchange::{Create, Event};
use skein_domain::manifest::PluginManifest;
use skein_domain::{CommandId, NodeTime, Refusal};
use skein_plugin_abi::{PluginKind, Status};

/// Events in, effects out, of any kind.
pub(super) trait Behaviour: Sized + Send + 'static {
    /// What it is for.
    const KIND: PluginKind;

    fn manifest() -> PluginManifest;
    fn create(create: Create) -> Result<Self, Failure>;
    fn handle(&mut self, now: NodeTime, events: &[Event], effects: &mut Effects);
    fn snapshot(&self) -> Vec<u8>;
}

/// A UAV model.
pub(super) struct Flying<M>(M);

impl<M: UavModel> Behaviour for Flying<M> {
    const KIND: PluginKind = PluginKind::UAV_MODEL;

    fn manifest() -> PluginManifest {
        manifest::<M>()
    }

    fn create(create: Create) -> Result<Self, Failure> {
        let config = config(&create)?;
        M::create(create, config).map(Self).map_err(refused)
    }

    fn handle(&mut self, now: NodeTime, events: &[Event], effects: &mut Effects) {
        self.0.handle(now, events, effects);
    }

    fn snapshot(&self) -> Vec<u8> {
        self.0.snapshot()
    }
}

/// A payload.
pub(super) struct Carried<P>(P);

impl<P: Payload> Behaviour for Carried<P> {
    const KIND: PluginKind = P::MANIFEST.kind;

    fn manifest() -> PluginManifest {
        let own = P::MANIFEST;
        PluginManifest {
            name: own.name.to_owned(),
            version: own.version.to_owned(),
            description: own.description.to_owned(),
            config_schema_json: schema::<P::Config>(),
            effects: own.effects.iter().map(|effect| effect.code()).collect(),
            command_schema_json: Some(schema::<P::Command>()),
            state_schema_json: Some(schema::<P::State>()),
            event_schema_json: Some(schema::<P::Occurrence>()),
            mavlink_messages: Some(own.mavlink_messages.to_vec()),
            tick_rate_hz: Some(own.tick_rate_hz),
        }
    }

    fn create(create: Create) -> Result<Self, Failure> {
        let config = config(&create)?;
        P::create(create, config).map(Self).map_err(refused)
    }

    fn handle(&mut self, now: NodeTime, events: &[Event], effects: &mut Effects) {
        // In order: what came before a command is handled before it.
        let mut rest = events;
        while let Some(at) = rest.iter().position(|e| matches!(e, Event::PayloadCommand { .. })) {
            let (before, from) = rest.split_at(at);
            if !before.is_empty() {
                self.0.handle(now, before, effects);
            }
            if let Some(Event::PayloadCommand { id, command_json }) = from.first() {
                self.command(now, *id, command_json, effects);
            }
            rest = from.get(1..).unwrap_or_default();
        }
        if !rest.is_empty() {
            self.0.handle(now, rest, effects);
        }
    }

    fn snapshot(&self) -> Vec<u8> {
        self.0.snapshot()
    }
}

impl<P: Payload> Carried<P> {
    fn command(&mut self, now: NodeTime, id: CommandId, command_json: &str, effects: &mut Effects) {
        match serde_json::from_str::<P::Command>(command_json) {
            Ok(command) => self.0.command(now, id, command, effects),
            Err(error) => effects.refused(id, Refusal::invalid(format!("command: {error}"))),
        }
    }
}

fn config<C: DeserializeOwned>(create: &Create) -> Result<C, Failure> {
    serde_json::from_str(&create.config_json).map_err(|e| (Status::REFUSED, format!("configuration: {e}")))
}

fn refused(error: crate::CreateError) -> Failure {
    (Status::REFUSED, error.to_string())
}

fn schema<T: JsonSchema>() -> String {
    schemars::schema_for!(T).to_value().to_string()
}
