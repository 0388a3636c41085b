//! Satellite navigation as PX4's estimator lives with it: which receiver it follows, what it does when there is none, and when it
//! stops believing one and when it gives in.
//!
//! The times and the gate are those of EKF2's defaults: EKF2_NOAID_TOUT (5 s), the reset of the position after seven seconds of
//! refused measurements, and a gate of five standard deviations of about 0.6 m. The drift is that of a low-cost inertial sensor.

use crate::faults::Receiver;
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use skein_sim_payloads::wander::normal;

/// Without any aid the horizontal position counts as valid for so long, in seconds.
const NO_AID_S: f64 = 5.0;
/// A place further off than this is not believed, in metres.
const GATE_M: f64 = 3.0;
/// After so long of not believing it, it is taken over as a whole, in seconds.
const RESET_AFTER_S: f64 = 7.0;
/// How fast a believed place is followed, in seconds.
const FOLLOW_S: f64 = 1.0;
/// Error of the acceleration by which an estimate without aid drifts off, in metres per second squared, and the fastest drift.
const DRIFT_M_S2: f64 = 0.05;
const DRIFT_MAX_M_S: f64 = 1.5;
/// How fast the drift dies out when there is an aid again, in seconds.
const DRIFT_ENDS_S: f64 = 0.4;

/// One receiver.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Reception {
    /// It hears nothing.
    pub lost: bool,
    /// What it tells minus what is true, in metres.
    pub offset: Vector3<f64>,
}

/// The receivers, and what the estimator makes of them.
#[derive(Debug, Clone)]
pub(crate) struct Satellites {
    first: Reception,
    second: Option<Reception>,
    unaided_s: f64,
    refused_s: f64,
    direction: Vector3<f64>,
    /// What the receivers have done to the estimated position: estimated minus true, in metres.
    pub error: Vector3<f64>,
    /// The same of the velocity in metres per second.
    pub drift: Vector3<f64>,
}

impl Satellites {
    pub(crate) fn new(with_second: bool) -> Self {
        Self {
            first: Reception::default(),
            second: with_second.then(Reception::default),
            unaided_s: 0.0,
            refused_s: 0.0,
            direction: Vector3::zeros(),
            error: Vector3::zeros(),
            drift: Vector3::zeros(),
        }
    }

    /// Changes one receiver, or all.
    pub(crate) fn change(&mut self, which: Receiver, change: impl Fn(&mut Reception)) {
        if which != Receiver::Second {
            change(&mut self.first);
        }
        if let Some(second) = self.second.as_mut().filter(|_| which != Receiver::First) {
            change(second);
        }
    }

    /// The autopilot starts anew: it believes the first place it gets.
    pub(crate) fn restart(&mut self) {
        self.error = self.followed().map_or_else(Vector3::zeros, |receiver| receiver.offset);
        // Without a receiver there is no place from the start.
        self.unaided_s = if self.followed().is_some() { 0.0 } else { NO_AID_S };
        (self.refused_s, self.drift) = (0.0, Vector3::zeros());
    }

    /// The receiver of GPS_RAW_INT.
    pub(crate) fn first(&self) -> Reception {
        self.first
    }

    /// The receiver of GPS2_RAW.
    pub(crate) fn second(&self) -> Option<Reception> {
        self.second
    }

    fn followed(&self) -> Option<Reception> {
        Some(self.first).into_iter().chain(self.second).find(|r| !r.lost)
    }

    /// Whether the horizontal position counts as valid.
    pub(crate) fn is_valid(&self) -> bool {
        self.unaided_s < NO_AID_S
    }

    /// Whether the receiver is heard but not believed.
    pub(crate) fn is_refused(&self) -> bool {
        self.refused_s > 0.0
    }

    /// How long there has been no receiver, in seconds.
    pub(crate) fn unaided_s(&self) -> f64 {
        self.unaided_s
    }

    /// How far what the receiver tells is from what is believed, in gates: over 1 it is refused.
    pub(crate) fn ratio(&self) -> f64 {
        self.followed()
            .map_or(0.0, |receiver| (receiver.offset - self.error).xy().norm() / GATE_M)
    }

    /// Lets `dt_s` pass.
    pub(crate) fn step(&mut self, dt_s: f64, rng: &mut ChaCha8Rng) {
        let Some(receiver) = self.followed() else {
            if self.unaided_s <= 0.0 {
                let angle = normal(rng) * std::f64::consts::TAU;
                self.direction = Vector3::new(angle.cos(), angle.sin(), 0.0);
            }
            self.unaided_s += dt_s;
            self.refused_s = 0.0;
            if self.drift.norm() < DRIFT_MAX_M_S {
                self.drift += self.direction * (DRIFT_M_S2 * dt_s);
            }
            self.error += self.drift * dt_s;
            return;
        };
        let was_valid = self.is_valid();
        self.unaided_s = 0.0;
        self.drift *= (-dt_s / DRIFT_ENDS_S).exp();
        let far = self.ratio() > 1.0;
        self.refused_s = if far && was_valid { self.refused_s + dt_s } else { 0.0 };
        if !was_valid || self.refused_s >= RESET_AFTER_S {
            // The position is set anew: it jumps.
            self.error = receiver.offset;
            self.drift = Vector3::zeros();
            self.refused_s = 0.0;
        } else if !far {
            self.error += (receiver.offset - self.error) * (dt_s / (FOLLOW_S + dt_s));
        }
    }
}
