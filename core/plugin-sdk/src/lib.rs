//! What the author of a plugin imports: the trait to implement, the macro that exports it, logging, and the vocabulary.
//!
//! Must never do: let a panic out of a plugin, hand the plugin a fault drill, or make the author write `unsafe`.
//!
//! # A whole UAV model
//!
//! ```
//! use skein_plugin_sdk::domain::exchange::{Create, Event};
//! use skein_plugin_sdk::domain::{NodeTime, Setpoint, manifest::EffectKind};
//! use skein_plugin_sdk::{CreateError, Effects, UavManifest, UavModel, log};
//!
//! /// Settings, as they stand in the node's configuration.
//! #[derive(serde::Deserialize, schemars::JsonSchema)]
//! #[serde(deny_unknown_fields, default)]
//! struct Settings {
//!     /// How far above the first place to hold, in metres.
//!     above_m: f64,
//! }
//!
//! impl Default for Settings {
//!     fn default() -> Self {
//!         Self { above_m: 2.0 }
//!     }
//! }
//!
//! /// Holds where it first was.
//! struct Holder {
//!     settings: Settings,
//!     hold: Option<Setpoint>,
//! }
//!
//! impl UavModel for Holder {
//!     type Config = Settings;
//!
//!     const MANIFEST: UavManifest = UavManifest {
//!         name: "holder",
//!         version: env!("CARGO_PKG_VERSION"),
//!         description: "Holds where it first was.",
//!         effects: &[EffectKind::Setpoint],
//!     };
//!
//!     fn create(create: Create, settings: Settings) -> Result<Self, CreateError> {
//!         if settings.above_m < 0.0 {
//!             return Err(CreateError::new("above_m must not be negative"));
//!         }
//!         log::info!("flying vehicle {}", create.vehicle);
//!         Ok(Self { settings, hold: None })
//!     }
//!
//!     fn handle(&mut self, _now: NodeTime, events: &[Event], effects: &mut Effects) {
//!         for event in events {
//!             match event {
//!                 Event::Own(own) if self.hold.is_none() => {
//!                     let up = skein_plugin_sdk::domain::VelocityNed::new(0.0, 0.0, -self.settings.above_m);
//!                     self.hold = own.kinematics.map(|k| Setpoint::hold(k.position.after(&up, 1.0), Some(k.yaw_rad)));
//!                 }
//!                 Event::Tick => effects.extend(self.hold.map(skein_plugin_sdk::domain::exchange::Effect::Setpoint)),
//!                 _ => {}
//!             }
//!         }
//!     }
//!
//!     fn snapshot(&self) -> Vec<u8> {
//!         Vec::new()
//!     }
//! }
//!
//! // In the shim crate with `crate-type = ["cdylib"]`; this line is all of it:
//! skein_plugin_sdk::export_uav_model!(Holder);
//! # fn main() {
//! # assert!(SKEIN_PLUGIN.check().is_ok());
//! # }
//! ```

mod decode;
mod effects;
pub mod export;
pub mod frames;
mod guard;
mod host;
pub mod log;
mod payload;
pub mod saved;
mod uav_model;

pub use effects::Effects;
pub use payload::{Payload, PayloadManifest};
pub use skein_domain as domain;
pub use skein_plugin_abi as abi;
pub use skein_plugin_abi::PluginKind;
pub use uav_model::{CreateError, UavManifest, UavModel};
