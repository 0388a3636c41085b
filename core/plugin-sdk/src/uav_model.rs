//! The trait of a plugin that flies one vehicle.

use crate::Effects;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use skein_domain::exchange::{Create, Event};
use skein_domain::manifest::{EffectKind, PluginManifest};
use skein_domain::{NodeTime, VehicleCommand};

/// Flies one vehicle: events in, effects out. It does no I/O, reads no clock and draws no random numbers, so that the same events give
/// the same effects; what it needs of time comes with the events.
pub trait UavModel: Sized + Send + 'static {
    /// Its configuration. Use `#[serde(deny_unknown_fields, default)]`, and a doc comment on every field: the schema shows it.
    type Config: DeserializeOwned + JsonSchema;

    /// What it says of itself.
    const MANIFEST: UavManifest;

    /// Makes an instance. With `create.snapshot` it goes on from there, in flight and without a jump; a snapshot it does not
    /// understand must not keep it from starting in a safe state.
    fn create(create: Create, config: Self::Config) -> Result<Self, CreateError>;

    /// Takes the events of one period, oldest first, and says what is to be done. Must return within a few milliseconds.
    fn handle(&mut self, now: NodeTime, events: &[Event], effects: &mut Effects);

    /// Everything a new instance needs to go on after this one, as bytes of its own. Asked for after every call: keep it small. An
    /// instance made from it gives the same bytes again until its first event.
    fn snapshot(&self) -> Vec<u8>;

    /// Schema of the state it reports with [`Effects::report`], if it does.
    #[must_use]
    fn state_schema() -> Option<schemars::Schema> {
        None
    }

    /// Schema of the events it tells with [`Effects::occurrence`], if it does.
    #[must_use]
    fn occurrence_schema() -> Option<schemars::Schema> {
        None
    }
}

/// What a UAV model says of itself.
#[derive(Debug, Clone, Copy)]
pub struct UavManifest {
    /// Its name, by which configurations choose it: lower-case letters, digits and hyphens.
    pub name: &'static str,
    /// Its version: `env!("CARGO_PKG_VERSION")`.
    pub version: &'static str,
    /// What it is for, one or two sentences.
    pub description: &'static str,
    /// The effects it may return. The host refuses any other.
    pub effects: &'static [EffectKind],
}

/// Why no instance was made, in a sentence for the operator.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CreateError(String);

impl CreateError {
    /// From a sentence, or from an error whose text is one.
    #[must_use]
    pub fn new(why: impl std::fmt::Display) -> Self {
        Self(why.to_string())
    }
}

/// The manifest as it crosses.
pub(crate) fn manifest<M: UavModel>() -> PluginManifest {
    let UavManifest {
        name,
        version,
        description,
        effects,
    } = M::MANIFEST;
    let schema = schemars::schema_for!(M::Config);
    PluginManifest {
        name: name.to_owned(),
        version: version.to_owned(),
        description: description.to_owned(),
        config_schema_json: schema.to_value().to_string(),
        effects: effects.iter().map(|effect| effect.code()).collect(),
        // All UAV models take the same commands; what one cannot do it refuses by name.
        command_schema_json: Some(schemars::schema_for!(VehicleCommand).to_value().to_string()),
        event_schema_json: M::occurrence_schema().map(|schema| schema.to_value().to_string()),
        state_schema_json: M::state_schema().map(|schema| schema.to_value().to_string()),
        ..PluginManifest::default()
    }
}
