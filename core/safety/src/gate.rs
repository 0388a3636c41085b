//! The gate: one place that says yes or no to setpoints, goals, commands, formations and routes.

mod inside;

mod steer;

pub use steer::{Steered, Steering};

use crate::fence::Fences;
use serde::{Deserialize, Serialize};
use skein_domain::payload::Target;
use skein_domain::{AutopilotCommand, FlightMode, PositionNed, Refusal, Route, Setpoint, VehicleCommand, VelocityNed};
use thiserror::Error;

/// What no vehicle may exceed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Largest horizontal speed in metres per second.
    pub max_speed_m_s: f64,
    /// Largest climb rate in metres per second.
    pub max_climb_m_s: f64,
    /// Largest descent rate in metres per second.
    pub max_descent_m_s: f64,
    /// Smallest distance between two vehicles in the air in metres.
    pub min_separation_m: f64,
    /// How far ahead distances and the fence are looked at, in seconds.
    pub separation_horizon_s: f64,
}

/// A limit that is not usable.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{limit} = {value}: it must be a finite number, and not below zero; speeds must be above it")]
pub struct LimitsError {
    /// Which one.
    pub limit: &'static str,
    /// What was given.
    pub value: f64,
}

impl Limits {
    /// Whether every limit is a finite number above zero; separation and horizon may be zero, which turns the check of distances
    /// off.
    ///
    /// # Errors
    /// [`LimitsError`] with the first that is not. A gate made with such limits lets nothing pass that they should bound.
    pub fn check(&self) -> Result<(), LimitsError> {
        for (limit, value, may_be_zero) in [
            ("max_speed_m_s", self.max_speed_m_s, false),
            ("max_climb_m_s", self.max_climb_m_s, false),
            ("max_descent_m_s", self.max_descent_m_s, false),
            ("min_separation_m", self.min_separation_m, true),
            ("separation_horizon_s", self.separation_horizon_s, true),
        ] {
            let usable = value.is_finite() && (value > 0.0 || may_be_zero && value == 0.0);
            if !usable {
                return Err(LimitsError { limit, value });
            }
        }
        Ok(())
    }
}

/// Unless it is told otherwise no setpoint leads lower than this in flight, in metres above the ground.
const MIN_HEIGHT_M: f64 = 1.0;
/// Nothing is observed from further away.
const MAX_STAND_OFF_M: f64 = 10_000.0;
/// Rounding must not refuse what is exactly at a limit.
const ROUNDING: f64 = 1.0 + 1e-9;

/// The gate of one swarm: the same for all its vehicles.
#[derive(Debug, Clone, PartialEq)]
pub struct Gate {
    limits: Limits,
    fences: Fences,
    min_height_m: f64,
}

fn observation(
    target: &Target,
    stand_off_m: Option<f64>,
    height_m: Option<f64>,
    bearing_rad: Option<f64>,
) -> Result<(), Refusal> {
    if !bearing_rad.is_none_or(f64::is_finite) {
        return Err(Refusal::invalid("the bearing is not finite"));
    }
    let stand_off = stand_off_m.is_none_or(|v| v.is_finite() && (0.0..=MAX_STAND_OFF_M).contains(&v));
    let height = height_m.is_none_or(|v| v.is_finite() && v.abs() <= MAX_STAND_OFF_M);
    if !(stand_off && height) {
        return Err(Refusal::invalid(format!(
            "the stand-off must be 0 to {MAX_STAND_OFF_M} m, the height no more than that above or below"
        )));
    }
    finite_target(target)
}

fn finite_target(target: &Target) -> Result<(), Refusal> {
    match target {
        Target::Place { position } if !position.is_finite() => Err(Refusal::invalid("the target is not finite")),
        _ => Ok(()),
    }
}

impl Gate {
    /// A gate with these limits and fences: [`Fences`], one [`crate::Fence`], or `None`.
    #[must_use]
    pub fn new(limits: Limits, fences: impl Into<Fences>) -> Self {
        Self {
            limits,
            fences: fences.into(),
            min_height_m: MIN_HEIGHT_M,
        }
    }

    /// The same with another height above the ground below which no setpoint leads in flight, in metres.
    #[must_use]
    pub fn with_min_height(self, min_height_m: f64) -> Self {
        Self { min_height_m, ..self }
    }

    /// Height above the ground below which no setpoint leads in flight, in metres.
    #[must_use]
    pub fn min_height_m(&self) -> f64 {
        self.min_height_m
    }

    /// Its limits.
    #[must_use]
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Its fences.
    #[must_use]
    pub fn fences(&self) -> &Fences {
        &self.fences
    }

    /// The same setpoint with its velocity brought within the speed limits, each axis group on its own and without turning it: what
    /// may be tried instead of one that was refused as too fast. It has to pass the gate like any other.
    #[must_use]
    pub fn slowed(&self, setpoint: &Setpoint) -> Setpoint {
        let Some(velocity) = setpoint.velocity else {
            return *setpoint;
        };
        let horizontal_m_s = velocity.north_m_s.hypot(velocity.east_m_s);
        let share = if horizontal_m_s > self.limits.max_speed_m_s {
            self.limits.max_speed_m_s / horizontal_m_s
        } else {
            1.0
        };
        let velocity = VelocityNed {
            north_m_s: velocity.north_m_s * share,
            east_m_s: velocity.east_m_s * share,
            down_m_s: velocity
                .down_m_s
                .clamp(-self.limits.max_climb_m_s, self.limits.max_descent_m_s),
        };
        Setpoint {
            velocity: Some(velocity),
            ..*setpoint
        }
    }

    /// Whether a place may be flown to.
    ///
    /// # Errors
    /// The typed reason.
    pub fn goal(&self, position: &PositionNed) -> Result<(), Refusal> {
        if !position.is_finite() {
            return Err(Refusal::invalid("the position is not finite"));
        }
        self.fences.contains(position)
    }

    /// How far below the swarm's origin a vehicle is let fly at most, in metres, over ground that is `ground_down_m` below it.
    #[must_use]
    pub fn lowest_down_m(&self, ground_down_m: f64) -> f64 {
        ground_down_m - self.min_height_m
    }

    /// Whether a place is as high as a vehicle is let fly over ground that is `ground_down_m` below the swarm's origin.
    ///
    /// # Errors
    /// It is lower.
    pub fn height(&self, position: &PositionNed, ground_down_m: f64) -> Result<(), Refusal> {
        let (height_m, least_m) = (ground_down_m - position.down_m, self.min_height_m);
        if height_m >= least_m {
            return Ok(());
        }
        let detail = format!("a place {height_m:.1} m over the ground: nobody is flown lower than {least_m:.1} m");
        Err(Refusal::InvalidValue { detail })
    }

    /// Whether an operator's command makes sense and stays within the limits. `ground` is where the vehicle stands or was launched,
    /// if known; with a fence a take-off needs it.
    ///
    /// # Errors
    /// The typed reason.
    pub fn command(&self, command: &VehicleCommand, ground: Option<&PositionNed>) -> Result<(), Refusal> {
        match command {
            VehicleCommand::TakeOff { height_m } => {
                take_off_height(*height_m)?;
                match ground {
                    _ if self.fences.is_empty() => Ok(()),
                    None => Err(Refusal::NoPosition),
                    Some(ground) => self.take_off_in_fences(ground, *height_m),
                }
            }
            VehicleCommand::LandAt { spot } => {
                if !spot.is_finite() {
                    return Err(Refusal::invalid("the landing spot is not finite"));
                }
                self.fences.landing(spot)
            }
            VehicleCommand::GoTo {
                position,
                yaw_rad,
                speed_m_s,
            } => {
                if !yaw_rad.is_none_or(f64::is_finite) {
                    return Err(Refusal::invalid("the yaw is not finite"));
                }
                speed_m_s.map_or(Ok(()), |speed| self.cruise_speed(speed))?;
                self.goal(position)
            }
            VehicleCommand::Observe {
                target,
                stand_off_m,
                height_m,
                bearing_rad,
            } => observation(target, *stand_off_m, *height_m, *bearing_rad),
            VehicleCommand::LookAt { target } => finite_target(target),
            VehicleCommand::Arm
            | VehicleCommand::StopObserving
            // Where it leads is looked at setpoint by setpoint.
            | VehicleCommand::Steer
            | VehicleCommand::Disarm
            | VehicleCommand::Land
            | VehicleCommand::Hold
            | VehicleCommand::Return => Ok(()),
        }
    }

    /// Whether the autopilot may be asked for this. In the air neither disarming nor a take-off is; OFFBOARD and ending the flight
    /// are not modes to be set by hand.
    ///
    /// # Errors
    /// The typed reason.
    pub fn autopilot(&self, command: &AutopilotCommand, airborne: bool) -> Result<(), Refusal> {
        let not_permitted = |detail: &str| Err(Refusal::not_permitted(detail));
        match command {
            AutopilotCommand::Disarm if airborne => not_permitted("disarm in the air"),
            AutopilotCommand::TakeOff { .. } if airborne => not_permitted("take off in the air"),
            AutopilotCommand::TakeOff { height_m } => take_off_height(*height_m),
            AutopilotCommand::SetMode {
                mode: FlightMode::Offboard,
            } => not_permitted("OFFBOARD is entered with its setpoint stream only"),
            AutopilotCommand::SetMode {
                mode: FlightMode::Termination,
            } => not_permitted("end the flight"),
            AutopilotCommand::SetMode {
                mode: FlightMode::Unknown,
            } => Err(Refusal::invalid("the mode is not known")),
            AutopilotCommand::EmergencyStop => not_permitted("stop the motors"),
            AutopilotCommand::Arm
            | AutopilotCommand::Disarm
            | AutopilotCommand::Land
            | AutopilotCommand::ReturnToLaunch
            | AutopilotCommand::SetMode { .. }
            | AutopilotCommand::EnterOffboard => Ok(()),
        }
    }

    /// Whether a formation of this spacing keeps the vehicles apart.
    ///
    /// # Errors
    /// The typed reason.
    pub fn formation(&self, spacing_m: f64) -> Result<(), Refusal> {
        // Nearer than that the separation filter would push them out of their places.
        let least_m = self.limits.min_separation_m + 2.0 * self.avoidance().noise_m;
        if spacing_m.is_finite() && spacing_m >= least_m {
            return Ok(());
        }
        let detail = format!(
            "{spacing_m:.1} m between two places: at least {least_m:.1} m is needed (the smallest separation, and room for errors of position)"
        );
        Err(Refusal::InvalidValue { detail })
    }

    /// Whether a route's waypoints, the legs between them and its speed stay within the limits. Where it starts is not known here:
    /// see [`Self::route_from`].
    ///
    /// # Errors
    /// The typed reason.
    pub fn route(&self, route: &Route) -> Result<(), Refusal> {
        if route.waypoints.is_empty() {
            return Err(Refusal::invalid("a route needs at least one waypoint"));
        }
        if !(route.corner_radius_m >= 0.0 && route.corner_radius_m.is_finite()) {
            return Err(Refusal::invalid("the corner radius must be zero or above"));
        }
        self.cruise_speed(route.speed_m_s)?;
        for waypoint in &route.waypoints {
            self.goal(waypoint)?;
        }
        for (from, to) in route.waypoints.iter().zip(route.waypoints.iter().skip(1)) {
            self.fences.contains_way(from, to)?;
        }
        Ok(())
    }

    /// The same together with the way to the first waypoint.
    ///
    /// # Errors
    /// The typed reason.
    pub fn route_from(&self, start: &PositionNed, route: &Route) -> Result<(), Refusal> {
        self.route(route)?;
        let first = route.waypoints.first();
        first.map_or(Ok(()), |first| self.fences.contains_way(start, first))
    }

    fn cruise_speed(&self, speed_m_s: f64) -> Result<(), Refusal> {
        if !(speed_m_s > 0.0 && speed_m_s.is_finite()) {
            return Err(Refusal::invalid("the speed must be above zero"));
        }
        within(speed_m_s, self.limits.max_speed_m_s)
    }

    fn velocity(&self, velocity: &VelocityNed) -> Result<(), Refusal> {
        within(velocity.north_m_s.hypot(velocity.east_m_s), self.limits.max_speed_m_s)?;
        within(-velocity.down_m_s, self.limits.max_climb_m_s)?;
        within(velocity.down_m_s, self.limits.max_descent_m_s)
    }
}

fn take_off_height(height_m: f64) -> Result<(), Refusal> {
    if height_m > 0.0 && height_m.is_finite() {
        Ok(())
    } else {
        Err(Refusal::invalid("the take-off height must be above zero"))
    }
}

fn within(speed_m_s: f64, limit_m_s: f64) -> Result<(), Refusal> {
    // Written so that a limit that is not a number lets nothing pass.
    if speed_m_s <= limit_m_s * ROUNDING {
        Ok(())
    } else {
        Err(Refusal::TooFast { speed_m_s, limit_m_s })
    }
}

#[cfg(test)]
mod tests;
