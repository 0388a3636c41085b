//! A payload that gives back what it receives, for measuring what a call costs. Loaded as a plugin and called directly, it is the same code.
//!
//! Must never do: anything else. What it costs is what is subtracted.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use skein_plugin_sdk::domain::exchange::{Create, Event};
use skein_plugin_sdk::domain::manifest::EffectKind;
use skein_plugin_sdk::domain::{CommandId, NodeTime};
use skein_plugin_sdk::{CreateError, Effects, Payload, PayloadManifest, PluginKind};

/// It has no settings.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {}

/// It takes one command, which does nothing.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Command {
    /// Do nothing.
    Nothing,
}

/// It has no state.
#[derive(Debug, Serialize, JsonSchema)]
pub struct State {}

/// The payload.
#[derive(Debug, Default)]
pub struct Echo {
    answered: u64,
}

impl Payload for Echo {
    type Config = Settings;
    type Command = Command;
    type State = State;
    type Occurrence = State;

    const MANIFEST: PayloadManifest = PayloadManifest {
        kind: PluginKind::RADIO,
        name: env!("CARGO_PKG_NAME"),
        version: env!("CARGO_PKG_VERSION"),
        description: "Gives back what it receives.",
        effects: &[EffectKind::Transmit, EffectKind::CommandProgress],
        mavlink_messages: &[],
        tick_rate_hz: 0,
    };

    fn create(create: Create, _: Settings) -> Result<Self, CreateError> {
        let bytes = create.snapshot.unwrap_or_default();
        let answered = bytes.try_into().map_or(0, u64::from_le_bytes);
        Ok(Self { answered })
    }

    fn command(&mut self, _: NodeTime, id: CommandId, _: Command, effects: &mut Effects) {
        effects.done(id);
    }

    #[inline(never)]
    fn handle(&mut self, _: NodeTime, events: &[Event], effects: &mut Effects) {
        for event in events {
            if let Event::Received { bytes } = event {
                self.answered += 1;
                effects.transmit(bytes.clone());
            }
        }
    }

    fn snapshot(&self) -> Vec<u8> {
        self.answered.to_le_bytes().to_vec()
    }
}

skein_plugin_sdk::export_payload!(Echo);
