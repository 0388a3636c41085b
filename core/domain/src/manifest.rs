//! What a plugin says of itself before an instance of it is made, as CBOR with numbered fields.

use crate::exchange::Effect;
use minicbor::{Decode, Encode};
use serde::Serialize;

/// What a plugin says of itself. The kind of plugin stands in its handshake.
#[derive(Debug, Clone, PartialEq, Eq, Default, Encode, Decode)]
pub struct PluginManifest {
    /// Its name, by which configurations choose it: lower-case letters, digits and hyphens.
    #[n(0)]
    pub name: String,
    /// Its own version.
    #[n(1)]
    pub version: String,
    /// What it is for, one or two sentences.
    #[n(2)]
    pub description: String,
    /// JSON Schema of its configuration, as text.
    #[n(3)]
    pub config_schema_json: String,
    /// Codes of the effects it may return ([`EffectKind::code`]); any other is refused. Numbers and not the enum, so that a host
    /// can name one it does not know.
    #[n(4)]
    pub effects: Vec<u32>,
    /// JSON Schema of the commands it takes, as text; absent if it takes none of its own.
    #[n(5)]
    pub command_schema_json: Option<String>,
    /// JSON Schema of the state it reports, as text; absent if it reports none.
    #[n(6)]
    pub state_schema_json: Option<String>,
    /// JSON Schema of the events it tells, as text; absent if it tells none.
    #[n(7)]
    pub event_schema_json: Option<String>,
    /// MAVLink messages it wants to see, by id.
    #[n(8)]
    pub mavlink_messages: Option<Vec<u32>>,
    /// How often a payload wants to be called without an occasion, per second; absent for a UAV model, which is called in every
    /// control period.
    #[n(9)]
    pub tick_rate_hz: Option<u16>,
}

macro_rules! effect_kinds {
    ($($(#[$doc:meta])* $code:literal $kind:ident $word:literal $pattern:pat),+ $(,)?) => {
        /// The kind of an effect, as manifests name it. Codes are those of [`Effect`]'s variants and are never reused.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
        #[serde(rename_all = "snake_case")]
        #[repr(u8)]
        pub enum EffectKind { $($(#[$doc])* $kind = $code),+ }

        impl EffectKind {
            /// All kinds in the order of their codes.
            pub const ALL: &'static [Self] = &[$(Self::$kind),+];

            /// The kind with this code, if there is one.
            #[must_use]
            pub fn from_code(code: u32) -> Option<Self> {
                match code { $($code => Some(Self::$kind),)+ _ => None }
            }

            /// The word for it.
            #[must_use]
            pub const fn word(self) -> &'static str {
                match self { $(Self::$kind => $word),+ }
            }
        }

        impl Effect {
            /// Which kind of effect it is.
            #[must_use]
            pub const fn kind(&self) -> EffectKind {
                match self { $($pattern => EffectKind::$kind),+ }
            }
        }
    };
}

effect_kinds!(
    /// Streams a setpoint.
    0 Setpoint "setpoint" Effect::Setpoint(_),
    /// Ends the stream.
    1 StopStream "stop_stream" Effect::StopStream,
    /// Asks the autopilot.
    2 Autopilot "autopilot" Effect::Autopilot { .. },
    /// Reports on a command.
    3 CommandProgress "command_progress" Effect::CommandProgress { .. },
    /// Changes the flight state.
    4 State "state" Effect::State { .. },
    /// Publishes the anchor of a formation.
    5 Anchor "anchor" Effect::Anchor(_),
    /// Tells an operator something.
    6 Notice "notice" Effect::Notice { .. },
    /// Reports the tracking error.
    7 TrackingError "tracking_error" Effect::TrackingError { .. },
    /// Reports the end of the route.
    8 RouteFinished "route_finished" Effect::RouteFinished,
    /// Sends a MAVLink message to its vehicle's system.
    9 Mavlink "mavlink" Effect::Mavlink(_),
    /// Sends bytes on the payload's own transport.
    10 Transmit "transmit" Effect::Transmit { .. },
    /// Reports its own state.
    11 Report "report" Effect::Report { .. },
    /// Tells of something that happened.
    12 Occurrence "occurrence" Effect::Occurrence { .. },
    /// Commands a payload of its vehicle.
    13 PayloadCommand "payload_command" Effect::PayloadCommand { .. },
    /// Gives a frame.
    14 Frame "frame" Effect::Frame(_),
    /// Says whether the vehicle can host the coordinator.
    15 Capability "capability" Effect::Capability(_),
    /// Says what the vehicle can do.
    16 Limits "limits" Effect::Limits(_),
    /// Adds to the preflight report.
    17 Preflight "preflight" Effect::Preflight(_),
);

impl EffectKind {
    /// The code that stands for it in manifests.
    #[must_use]
    pub const fn code(self) -> u32 {
        self as u32
    }

    /// Whether a UAV model may name it in its manifest.
    #[must_use]
    pub const fn is_for_uav_models(self) -> bool {
        !matches!(self, Self::Mavlink | Self::Transmit | Self::Frame)
    }

    /// Whether a payload may name it in its manifest. Nothing that moves a vehicle is among them.
    #[must_use]
    pub const fn is_for_payloads(self) -> bool {
        matches!(
            self,
            Self::CommandProgress
                | Self::Notice
                | Self::Mavlink
                | Self::Transmit
                | Self::Report
                | Self::Occurrence
                | Self::Frame
        )
    }
}

impl std::fmt::Display for EffectKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.word())
    }
}

#[cfg(test)]
mod tests;
