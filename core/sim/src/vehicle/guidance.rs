//! The automatic modes: take-off, hold, land, return, and what a pilot with centred sticks would do. Each gives the
//! position controller a smooth target, with PX4's default speeds.

use super::estimator::Estimate;
use super::position_control::Target;
use nalgebra::{Vector2, Vector3};
use skein_domain::FlightMode;

/// Speeds and heights, from the parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GuidanceLimits {
    /// Horizontal speed of the automatic modes in metres per second.
    pub cruise_m_s: f64,
    /// Climb in metres per second.
    pub up_m_s: f64,
    /// Descent far above the ground in metres per second.
    pub down_m_s: f64,
    /// Climb during take-off in metres per second.
    pub take_off_m_s: f64,
    /// Descent near the ground in metres per second.
    pub land_m_s: f64,
    /// Descent just above the ground in metres per second.
    pub crawl_m_s: f64,
    /// Height above home from which the descent is slowed down, in metres.
    pub slow_from_m: f64,
    /// Height above home below which it is slowest, in metres.
    pub slow_below_m: f64,
    /// Height above home of the way back, in metres.
    pub return_height_m: f64,
    /// Horizontal acceleration in metres per second squared.
    pub acceleration_m_s2: f64,
    /// Jerk in metres per second cubed.
    pub jerk_m_s3: f64,
}

/// Largest vertical acceleration of the automatic modes in metres per second squared.
const VERTICAL_ACCELERATION_M_S2: f64 = 3.5;
/// A take-off counts as done this far below its height, in metres.
const TAKE_OFF_DONE_M: f64 = 0.73;
/// Below this height a distance sensor sees the ground and the landing crawls, in metres.
const CRAWL_BELOW_M: f64 = 1.05;

/// Where the guidance wants to be.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Goal {
    Nothing,
    TakeOff { down_m: f64 },
    Hold { place: Vector3<f64>, speed_m_s: f64 },
    Land { spot: Vector2<f64> },
    Return { leg: ReturnLeg, turn: Vector3<f64> },
    Level { down_m: f64 },
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum ReturnLeg {
    Climb,
    Home,
    Down,
}

/// The guidance of the automatic modes.
#[derive(Debug, Clone)]
pub(crate) struct Guidance {
    goal: Goal,
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    acceleration: Vector3<f64>,
    yaw_rad: f64,
}

impl Guidance {
    pub(crate) fn new(now: &Estimate) -> Self {
        Self {
            goal: Goal::Nothing,
            position: now.position,
            velocity: Vector3::zeros(),
            acceleration: Vector3::zeros(),
            yaw_rad: now.yaw_rad,
        }
    }

    /// A mode begins: plan from where the vehicle is.
    pub(crate) fn enter(&mut self, mode: FlightMode, now: &Estimate, home: &Vector3<f64>, limits: &GuidanceLimits) {
        let after_take_off = match (self.goal, mode) {
            (Goal::TakeOff { down_m }, FlightMode::Hold) => Some(down_m),
            _ => None,
        };
        if after_take_off.is_none() {
            self.restart(now);
        }
        let stop = stopping_place(now, limits);
        self.goal = match mode {
            FlightMode::TakeOff => self.goal_of_take_off(now),
            FlightMode::Land => Goal::Land { spot: stop.xy() },
            FlightMode::Return => {
                let height = (home.z - limits.return_height_m).min(now.position.z);
                Goal::Return {
                    leg: ReturnLeg::Climb,
                    turn: Vector3::new(stop.x, stop.y, height),
                }
            }
            FlightMode::Altitude | FlightMode::Stabilized | FlightMode::Manual | FlightMode::Acro => {
                Goal::Level { down_m: stop.z }
            }
            FlightMode::Descend => Goal::Level { down_m: f64::NAN },
            FlightMode::Offboard | FlightMode::Termination | FlightMode::Unknown => Goal::Nothing,
            _ => {
                let place = match after_take_off {
                    Some(down_m) => Vector3::new(self.position.x, self.position.y, down_m),
                    None => stop,
                };
                Goal::Hold {
                    place,
                    speed_m_s: limits.cruise_m_s,
                }
            }
        };
    }

    fn goal_of_take_off(&self, now: &Estimate) -> Goal {
        match self.goal {
            keep @ Goal::TakeOff { .. } => keep,
            _ => Goal::TakeOff { down_m: now.position.z },
        }
    }

    fn restart(&mut self, now: &Estimate) {
        self.position = now.position;
        self.velocity = now.velocity;
        self.acceleration = Vector3::zeros();
        self.yaw_rad = now.yaw_rad;
    }

    /// How high the next take-off goes: the down coordinate in metres.
    pub(crate) fn set_take_off(&mut self, down_m: f64) {
        self.goal = Goal::TakeOff { down_m };
    }

    /// The down coordinate of the take-off under way.
    pub(crate) fn take_off_down_m(&self) -> Option<f64> {
        match self.goal {
            Goal::TakeOff { down_m } => Some(down_m),
            _ => None,
        }
    }

    /// Go there and hold; NaN parts stay as they are.
    pub(crate) fn set_hold(&mut self, place: Vector3<f64>, yaw_rad: f64, speed_m_s: f64) {
        if let Goal::Hold {
            place: old,
            speed_m_s: old_speed,
        } = self.goal
        {
            let place = Vector3::from_fn(|i, _| if place[i].is_finite() { place[i] } else { old[i] });
            let speed_m_s = if speed_m_s > 0.0 { speed_m_s } else { old_speed };
            self.goal = Goal::Hold { place, speed_m_s };
        }
        if yaw_rad.is_finite() {
            self.yaw_rad = yaw_rad;
        }
    }

    /// Whether the take-off has come near enough to its height.
    pub(crate) fn take_off_done(&self, now: &Estimate) -> bool {
        matches!(self.goal, Goal::TakeOff { down_m } if now.position.z - down_m < TAKE_OFF_DONE_M)
    }

    /// Whether it now means to go down to the ground.
    pub(crate) fn is_landing(&self) -> bool {
        matches!(
            self.goal,
            Goal::Land { .. }
                | Goal::Return {
                    leg: ReturnLeg::Down,
                    ..
                }
        ) || matches!(self.goal, Goal::Level { down_m } if down_m.is_nan())
    }

    /// The motors have lifted it off: begin from here.
    pub(crate) fn lift_off(&mut self, now: &Estimate) {
        self.restart(now);
        self.velocity = Vector3::zeros();
    }

    /// One step. `take_off_m_s` bounds the climb while the motors are still being run up.
    pub(crate) fn step(
        &mut self,
        now: &Estimate,
        home: &Vector3<f64>,
        limits: &GuidanceLimits,
        take_off_m_s: f64,
        dt_s: f64,
    ) -> Target {
        let wanted = match self.goal {
            Goal::Nothing => return Target::NONE,
            Goal::Level { down_m } => return level(down_m, self.yaw_rad, limits),
            Goal::TakeOff { down_m } => {
                let left = (self.position.z - down_m).max(0.0);
                Vector3::new(0.0, 0.0, -(0.45 + 0.45 * left).min(take_off_m_s))
            }
            Goal::Hold { place, speed_m_s } => self.towards(&place, speed_m_s, limits),
            Goal::Land { spot } => {
                let place = Vector3::new(spot.x, spot.y, self.position.z);
                let mut wanted = self.towards(&place, limits.cruise_m_s, limits);
                wanted.z = descent_m_s(now, home, limits);
                wanted
            }
            Goal::Return { leg, turn } => self.return_home(leg, turn, now, home, limits),
        };
        self.follow(wanted, limits, dt_s);
        Target {
            position: self.position,
            velocity: self.velocity,
            acceleration: self.acceleration,
            yaw_rad: self.yaw_rad,
            yaw_rate_rad_s: f64::NAN,
        }
    }

    fn return_home(
        &mut self,
        leg: ReturnLeg,
        turn: Vector3<f64>,
        now: &Estimate,
        home: &Vector3<f64>,
        limits: &GuidanceLimits,
    ) -> Vector3<f64> {
        let above_home = Vector3::new(home.x, home.y, turn.z);
        match leg {
            ReturnLeg::Climb => {
                if (now.position.z - turn.z).abs() < 0.8 {
                    self.goal = Goal::Return {
                        leg: ReturnLeg::Home,
                        turn,
                    };
                    let way = home.xy() - now.position.xy();
                    if way.norm() > 1.0 {
                        self.yaw_rad = way.y.atan2(way.x);
                    }
                }
                self.towards(&turn, limits.cruise_m_s, limits)
            }
            ReturnLeg::Home => {
                if (now.position.xy() - home.xy()).norm() < 0.5 {
                    self.goal = Goal::Return {
                        leg: ReturnLeg::Down,
                        turn,
                    };
                }
                self.towards(&above_home, limits.cruise_m_s, limits)
            }
            ReturnLeg::Down => {
                let mut wanted = self.towards(&above_home, limits.cruise_m_s, limits);
                wanted.z = descent_m_s(now, home, limits);
                wanted
            }
        }
    }

    /// The velocity that leads to a place and comes to rest there.
    fn towards(&self, place: &Vector3<f64>, cruise_m_s: f64, limits: &GuidanceLimits) -> Vector3<f64> {
        let way = place - self.position;
        let level = way.xy();
        let distance = level.norm();
        let speed = speed_from_distance(distance, limits.acceleration_m_s2, limits.jerk_m_s3).min(cruise_m_s);
        let level = if distance > 1e-6 {
            level * (speed / distance)
        } else {
            Vector2::zeros()
        };
        let vertical = speed_from_distance(way.z.abs(), VERTICAL_ACCELERATION_M_S2, limits.jerk_m_s3);
        let vertical = if way.z < 0.0 {
            -vertical.min(limits.up_m_s)
        } else {
            vertical.min(limits.down_m_s)
        };
        Vector3::new(level.x, level.y, vertical)
    }

    /// Moves the smooth target: velocity towards `wanted`, acceleration and jerk bounded.
    fn follow(&mut self, wanted: Vector3<f64>, limits: &GuidanceLimits, dt_s: f64) {
        for axis in 0..3 {
            let bound = if axis == 2 {
                VERTICAL_ACCELERATION_M_S2
            } else {
                limits.acceleration_m_s2
            };
            let acceleration = ((wanted[axis] - self.velocity[axis]) * 3.0).clamp(-bound, bound);
            let jerk = limits.jerk_m_s3 * 2.0 * dt_s;
            self.acceleration[axis] += (acceleration - self.acceleration[axis]).clamp(-jerk, jerk);
            let before = self.velocity[axis];
            self.velocity[axis] += self.acceleration[axis] * dt_s;
            self.position[axis] += 0.5 * (before + self.velocity[axis]) * dt_s;
        }
    }
}

/// Centred sticks without position control: level, at the height it has; NaN = descend.
fn level(down_m: f64, yaw_rad: f64, limits: &GuidanceLimits) -> Target {
    let mut target = Target::NONE;
    target.acceleration = Vector3::new(0.0, 0.0, f64::NAN);
    if down_m.is_finite() {
        target.position.z = down_m;
    } else {
        target.velocity.z = limits.land_m_s;
    }
    target.yaw_rad = yaw_rad;
    target
}

/// Where it would come to rest when it brakes now.
fn stopping_place(now: &Estimate, limits: &GuidanceLimits) -> Vector3<f64> {
    let brake = |v: f64, a: f64| v * v.abs() / (2.0 * a) + 0.3 * v;
    Vector3::new(
        now.position.x + brake(now.velocity.x, limits.acceleration_m_s2),
        now.position.y + brake(now.velocity.y, limits.acceleration_m_s2),
        now.position.z + brake(now.velocity.z, VERTICAL_ACCELERATION_M_S2),
    )
}

/// The speed from which one can still come to rest over a distance with this acceleration and jerk.
fn speed_from_distance(distance_m: f64, acceleration_m_s2: f64, jerk_m_s3: f64) -> f64 {
    let b = 4.0 * acceleration_m_s2 * acceleration_m_s2 / jerk_m_s3;
    0.5 * ((b * b + 8.0 * acceleration_m_s2 * distance_m).sqrt() - b)
}

/// Descent of a landing at this height.
fn descent_m_s(now: &Estimate, home: &Vector3<f64>, limits: &GuidanceLimits) -> f64 {
    if now.height_m < CRAWL_BELOW_M {
        return limits.crawl_m_s;
    }
    let above_home = home.z - now.position.z;
    let span = (limits.slow_from_m - limits.slow_below_m).max(0.1);
    let share = ((above_home - limits.slow_below_m) / span).clamp(0.0, 1.0);
    limits.land_m_s + (limits.down_m_s - limits.land_m_s) * share
}
