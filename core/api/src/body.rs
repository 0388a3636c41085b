//! Bodies of requests: JSON of exactly the published shape, with numbers that make sense before anyone asks whether they are
//! allowed. What is allowed is the safety gate's to say, not ours.

use crate::error::ApiError;
use crate::examples::Example;
use crate::protocol::{
    AcknowledgeBody, CommandBody, ControlBody, CoordinatorBody, EmergencyStopBody, FenceFileBody, FencePlanBody,
    OverrideBody, ParameterBody, ReadingBody, ResumeBody, RouteBody,
};
use axum::Json;
use axum::body::Bytes;
use axum::extract::rejection::JsonRejection;
use axum::extract::{FromRequest, Request};
use axum::http::{HeaderMap, header};
use schemars::JsonSchema;
use serde::de::{DeserializeOwned, IgnoredAny};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use skein_config::PayloadRule;
use skein_domain::payload::{Target, Track};
use skein_domain::preflight::LONGEST_OVERRIDE_S;
use skein_domain::{
    FormationAnchor, FormationRequest, HeadingRequest, OffsetFrd, PositionNed, Route, VehicleCommand, VehicleId,
};
use skein_runtime::{Fault, ReferenceReport, Targets};
use std::time::Duration;
use tokio::time::timeout;

/// Largest body that is read, in bytes.
pub const MAX_BODY_BYTES: usize = 1024 * 1024;
/// A body has to be there within this time.
const BODY_WITHIN: Duration = Duration::from_secs(10);

/// More vehicles than this are not named in one request. A MAVLink network has at most 255.
const MAX_VEHICLES: usize = 1024;
/// Longest route.
const MAX_WAYPOINTS: usize = 10_000;
/// Farthest from the swarm's origin that a position means anything: beyond it the tangent plane is no use.
const MAX_DISTANCE_M: f64 = 100_000.0;
/// No take-off goes higher, whatever the fence.
const MAX_HEIGHT_M: f64 = 10_000.0;
/// No multicopter flies faster.
const MAX_SPEED_M_S: f64 = 200.0;
/// Angles may be given over several turns, but not as a number without meaning.
const MAX_ANGLE_RAD: f64 = 1000.0;
/// The same in degrees.
const MAX_ANGLE_DEG: f64 = 57_296.0;
/// More items are not overridden at once.
const MAX_ITEMS: usize = 64;
/// No formation is made larger than so many times itself.
const MAX_SCALE: f64 = 1000.0;

/// A body that was read, is of the published shape, and makes sense.
#[derive(Debug, Clone, Copy)]
pub struct Body<T>(pub T);

impl<T, S> FromRequest<S> for Body<T>
where
    T: DeserializeOwned + Serialize + MakesSense + Example,
    S: Send + Sync,
{
    type Rejection = ApiError;

    async fn from_request(request: Request, state: &S) -> Result<Self, ApiError> {
        if !says_json(request.headers()) {
            return Err(ApiError::NotJson);
        }
        let received = timeout(BODY_WITHIN, Bytes::from_request(request, state)).await;
        let bytes = received.map_err(|_| ApiError::TooSlow)?.map_err(JsonRejection::from)?;
        let understood = understand(&bytes).map_err(|problem| ApiError::Unfit {
            problem: Box::new(problem),
            example: T::example(),
        });
        understood.map(Self)
    }
}

/// What the bytes say, if it is of the published shape and makes sense.
pub(crate) fn understand<T: DeserializeOwned + Serialize + MakesSense>(bytes: &[u8]) -> Result<T, ApiError> {
    let Json(value) = Json::<T>::from_bytes(bytes).map_err(|rejection| not_understood(rejection, bytes))?;
    reject_what_was_overlooked(bytes, &value)?;
    value.check(&Place::root())?;
    Ok(value)
}

/// Whether the body says that it is JSON. A foreign page cannot say so without asking first, and is refused then.
fn says_json(headers: &HeaderMap) -> bool {
    let said = headers
        .get(header::CONTENT_TYPE)
        .and_then(|value| value.to_str().ok())
        .unwrap_or_default();
    said.split(';')
        .next()
        .is_some_and(|kind| kind.trim().eq_ignore_ascii_case("application/json"))
}

/// Some mistakes of type are reported as if the text were no JSON (a number where a word is due).
fn not_understood(rejection: JsonRejection, bytes: &[u8]) -> ApiError {
    let is_json = || serde_json::from_slice::<IgnoredAny>(bytes).is_ok();
    match rejection {
        JsonRejection::JsonSyntaxError(error) if is_json() => ApiError::Shape {
            problem: error.body_text(),
        },
        rejection => rejection.into(),
    }
}

/// Serde overlooks unknown fields beside a tag that needs no others (`{"command":"arm","when":1}`), and takes a list for an
/// object. What was understood is written out again: what is then missing was overlooked.
fn reject_what_was_overlooked<T: Serialize>(bytes: &[u8], understood: &T) -> Result<(), ApiError> {
    let (Ok(given), Ok(understood)) = (serde_json::from_slice::<Value>(bytes), serde_json::to_value(understood)) else {
        return Ok(());
    };
    overlooked(&given, &understood, &Place::root()).map_or(Ok(()), Err)
}

fn overlooked(given: &Value, understood: &Value, place: &Place<'_>) -> Option<ApiError> {
    match (given, understood) {
        (Value::Object(given), Value::Object(understood)) => given.iter().find_map(|(key, value)| {
            let place = place.field(key);
            match understood.get(key) {
                Some(understood) => overlooked(value, understood, &place),
                None => Some(ApiError::UnknownField {
                    field: place.to_string(),
                    taken: understood.keys().cloned().collect(),
                }),
            }
        }),
        (Value::Array(given), Value::Array(understood)) => given
            .iter()
            .zip(understood)
            .enumerate()
            .find_map(|(index, (given, understood))| overlooked(given, understood, &place.item(index))),
        (Value::Array(_), Value::Object(_)) => Some(ApiError::Shape {
            problem: format!("{place}: a list stands where an object belongs"),
        }),
        _ => None,
    }
}

/// Where in a body something stands, for the message.
pub enum Place<'a> {
    /// The body itself.
    Root,
    /// A field of an object.
    Field(&'a Place<'a>, &'a str),
    /// An item of a list.
    Item(&'a Place<'a>, usize),
}

impl<'a> Place<'a> {
    fn root() -> Self {
        Self::Root
    }

    pub(crate) fn field(&'a self, name: &'a str) -> Self {
        Self::Field(self, name)
    }

    pub(crate) fn item(&'a self, index: usize) -> Self {
        Self::Item(self, index)
    }

    fn wrong(&self, problem: impl Into<String>) -> ApiError {
        ApiError::OutOfRange {
            field: self.to_string(),
            problem: problem.into(),
        }
    }

    /// A finite number within limits.
    pub(crate) fn number(&self, value: f64, at_least: f64, at_most: f64) -> Result<(), ApiError> {
        if value >= at_least && value <= at_most {
            return Ok(());
        }
        Err(self.wrong(format!("{value} is not within {at_least} to {at_most}")))
    }

    /// A finite number above zero.
    pub(crate) fn positive(&self, value: f64, at_most: f64) -> Result<(), ApiError> {
        if value > 0.0 && value <= at_most {
            return Ok(());
        }
        Err(self.wrong(format!("{value} is not above 0 and at most {at_most}")))
    }

    /// A list that is neither empty nor too long.
    pub(crate) fn length(&self, length: usize, at_most: usize) -> Result<(), ApiError> {
        if (1..=at_most).contains(&length) {
            return Ok(());
        }
        Err(self.wrong(format!("{length} entries; 1 to {at_most} are taken")))
    }

    pub(crate) fn position(&self, position: &PositionNed) -> Result<(), ApiError> {
        self.field("north_m")
            .number(position.north_m, -MAX_DISTANCE_M, MAX_DISTANCE_M)?;
        self.field("east_m")
            .number(position.east_m, -MAX_DISTANCE_M, MAX_DISTANCE_M)?;
        self.field("down_m")
            .number(position.down_m, -MAX_DISTANCE_M, MAX_DISTANCE_M)
    }

    fn offset(&self, offset: &OffsetFrd) -> Result<(), ApiError> {
        for (axis, value) in [
            ("forward_m", offset.forward_m),
            ("right_m", offset.right_m),
            ("down_m", offset.down_m),
        ] {
            self.field(axis).number(value, -MAX_DISTANCE_M, MAX_DISTANCE_M)?;
        }
        Ok(())
    }

    pub(crate) fn vehicles(&self, vehicles: &[VehicleId]) -> Result<(), ApiError> {
        self.length(vehicles.len(), MAX_VEHICLES)?;
        let mut seen = std::collections::BTreeSet::new();
        for (index, vehicle) in vehicles.iter().enumerate() {
            if !seen.insert(*vehicle) {
                return Err(self.item(index).wrong(format!("vehicle {vehicle} is named twice")));
            }
        }
        Ok(())
    }
}

impl std::fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Root => f.write_str("body"),
            Self::Field(Self::Root, name) => f.write_str(name),
            Self::Field(outer, name) => write!(f, "{outer}.{name}"),
            Self::Item(outer, index) => write!(f, "{outer}[{index}]"),
        }
    }
}

/// A body whose numbers can be looked at before anyone acts on them.
pub trait MakesSense {
    /// Ok if every number is finite and in a range in which it means something.
    ///
    /// # Errors
    /// The first field that makes no sense.
    fn check(&self, place: &Place<'_>) -> Result<(), ApiError>;
}

impl MakesSense for CommandBody {
    fn check(&self, place: &Place<'_>) -> Result<(), ApiError> {
        self.targets.check(&place.field("targets"))?;
        self.command.check(&place.field("command"))
    }
}

impl MakesSense for ControlBody {
    fn check(&self, place: &Place<'_>) -> Result<(), ApiError> {
        self.targets.check(&place.field("targets"))
    }
}

impl MakesSense for ParameterBody {
    /// Its range only the autopilot knows.
    fn check(&self, place: &Place<'_>) -> Result<(), ApiError> {
        place.field("value").number(self.value, f64::MIN, f64::MAX)
    }
}

impl MakesSense for ResumeBody {
    fn check(&self, _: &Place<'_>) -> Result<(), ApiError> {
        Ok(())
    }
}

impl MakesSense for ReadingBody {
    fn check(&self, _: &Place<'_>) -> Result<(), ApiError> {
        Ok(())
    }
}

impl MakesSense for Targets {
    fn check(&self, place: &Place<'_>) -> Result<(), ApiError> {
        match self {
            Self::All => Ok(()),
            Self::Vehicles(vehicles) => place.field("vehicles").vehicles(vehicles),
        }
    }
}

impl MakesSense for VehicleCommand {
    fn check(&self, place: &Place<'_>) -> Result<(), ApiError> {
        match self {
            Self::Arm | Self::Disarm | Self::Land | Self::Hold | Self::Return | Self::StopObserving | Self::Steer => {
                Ok(())
            }
            Self::TakeOff { height_m } => place.field("height_m").positive(*height_m, MAX_HEIGHT_M),
            Self::LandAt { spot } => place.field("spot").position(spot),
            Self::GoTo {
                position,
                yaw_rad,
                speed_m_s,
            } => {
                place.field("position").position(position)?;
                if let Some(yaw_rad) = yaw_rad {
                    place.field("yaw_rad").number(*yaw_rad, -MAX_ANGLE_RAD, MAX_ANGLE_RAD)?;
                }
                speed_m_s.map_or(Ok(()), |speed| place.field("speed_m_s").positive(speed, MAX_SPEED_M_S))
            }
            Self::Observe {
                target,
                stand_off_m,
                height_m,
            } => {
                if let Some(stand_off_m) = stand_off_m {
                    place.field("stand_off_m").number(*stand_off_m, 0.0, MAX_DISTANCE_M)?;
                }
                if let Some(height_m) = height_m {
                    place.field("height_m").number(*height_m, -MAX_HEIGHT_M, MAX_HEIGHT_M)?;
                }
                target.check(&place.field("target"))
            }
            Self::LookAt { target } => target.check(&place.field("target")),
        }
    }
}

impl MakesSense for Target {
    fn check(&self, place: &Place<'_>) -> Result<(), ApiError> {
        match self {
            Self::Place { position } => place.field("position").position(position),
            Self::Vehicle { .. } | Self::Track { .. } => Ok(()),
        }
    }
}

impl MakesSense for FormationRequest {
    fn check(&self, place: &Place<'_>) -> Result<(), ApiError> {
        place.field("spacing_m").positive(self.spacing_m, MAX_DISTANCE_M)?;
        place
            .field("altitude_step_m")
            .number(self.altitude_step_m, -MAX_HEIGHT_M, MAX_HEIGHT_M)?;
        if let HeadingRequest::Fixed { heading_deg } = self.heading {
            place
                .field("heading")
                .field("heading_deg")
                .number(heading_deg, -MAX_ANGLE_DEG, MAX_ANGLE_DEG)?;
        }
        place
            .field("rotation_deg")
            .number(self.rotation_deg, -MAX_ANGLE_DEG, MAX_ANGLE_DEG)?;
        place.field("scale").positive(self.scale, MAX_SCALE)?;
        if let Some(arc_deg) = self.arc_deg {
            place.field("arc_deg").positive(arc_deg, 360.0)?;
        }
        if let Some(layers) = self.layers {
            place.field("layers").positive(f64::from(layers), f64::from(u16::MAX))?;
        }
        if let Some(pitch_m) = self.pitch_m {
            place.field("pitch_m").positive(pitch_m, MAX_HEIGHT_M)?;
        }
        if let Some(offsets) = &self.offsets {
            let place = place.field("offsets");
            place.length(offsets.len(), MAX_VEHICLES)?;
            for (index, offset) in offsets.iter().enumerate() {
                place.item(index).offset(offset)?;
            }
        }
        self.anchor.check(&place.field("anchor"))?;
        self.members
            .as_ref()
            .map_or(Ok(()), |members| place.field("members").vehicles(members))
    }
}

impl MakesSense for FormationAnchor {
    fn check(&self, place: &Place<'_>) -> Result<(), ApiError> {
        match self {
            Self::Leader | Self::Reference { .. } => Ok(()),
            Self::Path { route } => route.check(&place.field("route")),
            Self::Place { position, heading_deg } => {
                if let Some(heading_deg) = heading_deg {
                    place
                        .field("heading_deg")
                        .number(*heading_deg, -MAX_ANGLE_DEG, MAX_ANGLE_DEG)?;
                }
                place.field("position").position(position)
            }
        }
    }
}

impl MakesSense for ReferenceReport {
    fn check(&self, place: &Place<'_>) -> Result<(), ApiError> {
        place.field("position").position(&self.position)?;
        if let Some(heading_rad) = self.heading_rad {
            place
                .field("heading_rad")
                .number(heading_rad, -MAX_ANGLE_RAD, MAX_ANGLE_RAD)?;
        }
        let Some(velocity) = self.velocity else { return Ok(()) };
        let place = place.field("velocity");
        for (axis, value) in [
            ("north_m_s", velocity.north_m_s),
            ("east_m_s", velocity.east_m_s),
            ("down_m_s", velocity.down_m_s),
        ] {
            place.field(axis).number(value, -MAX_SPEED_M_S, MAX_SPEED_M_S)?;
        }
        Ok(())
    }
}

impl MakesSense for EmergencyStopBody {
    fn check(&self, place: &Place<'_>) -> Result<(), ApiError> {
        self.targets.check(&place.field("targets"))
    }
}

impl MakesSense for OverrideBody {
    fn check(&self, place: &Place<'_>) -> Result<(), ApiError> {
        place.field("items").length(self.items.len(), MAX_ITEMS)?;
        place.field("valid_s").positive(self.valid_s, LONGEST_OVERRIDE_S)
    }
}

impl MakesSense for FencePlanBody {
    // Whether the zones are any is said with the reason by whoever places them.
    fn check(&self, _: &Place<'_>) -> Result<(), ApiError> {
        Ok(())
    }
}

impl MakesSense for FenceFileBody {
    fn check(&self, _: &Place<'_>) -> Result<(), ApiError> {
        Ok(())
    }
}

impl MakesSense for AcknowledgeBody {
    /// A number that is no alert's, or is not kept any more, marks nothing.
    fn check(&self, _: &Place<'_>) -> Result<(), ApiError> {
        Ok(())
    }
}

impl MakesSense for CoordinatorBody {
    fn check(&self, place: &Place<'_>) -> Result<(), ApiError> {
        if self.node.0 == 0 {
            return Err(ApiError::OutOfRange {
                field: place.field("node").to_string(),
                problem: "nodes have numbers from 1".to_owned(),
            });
        }
        Ok(())
    }
}

impl MakesSense for RouteBody {
    fn check(&self, place: &Place<'_>) -> Result<(), ApiError> {
        self.route.check(&place.field("route"))
    }
}

impl MakesSense for Route {
    fn check(&self, place: &Place<'_>) -> Result<(), ApiError> {
        let waypoints = place.field("waypoints");
        waypoints.length(self.waypoints.len(), MAX_WAYPOINTS)?;
        for (index, waypoint) in self.waypoints.iter().enumerate() {
            waypoints.item(index).position(waypoint)?;
        }
        place.field("speed_m_s").positive(self.speed_m_s, MAX_SPEED_M_S)?;
        place
            .field("corner_radius_m")
            .number(self.corner_radius_m, 0.0, MAX_DISTANCE_M)
    }
}

/// A command to a payload, as its plugin's command schema has it.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct PayloadCommandBody(pub Value);

impl MakesSense for PayloadCommandBody {
    fn check(&self, _: &Place<'_>) -> Result<(), ApiError> {
        if self.0.is_object() {
            return Ok(());
        }
        Err(ApiError::Shape {
            problem: "a command is an object".to_owned(),
        })
    }
}

/// Everything that is tracked.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TracksBody {
    /// The tracks.
    pub tracks: Vec<Track>,
}

impl MakesSense for TracksBody {
    fn check(&self, place: &Place<'_>) -> Result<(), ApiError> {
        let tracks = place.field("tracks");
        for (index, track) in self.tracks.iter().enumerate() {
            tracks.item(index).field("position").position(&track.position)?;
        }
        Ok(())
    }
}

impl MakesSense for PayloadRule {
    fn check(&self, place: &Place<'_>) -> Result<(), ApiError> {
        PayloadRule::check(self).map_err(|problem| ApiError::OutOfRange {
            field: place.to_string(),
            problem,
        })
    }
}

impl MakesSense for Fault {
    fn check(&self, _: &Place<'_>) -> Result<(), ApiError> {
        Ok(())
    }
}

#[cfg(test)]
mod tests;
