//! The manifest of a plugin, decoded and found right.

use crate::schemas::{Schema, Schemas, check};
use crate::{LoadError, SchemaError};
use serde::Serialize;
use skein_domain::manifest::{EffectKind, PluginManifest};
use skein_plugin_abi::PluginKind;
use std::collections::BTreeSet;
use std::sync::Arc;

/// No manifest is longer, in bytes.
const MAX_MANIFEST_BYTES: usize = 1 << 20;
/// No name or version is longer, in bytes.
const MAX_NAME_BYTES: usize = 64;
/// More than this many calls per second without an occasion are not made.
const MAX_TICK_RATE_HZ: u16 = 200;
/// Message ids of MAVLink have 24 bits.
const MAX_MESSAGE_ID: u32 = (1 << 24) - 1;

/// What a plugin says of itself.
#[derive(Debug, Clone, Serialize)]
pub struct Manifest {
    /// Its name, by which configurations choose it.
    pub name: String,
    /// Its own version.
    pub version: String,
    /// What it is for.
    #[serde(serialize_with = "kind_word")]
    pub kind: PluginKind,
    /// One or two sentences for people.
    pub description: String,
    /// JSON Schema of its configuration, as text.
    pub config_schema_json: String,
    /// JSON Schema of the commands it takes, as text; absent if it takes none of its own.
    pub command_schema_json: Option<String>,
    /// JSON Schema of the state it reports, as text; absent if it reports none.
    pub state_schema_json: Option<String>,
    /// JSON Schema of the events it tells, as text; absent if it tells none.
    pub event_schema_json: Option<String>,
    /// MAVLink messages it wants to see, by id.
    pub mavlink_messages: BTreeSet<u32>,
    /// How often it wants to be called without an occasion, per second; 0 for a UAV model, which is called in every control period.
    pub tick_rate_hz: u16,
    /// The effects it may return.
    pub effects: BTreeSet<EffectKind>,
    #[serde(skip)]
    schemas: Arc<Schemas>,
}

fn kind_word<S: serde::Serializer>(kind: &PluginKind, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(kind)
}

impl Manifest {
    /// Decodes and checks.
    pub(crate) fn decode(kind: PluginKind, bytes: &[u8]) -> Result<Self, LoadError> {
        if bytes.len() > MAX_MANIFEST_BYTES {
            return Err(bad(format!("it has {} bytes", bytes.len())));
        }
        let manifest: PluginManifest = minicbor::decode(bytes).map_err(|e| bad(format!("not decodable: {e}")))?;
        check_words(&manifest)?;
        let tick_rate_hz = manifest.tick_rate_hz.unwrap_or(0);
        if tick_rate_hz > MAX_TICK_RATE_HZ {
            return Err(bad(format!(
                "it wants {tick_rate_hz} calls per second, the limit is {MAX_TICK_RATE_HZ}"
            )));
        }
        let mavlink_messages: BTreeSet<u32> = manifest.mavlink_messages.unwrap_or_default().into_iter().collect();
        if let Some(id) = mavlink_messages.iter().find(|id| **id > MAX_MESSAGE_ID) {
            return Err(bad(format!("{id} is no id of a MAVLink message")));
        }
        let effects = manifest
            .effects
            .iter()
            .map(|code| effect(kind, *code))
            .collect::<Result<_, _>>()?;
        let optional =
            |what, json: &Option<String>| json.as_deref().map(|json| Schema::compile(what, json)).transpose();
        let schemas = Schemas {
            config: Schema::compile("the configuration", &manifest.config_schema_json).map_err(bad)?,
            command: optional("the commands", &manifest.command_schema_json).map_err(bad)?,
            state: optional("the state", &manifest.state_schema_json).map_err(bad)?,
            event: optional("the events", &manifest.event_schema_json).map_err(bad)?,
        };
        Ok(Self {
            name: manifest.name,
            version: manifest.version,
            kind,
            description: manifest.description,
            config_schema_json: manifest.config_schema_json,
            command_schema_json: manifest.command_schema_json,
            state_schema_json: manifest.state_schema_json,
            event_schema_json: manifest.event_schema_json,
            mavlink_messages,
            tick_rate_hz,
            effects,
            schemas: Arc::new(schemas),
        })
    }

    /// Whether a configuration is as its schema has it. What only the plugin itself can judge shows when an instance is created.
    pub fn check_config(&self, json: &str) -> Result<(), SchemaError> {
        self.schemas.config.check(json)
    }

    /// Whether a command is as its schema has it.
    pub fn check_command(&self, json: &str) -> Result<(), SchemaError> {
        check(self.schemas.command.as_ref(), json)
    }

    /// Whether a state is as its schema has it.
    pub fn check_state(&self, json: &str) -> Result<(), SchemaError> {
        check(self.schemas.state.as_ref(), json)
    }

    /// Whether an event is as its schema has it.
    pub fn check_event(&self, json: &str) -> Result<(), SchemaError> {
        check(self.schemas.event.as_ref(), json)
    }
}

fn check_words(manifest: &PluginManifest) -> Result<(), LoadError> {
    let PluginManifest {
        name,
        version,
        description,
        ..
    } = manifest;
    let name_letter = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if name.is_empty() || name.len() > MAX_NAME_BYTES || !name.chars().all(name_letter) {
        return Err(bad(format!(
            "the name {name:?} is not made of 1 to {MAX_NAME_BYTES} of a-z, 0-9 and -"
        )));
    }
    if version.is_empty() || version.len() > MAX_NAME_BYTES || !version.chars().all(|c| c.is_ascii_graphic()) {
        return Err(bad(format!(
            "the version {version:?} is not made of 1 to {MAX_NAME_BYTES} printable letters"
        )));
    }
    if description.trim().is_empty() {
        return Err(bad("it has no description".to_owned()));
    }
    Ok(())
}

/// The effect with this code, if a plugin of this kind may have it.
fn effect(kind: PluginKind, code: u32) -> Result<EffectKind, LoadError> {
    let effect = EffectKind::from_code(code).ok_or_else(|| bad(format!("effect {code} is not known to this host")))?;
    let may = match (kind, effect) {
        (PluginKind::UAV_MODEL, effect) => effect.is_for_uav_models(),
        (kind, EffectKind::Frame) => kind == PluginKind::CAMERA,
        (_, effect) => effect.is_for_payloads(),
    };
    if may {
        Ok(effect)
    } else {
        Err(bad(format!("a {kind} plugin may not have the effect {effect}")))
    }
}

fn bad(detail: String) -> LoadError {
    LoadError::BadManifest { detail }
}

#[cfg(test)]
mod tests;
