//! The truth as lines of JSON, so that a referee can put together what several simulations saw.
//!
//! Must never do: hold the simulation up. What cannot be written is not written.

use crate::truth::{TruthFrame, VehicleTruth};
use serde::{Deserialize, Serialize};
use skein_domain::{FlightMode, LandedState, PositionNed, VelocityNed};
use std::io::Write;
use std::time::{SystemTime, UNIX_EPOCH};

/// Every so many frames, of 50 a second, a line is written: 17 a second.
const FRAMES_PER_LINE: u32 = 3;
/// A simulation that is further behind than this has let time go, in seconds: it does not catch up on that.
const LET_GO_S: f64 = 1.0;

/// One line: all vehicles of a simulation at one moment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TruthLine {
    /// When, in seconds since 1970, by the clock of the computer.
    pub time_s: f64,
    /// Every vehicle ever started.
    pub vehicles: Vec<VehicleLine>,
}

/// One vehicle at one moment. Its place is about the origin of the field, which all simulations of one field share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VehicleLine {
    /// MAVLink system id.
    pub system_id: u8,
    /// Where it is.
    pub position: PositionNed,
    /// Velocity.
    pub velocity: VelocityNed,
    /// Motors armed.
    pub armed: bool,
    /// What its own land detector says.
    pub landed: LandedState,
    /// Whether it really stands on the ground.
    pub touches_ground: bool,
    /// Flight mode.
    pub mode: FlightMode,
    /// Whether a failsafe is in command.
    pub failsafe: bool,
    /// Longest time between two accepted setpoints since the last line, in seconds, while in OFFBOARD and armed; without the time in
    /// which the machine did not let the simulation's process run.
    pub setpoint_gap_s: f64,
    /// Setpoints accepted since the start.
    pub setpoints: u64,
}

/// Writes the truth.
#[derive(Debug)]
pub struct TruthLines<W> {
    out: W,
    frames: u32,
    /// Longest gap of each vehicle since the last line, in their order.
    gaps_s: Vec<f64>,
    /// The clock of the computer when the simulation's was zero, in seconds.
    zero_s: Option<f64>,
}

impl<W: Write> TruthLines<W> {
    /// Nothing written yet.
    pub fn new(out: W) -> Self {
        Self {
            out,
            frames: 0,
            gaps_s: Vec::new(),
            zero_s: None,
        }
    }

    /// Takes a frame in; every third becomes a line.
    pub fn look(&mut self, frame: &TruthFrame) {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        self.look_at(frame, now.as_secs_f64());
    }

    fn look_at(&mut self, frame: &TruthFrame, now_s: f64) {
        let time_s = self.stamp_s(frame.time_s, now_s);
        self.gaps_s.resize(frame.vehicles.len().max(self.gaps_s.len()), 0.0);
        for (gap_s, vehicle) in self.gaps_s.iter_mut().zip(&frame.vehicles) {
            *gap_s = gap_s.max(vehicle.offboard_gap_recent_s);
        }
        self.frames += 1;
        if self.frames < FRAMES_PER_LINE {
            return;
        }
        self.frames = 0;
        let vehicles = frame.vehicles.iter().zip(&self.gaps_s);
        let line = TruthLine {
            time_s,
            vehicles: vehicles.map(|(vehicle, gap_s)| line_of(vehicle, *gap_s)).collect(),
        };
        self.gaps_s.fill(0.0);
        if let Ok(mut text) = serde_json::to_string(&line) {
            text.push('\n');
            // In one write: who reads along sees whole lines as a rule.
            let _ = self.out.write_all(text.as_bytes());
        }
    }

    /// A simulation that catches up on a stall shows several moments at once. Each belongs to its own time, not to that at which it is shown.
    fn stamp_s(&mut self, time_s: f64, now_s: f64) -> f64 {
        let zero_s = self.zero_s.get_or_insert(now_s - time_s);
        let late_s = now_s - time_s - *zero_s;
        if !(0.0..=LET_GO_S).contains(&late_s) {
            *zero_s += late_s;
        }
        *zero_s + time_s
    }
}

fn line_of(vehicle: &VehicleTruth, setpoint_gap_s: f64) -> VehicleLine {
    VehicleLine {
        system_id: vehicle.system_id,
        position: vehicle.position,
        velocity: vehicle.velocity,
        armed: vehicle.armed,
        landed: vehicle.landed,
        touches_ground: vehicle.touches_ground,
        mode: vehicle.mode,
        failsafe: vehicle.failsafe,
        setpoint_gap_s,
        setpoints: vehicle.setpoints,
    }
}

#[cfg(test)]
mod tests;
