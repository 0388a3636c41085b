//! What a gimbal is asked and what it tells, whatever protocol it speaks.
//!
//! Must never do: know a protocol.

use crate::aim::Rates;
use crate::attitude::{Attitude, Direction, Limits};
use crate::settings::Settings;
use minicbor::{Decode, Encode};
use skein_domain::payload::GimbalOwner;
use skein_domain::{NodeTime, Refusal};

/// What every step of a device looks at.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moment<'a> {
    pub(crate) now: NodeTime,
    pub(crate) settings: &'a Settings,
    /// The vehicle's yaw from north in radians, if known.
    pub(crate) vehicle_yaw_rad: Option<f64>,
    /// Its roll and pitch about the horizon in radians, if known.
    pub(crate) vehicle_roll_pitch_rad: Option<(f64, f64)>,
}

impl Moment<'_> {
    /// Whether `time` is no longer ago than `for_s`.
    pub(crate) fn within(&self, time: Option<NodeTime>, for_s: f64) -> bool {
        time.is_some_and(|time| self.now.seconds_since(time) <= for_s)
    }
}

/// What is known of a device.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Status {
    pub(crate) connected: bool,
    pub(crate) owner: GimbalOwner,
    pub(crate) attitude: Option<Attitude>,
    /// It says that it is at an end stop.
    pub(crate) at_end_stop: bool,
    /// The autopilot turns it, by servos.
    pub(crate) by_servos: bool,
    pub(crate) limits: Option<Limits>,
    pub(crate) model: String,
    pub(crate) fault: String,
}

/// What is asked of a device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Turn {
    /// There, by what is acknowledged where there is such a thing.
    Once(Direction),
    /// There, again and again.
    To(Direction),
    At(Rates),
}

/// Which change of control ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Encode, Decode)]
#[cbor(index_only)]
pub(crate) enum Control {
    #[n(0)]
    Take,
    #[n(1)]
    Release,
}

/// How a change of control ended.
pub(crate) type ControlOutcome = (Control, Result<(), Refusal>);
