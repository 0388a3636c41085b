//! What an autopilot publishes as topics and what it takes as such, in the simulation's own terms; and the port to whoever carries
//! them.
//!
//! Must never do: name a message, a release or an encoding. Frames are the vehicle's own: north, east, down of its estimator's
//! origin. All stamps are on the autopilot's own clock, in microseconds since it was started.

use nalgebra::{UnitQuaternion, Vector3};
use skein_domain::{FlightMode, Geodetic};

/// Something that the autopilot publishes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Published {
    /// What it does: twice a second, and at once when something of it changes.
    Status(StatusReport),
    /// Where it is in its own frame: 50 times a second.
    Local(LocalReport),
    /// How it is turned: 50 times a second.
    Attitude(AttitudeReport),
    /// Where it is on Earth: 50 times a second.
    Global(GlobalReport),
    /// Whether it stands on the ground: once a second, and at once when that changes.
    Landed(LandedReport),
    /// Its battery: once a second.
    Battery(BatteryReport),
    /// Its satellite receiver: five times a second.
    Gnss(GnssReport),
    /// Where it was launched: once, when that changes. Whoever comes later does not hear of it.
    Home(HomeReport),
    /// Its clock and that of the world: once a second.
    Timesync(TimesyncReport),
    /// The answer to a command.
    CommandAnswer(CommandAnswer),
}

/// What the autopilot does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatusReport {
    /// When.
    pub stamp_us: u64,
    /// MAVLink system id.
    pub system_id: u8,
    /// Motors armed.
    pub armed: bool,
    /// When it was armed; zero if it is not.
    pub armed_us: u64,
    /// The mode it is in.
    pub mode: FlightMode,
    /// The mode that was asked for.
    pub intention: FlightMode,
    /// A failsafe is in command.
    pub failsafe: bool,
    /// It would let itself be armed.
    pub checks_pass: bool,
}

/// Where it is in its own frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalReport {
    /// When.
    pub stamp_us: u64,
    /// The horizontal position is valid.
    pub horizontal_valid: bool,
    /// The height is valid.
    pub vertical_valid: bool,
    /// Metres.
    pub position_m: Vector3<f64>,
    /// Metres per second.
    pub velocity_m_s: Vector3<f64>,
    /// Metres per second squared.
    pub acceleration_m_s2: Vector3<f64>,
    /// Clockwise from north in radians.
    pub yaw_rad: f64,
    /// Where the origin lies, once it is known.
    pub origin: Option<Geodetic>,
    /// When the origin was set.
    pub origin_us: u64,
    /// Height over the ground below in metres.
    pub height_m: f64,
    /// Accuracy of the horizontal position in metres.
    pub accuracy_horizontal_m: f64,
    /// Accuracy of the height in metres.
    pub accuracy_vertical_m: f64,
    /// It goes on without a measurement of the position.
    pub dead_reckoning: bool,
}

/// How it is turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AttitudeReport {
    /// When.
    pub stamp_us: u64,
    /// From forward, right, down to north, east, down.
    pub turned: UnitQuaternion<f64>,
}

/// Where it is on Earth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GlobalReport {
    /// When.
    pub stamp_us: u64,
    /// The horizontal position is valid. The height always is.
    pub horizontal_valid: bool,
    /// Where.
    pub place: Geodetic,
    /// Accuracy of the horizontal position in metres.
    pub accuracy_horizontal_m: f64,
    /// Accuracy of the height in metres.
    pub accuracy_vertical_m: f64,
    /// It goes on without a measurement of the position.
    pub dead_reckoning: bool,
}

/// Whether it stands on the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LandedReport {
    /// When.
    pub stamp_us: u64,
    /// It stands on the ground.
    pub landed: bool,
}

/// Its battery.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatteryReport {
    /// When.
    pub stamp_us: u64,
    /// Volts.
    pub voltage_v: f64,
    /// Amperes.
    pub current_a: f64,
    /// Milliampere hours used.
    pub consumed_mah: f64,
    /// Charge, 0..=1.
    pub charge: f64,
    /// Flight time left in seconds.
    pub remaining_s: f64,
    /// How worrying the charge is: 0 good, 1 low, 2 critical, 3 emergency.
    pub warning: u8,
}

/// What its satellite receiver tells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GnssReport {
    /// When.
    pub stamp_us: u64,
    /// It has a fix. Without one the rest has no meaning.
    pub fixed: bool,
    /// Satellites used.
    pub satellites: u8,
    /// Where.
    pub place: Geodetic,
    /// Metres per second.
    pub velocity_m_s: Vector3<f64>,
    /// Accuracy of the horizontal position in metres.
    pub accuracy_horizontal_m: f64,
    /// Accuracy of the height in metres.
    pub accuracy_vertical_m: f64,
    /// Universal time in microseconds since 1970.
    pub utc_us: u64,
}

/// Where it was launched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HomeReport {
    /// When that was last told.
    pub stamp_us: u64,
    /// Where on Earth.
    pub place: Geodetic,
    /// Where in its own frame, in metres.
    pub position_m: Vector3<f64>,
    /// How often it has been set.
    pub count: u32,
}

/// Its clock and that of the world.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimesyncReport {
    /// When.
    pub stamp_us: u64,
    /// The autopilot's clock minus universal time since 1970, in microseconds.
    pub offset_us: i64,
}

/// The answer to a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CommandAnswer {
    /// When.
    pub stamp_us: u64,
    /// Number of the command.
    pub command: u32,
    /// `MAV_RESULT`.
    pub result: u8,
    /// System that asked.
    pub to_system: u8,
    /// Component that asked.
    pub to_component: u16,
}

/// Something that the autopilot takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Asked {
    /// A command.
    Command(AskedCommand),
    /// What of the setpoints counts: what keeps OFFBOARD alive.
    Mode(AskedMode),
    /// A setpoint.
    Setpoint(AskedSetpoint),
}

/// A command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AskedCommand {
    /// Number of the command.
    pub command: u32,
    /// Parameters 1 to 4.
    pub param: [f32; 4],
    /// Parameters 5 to 7: latitude and longitude in degrees and altitude above mean sea level in metres, where a command has a place.
    pub place: [f64; 3],
    /// System it is for; zero for any.
    pub to_system: u8,
    /// Component it is for; zero for any.
    pub to_component: u8,
    /// System that asks.
    pub from_system: u8,
    /// Component that asks.
    pub from_component: u16,
}

/// What of the setpoints counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AskedMode {
    /// On the autopilot's own clock; zero for the time of receipt.
    pub stamp_us: u64,
    /// Positions, velocities or accelerations: what this vehicle can follow. Without any of them nothing is kept alive.
    pub follows: bool,
}

/// A setpoint in the vehicle's own frame. What is not a number is not controlled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AskedSetpoint {
    /// Metres.
    pub position_m: Vector3<f64>,
    /// Metres per second.
    pub velocity_m_s: Vector3<f64>,
    /// Metres per second squared.
    pub acceleration_m_s2: Vector3<f64>,
    /// Clockwise from north in radians.
    pub yaw_rad: f64,
    /// Radians per second.
    pub yaw_rate_rad_s: f64,
}

/// Why a carrier does not take a vehicle.
pub type CarrierError = Box<dyn std::error::Error + Send + Sync>;

/// Carries the topics of all vehicles of a simulation. Called from the simulation's thread, but for [`Self::enter`]: must return at once.
/// Vehicles are told apart by a number of the simulation's own, for two may be given the same system id.
pub trait TopicCarrier: Send + Sync {
    /// A vehicle is going to be there.
    ///
    /// # Errors
    /// When its topics cannot be had.
    fn enter(&self, vehicle: u64, system_id: u8) -> Result<(), CarrierError>;

    /// A vehicle is gone.
    fn leave(&self, vehicle: u64);

    /// A vehicle publishes something.
    fn publish(&self, vehicle: u64, published: &Published);

    /// The oldest that has come for a vehicle and was not taken yet.
    fn take(&self, vehicle: u64) -> Option<Asked>;

    /// A step of the simulation is over.
    fn step_done(&self);
}
