//! `cmd_vel`: a velocity that expires, flown as a chain of short ways to a place, each of which passes the gate like any other.
//!
//! The model flies straight to places; it takes no velocity by itself. So a velocity becomes a way of a few seconds in its direction, which is
//! laid out anew before its end as long as the velocity is repeated. One that is not repeated in time becomes a hold. If whatever decides this
//! here ended without a word, the vehicle would still hold at the end of its way.
//!
//! Must never do: fly on when the velocity has expired, or take a vehicle back from somebody who has commanded it since.

pub mod driver;

use crate::frames;
use crate::interfaces::geometry::{Twist, Vector3};
use crate::requests;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{PositionNed, Refusal, VehicleCommand, VelocityNed};

/// A way leads so many seconds ahead.
const AHEAD_S: f64 = 5.0;
/// It is laid out anew when less than this is left, in seconds: the model begins to brake before its end.
const ANEW_WITH_LEFT_S: f64 = 2.5;
/// Ways are not laid out more often than this, in seconds.
const SOONEST_S: f64 = 0.5;
/// After a refusal it is not asked again for so long, in seconds.
const AFTER_REFUSAL_S: f64 = 1.0;
/// A change of the velocity below this is none, in metres per second.
const SAME_M_S: f64 = 0.15;
/// A velocity below this is none, in metres per second.
const STANDS_M_S: f64 = 0.05;

/// What is to be asked of the vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Order {
    /// Nothing new.
    Nothing,
    /// This.
    Give(VehicleCommand),
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

#[derive(Debug, Clone, Copy)]
struct Way {
    velocity: VelocityNed,
    goal: PositionNed,
}

/// One vehicle flown by velocity.
#[derive(Debug)]
pub struct Steering {
    valid_s: f64,
    fastest_m_s: f64,
    /// The last velocity: forward, left, up; and when it came.
    wanted: Option<(Vector3, f64)>,
    way: Option<Way>,
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
            way: None,
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
        self.way.is_some()
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
            Ok(velocity) => {
                self.report.taken += 1;
                self.wanted = Some((velocity, now_s));
            }
            // The one before it stays good until it expires.
            Err(refusal) => self.refuse(&refusal),
        }
    }

    /// The node refused what was asked last.
    pub fn refused(&mut self, refusal: &Refusal, now_s: f64) {
        self.refuse(refusal);
        self.way = None;
        self.not_before_s = now_s + AFTER_REFUSAL_S;
    }

    /// Somebody else has commanded the vehicle, or it flies otherwise: it is theirs.
    pub fn taken_over(&mut self, by: &str, now_s: f64) {
        if self.way.take().is_some() {
            self.report.reason = format!("taken over: {by}");
            self.silent_since_s = Some(now_s);
            self.wanted = None;
        }
    }

    fn refuse(&mut self, refusal: &Refusal) {
        self.report.refused += 1;
        self.report.reason = format!("{}: {refusal}", refusal.code());
    }

    /// What is to be asked now of the vehicle, which is here.
    pub fn decide(&mut self, here: Option<&VehicleKinematics>, now_s: f64) -> Order {
        let good = self.wanted.as_ref().filter(|(_, at_s)| now_s - at_s <= self.valid_s);
        let Some((body, _)) = good else {
            if self.wanted.take().is_some() && self.is_engaged() {
                self.report.reason = format!("no velocity for {:.1} s", self.valid_s);
            }
            return self.stop();
        };
        if body.x.hypot(body.y).hypot(body.z) < STANDS_M_S {
            return self.stop();
        }
        let Some(here) = here else { return Order::Nothing };
        let velocity = frames::velocity_from_level_body(body, here.yaw_rad);
        if now_s < self.not_before_s || !self.is_due(&velocity, here) {
            return Order::Nothing;
        }
        self.not_before_s = now_s + SOONEST_S;
        let goal = here.position.after(&velocity, AHEAD_S);
        self.way = Some(Way { velocity, goal });
        Order::Give(VehicleCommand::GoTo {
            position: goal,
            // It does not turn, so that forward stays where it is.
            yaw_rad: Some(here.yaw_rad),
            speed_m_s: Some(velocity.norm()),
        })
    }

    fn stop(&mut self) -> Order {
        match self.way.take() {
            Some(_) => Order::Give(VehicleCommand::Hold),
            None => Order::Nothing,
        }
    }

    /// Whether the way it is on is not the one wanted, or is about to end.
    fn is_due(&self, velocity: &VelocityNed, here: &VehicleKinematics) -> bool {
        let Some(way) = &self.way else { return true };
        let changed_m_s = (way.velocity.vector() - velocity.vector()).norm();
        let left_m = here.position.distance_m(&way.goal);
        changed_m_s > SAME_M_S || left_m < velocity.norm() * ANEW_WITH_LEFT_S
    }
}

#[cfg(test)]
mod tests;
