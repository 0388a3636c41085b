//! What is asked over ROS 2 as what the node is asked: frames and units converted, and everything refused that cannot be meant.
//!
//! Must never do: ask the node itself, or put a value in the place of one that is wrong.

use crate::frames;
use crate::interfaces::geometry::Twist;
use crate::interfaces::skein::{
    FollowRequest, FormationOutcome, GoToRequest, PointGimbalRequest, SetFormationRequest, TakeOffRequest,
};
use skein_domain::formation::HeadingRequest;
use skein_domain::payload::{GimbalCommand, GimbalYawFrame};
use skein_domain::stick::FASTEST_STICK_RAD_S;
use skein_domain::{FormationRequest, Refusal, Shape, Stick, VehicleCommand, VehicleId};
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// Nothing is further away, in metres.
const FARTHEST_M: f64 = 100_000.0;
/// No take-off goes higher, in metres; the gate may say less.
const HIGHEST_M: f64 = 1_000.0;
/// Nothing is faster, in metres per second; the gate says less.
const FASTEST_M_S: f64 = 100.0;
/// No formation is larger.
const MOST_MEMBERS: usize = 512;
/// A rate of turning below this is none, in radians per second.
const NO_RATE_RAD_S: f64 = 1e-3;

/// Why it cannot be meant.
fn invalid(what: &str, value: f64, low: f64, high: f64) -> Refusal {
    Refusal::invalid(format!("{what}: {value} is not within {low} to {high}"))
}

fn within(what: &str, value: f64, low: f64, high: f64) -> Result<(), Refusal> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(invalid(what, value, low, high))
}

/// A take-off to a height.
///
/// # Errors
/// For a height that is none.
pub fn take_off(request: &TakeOffRequest) -> Result<VehicleCommand, Refusal> {
    within("height_m", request.height_m, 0.1, HIGHEST_M)?;
    Ok(VehicleCommand::TakeOff {
        height_m: request.height_m,
    })
}

/// A flight to a place of `map`.
///
/// # Errors
/// For a number that cannot be meant.
pub fn go_to(request: &GoToRequest) -> Result<VehicleCommand, Refusal> {
    let point = &request.position;
    for (axis, value) in [("x", point.x), ("y", point.y), ("z", point.z)] {
        within(&format!("position.{axis}"), value, -FARTHEST_M, FARTHEST_M)?;
    }
    if request.set_yaw {
        within("yaw_rad", request.yaw_rad, -TAU, TAU)?;
    }
    within("speed_m_s", request.speed_m_s, 0.0, FASTEST_M_S)?;
    Ok(VehicleCommand::GoTo {
        position: frames::position(point),
        yaw_rad: request.set_yaw.then(|| frames::yaw_rad(request.yaw_rad)),
        speed_m_s: (request.speed_m_s > 0.0).then_some(request.speed_m_s),
    })
}

/// Where a gimbal is to look.
///
/// # Errors
/// For a direction without a length, or a frame that is not known here.
pub fn point_gimbal(request: &PointGimbalRequest, base_link: &str) -> Result<GimbalCommand, Refusal> {
    let in_map = request.frame_id == frames::MAP;
    if !in_map && request.frame_id != base_link && request.frame_id != "base_link" {
        return Err(Refusal::invalid(format!(
            "frame_id: neither {} nor {base_link}",
            frames::MAP
        )));
    }
    let (pitch_rad, yaw_rad) =
        frames::look(&request.direction, in_map).ok_or_else(|| Refusal::invalid("direction: it has no length"))?;
    Ok(GimbalCommand::Angles {
        pitch_rad,
        yaw_rad,
        yaw_frame: if in_map {
            GimbalYawFrame::North
        } else {
            GimbalYawFrame::Vehicle
        },
    })
}

/// A formation.
///
/// # Errors
/// For a shape that is not known, or a number that cannot be meant.
pub fn formation(request: &SetFormationRequest) -> Result<FormationRequest, Refusal> {
    let shape = Shape::ALL.iter().find(|shape| word(shape) == request.shape);
    let shape = shape.filter(|shape| **shape != Shape::Free).ok_or_else(|| {
        let known: Vec<_> = Shape::ALL
            .iter()
            .filter(|shape| **shape != Shape::Free)
            .map(word)
            .collect();
        Refusal::invalid(format!("shape: none of {}", known.join(", ")))
    })?;
    within("spacing_m", request.spacing_m, 0.1, FARTHEST_M)?;
    within("altitude_step_m", request.altitude_step_m, -HIGHEST_M, HIGHEST_M)?;
    within("rotation_rad", request.rotation_rad, -TAU, TAU)?;
    within("scale", request.scale, 0.0, 100.0)?;
    let heading = match request.heading.as_str() {
        "" | "auto" => HeadingRequest::Auto,
        "course" => HeadingRequest::Course,
        "fixed" => {
            within("heading_rad", request.heading_rad, -TAU, TAU)?;
            HeadingRequest::Fixed {
                heading_deg: frames::yaw_rad(request.heading_rad).to_degrees(),
            }
        }
        _ => {
            return Err(Refusal::invalid("heading: none of auto, course, fixed"));
        }
    };
    let members = vehicles("members", &request.members)?;
    Ok(FormationRequest {
        heading,
        altitude_step_m: request.altitude_step_m,
        // Clockwise there.
        rotation_deg: -request.rotation_rad.to_degrees(),
        scale: if request.scale > 0.0 { request.scale } else { 1.0 },
        leader: request.set_leader.then_some(VehicleId(request.leader)),
        members: (!members.is_empty()).then_some(members),
        ..FormationRequest::new(*shape, request.spacing_m)
    })
}

/// Some vehicles behind another.
///
/// # Errors
/// When nobody follows, somebody would follow itself, or the distance cannot be meant.
pub fn follow(request: &FollowRequest) -> Result<FormationRequest, Refusal> {
    within("spacing_m", request.spacing_m, 0.1, FARTHEST_M)?;
    let mut members = vec![request.leader];
    members.extend(&request.followers);
    if members.len() < 2 {
        return Err(Refusal::invalid("followers: nobody"));
    }
    Ok(FormationRequest {
        leader: Some(VehicleId(request.leader)),
        members: Some(vehicles("leader and followers", &members)?),
        ..FormationRequest::new(Shape::Column, request.spacing_m)
    })
}

fn vehicles(what: &str, ids: &[u16]) -> Result<Vec<VehicleId>, Refusal> {
    let once: BTreeSet<_> = ids.iter().collect();
    if ids.len() > MOST_MEMBERS || once.len() != ids.len() {
        return Err(Refusal::invalid(format!(
            "{what}: more than {MOST_MEMBERS}, or one is there twice"
        )));
    }
    Ok(ids.iter().copied().map(VehicleId).collect())
}

/// A velocity, in metres per second forward, left and up, and a rate of turning about up in radians per second, as a stick.
///
/// # Errors
/// For numbers that cannot be meant, and for rates about other axes: the vehicle is level.
pub fn velocity(twist: &Twist, fastest_m_s: f64) -> Result<Stick, Refusal> {
    let linear = &twist.linear;
    for (axis, value) in [("x", linear.x), ("y", linear.y), ("z", linear.z)] {
        within(&format!("linear.{axis}"), value, -FASTEST_M_S, FASTEST_M_S)?;
    }
    let speed_m_s = linear.x.hypot(linear.y).hypot(linear.z);
    if speed_m_s > fastest_m_s {
        return Err(Refusal::TooFast {
            speed_m_s,
            limit_m_s: fastest_m_s,
        });
    }
    let angular = &twist.angular;
    within("angular.z", angular.z, -FASTEST_STICK_RAD_S, FASTEST_STICK_RAD_S)?;
    // Also for what is no number.
    if ![angular.x, angular.y].iter().all(|rate| rate.abs() <= NO_RATE_RAD_S) {
        return Err(Refusal::not_supported(
            "rates of rolling and pitching over cmd_vel: the vehicle is level",
        ));
    }
    Ok(frames::stick(linear, angular.z))
}

/// A unit of an enumeration as serde writes it.
pub fn word<T: serde::Serialize>(value: &T) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(word)) => word,
        _ => String::new(),
    }
}

/// A refused formation.
#[must_use]
pub fn refused_formation(refusal: &Refusal) -> FormationOutcome {
    FormationOutcome {
        success: false,
        code: refusal.code().to_owned(),
        message: refusal.to_string(),
        ..FormationOutcome::default()
    }
}

#[cfg(test)]
mod tests;
