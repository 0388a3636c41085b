//! Others that move about: a ground vehicle that tells of itself, an aircraft that a receiver hears, a vehicle of somebody else's
//! that sends its position. Each follows a script and is heard by real frames.
//!
//! Must never do: answer to anything, or get out of anybody's way.

use crate::truth::MoverTruth;
use crate::wire;
use mavlink::MavHeader;
use mavlink::dialects::common::{
    ADSB_VEHICLE_DATA, AdsbAltitudeType, AdsbEmitterType, AdsbFlags, FOLLOW_TARGET_DATA, GLOBAL_POSITION_INT_DATA,
};
use nalgebra::{UnitQuaternion, Vector3};
use skein_domain::{Geodetic, PositionNed, SwarmFrame, VelocityNed};
use std::net::SocketAddr;

/// Component id of a telemetry partner such as a ground station, and that of a receiver for transponders.
const GROUND_STATION_COMPONENT: u8 = 190;
const RECEIVER_COMPONENT: u8 = 156;
/// Component id of an autopilot.
const AUTOPILOT_COMPONENT: u8 = 1;

/// One mover.
#[derive(Debug, Clone, PartialEq)]
pub struct Mover {
    /// How it is heard of.
    pub report: Report,
    /// The places it goes by about the simulation's origin, at a steady speed.
    pub path: Vec<PositionNed>,
    /// Speed in metres per second.
    pub speed_m_s: f64,
    /// Whether it goes on from the last place to the first, round and round; else it stays at the last.
    pub circuit: bool,
    /// When it sets off, in seconds of the simulation; it waits at the first place until then, and is heard all the same.
    pub starts_s: f64,
    /// When it is last heard of, in seconds of the simulation.
    pub heard_until_s: f64,
    /// Reports per second.
    pub rate_hz: f64,
    /// Where the reports are sent to; where the first vehicle of the port plan sends its onboard link to if left out.
    pub to: Option<SocketAddr>,
}

impl Default for Mover {
    fn default() -> Self {
        Self {
            report: Report::FollowTarget { system_id: 42 },
            path: Vec::new(),
            speed_m_s: 2.0,
            circuit: false,
            starts_s: 0.0,
            heard_until_s: f64::INFINITY,
            rate_hz: 5.0,
            to: None,
        }
    }
}

/// How a mover is heard of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Report {
    /// It tells of itself by FOLLOW_TARGET, as a ground station does whose place is to be followed.
    FollowTarget {
        /// Its MAVLink system id.
        system_id: u8,
    },
    /// A receiver tells of it by ADSB_VEHICLE.
    Adsb {
        /// Address of its transponder, 24 bits.
        address: u32,
        /// MAVLink system id of the receiver.
        receiver_system_id: u8,
    },
    /// It sends GLOBAL_POSITION_INT and no heartbeat.
    Position {
        /// Its MAVLink system id.
        system_id: u8,
    },
}

impl Report {
    /// Who it is to whoever hears the report.
    #[must_use]
    pub fn source(&self) -> String {
        match self {
            Self::FollowTarget { system_id } | Self::Position { system_id } => format!("mavlink:{system_id}"),
            Self::Adsb { address, .. } => format!("adsb:{:06X}", address & 0x00FF_FFFF),
        }
    }
}

/// A mover on its way, without sockets or clock.
#[derive(Debug, Clone)]
pub struct Scripted {
    mover: Mover,
    frame: SwarmFrame,
    next_s: f64,
    sequence: u8,
}

impl Scripted {
    /// Follows the script of a mover about an origin.
    #[must_use]
    pub fn new(mover: Mover, origin: Geodetic) -> Self {
        Self {
            mover,
            frame: SwarmFrame::new(origin),
            next_s: 0.0,
            sequence: 0,
        }
    }

    /// Where it really is at a time of the simulation.
    #[must_use]
    pub fn truth(&self, now_s: f64) -> MoverTruth {
        let (position, velocity) = self.state(now_s);
        MoverTruth {
            source: self.mover.report.source(),
            position,
            velocity,
        }
    }

    /// The frame that is due, if one is.
    pub fn report(&mut self, now_s: f64) -> Option<Vec<u8>> {
        let has_place = !self.mover.path.is_empty() && self.mover.rate_hz > 0.0;
        if !has_place || now_s < self.next_s || now_s > self.mover.heard_until_s {
            return None;
        }
        let period_s = 1.0 / self.mover.rate_hz;
        self.next_s = (self.next_s + period_s).max(now_s + 0.5 * period_s);
        Some(self.frame_at(now_s))
    }

    fn state(&self, now_s: f64) -> (PositionNed, VelocityNed) {
        let path = &self.mover.path;
        let Some(first) = path.first() else {
            return (PositionNed::default(), VelocityNed::default());
        };
        let back = self.mover.circuit.then_some(first);
        let ends = path.iter().skip(1).chain(back);
        let legs: Vec<(Vector3<f64>, Vector3<f64>)> = path
            .iter()
            .zip(ends)
            .map(|(a, b)| (a.vector(), b.vector() - a.vector()))
            .collect();
        let whole_m: f64 = legs.iter().map(|(_, way)| way.norm()).sum();
        let mut left_m = (now_s - self.mover.starts_s).max(0.0) * self.mover.speed_m_s.max(0.0);
        if self.mover.circuit && whole_m > 1e-6 {
            left_m %= whole_m;
        }
        for (from, way) in &legs {
            let length_m = way.norm();
            if left_m < length_m {
                let along = way / length_m;
                let moves = now_s >= self.mover.starts_s;
                let speed_m_s = if moves { self.mover.speed_m_s.max(0.0) } else { 0.0 };
                return ((from + along * left_m).into(), (along * speed_m_s).into());
            }
            left_m -= length_m;
        }
        (path.last().copied().unwrap_or(*first), VelocityNed::default())
    }

    fn frame_at(&mut self, now_s: f64) -> Vec<u8> {
        let (position, velocity) = self.state(now_s);
        let place = self.frame.geodetic(&position);
        let heading_rad = velocity.east_m_s.atan2(velocity.north_m_s);
        let mut bytes = Vec::new();
        let sequence = self.sequence;
        self.sequence = sequence.wrapping_add(1);
        let header = |system_id: u8, component_id: u8| MavHeader {
            system_id: u32::from(system_id),
            component_id,
            sequence,
        };
        match self.mover.report {
            Report::FollowTarget { system_id } => {
                let message = follow_target(now_s, &place, &velocity, heading_rad);
                wire::write_frame(&mut bytes, header(system_id, GROUND_STATION_COMPONENT), &message);
            }
            Report::Adsb {
                address,
                receiver_system_id,
            } => {
                let message = adsb(address, &place, &velocity, heading_rad);
                wire::write_frame(&mut bytes, header(receiver_system_id, RECEIVER_COMPONENT), &message);
            }
            Report::Position { system_id } => {
                let message = position_int(now_s, &place, &velocity, heading_rad);
                wire::write_frame(&mut bytes, header(system_id, AUTOPILOT_COMPONENT), &message);
            }
        }
        bytes
    }
}

fn follow_target(now_s: f64, place: &Geodetic, velocity: &VelocityNed, heading_rad: f64) -> FOLLOW_TARGET_DATA {
    // Position, velocity, attitude.
    const KNOWN: u8 = 0b1011;
    let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, heading_rad);
    FOLLOW_TARGET_DATA {
        timestamp: (now_s * 1e3) as u64,
        lat: e7(place.latitude_deg),
        lon: e7(place.longitude_deg),
        alt: place.altitude_amsl_m as f32,
        vel: [velocity.north_m_s, velocity.east_m_s, velocity.down_m_s].map(|v| v as f32),
        attitude_q: [turn.w, turn.i, turn.j, turn.k].map(|v| v as f32),
        est_capabilities: KNOWN,
        ..FOLLOW_TARGET_DATA::default()
    }
}

fn adsb(address: u32, place: &Geodetic, velocity: &VelocityNed, heading_rad: f64) -> ADSB_VEHICLE_DATA {
    let speed_m_s = velocity.north_m_s.hypot(velocity.east_m_s);
    ADSB_VEHICLE_DATA {
        ICAO_address: address & 0x00FF_FFFF,
        lat: e7(place.latitude_deg),
        lon: e7(place.longitude_deg),
        altitude: mm(place.altitude_amsl_m),
        altitude_type: AdsbAltitudeType::ADSB_ALTITUDE_TYPE_GEOMETRIC,
        heading: centidegrees(heading_rad),
        hor_velocity: (speed_m_s * 1e2).round() as u16,
        ver_velocity: (-velocity.down_m_s * 1e2).round() as i16,
        flags: AdsbFlags::ADSB_FLAGS_VALID_COORDS
            | AdsbFlags::ADSB_FLAGS_VALID_ALTITUDE
            | AdsbFlags::ADSB_FLAGS_VALID_HEADING
            | AdsbFlags::ADSB_FLAGS_VALID_VELOCITY
            | AdsbFlags::ADSB_FLAGS_VERTICAL_VELOCITY_VALID
            | AdsbFlags::ADSB_FLAGS_SIMULATED,
        emitter_type: AdsbEmitterType::ADSB_EMITTER_TYPE_LIGHT,
        ..ADSB_VEHICLE_DATA::default()
    }
}

fn position_int(now_s: f64, place: &Geodetic, velocity: &VelocityNed, heading_rad: f64) -> GLOBAL_POSITION_INT_DATA {
    let cm_s = |speed: f64| (speed * 1e2).round() as i16;
    GLOBAL_POSITION_INT_DATA {
        time_boot_ms: (now_s * 1e3) as u32,
        lat: e7(place.latitude_deg),
        lon: e7(place.longitude_deg),
        alt: mm(place.altitude_amsl_m),
        relative_alt: 0,
        vx: cm_s(velocity.north_m_s),
        vy: cm_s(velocity.east_m_s),
        vz: cm_s(velocity.down_m_s),
        hdg: centidegrees(heading_rad),
    }
}

/// Degrees as the wire has them: times ten million.
fn e7(degrees: f64) -> i32 {
    (degrees * 1e7).round() as i32
}

/// Metres as millimetres.
fn mm(metres: f64) -> i32 {
    (metres * 1e3).round() as i32
}

/// An angle in radians as hundredths of a degree, 0..36000.
fn centidegrees(angle_rad: f64) -> u16 {
    (angle_rad.to_degrees().rem_euclid(360.0) * 100.0).round() as u16 % 36_000
}

#[cfg(test)]
mod tests;
