//! `cmd_vel`: a velocity that expires, flown by hand as any stick is: the vehicle is commanded to be steered, then told how to move as long
//! as the velocity is repeated. One that is not repeated in time becomes a hold. If whatever decides this here ended without a word, the
//! vehicle would stand half a second later all the same.
//!
//! Must never do: fly on when the velocity has expired, or take a vehicle back from somebody who has commanded it since.

pub mod driver;

use crate::interfaces::geometry::Twist;
use crate::requests;
use skein_domain::{Refusal, Stick};

/// After a refusal it is not asked again for so long, in seconds.
const AFTER_REFUSAL_S: f64 = 1.0;
/// A velocity below this is none, in metres per second.
const STANDS_M_S: f64 = 0.05;
/// A rate of turning below this is none, in radians per second.
const NO_RATE_RAD_S: f64 = 1e-3;

/// What is to be asked of the vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Order {
    /// Nothing new.
    Nothing,
    /// To be steered from now on.
    Begin,
    /// To move like this.
    Move(Stick),
    /// To hold.
    Stop,
}

/// What is flown by velocity, and what came of it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Report {
    /// The vehicle is flown by velocity.
    pub engaged: bool,
    /// Velocities taken.
    pub taken: u64,
    /// Velocities refused, by us or by the gate.
    pub refused: u64,
    /// The last reason of a refusal or an end; empty if there was none.
    pub reason: String,
}

/// One vehicle flown by velocity.
#[derive(Debug)]
pub struct Steering {
    valid_s: f64,
    fastest_m_s: f64,
    /// The last velocity, and when it came.
    wanted: Option<(Stick, f64)>,
    engaged: bool,
    not_before_s: f64,
    /// Somebody else has commanded it: nothing is taken until it was silent here for as long as a velocity is good.
    silent_since_s: Option<f64>,
    report: Report,
}

impl Steering {
    /// Of velocities that are good for so long and no faster than this.
    #[must_use]
    pub fn new(valid_s: f64, fastest_m_s: f64) -> Self {
        Self {
            valid_s,
            fastest_m_s,
            wanted: None,
            engaged: false,
            not_before_s: 0.0,
            silent_since_s: None,
            report: Report::default(),
        }
    }

    /// How it stands.
    #[must_use]
    pub fn report(&self) -> Report {
        Report {
            engaged: self.is_engaged(),
            ..self.report.clone()
        }
    }

    /// Whether the vehicle is flown by velocity.
    #[must_use]
    pub fn is_engaged(&self) -> bool {
        self.engaged
    }

    /// A velocity came in.
    pub fn take(&mut self, twist: &Twist, now_s: f64) {
        if let Some(since_s) = self.silent_since_s {
            self.silent_since_s = Some(now_s);
            if now_s - since_s < self.valid_s {
                self.report.refused += 1;
                return;
            }
            self.silent_since_s = None;
        }
        match requests::velocity(twist, self.fastest_m_s) {
            Ok(stick) => {
                self.report.taken += 1;
                self.wanted = Some((stick, now_s));
            }
            // The one before it stays good until it expires.
            Err(refusal) => self.refuse(&refusal),
        }
    }

    /// The node refused what was asked last.
    pub fn refused(&mut self, refusal: &Refusal, now_s: f64) {
        self.refuse(refusal);
        self.engaged = false;
        self.not_before_s = now_s + AFTER_REFUSAL_S;
    }

    /// Somebody else has commanded the vehicle, or it flies otherwise: it is theirs.
    pub fn taken_over(&mut self, by: &str, now_s: f64) {
        if self.engaged {
            self.report.reason = format!("taken over: {by}");
            self.leave(now_s);
        }
    }

    /// The node refused a stick. What passes by itself is only counted: the vehicle stands meanwhile. Otherwise somebody else has the vehicle,
    /// whether that was heard of already or not.
    pub fn stick_refused(&mut self, refusal: &Refusal, now_s: f64) {
        self.refuse(refusal);
        let passes = matches!(
            refusal,
            Refusal::TimedOut { .. } | Refusal::Clock { .. } | Refusal::NotRunning { .. }
        );
        if !passes {
            self.leave(now_s);
        }
    }

    /// A pilot flies the vehicle: a velocity is no reason to take it from him, however long there was none.
    pub fn leave_to_pilot(&mut self, now_s: f64) {
        if self.wanted.is_some_and(|(stick, _)| !is_none(&stick)) {
            self.refuse(&Refusal::PilotInControl);
            self.leave(now_s);
        }
        (self.engaged, self.wanted) = (false, None);
    }

    /// Nothing is taken until it was silent here.
    fn leave(&mut self, now_s: f64) {
        self.engaged = false;
        self.silent_since_s = Some(now_s);
        self.wanted = None;
    }

    fn refuse(&mut self, refusal: &Refusal) {
        self.report.refused += 1;
        self.report.reason = format!("{}: {refusal}", refusal.code());
    }

    /// What is to be asked now of the vehicle. To be looked at more often than a stick is good for.
    pub fn decide(&mut self, now_s: f64) -> Order {
        let good = self.wanted.filter(|(_, at_s)| now_s - at_s <= self.valid_s);
        let Some((stick, _)) = good else {
            let expired = self.wanted.take().is_some();
            if !std::mem::take(&mut self.engaged) {
                return Order::Nothing;
            }
            if expired {
                self.report.reason = format!("no velocity for {:.1} s", self.valid_s);
            }
            return Order::Stop;
        };
        if self.engaged {
            return Order::Move(stick);
        }
        // Who does not move is not stopped, and is not taken from what it does.
        if is_none(&stick) || now_s < self.not_before_s {
            return Order::Nothing;
        }
        self.engaged = true;
        Order::Begin
    }
}

/// Whether it asks for nothing.
fn is_none(stick: &Stick) -> bool {
    let speed_m_s = stick.forward_m_s.hypot(stick.right_m_s).hypot(stick.up_m_s);
    speed_m_s < STANDS_M_S && stick.yaw_rate_rad_s.abs() < NO_RATE_RAD_S
}

#[cfg(test)]
mod tests;
