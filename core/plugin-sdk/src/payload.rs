//! The trait of a plugin that is a payload of a vehicle: a gimbal, a camera, a radio, a detector.

use crate::{CreateError, Effects};
use schemars::JsonSchema;
use serde::Serialize;
use serde::de::DeserializeOwned;
use skein_domain::exchange::{Create, Event};
use skein_domain::manifest::EffectKind;
use skein_domain::{CommandId, NodeTime};
use skein_plugin_abi::PluginKind;

/// A payload of one vehicle: events in, effects out. It can send to its own device and to nothing else; no effect that moves a vehicle
/// is open to it.
///
/// Its device is reached through the host: over the vehicle's MAVLink ([`Event::Mavlink`], [`Effects::mavlink`]) or over a transport of
/// its own that the configuration names ([`Event::Received`], [`Effects::transmit`]). So the same plugin can be tested without any
/// device, and runs in a child process that needs no network. A plugin that has to open something of its own all the same (a video file, a
/// netlink socket) does it on a thread of its own, which ends with the instance.
pub trait Payload: Sized + Send + 'static {
    /// Its configuration. Use `#[serde(deny_unknown_fields, default)]`, and a doc comment on every field: the schema shows it.
    type Config: DeserializeOwned + JsonSchema;

    /// What it can be told: `skein_domain::payload::GimbalCommand` and its like, or a type of its own.
    type Command: DeserializeOwned + JsonSchema;

    /// What it reports of itself: `skein_domain::payload::GimbalState` and its like, or a type of its own.
    type State: Serialize + JsonSchema;

    /// What it tells when something happens; `()` if it never does.
    type Occurrence: Serialize + JsonSchema;

    /// What it says of itself.
    const MANIFEST: PayloadManifest;

    /// Makes an instance. With `create.snapshot` it goes on from there; a snapshot it does not understand must not keep it from
    /// starting in a safe state.
    fn create(create: Create, config: Self::Config) -> Result<Self, CreateError>;

    /// A command. It ends in exactly one [`Effects::done`] or [`Effects::refused`], now or later.
    fn command(&mut self, now: NodeTime, id: CommandId, command: Self::Command, effects: &mut Effects);

    /// Takes other events, oldest first. Must return within a few milliseconds.
    fn handle(&mut self, now: NodeTime, events: &[Event], effects: &mut Effects);

    /// Everything a new instance needs to go on after this one, as bytes of its own. Asked for after every call: keep it small. An
    /// instance made from it gives the same bytes again until its first event.
    fn snapshot(&self) -> Vec<u8>;
}

/// What a payload says of itself.
#[derive(Debug, Clone, Copy)]
pub struct PayloadManifest {
    /// What it is: [`PluginKind::GIMBAL`] and its like.
    pub kind: PluginKind,
    /// Its name, by which configurations choose it: lower-case letters, digits and hyphens.
    pub name: &'static str,
    /// Its version: `env!("CARGO_PKG_VERSION")`.
    pub version: &'static str,
    /// What it is for, one or two sentences.
    pub description: &'static str,
    /// The effects it may return. The host refuses any other.
    pub effects: &'static [EffectKind],
    /// MAVLink messages it wants to see, by id.
    pub mavlink_messages: &'static [u32],
    /// How often it wants to be called without an occasion, per second.
    pub tick_rate_hz: u16,
}
