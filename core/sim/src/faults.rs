//! What can go wrong with one vehicle while it flies, as a test or a demonstration orders it.

use crate::faces::Face;
use nalgebra::Vector3;

/// Something that goes wrong with a vehicle, or is mended again. Whatever is not named stays as it was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// A satellite receiver hears nothing any more (or again). Without any receiver the estimate drifts for five seconds, then the
    /// horizontal position is invalid: the autopilot sends none and descends (with a pilot present: holds its altitude) until it
    /// has one again.
    GnssLost {
        /// Which one.
        receiver: Receiver,
        /// Lost, or back.
        lost: bool,
    },
    /// A satellite receiver tells a place that is off by this, in metres. The estimator follows the first receiver that has a fix:
    /// an offset of up to three metres at once, a larger one is not believed for seven seconds and then taken over as a whole, so
    /// that the vehicle flies off by it.
    GnssOffset {
        /// Which one.
        receiver: Receiver,
        /// Metres along north, east, down; zero mends it.
        offset_m: Vector3<f64>,
    },
    /// Nothing of the estimator is sent any more (positions, odometry, its status); the autopilot itself flies on.
    EstimateStopped(bool),
    /// The autopilot's clock makes a step, in seconds; it does not restart. The stamps of all messages and TIMESYNC follow it.
    ClockStep(f64),
    /// Whatever it is told, it does not steer sideways any more and is carried off by the wind; in OFFBOARD it keeps its height as
    /// well. Landing and descending still go down.
    Stuck(bool),
    /// The battery drains so many times as fast as it should; 1 is as it should be.
    BatteryDrain(f64),
    /// The battery has this charge from now on, 0..=1.
    BatteryCharge(f64),
    /// It neither hears nor sends anything, though it flies on.
    Silent(bool),
    /// The same on one of its faces alone.
    Cut {
        /// Which one.
        face: Face,
        /// Cut, or whole again.
        cut: bool,
    },
}

/// One of a vehicle's satellite receivers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Receiver {
    /// The one that GPS_RAW_INT tells of.
    First,
    /// The one that GPS2_RAW tells of, if the vehicle has a second.
    Second,
    /// All it has.
    All,
}
