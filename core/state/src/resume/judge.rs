//! Whether a vehicle that this node flew until it ended is taken back. Its setpoints come again, holding where it is, and it is watched whether
//! its autopilot goes back into OFFBOARD by itself, as PX4 does out of the failsafe that follows their loss. It is not asked to: so neither a
//! pilot's mode nor any other failsafe is ever undone.
//!
//! Must never do: read a clock; take a vehicle back over which anybody else may have control authority.

use skein_domain::{FlightMode, NodeTime};
use skein_view::PeerEntry;
use std::fmt;

/// An autopilot that is not back in OFFBOARD after so long does not come back, in seconds.
pub const COMES_BACK_S: f64 = 4.0;
/// A vehicle that shows OFFBOARD from the beginning has stayed in it if it still does after so long, in seconds: a failsafe that acted just before
/// the first setpoint shows with the next heartbeat, a second later, and has ended after another one.
pub const STAYED_S: f64 = 2.3;
/// Who is not heard, or has no position, this long after the node's start is not waited for, in seconds.
pub const HEARD_WITHIN_S: f64 = 6.0;

/// What is known of a vehicle in one period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenVehicle {
    /// It is heard, and where it is in its own frame.
    pub is_heard: bool,
    /// It is known where it is in the swarm's frame.
    pub is_placed: bool,
    /// Armed, and not known to stand on the ground.
    pub airborne: bool,
    /// Its mode.
    pub mode: FlightMode,
    /// Its autopilot's own failsafe acts.
    pub failsafe: bool,
}

impl SeenVehicle {
    /// From the picture of a period.
    pub fn of(entry: &PeerEntry) -> Self {
        Self {
            is_heard: entry.link.connected && entry.telemetry.local.is_some(),
            is_placed: entry.kinematics.is_some() && entry.telemetry.local_frame.is_some(),
            airborne: entry.airborne,
            mode: entry.telemetry.mode,
            failsafe: entry.telemetry.failsafe,
        }
    }
}

/// How far it has come with a vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Taking {
    /// It is not heard yet.
    #[default]
    Awaited,
    /// It gets setpoints; since when, and whether it has been seen out of OFFBOARD.
    Holding {
        /// Since when.
        since: NodeTime,
        /// It was seen in its failsafe.
        fell: bool,
    },
    /// It flies by this node's setpoints again.
    Taken,
    /// It is left to whoever has it.
    Left(Why),
}

/// Why a vehicle is not taken back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Why {
    /// Nothing is heard of it, or not where it is.
    NotHeard,
    /// It is not in the air any more.
    OnGround,
    /// Somebody has chosen this mode.
    Chosen(FlightMode),
    /// It stays in this mode although setpoints come.
    Stays(FlightMode),
    /// An operator commanded it meanwhile.
    Commanded,
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotHeard => f.write_str("it is not heard, or not known where it is"),
            Self::OnGround => f.write_str("it is not in the air any more"),
            Self::Chosen(mode) => write!(f, "a pilot or another ground station may have chosen its mode {mode}"),
            Self::Stays(mode) => write!(f, "its autopilot stays in mode {mode} although setpoints come"),
            Self::Commanded => f.write_str("it was commanded meanwhile"),
        }
    }
}

/// The modes in which the loss of setpoints leaves a vehicle, by the autopilot's parameter for it.
fn follows_loss(seen: &SeenVehicle) -> bool {
    seen.failsafe && matches!(seen.mode, FlightMode::Return | FlightMode::Hold | FlightMode::Land)
}

/// How it goes on with a vehicle that is awaited or held.
#[must_use]
pub fn step(taking: Taking, seen: &SeenVehicle, now: NodeTime) -> Taking {
    if matches!(taking, Taking::Taken | Taking::Left(_)) {
        return taking;
    }
    // Not told yet, or not heard: nothing follows from it.
    if !seen.is_heard || seen.mode == FlightMode::Unknown {
        return taking;
    }
    if !seen.airborne {
        return Taking::Left(Why::OnGround);
    }
    let offboard = seen.mode == FlightMode::Offboard;
    if !offboard && !follows_loss(seen) {
        return Taking::Left(Why::Chosen(seen.mode));
    }
    let Taking::Holding { since, fell } = taking else {
        return Taking::Holding {
            since: now,
            fell: !offboard,
        };
    };
    let for_s = now.seconds_since(since);
    match (offboard, fell) {
        (true, true) if seen.is_placed => Taking::Taken,
        (true, false) if seen.is_placed && for_s >= STAYED_S => Taking::Taken,
        (false, _) if for_s >= COMES_BACK_S => Taking::Left(Why::Stays(seen.mode)),
        _ => Taking::Holding {
            since,
            fell: fell || !offboard,
        },
    }
}

#[cfg(test)]
mod tests;
