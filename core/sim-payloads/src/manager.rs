//! Who may steer a gimbal, and what it was told: the gimbal manager as PX4 has it (1.18 development; `src/modules/gimbal`). Only
//! whoever took primary control is obeyed; a region of interest is the vehicle's own business and obeyed whoever asked for it.
//!
//! Its oddities are PX4's too: the lock alone says in which frame a yaw is given, retracting is heard and not done, rates end when they
//! are not repeated, and what it turns by servos has a slow rate and an attitude that is only what was asked for.
//!
//! Must never do: obey somebody who is not in control.

use super::gimbal::{AxisGoal, GimbalOutput, GimbalSettings, Head};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use skein_domain::Geodetic;
use skein_domain::frames::wrap_angle_rad;

/// Flags of the manager that matter here; those of the device have the same values.
pub mod flags {
    /// Retracted: PX4 does not do it.
    pub const RETRACT: u32 = 1;
    /// Level and ahead.
    pub const NEUTRAL: u32 = 2;
    /// Roll and pitch count from the horizon: this head does nothing else.
    pub const ROLL_LOCK: u32 = 4;
    /// See `ROLL_LOCK`.
    pub const PITCH_LOCK: u32 = 8;
    /// Yaw stays where it is when the vehicle turns.
    pub const YAW_LOCK: u32 = 16;
    /// The yaw given counts from the vehicle's nose.
    pub const YAW_IN_VEHICLE_FRAME: u32 = 32;
    /// The yaw given counts from north.
    pub const YAW_IN_EARTH_FRAME: u32 = 64;
}

/// Rates that nobody repeats end after this time, in seconds.
const RATES_LAST_S: f64 = 2.0;
/// PX4 filters the angles of servos (MNT_TAU 0.3 s, every 0.01 s) and integrates a rate behind its own filter: this share of it is left.
const SERVO_RATE_SHARE: f64 = 0.01 / (0.01 + 0.3);

/// A system and one of its components.
pub type Party = (u8, u8);

/// What is asked of a gimbal. What is not a number is left as it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Asked {
    /// Angles in radians.
    pub pitch_rad: f64,
    /// See `pitch_rad`.
    pub yaw_rad: f64,
    /// Rates in radians per second; an angle goes before a rate.
    pub pitch_rad_s: f64,
    /// See `pitch_rad_s`.
    pub yaw_rad_s: f64,
    /// The manager's flags.
    pub flags: u32,
}

impl Asked {
    /// From a quaternion (w, x, y, z) and an angular velocity.
    pub fn from_attitude(q: [f32; 4], velocity_rad_s: [f32; 3], flags: u32) -> Self {
        let [w, x, y, z] = q.map(f64::from);
        let [_, pitch_rad_s, yaw_rad_s] = velocity_rad_s.map(f64::from);
        let (pitch_rad, yaw_rad) =
            UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-3).map_or((f64::NAN, f64::NAN), |turn| {
                let (_, pitch_rad, yaw_rad) = turn.euler_angles();
                (pitch_rad, yaw_rad)
            });
        Self {
            pitch_rad,
            yaw_rad,
            pitch_rad_s,
            yaw_rad_s,
            flags,
        }
    }
}

/// Where the head is to point.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Aim {
    /// Level and ahead.
    Rest,
    /// Each axis for itself; with `lock` the yaw counts from north, else from the vehicle's nose.
    Axes {
        pitch: AxisGoal,
        yaw: AxisGoal,
        lock: bool,
        pitch_lock: bool,
    },
    /// At a place on Earth.
    Place(Geodetic),
}

/// How the vehicle that carries it turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Carrier {
    /// Radians, clockwise from north.
    pub yaw_rad: f64,
    /// Radians per second.
    pub yaw_rate_rad_s: f64,
}

/// A gimbal and its manager.
#[derive(Debug, Clone, PartialEq)]
pub struct Gimbal {
    /// The head.
    pub head: Head,
    /// Who has primary control; zeros: nobody.
    pub owner: Party,
    aim: Aim,
    /// Pitch and yaw as last asked for, in radians.
    asked_rad: (f64, f64),
    /// How long nobody asked for anything, in seconds.
    unasked_s: f64,
}

impl Gimbal {
    /// At rest, steered by nobody.
    pub fn new(settings: GimbalSettings) -> Self {
        Self {
            head: Head::new(settings),
            owner: (0, 0),
            aim: Aim::Rest,
            asked_rad: (0.0, 0.0),
            unasked_s: 0.0,
        }
    }

    /// The manager starts anew: it has forgotten who was in control and what was asked.
    pub fn restart_manager(&mut self) {
        self.owner = (0, 0);
        self.rest();
    }

    /// Primary control is given: -1 leaves it, -2 the vehicle itself, -3 gives it back if the asking party has it; else an id.
    pub fn configure(&mut self, by: Party, asked: (f32, f32), autopilot: Party) {
        let pick = |asked: f32, now: u8, by: u8, own: u8| {
            let asked = asked.round();
            if asked == -2.0 {
                own
            } else if asked == -3.0 && now == by {
                0
            } else if (0.0..256.0).contains(&asked) {
                asked as u8
            } else {
                now
            }
        };
        self.owner = (
            pick(asked.0, self.owner.0, by.0, autopilot.0),
            pick(asked.1, self.owner.1, by.1, autopilot.1),
        );
    }

    /// Does what is asked, if whoever asks is in control.
    pub fn ask(&mut self, by: Party, asked: &Asked, carrier: &Carrier) -> bool {
        if by != self.owner || by == (0, 0) {
            return false;
        }
        self.unasked_s = 0.0;
        if asked.flags & flags::RETRACT != 0 {
            return true;
        }
        if asked.flags & flags::NEUTRAL != 0 {
            self.rest();
            return true;
        }
        let lock = asked.flags & flags::YAW_LOCK != 0;
        let axis = |angle_rad: f64, rate_rad_s: f64, held_rad: f64| {
            if angle_rad.is_finite() {
                AxisGoal::Angle(angle_rad)
            } else if rate_rad_s.is_finite() {
                AxisGoal::Rate(rate_rad_s)
            } else {
                AxisGoal::Angle(held_rad)
            }
        };
        let yaw_now_rad = if lock {
            self.yaw_north_rad(carrier)
        } else {
            self.head.yaw.angle_rad
        };
        let known = |asked_rad: f64, before_rad: f64| if asked_rad.is_finite() { asked_rad } else { before_rad };
        self.asked_rad = (
            known(asked.pitch_rad, self.asked_rad.0),
            known(asked.yaw_rad, self.asked_rad.1),
        );
        let (mut pitch, mut yaw) = (
            axis(asked.pitch_rad, asked.pitch_rad_s, self.head.pitch.angle_rad),
            axis(wrap_angle_rad(asked.yaw_rad), asked.yaw_rad_s, yaw_now_rad),
        );
        if matches!(self.head.settings.output, GimbalOutput::Servos { .. }) {
            (pitch, yaw) = (pitch.slowed(SERVO_RATE_SHARE), yaw.slowed(SERVO_RATE_SHARE));
        }
        self.aim = Aim::Axes {
            pitch,
            yaw,
            lock,
            pitch_lock: asked.flags & flags::PITCH_LOCK != 0,
        };
        true
    }

    fn rest(&mut self) {
        self.aim = Aim::Rest;
        self.asked_rad = (0.0, 0.0);
    }

    /// Looks at a place from now on, or ahead again.
    pub fn region_of_interest(&mut self, place: Option<Geodetic>) {
        match place {
            Some(place) => self.aim = Aim::Place(place),
            None => self.rest(),
        }
    }

    /// Lets `dt_s` pass; `towards` gives the way from the camera to a place in metres north, east, down.
    pub fn step(&mut self, carrier: &Carrier, towards: impl FnOnce(&Geodetic) -> Vector3<f64>, dt_s: f64) {
        self.unasked_s += dt_s;
        if let (Aim::Axes { pitch, yaw, .. }, true) = (&mut self.aim, self.unasked_s > RATES_LAST_S) {
            (*pitch, *yaw) = (pitch.slowed(0.0), yaw.slowed(0.0));
        }
        let level = AxisGoal::Angle(0.0);
        let by_servos = matches!(self.head.settings.output, GimbalOutput::Servos { .. });
        let from_nose = |north_rad: f64| {
            let (north_rad, nose_rad) = (wrap_angle_rad(north_rad), wrap_angle_rad(carrier.yaw_rad));
            // Servos are not turned round the circle: they end at their stop.
            let yaw_rad = north_rad - nose_rad;
            AxisGoal::Angle(if by_servos { yaw_rad } else { wrap_angle_rad(yaw_rad) })
        };
        let (mut pitch, mut yaw, mut drift_rad_s) = match &self.aim {
            Aim::Rest => (level, level, 0.0),
            Aim::Axes {
                pitch,
                yaw,
                lock: false,
                ..
            } => (*pitch, *yaw, 0.0),
            Aim::Axes {
                pitch,
                yaw: AxisGoal::Angle(yaw_rad),
                ..
            } => (*pitch, from_nose(*yaw_rad), -carrier.yaw_rate_rad_s),
            Aim::Axes {
                pitch,
                yaw: AxisGoal::Rate(rate_rad_s),
                ..
            } => (*pitch, AxisGoal::Rate(rate_rad_s - carrier.yaw_rate_rad_s), 0.0),
            Aim::Place(place) => {
                let way = towards(place);
                let pitch = AxisGoal::Angle((-way.z).atan2(way.xy().norm()));
                (pitch, from_nose(way.y.atan2(way.x)), -carrier.yaw_rate_rad_s)
            }
        };
        let (pitch_stays, yaw_stays) = self.stays();
        if pitch_stays {
            pitch = AxisGoal::Rate(0.0);
        }
        if yaw_stays {
            (yaw, drift_rad_s) = (AxisGoal::Rate(0.0), 0.0);
        }
        self.head.step(pitch, yaw, drift_rad_s, dt_s);
    }

    /// Whether pitch and yaw are servos that PX4 does not turn: to be held, but not stabilised.
    fn stays(&self) -> (bool, bool) {
        match (self.head.settings.output, &self.aim) {
            (GimbalOutput::Servos { stabilised: false }, Aim::Axes { lock, pitch_lock, .. }) => (*pitch_lock, *lock),
            _ => (false, false),
        }
    }

    /// Yaw from north in radians.
    pub fn yaw_north_rad(&self, carrier: &Carrier) -> f64 {
        wrap_angle_rad(carrier.yaw_rad + self.head.yaw.angle_rad)
    }

    /// Pitch and yaw as asked for, in radians, in the frame in which they are held: what PX4 says of servos, wherever those are.
    pub fn asked_rad(&self, carrier: &Carrier) -> (f64, f64) {
        match &self.aim {
            Aim::Rest | Aim::Place(_) => (self.head.pitch.angle_rad, self.yaw_held_rad(carrier)),
            Aim::Axes { pitch, yaw, .. } => {
                let turns = |goal: &AxisGoal| matches!(goal, AxisGoal::Rate(rate_rad_s) if *rate_rad_s != 0.0);
                (
                    if turns(pitch) {
                        self.head.pitch.angle_rad
                    } else {
                        self.asked_rad.0
                    },
                    if turns(yaw) {
                        self.yaw_held_rad(carrier)
                    } else {
                        self.asked_rad.1
                    },
                )
            }
        }
    }

    /// Yaw in radians in the frame in which it is held.
    pub fn yaw_held_rad(&self, carrier: &Carrier) -> f64 {
        if self.is_yaw_locked() {
            self.yaw_north_rad(carrier)
        } else {
            self.head.yaw.angle_rad
        }
    }

    /// Whether the yaw is held to north.
    pub fn is_yaw_locked(&self) -> bool {
        matches!(self.aim, Aim::Axes { lock: true, .. } | Aim::Place(_))
    }

    /// The flags that are in force, of manager and device alike.
    pub fn flags(&self) -> u32 {
        let mut flags = flags::ROLL_LOCK | flags::PITCH_LOCK;
        if self.aim == Aim::Rest {
            flags |= flags::NEUTRAL;
        }
        flags
            | if self.is_yaw_locked() {
                flags::YAW_LOCK | flags::YAW_IN_EARTH_FRAME
            } else {
                flags::YAW_IN_VEHICLE_FRAME
            }
    }
}

#[cfg(test)]
mod tests;
