//! The fleet in Foxglove's own messages, for its map, 3D view and log. Lengths in metres, axes east, north, up; what looks ahead looks along x.
//!
//! Must never do: be read back by this program.

use foxglove::messages::{
    ArrowPrimitive, Color, CompressedVideo, Duration, FrameTransform, FrameTransforms, LocationFix, Log, Pose,
    Quaternion, SceneEntity, SceneUpdate, TextPrimitive, Timestamp, Vector3, log::Level,
};
use skein_domain::exchange::Severity;
use skein_domain::payload::TrackEstimate;
use skein_domain::{PositionNed, VehicleId};
use skein_view::{EventRecord, FleetSnapshot, VehicleSnapshot};

/// The frame of everything: the swarm's origin, x to the east, y to the north, z up.
const SWARM: &str = "swarm";
/// How long something stays in the scene that is not shown again, in seconds.
const STAYS_S: i32 = 3;

const VEHICLE: Color = Color {
    r: 0.2,
    g: 0.6,
    b: 1.0,
    a: 1.0,
};
const LEADER: Color = Color {
    r: 1.0,
    g: 0.7,
    b: 0.1,
    a: 1.0,
};
const TRACK: Color = Color {
    r: 1.0,
    g: 0.3,
    b: 0.3,
    a: 1.0,
};
const WORDS: Color = Color {
    r: 1.0,
    g: 1.0,
    b: 1.0,
    a: 1.0,
};

/// A moment in nanoseconds since 1970, as Foxglove has it.
#[must_use]
pub fn timestamp(unix_ns: u64) -> Timestamp {
    let seconds = u32::try_from(unix_ns / 1_000_000_000).unwrap_or(u32::MAX);
    Timestamp::new(seconds, u32::try_from(unix_ns % 1_000_000_000).unwrap_or_default())
}

fn vehicle_frame(vehicle: VehicleId) -> String {
    format!("vehicle/{vehicle}")
}

/// To a part of two's power: what is cut off of a number in binary is packed to nothing.
fn cut(value: f64, steps: f64) -> f64 {
    (value * steps).round() / steps
}

/// To a millimetre.
fn enu(position: &PositionNed) -> Vector3 {
    Vector3 {
        x: cut(position.east_m, 1_024.0),
        y: cut(position.north_m, 1_024.0),
        z: cut(-position.down_m, 1_024.0),
    }
}

/// From roll, pitch and yaw of a body with axes forward, right, down in north, east, down, to one with axes forward, left, up in east, north, up.
fn attitude(roll_rad: f64, pitch_rad: f64, yaw_rad: f64) -> Quaternion {
    let half = |angle_rad: f64| (angle_rad / 2.0).sin_cos();
    let (sr, cr) = half(roll_rad);
    let (sp, cp) = half(-pitch_rad);
    let (sy, cy) = half(std::f64::consts::FRAC_PI_2 - yaw_rad);
    // To a twentieth of a degree.
    let cut = |value: f64| cut(value, 4_096.0);
    Quaternion {
        w: cut(cr * cp * cy + sr * sp * sy),
        x: cut(sr * cp * cy - cr * sp * sy),
        y: cut(cr * sp * cy + sr * cp * sy),
        z: cut(cr * cp * sy - sr * sp * cy),
    }
}

/// Where a vehicle is on Earth, if it knows. A topic for each vehicle: Lichtblick's map knows no list of them.
#[must_use]
pub fn location(vehicle: &VehicleSnapshot, unix_ns: u64) -> Option<LocationFix> {
    let global = vehicle.global?;
    Some(LocationFix {
        timestamp: Some(timestamp(unix_ns)),
        frame_id: vehicle_frame(vehicle.id),
        latitude: global.latitude_deg,
        longitude: global.longitude_deg,
        altitude: global.altitude_amsl_m,
        heading: vehicle.kinematics.map(|kinematics| kinematics.yaw_rad),
        color: Some(if vehicle.is_leader { LEADER } else { VEHICLE }),
        ..LocationFix::default()
    })
}

/// Where vehicles and tracks are in the swarm's frame.
#[must_use]
pub fn transforms(fleet: &FleetSnapshot, unix_ns: u64) -> FrameTransforms {
    let transform = |child: String, translation, rotation| FrameTransform {
        timestamp: Some(timestamp(unix_ns)),
        parent_frame_id: SWARM.to_owned(),
        child_frame_id: child,
        translation: Some(translation),
        rotation: Some(rotation),
    };
    let vehicles = fleet.vehicles.iter().filter_map(|vehicle| {
        let kinematics = vehicle.kinematics?;
        let (roll_rad, pitch_rad) = (f64::from(vehicle.roll_rad), f64::from(vehicle.pitch_rad));
        let rotation = attitude(roll_rad, pitch_rad, kinematics.yaw_rad);
        Some(transform(
            vehicle_frame(vehicle.id),
            enu(&kinematics.position),
            rotation,
        ))
    });
    let tracks = fleet.tracks.iter().map(|track| {
        let level = attitude(0.0, 0.0, 0.0);
        transform(track_frame(track), enu(&track.track.position), level)
    });
    FrameTransforms {
        transforms: vehicles.chain(tracks).collect(),
    }
}

fn track_frame(track: &TrackEstimate) -> String {
    format!("track/{}", track.track.track)
}

/// An arrow and a name for each vehicle and track; they go along with its frame.
#[must_use]
pub fn scene(fleet: &FleetSnapshot, unix_ns: u64) -> SceneUpdate {
    let entity = |frame: String, color: Color, words: String| SceneEntity {
        timestamp: Some(timestamp(unix_ns)),
        id: frame.clone(),
        frame_id: frame,
        lifetime: Some(Duration::new(STAYS_S, 0)),
        frame_locked: true,
        arrows: vec![arrow(color)],
        texts: vec![label(words)],
        ..SceneEntity::default()
    };
    let vehicles = fleet.vehicles.iter().map(|vehicle| {
        let color = if vehicle.is_leader { LEADER } else { VEHICLE };
        entity(vehicle_frame(vehicle.id), color, vehicle.name.clone())
    });
    let tracks = fleet.tracks.iter().map(|track| {
        let named = [&track.name, &track.class].into_iter().find(|name| !name.is_empty());
        let words = named.cloned().unwrap_or_else(|| format!("track {}", track.track.track));
        entity(track_frame(track), TRACK, words)
    });
    SceneUpdate {
        deletions: Vec::new(),
        entities: vehicles.chain(tracks).collect(),
    }
}

fn arrow(color: Color) -> ArrowPrimitive {
    ArrowPrimitive {
        pose: Some(at(0.0)),
        shaft_length: 0.7,
        shaft_diameter: 0.2,
        head_length: 0.5,
        head_diameter: 0.5,
        color: Some(color),
    }
}

fn label(words: String) -> TextPrimitive {
    TextPrimitive {
        pose: Some(at(1.0)),
        billboard: true,
        font_size: 14.0,
        scale_invariant: true,
        color: Some(WORDS),
        text: words,
    }
}

/// So high above the frame's origin.
fn at(up_m: f64) -> Pose {
    Pose {
        position: Some(Vector3 {
            x: 0.0,
            y: 0.0,
            z: up_m,
        }),
        orientation: Some(Quaternion {
            x: 0.0,
            y: 0.0,
            z: 0.0,
            w: 1.0,
        }),
    }
}

/// An event as a line of a log.
#[must_use]
pub fn log(event: &EventRecord, unix_ns: u64) -> Log {
    let level = match event.severity {
        Severity::Info | Severity::Advisory => Level::Info,
        Severity::Warning => Level::Warning,
        Severity::Critical => Level::Error,
    };
    Log {
        timestamp: Some(timestamp(unix_ns)),
        level: level.into(),
        message: event.text.clone(),
        name: event.vehicle.map_or_else(|| "skein".to_owned(), vehicle_frame),
        file: String::new(),
        line: 0,
    }
}

/// A picture of a camera: H.264 in Annex B, with its parameter sets before each picture that stands for itself.
#[must_use]
pub fn video(vehicle: VehicleId, camera: &str, annex_b: Vec<u8>, unix_ns: u64) -> CompressedVideo {
    CompressedVideo {
        timestamp: Some(timestamp(unix_ns)),
        frame_id: format!("vehicle/{vehicle}/{camera}"),
        data: annex_b.into(),
        format: "h264".to_owned(),
    }
}
