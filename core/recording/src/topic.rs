//! The topics of a recording, and the schema of what is told on each. Their names are what people choose from in Foxglove and in `mcap`.
//!
//! Must never do: change a topic that this program reads again without raising [`crate::FORMAT`]. Those of `foxglove.*` are for viewers alone.

use crate::audit::AuditRecord;
use crate::plain_schema::plain;
use crate::telemetry::{ClockRecord, RecorderState, SetpointRecord, VehicleTelemetry};
use foxglove::Encode;
use foxglove::messages::{CompressedVideo, FrameTransforms, LocationFix, Log, SceneUpdate};
use schemars::{JsonSchema, schema_for};
use skein_domain::VehicleId;
use skein_view::{EventRecord, FleetSnapshot};
use std::borrow::Cow;
use std::fmt;

/// A topic.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Topic {
    /// Everything a screen shows, as [`FleetSnapshot`].
    Fleet,
    /// What happened, as [`EventRecord`].
    Events,
    /// What operators and programs did, chained, as [`AuditRecord`].
    Audit,
    /// How the clocks of the swarm stand to each other, as [`ClockRecord`].
    Clock,
    /// How the recorder fares, as [`RecorderState`].
    Recorder,
    /// The safety gate as it is from now on, as [`GateState`](crate::decisions::GateState).
    Gate,
    /// All vehicles at one control period, for decisions that name it, as [`PeersRecord`](crate::decisions::PeersRecord).
    Peers,
    /// What the failsafe policy decided and from what, as [`FailsafeDecision`](crate::decisions::FailsafeDecision).
    Failsafe,
    /// What was planned for a formation and from what, as [`FormationDecision`](crate::decisions::FormationDecision).
    Formation,
    /// What was decided about the leadership and from what, as [`LeadershipDecision`](crate::decisions::LeadershipDecision).
    Leadership,
    /// What is known of one vehicle, as [`VehicleTelemetry`].
    Telemetry(VehicleId),
    /// A setpoint as its model asked for it and as it was flown, as [`SetpointRecord`].
    Setpoint(VehicleId),
    /// Encoded pictures of a camera, as `foxglove.CompressedVideo`.
    Video(VehicleId, String),
    /// Where a vehicle is on Earth, as `foxglove.LocationFix`.
    Location(VehicleId),
    /// Where all vehicles and tracks are in the swarm's frame, east, north and up, as `foxglove.FrameTransforms`.
    Transforms,
    /// What stands for vehicles, tracks and fences in a 3D view, as `foxglove.SceneUpdate`.
    Scene,
    /// Events as lines of a log, as `foxglove.Log`.
    Log,
}

/// The schema of what is told on a topic.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TopicSchema {
    /// Its name, as `skein.VehicleTelemetry` or `foxglove.Log`.
    pub name: Cow<'static, str>,
    /// `jsonschema` or `protobuf`.
    pub encoding: Cow<'static, str>,
    /// The schema itself.
    pub data: Cow<'static, [u8]>,
    /// How messages are encoded: `json` or `protobuf`.
    pub message_encoding: Cow<'static, str>,
}

/// Topics that are about no vehicle, by name.
const ALONE: [(Topic, &str); 13] = [
    (Topic::Fleet, "/skein/fleet"),
    (Topic::Events, "/skein/events"),
    (Topic::Audit, "/skein/audit"),
    (Topic::Clock, "/skein/clock"),
    (Topic::Recorder, "/skein/recorder"),
    (Topic::Gate, "/skein/gate"),
    (Topic::Peers, "/skein/peers"),
    (Topic::Failsafe, "/skein/decisions/failsafe"),
    (Topic::Formation, "/skein/decisions/formation"),
    (Topic::Leadership, "/skein/decisions/leadership"),
    (Topic::Transforms, "/tf"),
    (Topic::Scene, "/scene"),
    (Topic::Log, "/log"),
];

impl fmt::Display for Topic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Telemetry(vehicle) => write!(f, "/vehicles/{vehicle}/telemetry"),
            Self::Setpoint(vehicle) => write!(f, "/vehicles/{vehicle}/setpoint"),
            Self::Location(vehicle) => write!(f, "/vehicles/{vehicle}/location"),
            Self::Video(vehicle, camera) => write!(f, "/vehicles/{vehicle}/cameras/{camera}"),
            alone => {
                let named = ALONE.iter().find(|(topic, _)| topic == alone);
                f.write_str(named.map_or("/skein", |(_, name)| *name))
            }
        }
    }
}

impl Topic {
    /// The topic of that name; `None` for one of another program.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        if let Some((topic, _)) = ALONE.iter().find(|(_, alone)| *alone == name) {
            return Some(topic.clone());
        }
        let (vehicle, rest) = name.strip_prefix("/vehicles/")?.split_once('/')?;
        let vehicle = VehicleId(vehicle.parse().ok()?);
        match rest.split_once('/') {
            None if rest == "telemetry" => Some(Self::Telemetry(vehicle)),
            None if rest == "location" => Some(Self::Location(vehicle)),
            None if rest == "setpoint" => Some(Self::Setpoint(vehicle)),
            Some(("cameras", camera)) => Some(Self::Video(vehicle, camera.to_owned())),
            _ => None,
        }
    }

    /// The schema of what is told on it.
    #[must_use]
    pub fn schema(&self) -> TopicSchema {
        match self {
            Self::Fleet => json::<FleetSnapshot>("skein.FleetSnapshot"),
            Self::Events => json::<EventRecord>("skein.EventRecord"),
            Self::Audit => json::<AuditRecord>("skein.AuditRecord"),
            Self::Clock => json::<ClockRecord>("skein.ClockRecord"),
            Self::Recorder => json::<RecorderState>("skein.RecorderState"),
            Self::Gate => anything("skein.GateState"),
            Self::Peers => anything("skein.PeersRecord"),
            Self::Failsafe => anything("skein.FailsafeDecision"),
            Self::Formation => anything("skein.FormationDecision"),
            Self::Leadership => anything("skein.LeadershipDecision"),
            Self::Telemetry(_) => json::<VehicleTelemetry>("skein.VehicleTelemetry"),
            Self::Setpoint(_) => json::<SetpointRecord>("skein.SetpointRecord"),
            Self::Video(..) => theirs::<CompressedVideo>(),
            Self::Location(_) => theirs::<LocationFix>(),
            Self::Transforms => theirs::<FrameTransforms>(),
            Self::Scene => theirs::<SceneUpdate>(),
            Self::Log => theirs::<Log>(),
        }
    }
}

fn json<T: JsonSchema>(name: &'static str) -> TopicSchema {
    of_json(name, plain(&schema_for!(T).to_value()).to_string().into_bytes())
}

/// What decisions were made from is for the program that decides: its schema says no more than that it is an object.
fn anything(name: &'static str) -> TopicSchema {
    of_json(name, br#"{"type":"object","additionalProperties":true}"#.to_vec())
}

fn of_json(name: &'static str, data: Vec<u8>) -> TopicSchema {
    TopicSchema {
        name: name.into(),
        encoding: "jsonschema".into(),
        data: data.into(),
        message_encoding: "json".into(),
    }
}

fn theirs<T: Encode>() -> TopicSchema {
    let schema = T::get_schema();
    let (name, encoding, data) = schema.map_or_else(
        || (String::new(), String::new(), Cow::Borrowed(&[][..])),
        |schema| (schema.name, schema.encoding, schema.data),
    );
    TopicSchema {
        name: name.into(),
        encoding: encoding.into(),
        data,
        message_encoding: T::get_message_encoding().into(),
    }
}
