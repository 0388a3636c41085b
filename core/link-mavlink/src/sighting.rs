//! Where others are, as they or somebody else say over MAVLink: movers that report themselves (FOLLOW_TARGET), aircraft that a
//! receiver heard (ADSB_VEHICLE), and systems that are no vehicle of ours but send their position (GLOBAL_POSITION_INT).
//!
//! Must never do: take what is heard for a vehicle of the swarm, or keep more than a bounded number of them.

use crate::fields::Fields;
use crate::frame::Frame;
use crate::vehicle::telemetry::place;
use mavlink::MessageData;
use mavlink::dialects::common::{ADSB_VEHICLE_DATA, FOLLOW_TARGET_DATA, GLOBAL_POSITION_INT_DATA};
use parking_lot::Mutex;
use skein_domain::frames::wrap_angle_rad;
use skein_domain::{Geodetic, NodeTime, VelocityNed};
use std::collections::BTreeMap;

/// Others that are remembered at most.
pub const SIGHTINGS_MAX: usize = 256;

/// Somebody's place at a moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Sighting {
    /// Who: `mavlink:42` by system id, `adsb:4CA123` by the address of its transponder.
    pub source: String,
    /// Where.
    pub place: Geodetic,
    /// How fast, if it says.
    pub velocity: Option<VelocityNed>,
    /// Where its nose or its track points, in radians clockwise from north, if it says.
    pub heading_rad: Option<f64>,
    /// When it was there: when it was heard, less the age that a receiver states.
    pub time: NodeTime,
}

/// Where sightings go. Called on an endpoint's task: must return at once, and bounds what it keeps by itself.
pub trait ReferenceSink: Send + Sync + 'static {
    /// Takes one; a newer one of the same source takes the place of the older.
    fn sighted(&self, sighting: Sighting);
}

/// The name under which a MAVLink system is sighted.
#[must_use]
pub fn source_of(system_id: u8) -> String {
    format!("mavlink:{system_id}")
}

/// The latest sighting of each source, for whoever looks. The one unheard for longest goes when there are too many.
#[derive(Debug, Default)]
pub struct Sightings {
    latest: Mutex<BTreeMap<String, Sighting>>,
}

impl Sightings {
    /// Empty.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The latest of one source.
    #[must_use]
    pub fn of(&self, source: &str) -> Option<Sighting> {
        self.latest.lock().get(source).cloned()
    }

    /// Forgets a source: it was sighted before it was known to be one of ours.
    pub fn forget(&self, source: &str) {
        self.latest.lock().remove(source);
    }

    /// The latest of all sources that were there at `since` or later, by source.
    #[must_use]
    pub fn since(&self, since: NodeTime) -> Vec<Sighting> {
        let latest = self.latest.lock();
        latest.values().filter(|s| s.time >= since).cloned().collect()
    }
}

impl ReferenceSink for Sightings {
    fn sighted(&self, sighting: Sighting) {
        let mut latest = self.latest.lock();
        if let Some(known) = latest.get_mut(&sighting.source) {
            if known.time <= sighting.time {
                *known = sighting;
            }
            return;
        }
        if latest.len() >= SIGHTINGS_MAX {
            let oldest = latest.values().min_by_key(|s| s.time).map(|s| s.source.clone());
            if let Some(oldest) = oldest {
                latest.remove(&oldest);
            }
        }
        latest.insert(sighting.source.clone(), sighting);
    }
}

/// Whether a message with this id may tell of somebody else even when a vehicle of ours sends it: a receiver aboard hears others.
pub(crate) fn is_of_others(message_id: u32) -> bool {
    message_id == ADSB_VEHICLE_DATA::ID
}

/// What a frame says about the place of somebody; `None` if it says nothing, or nothing usable.
///
/// An aircraft without a valid height is left out: beside or below it nobody knows what is safe.
#[must_use]
pub fn read(now: NodeTime, frame: &Frame<'_>) -> Option<Sighting> {
    if !frame.known {
        return None;
    }
    let system_id = frame.header.system_id;
    let sighting = match frame.header.message_id {
        FOLLOW_TARGET_DATA::ID => follow_target(now, system_id, frame),
        ADSB_VEHICLE_DATA::ID => adsb(now, &Fields(frame.payload)),
        GLOBAL_POSITION_INT_DATA::ID => position(now, system_id, frame),
        _ => None,
    }?;
    let somewhere = sighting.place.latitude_deg != 0.0 || sighting.place.longitude_deg != 0.0;
    (somewhere && sighting.place.is_valid()).then_some(sighting)
}

fn follow_target(now: NodeTime, system_id: u8, frame: &Frame<'_>) -> Option<Sighting> {
    // What it can tell: bit 0 position, 1 velocity, 2 acceleration, 3 attitude and rates.
    const VELOCITY: u8 = 1 << 1;
    const ATTITUDE: u8 = 1 << 3;
    let m = FOLLOW_TARGET_DATA::deser(frame.header.version, frame.payload).ok()?;
    let has = |what: u8| m.est_capabilities & what != 0;
    let [vn, ve, vd] = m.vel.map(f64::from);
    let velocity = Some(VelocityNed::new(vn, ve, vd)).filter(|v| has(VELOCITY) && v.is_finite());
    let [w, x, y, z] = m.attitude_q.map(f64::from);
    let yaw = (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z));
    let is_attitude = has(ATTITUDE) && (w * w + x * x + y * y + z * z - 1.0).abs() < 0.1;
    Some(Sighting {
        source: source_of(system_id),
        place: Geodetic {
            latitude_deg: f64::from(m.lat) / 1e7,
            longitude_deg: f64::from(m.lon) / 1e7,
            altitude_amsl_m: f64::from(m.alt),
        },
        velocity,
        heading_rad: Some(yaw).filter(|yaw| is_attitude && yaw.is_finite()),
        time: now,
    })
}

fn position(now: NodeTime, system_id: u8, frame: &Frame<'_>) -> Option<Sighting> {
    let m = GLOBAL_POSITION_INT_DATA::deser(frame.header.version, frame.payload).ok()?;
    let [vn, ve, vd] = [m.vx, m.vy, m.vz].map(|cm_s| f64::from(cm_s) * 0.01);
    Some(Sighting {
        source: source_of(system_id),
        place: place(m.lat, m.lon, m.alt),
        velocity: Some(VelocityNed::new(vn, ve, vd)),
        heading_rad: heading(m.hdg),
        time: now,
    })
}

/// Read by hand: a flag that is newer than the protocol description must not hide an aircraft.
fn adsb(now: NodeTime, fields: &Fields<'_>) -> Option<Sighting> {
    const COORDINATES: u16 = 1;
    const ALTITUDE: u16 = 2;
    const HEADING: u16 = 4;
    const VELOCITY: u16 = 8;
    const VERTICAL_VELOCITY: u16 = 128;
    let flags = fields.u16(22);
    let has = |what: u16| flags & what == what;
    if !has(COORDINATES | ALTITUDE) {
        return None;
    }
    let track_rad = heading(fields.u16(16)).filter(|_| has(HEADING));
    let speed_m_s = f64::from(fields.u16(18)) * 0.01;
    let climb_m_s = f64::from(fields.u16(20).cast_signed()) * 0.01;
    let velocity = track_rad.filter(|_| has(VELOCITY)).map(|track| {
        let down_m_s = if has(VERTICAL_VELOCITY) { -climb_m_s } else { 0.0 };
        VelocityNed::new(speed_m_s * track.cos(), speed_m_s * track.sin(), down_m_s)
    });
    let age_s = f64::from(fields.u8(37));
    Some(Sighting {
        source: format!("adsb:{:06X}", fields.u32(0) & 0x00FF_FFFF),
        place: place(fields.i32(4), fields.i32(8), fields.i32(12)),
        velocity,
        heading_rad: track_rad,
        time: now.plus_seconds(-age_s),
    })
}

/// Hundredths of a degree, 0..36000.
fn heading(centidegrees: u16) -> Option<f64> {
    (centidegrees <= 36_000).then(|| wrap_angle_rad((f64::from(centidegrees) * 0.01).to_radians()))
}

#[cfg(test)]
mod tests;
