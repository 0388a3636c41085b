//! What Skein takes from PX4's messages, the same for all releases; and whether it can be true.
//!
//! Must never do: let a number through that is not finite or that no vehicle can reach, where it is said to be valid.

mod shapes;

use skein_domain::Geodetic;
use thiserror::Error;

/// Farthest that a vehicle is from its own origin, in metres.
const FARTHEST_M: f32 = 1e6;
/// Fastest that a vehicle is, in metres per second.
const FASTEST_M_S: f32 = 1e3;
/// Highest and lowest place, in metres above mean sea level.
const ALTITUDE_M: std::ops::RangeInclusive<f64> = -12_000.0..=100_000.0;
/// Stamps of PX4 count from its start, or, once its agent has given it its clock, from 1970: no later than the year 2100, in microseconds.
const LATEST_STAMP_US: u64 = 4_102_444_800_000_000;
/// How far the length of an attitude may be from one.
const UNIT_WITHIN: f32 = 0.05;

/// A number that no vehicle can have.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("{field} is {value}")]
pub struct Implausible {
    /// Which field.
    pub field: &'static str,
    /// What it holds.
    pub value: f64,
}

/// `vehicle_status`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Status {
    /// Its stamp in microseconds.
    pub stamp_us: u64,
    /// MAVLink system id of the vehicle.
    pub system_id: u8,
    /// 1 disarmed, 2 armed.
    pub arming_state: u8,
    /// What it does, as PX4 numbers it.
    pub nav_state: u8,
    /// Its own failsafe is acting.
    pub failsafe: bool,
    /// It would let itself be armed.
    pub ready_to_arm: bool,
    /// It took off and has not landed since. PX4 tells it of an armed vehicle alone.
    pub took_off: bool,
}

impl Status {
    /// Whether the motors are armed.
    #[must_use]
    pub fn armed(&self) -> bool {
        self.arming_state == 2
    }

    fn check(&self) -> Result<(), Implausible> {
        stamp(self.stamp_us)?;
        within("arming_state", self.arming_state.into(), 1.0, 2.0)?;
        within("nav_state", self.nav_state.into(), 0.0, 30.0)?;
        within("system_id", self.system_id.into(), 1.0, 255.0)
    }
}

/// `vehicle_local_position`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalPosition {
    /// Its stamp in microseconds.
    pub stamp_us: u64,
    /// When it was measured, on the same clock.
    pub measured_us: u64,
    /// North and east are valid, down is, and so for the velocity.
    pub valid: Validity,
    /// North, east, down in metres.
    pub position_m: [f32; 3],
    /// North, east, down in metres per second.
    pub velocity_m_s: [f32; 3],
    /// The origin: latitude and longitude in degrees, if they are valid.
    pub origin_deg: Option<[f64; 2]>,
    /// The origin's altitude above mean sea level in metres, if it is valid.
    pub origin_altitude_m: Option<f32>,
    /// Accuracy of the position in metres: along the horizontal and of the height.
    pub accuracy_m: [f32; 2],
    /// It goes on without a measurement of the position.
    pub dead_reckoning: bool,
}

/// What of a local position is valid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Validity {
    /// North and east.
    pub horizontal: bool,
    /// Down.
    pub vertical: bool,
    /// Velocity north and east.
    pub velocity_horizontal: bool,
    /// Velocity down.
    pub velocity_vertical: bool,
}

impl LocalPosition {
    /// The origin of its frame, if PX4 knows where it is.
    #[must_use]
    pub fn origin(&self) -> Option<Geodetic> {
        let ([latitude_deg, longitude_deg], altitude) = (self.origin_deg?, self.origin_altitude_m?);
        Some(Geodetic {
            latitude_deg,
            longitude_deg,
            altitude_amsl_m: f64::from(altitude),
        })
    }

    fn check(&self) -> Result<(), Implausible> {
        stamp(self.stamp_us)?;
        stamp(self.measured_us)?;
        let Validity {
            horizontal,
            vertical,
            velocity_horizontal,
            velocity_vertical,
        } = self.valid;
        let [x, y, z] = self.position_m;
        let [vx, vy, vz] = self.velocity_m_s;
        let far = [("x", x, horizontal), ("y", y, horizontal), ("z", z, vertical)];
        let fast = [
            ("vx", vx, velocity_horizontal),
            ("vy", vy, velocity_horizontal),
            ("vz", vz, velocity_vertical),
        ];
        for (field, value, valid) in far {
            check_if(valid, field, value, FARTHEST_M)?;
        }
        for (field, value, valid) in fast {
            check_if(valid, field, value, FASTEST_M_S)?;
        }
        if let Some([latitude, longitude]) = self.origin_deg {
            within("ref_lat", latitude, -90.0, 90.0)?;
            within("ref_lon", longitude, -180.0, 180.0)?;
        }
        match self.origin_altitude_m {
            Some(altitude) => self::altitude("ref_alt", altitude.into()),
            None => Ok(()),
        }
    }
}

/// A place with its stamp: `vehicle_global_position`, `home_position`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Its stamp in microseconds.
    pub stamp_us: u64,
    /// When it was measured, on the same clock.
    pub measured_us: u64,
    /// Whether it is valid.
    pub valid: bool,
    /// Where.
    pub place: Geodetic,
}

impl Place {
    fn check(&self) -> Result<(), Implausible> {
        stamp(self.stamp_us)?;
        if !self.valid {
            return Ok(());
        }
        place(&self.place)
    }
}

/// `vehicle_attitude`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attitude {
    /// Its stamp in microseconds.
    pub stamp_us: u64,
    /// From the vehicle's axes (forward, right, down) to north, east, down; the real part first.
    pub quaternion: [f32; 4],
}

impl Attitude {
    fn check(&self) -> Result<(), Implausible> {
        stamp(self.stamp_us)?;
        let length = self.quaternion.iter().map(|part| part * part).sum::<f32>().sqrt();
        within(
            "q",
            length.into(),
            f64::from(1.0 - UNIT_WITHIN),
            f64::from(1.0 + UNIT_WITHIN),
        )
    }
}

/// `vehicle_land_detected`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Landed {
    /// Its stamp in microseconds.
    pub stamp_us: u64,
    /// It stands on the ground.
    pub landed: bool,
}

/// `battery_status`. What is not known is not a number or negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatteryReport {
    /// Its stamp in microseconds.
    pub stamp_us: u64,
    /// Which battery, from 1.
    pub id: u8,
    /// There is one.
    pub connected: bool,
    /// In volts.
    pub voltage_v: f32,
    /// In amperes.
    pub current_a: f32,
    /// Remaining charge, 0..=1.
    pub remaining: f32,
    /// Charge used in milliampere hours.
    pub discharged_mah: f32,
    /// Flight time that is left in seconds.
    pub time_remaining_s: f32,
}

impl BatteryReport {
    fn check(&self) -> Result<(), Implausible> {
        stamp(self.stamp_us)?;
        let voltage = if self.voltage_v.is_nan() { 0.0 } else { self.voltage_v };
        within("voltage_v", voltage.into(), -1.0, 1e4)
    }
}

/// `vehicle_gps_position`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GnssReport {
    /// Its stamp in microseconds.
    pub stamp_us: u64,
    /// Kind of fix as PX4 numbers it.
    pub fix_type: u8,
    /// Satellites used.
    pub satellites: u8,
    /// Accuracy along the horizontal in metres.
    pub horizontal_accuracy_m: f32,
    /// Where; without meaning without a fix.
    pub place: Geodetic,
}

impl GnssReport {
    /// Whether there is a fix.
    #[must_use]
    pub fn has_fix(&self) -> bool {
        self.fix_type >= 2
    }

    fn check(&self) -> Result<(), Implausible> {
        stamp(self.stamp_us)?;
        within("fix_type", self.fix_type.into(), 0.0, 8.0)?;
        if self.has_fix() { place(&self.place) } else { Ok(()) }
    }
}

/// `timesync_status`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timesync {
    /// Its stamp in microseconds.
    pub stamp_us: u64,
    /// 2 if it is about the clock of the agent.
    pub source: u8,
    /// PX4's clock minus that of its agent, in microseconds; 0 while it has none.
    pub offset_us: i64,
    /// Round trip between PX4 and its agent in microseconds.
    pub round_trip_us: u32,
}

/// `vehicle_command_ack`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ack {
    /// Number of the command.
    pub command: u32,
    /// `MAV_RESULT`.
    pub result: u8,
    /// System it is meant for.
    pub target_system: u8,
    /// Component it is meant for.
    pub target_component: u16,
}

/// One message of a vehicle, as far as Skein reads it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sample {
    /// What it does.
    Status(Status),
    /// Where it is in its own frame.
    Local(LocalPosition),
    /// Where it is on Earth.
    Global(Place),
    /// How it is turned.
    Attitude(Attitude),
    /// Whether it stands on the ground.
    Landed(Landed),
    /// Its battery.
    Battery(BatteryReport),
    /// Its satellite receiver.
    Gnss(GnssReport),
    /// Where it was launched.
    Home(Place),
    /// Its clock and its agent's.
    Timesync(Timesync),
    /// An answer.
    Ack(Ack),
}

impl Sample {
    /// Its stamp in microseconds; an answer has none that is of use.
    #[must_use]
    pub fn stamp_us(&self) -> Option<u64> {
        match self {
            Self::Status(sample) => Some(sample.stamp_us),
            Self::Local(sample) => Some(sample.stamp_us),
            Self::Global(sample) => Some(sample.stamp_us),
            Self::Attitude(sample) => Some(sample.stamp_us),
            Self::Landed(sample) => Some(sample.stamp_us),
            Self::Battery(sample) => Some(sample.stamp_us),
            Self::Gnss(sample) => Some(sample.stamp_us),
            Self::Timesync(sample) => Some(sample.stamp_us),
            // The launch place is sent again with the stamp of when it was set.
            Self::Home(_) | Self::Ack(_) => None,
        }
    }

    /// Whether it can be true.
    ///
    /// # Errors
    /// The first number that no vehicle can have.
    pub fn check(&self) -> Result<(), Implausible> {
        match self {
            Self::Status(sample) => sample.check(),
            Self::Local(sample) => sample.check(),
            Self::Global(sample) | Self::Home(sample) => sample.check(),
            Self::Attitude(sample) => sample.check(),
            Self::Landed(sample) => stamp(sample.stamp_us),
            Self::Battery(sample) => sample.check(),
            Self::Gnss(sample) => sample.check(),
            Self::Timesync(sample) => stamp(sample.stamp_us),
            Self::Ack(sample) => within("result", sample.result.into(), 0.0, 16.0),
        }
    }
}

fn stamp(stamp_us: u64) -> Result<(), Implausible> {
    within("timestamp", stamp_us as f64, 0.0, LATEST_STAMP_US as f64)
}

fn place(place: &Geodetic) -> Result<(), Implausible> {
    within("lat", place.latitude_deg, -90.0, 90.0)?;
    within("lon", place.longitude_deg, -180.0, 180.0)?;
    altitude("alt", place.altitude_amsl_m)
}

fn altitude(field: &'static str, value: f64) -> Result<(), Implausible> {
    within(field, value, *ALTITUDE_M.start(), *ALTITUDE_M.end())
}

fn check_if(valid: bool, field: &'static str, value: f32, most: f32) -> Result<(), Implausible> {
    if valid {
        within(field, value.into(), (-most).into(), most.into())
    } else {
        Ok(())
    }
}

/// Not a number is within nothing.
fn within(field: &'static str, value: f64, least: f64, most: f64) -> Result<(), Implausible> {
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(Implausible { field, value })
    }
}

#[cfg(test)]
mod tests;
