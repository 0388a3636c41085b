//! What a snapshot says, as messages.
//!
//! Must never do: read a clock, or say what the snapshot does not: what is not known is left out, or has the value that its definition has for
//! it.

use crate::frames;
use crate::interfaces::Fixed;
use crate::interfaces::diagnostic::{DiagnosticStatus, KeyValue, Level};
use crate::interfaces::geometry::{
    Pose, PoseStamped, PoseWithCovariance, TransformStamped, Twist, TwistWithCovariance, Vector3,
};
use crate::interfaces::nav::Odometry;
use crate::interfaces::sensor::{BatteryState, NavSatFix};
use crate::interfaces::skein::{Formation, GimbalState, VehicleState};
use crate::interfaces::vision::{BoundingBox3D, Detection3D, ObjectHypothesis, ObjectHypothesisWithPose};
use crate::names;
use crate::requests::word;
use crate::stamp::Stamps;
use skein_domain::payload::TrackEstimate;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{PositionNed, SwarmFrame};
use skein_ros2_messages::values;
use skein_view::{FleetSnapshot, PayloadSnapshot, VehicleSnapshot};

/// Data older than this is told as a fault, in seconds.
const STALE_S: f64 = 3.0;

/// Where a vehicle is and how it is turned, in `map`.
#[must_use]
pub fn pose(vehicle: &VehicleSnapshot, at: &VehicleKinematics) -> Pose {
    Pose {
        position: frames::point(&at.position),
        orientation: frames::orientation(f64::from(vehicle.roll_rad), f64::from(vehicle.pitch_rad), at.yaw_rad),
    }
}

/// The same with its time.
#[must_use]
pub fn pose_stamped(vehicle: &VehicleSnapshot, at: &VehicleKinematics, stamps: &Stamps) -> PoseStamped {
    PoseStamped {
        header: stamps.header(at.measured, frames::MAP),
        pose: pose(vehicle, at),
    }
}

/// The vehicle's launch place in the swarm's frame: the origin of its `odom`. That of the swarm's as long as it is not known.
#[must_use]
pub fn odom_origin(vehicle: &VehicleSnapshot, frame: Option<&SwarmFrame>) -> PositionNed {
    let home = vehicle.home.filter(skein_domain::Geodetic::is_valid);
    match (home, frame) {
        (Some(home), Some(frame)) => frame.position(&home),
        _ => PositionNed::default(),
    }
}

/// Pose about the launch place, velocity along the vehicle's own axes.
#[must_use]
pub fn odometry(
    vehicle: &VehicleSnapshot,
    name: &str,
    at: &VehicleKinematics,
    origin: &PositionNed,
    stamps: &Stamps,
) -> Odometry {
    let (roll_rad, pitch_rad) = (f64::from(vehicle.roll_rad), f64::from(vehicle.pitch_rad));
    let here = PositionNed::from(at.position.vector() - origin.vector());
    Odometry {
        header: stamps.header(at.measured, &names::odom(name)),
        child_frame_id: names::base_link(name),
        pose: PoseWithCovariance {
            pose: Pose {
                position: frames::point(&here),
                orientation: frames::orientation(roll_rad, pitch_rad, at.yaw_rad),
            },
            covariance: Fixed::default(),
        },
        twist: TwistWithCovariance {
            twist: Twist {
                linear: frames::velocity_in_body(&at.velocity, roll_rad, pitch_rad, at.yaw_rad),
                angular: Vector3::default(),
            },
            covariance: Fixed::default(),
        },
    }
}

/// `map` to the vehicle's `odom`, and from there to its `base_link`.
#[must_use]
pub fn transforms(odometry: &Odometry, origin: &PositionNed) -> [TransformStamped; 2] {
    let frames = [odometry.header.frame_id.as_str(), odometry.child_frame_id.as_str()];
    values::transforms(&odometry.header, frames, origin, &odometry.pose.pose)
}

/// Place on Earth. Altitude is above the sea, not above the ellipsoid: no model of the difference is at hand.
#[must_use]
pub fn fix(vehicle: &VehicleSnapshot, name: &str, stamps: &Stamps) -> Option<NavSatFix> {
    let place = vehicle.global?;
    let at = vehicle.kinematics.map_or(stamps.node, |k| k.measured);
    let header = stamps.header(at, &names::base_link(name));
    Some(values::fix(header, &place, &vehicle.gnss))
}

/// The battery; what is not known is not a number, as the definition has it.
#[must_use]
pub fn battery(vehicle: &VehicleSnapshot, name: &str, stamps: &Stamps) -> BatteryState {
    values::battery(stamps.header(stamps.node, &names::base_link(name)), &vehicle.battery)
}

/// How a vehicle is.
#[must_use]
pub fn state(vehicle: &VehicleSnapshot, fleet: &FleetSnapshot, name: &str, stamps: &Stamps) -> VehicleState {
    let formation = fleet.formation.as_ref();
    VehicleState {
        header: stamps.header(stamps.node, &names::base_link(name)),
        id: vehicle.id.0,
        name: vehicle.name.clone(),
        model: vehicle.plugin.clone(),
        flight_state: vehicle.flight_state.word(),
        detail: vehicle.state_detail.clone(),
        mode: vehicle.mode.word(),
        landed: vehicle.landed.word(),
        armed: vehicle.armed,
        ready_to_arm: vehicle.ready_to_arm == Some(true),
        connected: vehicle.link.connected,
        leader: vehicle.is_leader,
        in_formation: formation.is_some_and(|formation| formation.members.contains(&vehicle.id)),
        tracking_error_m: vehicle.tracking_error_m.unwrap_or(f64::NAN),
        degraded: vehicle.degraded.clone(),
    }
}

/// The formation that is flown.
#[must_use]
pub fn formation(fleet: &FleetSnapshot, stamps: &Stamps) -> Formation {
    let header = stamps.header(fleet.time, frames::MAP);
    let Some(flown) = &fleet.formation else {
        return Formation {
            header,
            ..Formation::default()
        };
    };
    Formation {
        header,
        active: true,
        shape: word(&flown.request.shape),
        spacing_m: flown.request.spacing_m,
        has_leader: flown.leader.is_some(),
        leader: flown.leader.map_or(0, |leader| leader.0),
        members: flown.members.iter().map(|member| member.0).collect(),
        anchor: flown.anchor.as_ref().map(frames::point).unwrap_or_default(),
        anchor_known: flown.anchor.is_some(),
        planned_min_distance_m: flown.planned_min_distance_m.unwrap_or(f64::INFINITY),
        route_finished: flown.route_finished,
    }
}

/// How a gimbal is, if what the payload reports is the state of one.
#[must_use]
pub fn gimbal(payload: &PayloadSnapshot, stamps: &Stamps) -> Option<GimbalState> {
    let state: skein_domain::payload::GimbalState = serde_json::from_value(payload.state.clone()?).ok()?;
    let orientation = state
        .yaw_north_rad
        .map(|yaw| frames::orientation(state.roll_rad, state.pitch_rad, yaw));
    Some(GimbalState {
        header: stamps.header(stamps.node, frames::MAP),
        name: payload.name.clone(),
        connected: state.connected,
        mode: word(&state.mode),
        orientation_known: orientation.is_some(),
        orientation: orientation.unwrap_or_else(frames::unrotated),
        fault: state.fault,
    })
}

/// Something that is tracked: where it is, how well that is known, and what it may be, the likeliest first. Its size is not known.
#[must_use]
pub fn track(estimate: &TrackEstimate, stamps: &Stamps) -> Detection3D {
    let pose = PoseWithCovariance {
        pose: Pose {
            position: frames::point(&estimate.track.position),
            orientation: frames::unrotated(),
        },
        covariance: estimate
            .position_covariance()
            .map(|covariance| frames::covariance(&covariance))
            .unwrap_or_default(),
    };
    let hypothesis = |(class_id, score): (String, f64)| ObjectHypothesisWithPose {
        hypothesis: ObjectHypothesis { class_id, score },
        pose: pose.clone(),
    };
    Detection3D {
        header: stamps.header(estimate.track.time, frames::MAP),
        results: classes(estimate).into_iter().map(hypothesis).collect(),
        bbox: BoundingBox3D {
            center: pose.pose.clone(),
            size: Vector3::default(),
        },
        id: estimate.track.track.to_string(),
    }
}

/// What a track may be with which score, the likeliest first; `unknown` if nobody says.
fn classes(estimate: &TrackEstimate) -> Vec<(String, f64)> {
    let mut all: Vec<(String, f64)> = estimate
        .classes
        .iter()
        .map(|(class, score)| (class.clone(), *score))
        .collect();
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    if all.is_empty() {
        all.push(("unknown".to_owned(), 1.0));
    }
    all
}

/// How well a vehicle is, with these facts added.
#[must_use]
pub fn health(vehicle: &VehicleSnapshot, name: &str, more: Vec<(&str, String)>) -> DiagnosticStatus {
    let (level, message) = if !vehicle.link.connected || vehicle.age_s > STALE_S {
        (Level::Stale, format!("not heard for {:.1} s", vehicle.age_s))
    } else if vehicle.stopped {
        (Level::Error, "stopped in an emergency".to_owned())
    } else if let Some(order) = vehicle.failsafe.as_ref().and_then(|failsafe| failsafe.order.as_ref()) {
        (Level::Error, format!("under orders: {}", json(order)))
    } else if vehicle.failsafe.is_some() || !vehicle.degraded.is_empty() {
        (Level::Warn, vehicle.degraded.join("; "))
    } else {
        (Level::Ok, vehicle.flight_state.word())
    };
    let number = |value: f64| format!("{value:.3}");
    let mut values = vec![
        ("flight_state", vehicle.flight_state.word()),
        ("mode", vehicle.mode.word()),
        ("age_s", number(vehicle.age_s)),
        ("link_loss_share", number(f64::from(vehicle.link.loss))),
        ("setpoint_rate_hz", number(f64::from(vehicle.link.setpoint_rate_hz))),
    ];
    if let Some(round_trip_s) = vehicle.link.round_trip_s {
        values.push(("round_trip_s", number(f64::from(round_trip_s))));
    }
    if let Some(failsafe) = &vehicle.failsafe {
        values.push(("alarms", json(&failsafe.alarms)));
    }
    values.extend(more);
    DiagnosticStatus {
        level: level as u8,
        name: format!("skein: {name}"),
        message,
        hardware_id: format!("vehicle {}", vehicle.id),
        values: values
            .into_iter()
            .map(|(key, value)| KeyValue {
                key: key.to_owned(),
                value,
            })
            .collect(),
    }
}

fn json<T: serde::Serialize>(value: &T) -> String {
    serde_json::to_string(value).unwrap_or_default()
}

#[cfg(test)]
mod tests;
