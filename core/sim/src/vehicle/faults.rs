//! What goes wrong with this vehicle, and what that does to it.

use super::SimVehicle;
use super::position_control::Target;
use crate::faces::Face;
use crate::faults::Fault;
use nalgebra::Vector3;
use skein_domain::FlightMode;

/// What is wrong at present.
#[derive(Debug, Clone, Default)]
pub(super) struct Faults {
    pub estimate_stopped: bool,
    pub silent: bool,
    pub mavlink_cut: bool,
    pub topics_cut: bool,
    /// The autopilot's clock minus the time since it was started, in seconds.
    pub clock_step_s: f64,
    stuck: bool,
    /// Height at which it got stuck in OFFBOARD, as its own down coordinate.
    stuck_down_m: Option<f64>,
}

impl SimVehicle {
    /// Something goes wrong, or is mended.
    pub fn inflict(&mut self, fault: Fault) {
        match fault {
            Fault::GnssLost { receiver, lost } => {
                self.estimator.satellites.change(receiver, |r| r.lost = lost);
            }
            Fault::GnssOffset { receiver, offset_m } => {
                let offset = offset_m.map(|metres| if metres.is_finite() { metres } else { 0.0 });
                self.estimator.satellites.change(receiver, |r| r.offset = offset);
            }
            Fault::EstimateStopped(stopped) => self.faults.estimate_stopped = stopped,
            Fault::ClockStep(by_s) if by_s.is_finite() => self.faults.clock_step_s += by_s,
            Fault::ClockStep(_) => {}
            Fault::Stuck(stuck) => {
                self.faults.stuck = stuck;
                self.faults.stuck_down_m = None;
            }
            Fault::BatteryDrain(factor) => self.battery.set_drain(factor),
            Fault::BatteryCharge(charge) => self.battery.set_charge(charge),
            Fault::Silent(silent) => self.faults.silent = silent,
            Fault::Cut { face, cut } => match face {
                Face::Mavlink => self.faults.mavlink_cut = cut,
                Face::Dds => self.faults.topics_cut = cut,
            },
        }
    }

    /// What a stuck vehicle makes of what it is to fly.
    pub(super) fn stuck(&mut self, mut target: Target) -> Target {
        if !self.faults.stuck {
            return target;
        }
        for axis in 0..2 {
            target.position[axis] = f64::NAN;
            target.velocity[axis] = f64::NAN;
            target.acceleration[axis] = 0.0;
        }
        if self.commander.mode() == FlightMode::Offboard {
            let here_m = self.estimator.now.position.z;
            let down_m = *self.faults.stuck_down_m.get_or_insert(here_m);
            target = Target {
                position: Vector3::new(f64::NAN, f64::NAN, down_m),
                velocity: Vector3::repeat(f64::NAN),
                acceleration: Vector3::new(0.0, 0.0, f64::NAN),
                yaw_rad: self.yaw_hold_rad,
                yaw_rate_rad_s: f64::NAN,
            };
        } else {
            self.faults.stuck_down_m = None;
        }
        target
    }
}
