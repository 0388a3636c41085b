//! What is being observed, as data: all of it goes into the snapshot, beside that of the flight.

use crate::target::Aimed;
use minicbor::bytes::ByteVec;
use minicbor::{Decode, Encode};
use skein_plugin_sdk::Effects;
use skein_plugin_sdk::domain::exchange::Severity;
use skein_plugin_sdk::domain::{CommandId, NodeTime, PositionNed, RequestId};

/// Changes when an older snapshot would be misunderstood. Fields that are only added keep it.
const SNAPSHOT_VERSION: u32 = 1;

/// Everything that is not the flight's.
#[derive(Debug, Clone, PartialEq, Default, Encode, Decode)]
pub(crate) struct Watch {
    /// What the vehicle flies beside.
    #[n(0)]
    pub observation: Option<Observation>,
    /// What is looked at without flying for it; outranks what is observed.
    #[n(1)]
    pub region: Option<Region>,
    /// Number of the next request to a payload.
    #[n(2)]
    pub next_request: u32,
    /// Where the gimbal was last told to point.
    #[n(3)]
    pub pointed: Option<Pointed>,
    /// What the camera was told to do.
    #[n(4)]
    pub camera: Begun,
    /// The same of its stream.
    #[n(5)]
    pub stream: Begun,
    /// The radio's warning was told.
    #[n(6)]
    pub radio_warning: bool,
    /// Since when the gimbal has not been looking where it was told to.
    #[n(7)]
    pub off_since: Option<NodeTime>,
    /// The gimbal does not reach: the vehicle's nose helps.
    #[n(8)]
    pub nose_helps: bool,
}

/// How something is to be observed, as far as the command says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Asked {
    pub stand_off_m: Option<f64>,
    pub height_m: Option<f64>,
    pub bearing_rad: Option<f64>,
}

/// Something is observed.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub(crate) struct Observation {
    /// The command it began with.
    #[n(0)]
    pub id: CommandId,
    #[n(1)]
    pub aimed: Aimed,
    #[n(2)]
    pub stand_off_m: f64,
    /// Height over the target; absent until that was first seen, if the command named none.
    #[n(3)]
    pub height_m: Option<f64>,
    /// From the target to the vehicle.
    #[n(4)]
    pub bearing_rad: Option<f64>,
    /// It has been where it should be.
    #[n(5)]
    pub on_station: bool,
    #[n(6)]
    pub since: NodeTime,
    /// The side that the command named.
    #[n(7)]
    pub asked_bearing_rad: Option<f64>,
    /// It stands still, for it is not known well enough where the target is.
    #[n(9)]
    #[cbor(default)]
    pub waits: bool,
    /// It goes no lower than this, along down in the swarm frame; absent until the target was first seen.
    #[n(8)]
    pub lowest_down_m: Option<f64>,
}

/// Whoever is to stand this far off a target does not fly by an error of more than this share of it, and then not before it is this small again.
const WAITS_FROM_SHARE: f64 = 0.25;
const FLIES_FROM_SHARE: f64 = 0.15;

/// A camera that looks more steeply than this, in radians, is made for what is below: no height brings what is a stand-off distance away into its view.
const STEEPEST_RAD: f64 = 1.0;

impl Observation {
    /// Whether to stand still, since the target may be anywhere around where it is thought to be: whoever flies by that may fly into it, or away from it.
    pub(crate) fn waits(&mut self, out: &mut Effects) -> bool {
        let (waited, error_m) = (self.waits, self.aimed.error_m());
        self.waits = error_m / self.stand_off_m > if waited { FLIES_FROM_SHARE } else { WAITS_FROM_SHARE };
        if self.waits && !waited {
            let text = format!("its target is known to {error_m:.0} m only: it stands until that is better");
            out.notice(Severity::Advisory, text);
        }
        self.waits
    }

    /// How far over the target to stand, for a vehicle that is at `place` now; and whether that is so as not to go lower. Something that goes down, or
    /// was never there, does not take the vehicle down with it. Where the command named no height, a camera that is fixed to the vehicle, and looks
    /// `camera_rad` above the horizon, is taken to the height from which it looks at the target; every other vehicle keeps the height that it has.
    pub(crate) fn height_over(
        &mut self,
        target: &PositionNed,
        place: &PositionNed,
        camera_rad: Option<f64>,
        lowest_m: f64,
    ) -> (f64, bool) {
        let lowest_down_m = *self.lowest_down_m.get_or_insert(match self.height_m {
            Some(_) => place.down_m.max(-lowest_m),
            None => place.down_m,
        });
        let level = camera_rad.filter(|camera_rad| camera_rad.abs() <= STEEPEST_RAD);
        let framed_m = level.map(|camera_rad| -camera_rad.tan() * self.stand_off_m);
        let kept_m = *self
            .height_m
            .get_or_insert(framed_m.unwrap_or(target.down_m - place.down_m));
        let least_m = target.down_m - lowest_down_m;
        (kept_m.max(least_m), least_m > kept_m)
    }
}

/// Something is looked at.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub(crate) struct Region {
    /// The command, until it has ended.
    #[n(0)]
    pub command: Option<CommandId>,
    #[n(1)]
    pub aimed: Aimed,
    #[n(2)]
    pub since: NodeTime,
}

/// Where the gimbal was told to point, and how that went.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub(crate) struct Pointed {
    #[n(0)]
    pub place: PositionNed,
    #[n(1)]
    pub time: NodeTime,
    #[n(2)]
    pub request: RequestId,
    /// It refused.
    #[n(3)]
    pub refused: bool,
}

/// Whether something was begun for the observation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Encode, Decode)]
#[cbor(index_only)]
pub(crate) enum Begun {
    /// Not yet.
    #[default]
    #[n(0)]
    No,
    /// It was running already: it is not ours to end.
    #[n(1)]
    Already,
    /// By us.
    #[n(2)]
    ByUs,
}

#[derive(Encode, Decode)]
struct Snapshot {
    #[n(0)]
    version: u32,
    #[n(1)]
    flight: ByteVec,
    #[n(2)]
    watch: Watch,
}

/// The bytes of everything.
pub(crate) fn encode(flight: Vec<u8>, watch: &Watch) -> Vec<u8> {
    let snapshot = Snapshot {
        version: SNAPSHOT_VERSION,
        flight: flight.into(),
        watch: watch.clone(),
    };
    // Writing into a vector does not fail; if it did, no snapshot would be better than half of one.
    minicbor::to_vec(snapshot).unwrap_or_default()
}

/// The flight's bytes and the rest, or why there is nothing.
pub(crate) fn decode(bytes: &[u8]) -> Result<(Vec<u8>, Watch), String> {
    let Snapshot { version, flight, watch } = minicbor::decode(bytes).map_err(|e| format!("not decodable: {e}"))?;
    if version != SNAPSHOT_VERSION {
        return Err(format!("version {version}, not {SNAPSHOT_VERSION}"));
    }
    Ok((flight.into(), watch))
}
