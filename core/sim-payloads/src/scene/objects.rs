//! What moves in the world beside the swarm: where each thing is at a time, by its path alone.
//!
//! Must never do: depend on anything but the object and the time, so that whoever knows both knows the truth.

use super::{SceneTarget, TargetKind};
use nalgebra::{Vector2, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use skein_domain::PositionNed;
use std::f64::consts::{PI, TAU};

const GRAVITY_M_S2: f64 = 9.81;
/// How far things lean into the turns of a line, in radians, and at most on a circle.
const LINE_BANK_RAD: f64 = 0.5;
const STEEPEST_BANK_RAD: f64 = 1.0;
/// No turn of a line is narrower than this, in metres.
const NARROWEST_TURN_M: f64 = 1.0;
/// Over this much of a turn they lean in and out again, in radians.
const LEANING_RAD: f64 = 0.5;
/// A bird one metre wide beats its wings so often, per second; a larger one more slowly.
const BEATS_HZ: f64 = 4.0;
const ROTOR_HZ: f64 = 6.0;

/// Something that moves along a path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneObject {
    /// What it is.
    pub kind: TargetKind,
    /// How wide it is from tip to tip in metres, a helicopter's rotor; left out: as its kind usually is.
    #[serde(default)]
    #[schemars(range(min = 0.01, max = 1000.0))]
    pub size_m: Option<f64>,
    /// Where it moves.
    pub path: ObjectPath,
    /// How fast it moves over the ground in metres per second; left out: as its kind usually does.
    #[serde(default)]
    #[schemars(range(min = 0.1, max = 1000.0))]
    pub speed_m_s: Option<f64>,
    /// Where on its path it is at time zero, as a share of the whole; of one that hovers, where it looks, as a share of a turn from north.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub phase: f64,
}

/// Where something moves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ObjectPath {
    /// From one place to another and back beside that: half circles to the right join both ways, as wide as its speed needs.
    Line {
        /// Where it begins.
        from: PositionNed,
        /// Where it turns.
        to: PositionNed,
    },
    /// Around a place, clockwise seen from above.
    Circle {
        /// The place.
        centre: PositionNed,
        /// How far from it, in metres.
        #[schemars(range(min = 0.1, max = 100_000.0))]
        radius_m: f64,
    },
    /// It stays where it is.
    Hover(PositionNed),
}

/// What follows of a path at a time.
#[derive(Default)]
struct Motion {
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    bank_rad: f64,
}

impl SceneObject {
    /// Its width in metres.
    #[must_use]
    pub fn size_m(&self) -> f64 {
        self.size_m.unwrap_or(match self.kind {
            TargetKind::Multirotor | TargetKind::Quadrotor => 0.6,
            TargetKind::Marker | TargetKind::Bird => 1.0,
            TargetKind::FixedWing => 2.0,
            TargetKind::Aeroplane => 11.0,
            TargetKind::Helicopter => 10.0,
        })
    }

    /// Its speed over the ground in metres per second, unless it hovers.
    #[must_use]
    pub fn speed_m_s(&self) -> f64 {
        self.speed_m_s.unwrap_or(match self.kind {
            TargetKind::Multirotor | TargetKind::Marker | TargetKind::Quadrotor | TargetKind::Bird => 10.0,
            TargetKind::FixedWing => 18.0,
            TargetKind::Aeroplane => 55.0,
            TargetKind::Helicopter => 35.0,
        })
    }

    /// Where it is at a time and how it looks there. Its nose points along its velocity.
    #[must_use]
    pub fn at(&self, time_s: f64) -> SceneTarget {
        let motion = match self.path {
            ObjectPath::Line { from, to } => self.on_line(time_s, from.vector(), to.vector()),
            ObjectPath::Circle { centre, radius_m } => self.on_circle(time_s, centre.vector(), radius_m),
            ObjectPath::Hover(position) => Motion {
                position: position.vector(),
                ..Motion::default()
            },
        };
        let velocity = motion.velocity;
        let winged = matches!(
            self.kind,
            TargetKind::FixedWing | TargetKind::Bird | TargetKind::Aeroplane
        );
        let beats_hz = match self.kind {
            TargetKind::Bird => BEATS_HZ / self.size_m().sqrt(),
            TargetKind::Helicopter => ROTOR_HZ,
            _ => 0.0,
        };
        SceneTarget {
            position: motion.position.into(),
            size_m: self.size_m(),
            kind: self.kind,
            velocity: velocity.into(),
            roll_rad: motion.bank_rad,
            pitch_rad: if winged {
                (-velocity.z).atan2(velocity.xy().norm())
            } else {
                0.0
            },
            yaw_rad: if matches!(self.path, ObjectPath::Hover(_)) {
                TAU * self.phase
            } else {
                velocity.y.atan2(velocity.x)
            },
            beat_rad: TAU * (beats_hz * time_s + self.phase).rem_euclid(1.0),
        }
    }

    fn on_circle(&self, time_s: f64, centre: Vector3<f64>, radius_m: f64) -> Motion {
        let speed_m_s = self.speed_m_s();
        let (sin, cos) = (TAU * self.phase + speed_m_s / radius_m * time_s).sin_cos();
        let bank_rad = (speed_m_s * speed_m_s / (GRAVITY_M_S2 * radius_m)).atan();
        Motion {
            position: centre + Vector3::new(cos, sin, 0.0) * radius_m,
            velocity: Vector3::new(-sin, cos, 0.0) * speed_m_s,
            bank_rad: bank_rad.min(STEEPEST_BANK_RAD),
        }
    }

    fn on_line(&self, time_s: f64, from: Vector3<f64>, to: Vector3<f64>) -> Motion {
        let speed_m_s = self.speed_m_s();
        let way = (to - from).xy();
        let way_m = way.norm();
        let mut along = way.try_normalize(0.0).unwrap_or(Vector2::x());
        let turn_m = (speed_m_s * speed_m_s / (GRAVITY_M_S2 * LINE_BANK_RAD.tan())).max(NARROWEST_TURN_M);
        let half_m = way_m + PI * turn_m;
        let mut gone_m = (2.0 * half_m * self.phase + speed_m_s * time_s).rem_euclid(2.0 * half_m);
        let (mut begin, mut end) = (from, to);
        if gone_m >= half_m {
            // The way back is the way out seen from the other end, two radii to the right.
            let aside = across(along) * (2.0 * turn_m);
            gone_m -= half_m;
            along = -along;
            (begin, end) = (to + aside.push(0.0), from + aside.push(0.0));
        }
        if gone_m < way_m {
            // Climbs gently in and out, so that the turns are level and nothing jumps.
            let share = gone_m / way_m;
            let climb = (end.z - begin.z) * 6.0 * share * (1.0 - share) / way_m;
            let place = begin.xy() + along * gone_m;
            return Motion {
                position: place.push(begin.z + (end.z - begin.z) * smooth(share)),
                velocity: along.push(climb) * speed_m_s,
                bank_rad: 0.0,
            };
        }
        let turned_rad = (gone_m - way_m) / turn_m;
        let (sin, cos) = turned_rad.sin_cos();
        let right = across(along);
        let place = end.xy() + (right * (1.0 - cos) + along * sin) * turn_m;
        let leaning = turned_rad.min(PI - turned_rad) / LEANING_RAD;
        Motion {
            position: place.push(end.z),
            velocity: (right * sin + along * cos).push(0.0) * speed_m_s,
            bank_rad: LINE_BANK_RAD * smooth(leaning.clamp(0.0, 1.0)),
        }
    }
}

/// To the right of a direction, seen from above.
fn across(along: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-along.y, along.x)
}

/// From 0 to 1, beginning and ending gently.
fn smooth(share: f64) -> f64 {
    share * share * (3.0 - 2.0 * share)
}

#[cfg(test)]
mod tests;
