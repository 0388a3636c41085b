//! What nodes tell each other of their vehicles and of themselves, as it goes over the bus: small where it is told often.
//!
//! Must never do: decide anything. Ages go over the bus, not moments, so that each receiver reckons by its own clock.

use crate::vehicle::VehicleRecord;
use minicbor::{Decode, Encode};
use skein_bus::latest::Key;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{
    AnchorReference, FlightMode, FlightState, LandedState, NodeTime, PositionNed, SwarmFrame, VehicleId, VelocityNed,
};
use skein_view::PeerEntry;

/// Kinds of values on the bus; the key's lower bits say which item and which part of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A beacon of the leadership.
    Beacon = 1,
    /// What a node is.
    Card = 2,
    /// Reports of some vehicles.
    Vehicles = 3,
    /// Everything that screens show of one vehicle.
    Sheet = 4,
    /// Intent and what a successor needs.
    Orders = 5,
    /// What operators told at this node.
    OperatorState = 6,
    /// Fences that were set while the swarm runs.
    Fences = 7,
    /// What the sensors of a node saw.
    Sightings = 8,
    /// The tracks of the node that coordinates.
    Tracks = 9,
}

const KINDS: [Kind; 9] = [
    Kind::Beacon,
    Kind::Card,
    Kind::Vehicles,
    Kind::Sheet,
    Kind::Orders,
    Kind::OperatorState,
    Kind::Fences,
    Kind::Sightings,
    Kind::Tracks,
];

/// The key of a part of an item.
#[must_use]
pub fn key(kind: Kind, item: u16, part: u8) -> Key {
    Key((kind as u32) << 24 | u32::from(item) << 8 | u32::from(part))
}

/// What a key names; nothing if it is of a later version of this program.
#[must_use]
pub fn named(key: Key) -> Option<(Kind, u16)> {
    let kind = KINDS.into_iter().find(|kind| *kind as u32 == key.0 >> 24)?;
    Some((kind, (key.0 >> 8 & 0xFFFF) as u16))
}

/// What other nodes have to know of a vehicle to fly beside it, and the coordinator to judge it.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub struct VehicleReport {
    /// Which.
    #[n(0)]
    pub id: VehicleId,
    /// See the constants.
    #[n(1)]
    pub flags: u16,
    /// Flight state.
    #[n(2)]
    pub flight_state: FlightState,
    /// Its autopilot's mode.
    #[n(3)]
    pub mode: FlightMode,
    /// On the ground or not.
    #[n(4)]
    pub landed: LandedState,
    /// Where it is and how it moves, if that is known.
    #[n(5)]
    pub motion: Option<Motion>,
    /// How long ago its autopilot was last heard, in microseconds.
    #[n(6)]
    pub heard_age_us: u32,
    /// Its anchor while it leads.
    #[n(7)]
    pub anchor: Option<AnchorReference>,
    /// Version of the task it has taken up last.
    #[n(8)]
    pub task_version: u64,
    /// Version of the task whose route it has flown to the end.
    #[n(9)]
    pub route_finished: Option<u64>,
    /// Counts how often it was taken out of the formation.
    #[n(10)]
    pub withdrawals: u32,
    /// Where it holds, in millimetres.
    #[n(11)]
    pub held_mm: Option<[i32; 3]>,
    /// Share of lost messages on its link, in percent.
    #[n(12)]
    pub loss_percent: u8,
    /// Distance to its slot or goal, in centimetres.
    #[n(13)]
    pub tracking_error_cm: Option<u16>,
}

/// Its autopilot is heard.
pub const CONNECTED: u16 = 1;
/// In the air.
pub const AIRBORNE: u16 = 2;
/// Motors on.
pub const ARMED: u16 = 4;
/// A reaction of its failsafe policy is in force.
pub const UNDER_ORDER: u16 = 8;
/// Its failsafe policy took it out of the formation, and that is over.
pub const MAY_REJOIN: u16 = 16;
/// An operator's command took it out of the formation.
pub const WITHDRAWN: u16 = 32;
/// It gets setpoints.
pub const STREAMS: u16 = 64;
/// Its clock is in doubt.
pub const CLOCK_FAULT: u16 = 128;

/// Position, velocity and yaw in the swarm's frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Encode, Decode)]
pub struct Motion {
    /// North, east, down in millimetres.
    #[n(0)]
    pub position_mm: [i32; 3],
    /// The same in millimetres per second.
    #[n(1)]
    pub velocity_mm_s: [i32; 3],
    /// Yaw in ten-thousandths of a radian.
    #[n(2)]
    pub yaw_e4: i32,
    /// How long ago this was measured, in microseconds.
    #[n(3)]
    pub age_us: u32,
}

/// Some vehicles of a node at one moment of its clock.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub struct Batch {
    /// The sender's clock.
    #[n(0)]
    pub told: NodeTime,
    /// Its vehicles.
    #[n(1)]
    pub reports: Vec<VehicleReport>,
}

fn is_finite(kinematics: &VehicleKinematics) -> bool {
    kinematics.position.is_finite() && kinematics.velocity.is_finite() && kinematics.yaw_rad.is_finite()
}

fn milli(value: f64) -> i32 {
    // Saturates: a vehicle two thousand kilometres away is wrong anyway.
    (value * 1e3).round() as i32
}

fn place_mm(place: &PositionNed) -> [i32; 3] {
    [milli(place.north_m), milli(place.east_m), milli(place.down_m)]
}

fn place(mm: [i32; 3]) -> PositionNed {
    let [north_m, east_m, down_m] = mm.map(|value| f64::from(value) * 1e-3);
    PositionNed {
        north_m,
        east_m,
        down_m,
    }
}

fn age_us(at: NodeTime, now: NodeTime) -> u32 {
    u32::try_from(now.0.saturating_sub(at.0)).unwrap_or(u32::MAX)
}

impl Motion {
    fn of(kinematics: &VehicleKinematics, now: NodeTime) -> Self {
        let v = &kinematics.velocity;
        Self {
            position_mm: place_mm(&kinematics.position),
            velocity_mm_s: [milli(v.north_m_s), milli(v.east_m_s), milli(v.down_m_s)],
            yaw_e4: (kinematics.yaw_rad * 1e4).round() as i32,
            age_us: age_us(kinematics.measured, now),
        }
    }

    /// The place alone.
    #[must_use]
    pub fn place(&self) -> PositionNed {
        place(self.position_mm)
    }

    /// The same motion elsewhere.
    pub fn place_at(&mut self, place: PositionNed) {
        self.position_mm = place_mm(&place);
    }

    /// By the receiver's clock, on which it was told at `told`.
    #[must_use]
    pub fn kinematics(&self, told: NodeTime) -> VehicleKinematics {
        let [north_m_s, east_m_s, down_m_s] = self.velocity_mm_s.map(|value| f64::from(value) * 1e-3);
        VehicleKinematics {
            position: place(self.position_mm),
            velocity: VelocityNed {
                north_m_s,
                east_m_s,
                down_m_s,
            },
            yaw_rad: f64::from(self.yaw_e4) * 1e-4,
            measured: NodeTime(told.0.saturating_sub(u64::from(self.age_us))),
        }
    }
}

impl VehicleReport {
    /// Of one of this node's own vehicles.
    #[must_use]
    pub fn of(record: &VehicleRecord, entry: &PeerEntry, withdrawn: bool, now: NodeTime) -> Self {
        let state = record.state();
        let flag = |is: bool, flag: u16| if is { flag } else { 0 };
        let alarms = state.failsafe.iter().flat_map(|failsafe| &failsafe.alarms);
        let clock_fault = alarms
            .into_iter()
            .any(|a| a.trigger == skein_domain::Trigger::ClockFault);
        let holds = state.flight_state == FlightState::Holding;
        Self {
            id: record.id,
            flags: flag(entry.link.connected, CONNECTED)
                | flag(entry.airborne, AIRBORNE)
                | flag(entry.telemetry.armed, ARMED)
                | flag(entry.under_order, UNDER_ORDER)
                | flag(entry.may_rejoin, MAY_REJOIN)
                | flag(withdrawn, WITHDRAWN)
                | flag(entry.link.setpoint_rate_hz > 0.0, STREAMS)
                | flag(clock_fault, CLOCK_FAULT),
            flight_state: entry.flight_state,
            mode: entry.telemetry.mode,
            landed: entry.telemetry.landed,
            motion: entry
                .kinematics
                .as_ref()
                .filter(|k| is_finite(k))
                .map(|k| Motion::of(k, now)),
            heard_age_us: age_us(entry.link.last_heard, now),
            anchor: entry.anchor,
            task_version: state.task_version,
            route_finished: state.route_finished,
            withdrawals: record.withdrawals(),
            held_mm: state
                .setpoint
                .and_then(|s| s.position)
                .filter(|_| holds)
                .map(|p| place_mm(&p)),
            loss_percent: (entry.link.loss.clamp(0.0, 1.0) * 100.0).round() as u8,
            tracking_error_cm: state
                .tracking_error_m
                .map(|m| (m.clamp(0.0, 650.0) * 100.0).round() as u16),
        }
    }

    /// Whether all of these flags are set.
    #[must_use]
    pub fn has(&self, flags: u16) -> bool {
        self.flags & flags == flags
    }

    /// Where it holds, if it does.
    #[must_use]
    pub fn held(&self) -> Option<PositionNed> {
        self.held_mm.map(place)
    }
}

/// What a node is. Told when it changes.
#[derive(Debug, Clone, PartialEq, Default, Encode, Decode)]
pub struct Card {
    /// Its name for people.
    #[n(0)]
    pub name: String,
    /// See [`skein_view::NodeRole`], one bit each.
    #[n(1)]
    pub roles: u8,
    /// Version of the program.
    #[n(2)]
    pub version: String,
    /// Vehicles it flies.
    #[n(3)]
    pub vehicles: Vec<VehicleId>,
    /// The swarm's origin as it has it: latitude, longitude in degrees, altitude in metres.
    #[n(4)]
    pub origin: Option<[f64; 3]>,
}

/// A frame as it stands on a card.
#[must_use]
pub fn origin_of(frame: Option<SwarmFrame>) -> Option<[f64; 3]> {
    let origin = frame?.origin;
    Some([origin.latitude_deg, origin.longitude_deg, origin.altitude_amsl_m])
}

#[cfg(test)]
mod tests;
