//! Flights by hand: the reference goes where the stick points, by the limits of any flight, and stands while there is no stick.
//!
//! Must never do: follow a stick that is older than it is good for, move the reference faster than the limits, or lead a formation faster
//! than its followers can swing round.

use crate::blend::Motion;
use crate::flight::{ActiveCommand, Flying, Lead, Phase, Plan, Purpose, Steered};
use crate::guidance::towards;
use crate::keeping::YAW_RATE_RAD_S;
use crate::model::GenericUav;
use crate::settings::Settings;
use nalgebra::Vector3;
use skein_domain::frames::wrap_angle_rad;
use skein_domain::stick::{HAND_GONE_S, STICK_GOOD_S};
use skein_domain::{FormationHeading, NodeTime, Stick, VehicleCommand};
use skein_plugin_sdk::Effects;

/// How long turning takes to come to its full rate, in seconds.
const TURN_RAMP_S: f64 = 0.4;
/// The same for a formation, whose outermost vehicles have to swing round.
const FORMATION_RAMP_S: f64 = 1.0;
/// A reference that is moved on by hand is no farther ahead of the vehicle than this, in metres, and what is flown in so many seconds at its
/// speed. Beyond that something holds the vehicle back, as a fence does.
const LEASH_M: f64 = 1.5;
const LEASH_S: f64 = 0.3;
/// The share of it that is left when the stick does not ask to go on: it is felt at once that it was let go or turned round.
const BACK_SHARE: f64 = 0.4;
/// A reference that is slower than this stands, in metres per second.
const STANDS_M_S: f64 = 0.3;

/// What a flight by hand may ask for at most.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    speed_m_s: f64,
    turn_rad_s: f64,
    ramp_s: f64,
}

impl GenericUav {
    /// The flight by hand begins, with the vehicle as it is. Who leads a formation leads it on; its route is over.
    pub(crate) fn begin_steering(&mut self, out: &mut Effects) {
        self.stick = None;
        let steered = Steered {
            heard: self.now,
            yaw_rate_rad_s: 0.0,
        };
        if let Phase::Flying(flying) = &self.flight.phase
            && flying.engaging.is_none()
            && let Purpose::Lead(lead) = &flying.purpose
        {
            let had_a_way = lead.route.is_some() && !lead.finished;
            let purpose = Purpose::Lead(Lead {
                steered: Some(steered),
                finished: true,
                ..lead.clone()
            });
            let flying = Flying {
                purpose,
                ..flying.clone()
            };
            if had_a_way {
                out.route_finished();
            }
            self.lay_out(flying, "by hand", out);
        } else {
            self.fly(Purpose::Steer(steered), None, "by hand", out);
        }
    }

    /// A stick came in. In a flight that is not by hand it is nobody's.
    pub(crate) fn take_stick(&mut self, stick: &Stick) {
        let now = self.now;
        if stick.check().is_ok()
            && self.is_steered_by_command()
            && let Phase::Flying(flying) = &mut self.flight.phase
            && let Some(steered) = flying.purpose.steered_mut()
        {
            steered.heard = now;
            self.stick = Some((*stick, now));
        }
    }

    /// Whether the command being carried out is to be steered.
    fn is_steered_by_command(&self) -> bool {
        matches!(
            self.flight.command,
            Some(ActiveCommand {
                command: VehicleCommand::Steer,
                ..
            })
        )
    }

    /// The stick, as long as it is good.
    fn good_stick(&self) -> Option<&Stick> {
        let (stick, at) = self.stick.as_ref()?;
        (0.0..=STICK_GOOD_S)
            .contains(&self.now.seconds_since(*at))
            .then_some(stick)
    }

    /// Moves the reference on by a period, as the stick says; without one it comes to a stand. What is held back stays where it is.
    pub(crate) fn step_steering(&self, flying: &mut Flying, dt_s: f64, held_back: bool) {
        let Some(bounds) = self.bounds_by_hand(&flying.purpose) else {
            return;
        };
        let stick = self.good_stick().filter(|_| !held_back);
        let heading_rad = flying.turn_by_hand(stick, &bounds, dt_s, held_back);
        if held_back {
            return;
        }
        let Plan::Guided {
            position,
            velocity,
            acceleration,
        } = &mut flying.plan
        else {
            return;
        };
        let wanted = stick.zip(heading_rad).map_or(Vector3::zeros(), |(stick, heading_rad)| {
            bounded(stick.velocity(heading_rad).vector(), bounds.speed_m_s, &self.settings)
        });
        let have = Motion::new(*position, *velocity, *acceleration);
        let next = towards(&have, wanted, dt_s, self.settings.acceleration_m_s2);
        // What was measured, and is gone on from, may be a little faster than what may be asked for.
        let within = bounded(next.velocity.vector(), self.settings.max_speed_m_s, &self.settings);
        (*position, *velocity, *acceleration) = (next.position, within.into(), next.acceleration);
    }

    /// Whether the vehicle does not come after the reference that a stick moves on.
    pub(crate) fn has_run_ahead(&self, flying: &Flying) -> bool {
        let (Plan::Guided { position, velocity, .. }, Some(here)) = (&flying.plan, self.measured()) else {
            return false;
        };
        let (ahead, velocity) = (position.vector() - here.position.vector(), velocity.vector());
        let runs = velocity.norm() > STANDS_M_S && ahead.dot(&velocity) > 0.0;
        if flying.purpose.steered().is_none() || !runs {
            return false;
        }
        let heading_rad = flying.yaw(None).0.unwrap_or_default();
        let asked = self.good_stick().map(|stick| stick.velocity(heading_rad).vector());
        let goes_on = asked.is_some_and(|asked| asked.dot(&ahead) > 0.0);
        let share = if goes_on { 1.0 } else { BACK_SHARE };
        ahead.norm() > share * (LEASH_M + LEASH_S * velocity.norm())
    }

    /// Whether nobody steers the vehicle any more: then it holds. Who leads a formation stands and leads it.
    pub(crate) fn see_whether_let_go(&mut self, flying: Flying, out: &mut Effects) {
        let quiet_s = flying.purpose.steered().map(|s| self.now.seconds_since(s.heard));
        if !quiet_s.is_some_and(|quiet_s| quiet_s > HAND_GONE_S) || !self.is_steered_by_command() {
            return;
        }
        self.command_done(out);
        if matches!(flying.purpose, Purpose::Steer(_)) {
            let purpose = Purpose::Hold { at: None };
            self.lay_out(Flying { purpose, ..flying }, "", out);
        } else {
            self.flight.detail.clear();
        }
    }

    fn bounds_by_hand(&self, purpose: &Purpose) -> Option<Bounds> {
        let settings = &self.settings;
        match purpose {
            Purpose::Steer(_) => Some(Bounds {
                speed_m_s: settings.max_speed_m_s,
                turn_rad_s: YAW_RATE_RAD_S,
                ramp_s: TURN_RAMP_S,
            }),
            // Its followers have to catch up with what it does.
            Purpose::Lead(lead) if lead.steered.is_some() => Some(Bounds {
                speed_m_s: settings.cruise_speed_m_s.min(settings.max_speed_m_s),
                turn_rad_s: lead.fastest_turn_rad_s(settings),
                ramp_s: FORMATION_RAMP_S,
            }),
            _ => None,
        }
    }
}

/// A velocity within the limits.
fn bounded(asked: Vector3<f64>, speed_m_s: f64, settings: &Settings) -> Vector3<f64> {
    let level = Vector3::new(asked.x, asked.y, 0.0).cap_magnitude(speed_m_s);
    let down_m_s = asked.z.clamp(-settings.climb_m_s, settings.descent_m_s);
    Vector3::new(level.x, level.y, down_m_s)
}

impl Flying {
    /// Turns the nose, or the formation, for one period; where it looks then, if that is known.
    fn turn_by_hand(&mut self, stick: Option<&Stick>, bounds: &Bounds, dt_s: f64, held_back: bool) -> Option<f64> {
        let most = bounds.turn_rad_s;
        let asked = stick.map_or(0.0, |stick| stick.yaw_rate_rad_s.clamp(-most, most));
        let ramp = most / bounds.ramp_s * dt_s;
        let turned = |rate_rad_s: f64| {
            if held_back {
                0.0
            } else {
                rate_rad_s + (asked - rate_rad_s).clamp(-ramp, ramp)
            }
        };
        match &mut self.purpose {
            Purpose::Steer(steered) => {
                steered.yaw_rate_rad_s = turned(steered.yaw_rate_rad_s);
                let yaw_rad = self.yaw_rad.as_mut()?;
                *yaw_rad = wrap_angle_rad(*yaw_rad + steered.yaw_rate_rad_s * dt_s);
                Some(*yaw_rad)
            }
            Purpose::Lead(lead) => {
                lead.heading_rate_rad_s = turned(lead.heading_rate_rad_s);
                lead.heading_rad = wrap_angle_rad(lead.heading_rad + lead.heading_rate_rad_s * dt_s);
                Some(lead.heading_rad)
            }
            _ => None,
        }
    }
}

impl Purpose {
    /// The flight by hand, if it is one.
    pub(crate) fn steered(&self) -> Option<&Steered> {
        match self {
            Self::Steer(steered) => Some(steered),
            Self::Lead(lead) => lead.steered.as_ref(),
            _ => None,
        }
    }

    /// The vehicle obeys from now on: whoever steers has all the time from here.
    pub(crate) fn steered_from_here(&mut self, now: NodeTime) {
        if let Some(steered) = self.steered_mut() {
            steered.heard = now;
        }
    }

    fn steered_mut(&mut self) -> Option<&mut Steered> {
        match self {
            Self::Steer(steered) => Some(steered),
            Self::Lead(lead) => lead.steered.as_mut(),
            _ => None,
        }
    }
}

impl Lead {
    /// How fast the formation may be turned: as the coordinator has it for its outermost vehicle.
    fn fastest_turn_rad_s(&self, settings: &Settings) -> f64 {
        let most = match self.heading {
            FormationHeading::Course { max_rate_rad_s } => max_rate_rad_s,
            FormationHeading::Fixed { max_rate_rad_s, .. } => max_rate_rad_s
                .unwrap_or(settings.heading_rate_rad_s)
                .min(settings.heading_rate_rad_s),
        };
        if most.is_finite() {
            most.clamp(0.0, YAW_RATE_RAD_S)
        } else {
            0.0
        }
    }
}
