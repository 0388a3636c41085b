//! What things of other people look like: ellipsoids along their own axes (forward, right, down), as shares of their width, and how these move.
//!
//! Must never do: know where a thing is or who looks at it.

use super::TargetKind;
use super::canvas::Colour;
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// No thing has more parts than this.
pub(super) const MOST_PARTS: usize = 14;
/// Where a bird's wing joins its body is the axis; here is where the outer half joins the inner one.
const ELBOW: f64 = 0.26;
/// How far a wing beats up and down, how far it is raised on the average, and how far its outer half lags, in radians.
const BEAT_RAD: f64 = 0.62;
const RAISED_RAD: f64 = 0.12;
const LAG_RAD: f64 = 1.0;

/// One ellipsoid.
pub(super) struct Part {
    middle: [f64; 3],
    /// Half axes.
    pub(super) half: [f64; 3],
    joint: Joint,
    pub(super) paint: Paint,
}

/// What a part looks like: its colour, and how bright its warmth is to an infrared camera.
#[derive(Clone, Copy)]
pub(super) struct Paint {
    pub(super) colour: Colour,
    pub(super) heat: f32,
}

/// How a part is turned against the thing.
#[derive(Clone, Copy)]
enum Joint {
    Fixed,
    /// About the axis downwards, in radians.
    Turned(f64),
    /// About the axis forwards, in radians.
    Tilted(f64),
    /// About the axis downwards, with the beat and so much ahead of it.
    Spins(f64),
    /// With the beat, about the body: on the right (1) or the left (-1).
    InnerWing(f64),
    /// With the beat, about the outer end of the inner wing.
    OuterWing(f64),
}

impl Part {
    /// Its middle and how it is turned, at this place within a beat.
    pub(super) fn posed(&self, beat_rad: f64) -> (Vector3<f64>, Rotation3<f64>) {
        let middle = Vector3::from(self.middle);
        let about_down = |angle_rad| (middle, Rotation3::from_axis_angle(&Vector3::z_axis(), angle_rad));
        let about_forward = |angle_rad| Rotation3::from_axis_angle(&Vector3::x_axis(), angle_rad);
        // Up is towards negative z: on the right a turn against the axis forwards, on the left one with it.
        let inner = |side: f64| about_forward(-side * (RAISED_RAD + BEAT_RAD * beat_rad.sin()));
        match self.joint {
            Joint::Fixed => about_down(0.0),
            Joint::Turned(angle_rad) => about_down(angle_rad),
            Joint::Spins(ahead_rad) => about_down(beat_rad + ahead_rad),
            Joint::Tilted(angle_rad) => (middle, about_forward(angle_rad)),
            Joint::InnerWing(side) => (inner(side) * middle, inner(side)),
            Joint::OuterWing(side) => {
                let outer = about_forward(-side * BEAT_RAD * (beat_rad - LAG_RAD).sin());
                let elbow = Vector3::new(middle.x, side * ELBOW, middle.z);
                (inner(side) * elbow + outer * (middle - elbow), outer)
            }
        }
    }
}

/// What a kind is made of; `None` of those that are drawn in another way.
pub(super) fn parts(kind: TargetKind) -> Option<&'static [Part]> {
    match kind {
        TargetKind::Multirotor | TargetKind::Marker => None,
        TargetKind::Quadrotor => Some(&QUADROTOR),
        TargetKind::FixedWing => Some(&FIXED_WING),
        TargetKind::Bird => Some(&BIRD),
        TargetKind::Aeroplane => Some(&AEROPLANE),
        TargetKind::Helicopter => Some(&HELICOPTER),
    }
}

const fn paint(red: f32, green: f32, blue: f32, heat: f32) -> Paint {
    Paint {
        colour: [red, green, blue],
        heat,
    }
}

const fn part(middle: [f64; 3], half: [f64; 3], paint: Paint) -> Part {
    jointed(middle, half, paint, Joint::Fixed)
}

const fn jointed(middle: [f64; 3], half: [f64; 3], paint: Paint, joint: Joint) -> Part {
    Part {
        middle,
        half,
        joint,
        paint,
    }
}

const WHITE: Paint = paint(232.0, 232.0, 228.0, 150.0);
const GREY: Paint = paint(110.0, 112.0, 116.0, 150.0);
const BLACK: Paint = paint(40.0, 40.0, 44.0, 130.0);
const GLASS: Paint = paint(44.0, 62.0, 84.0, 125.0);
const RED: Paint = paint(190.0, 40.0, 34.0, 140.0);
const OLIVE: Paint = paint(72.0, 78.0, 58.0, 165.0);
const MOTOR: Paint = paint(52.0, 52.0, 56.0, 235.0);
const FEATHER: Paint = paint(92.0, 78.0, 66.0, 170.0);
const PLUMAGE: Paint = paint(74.0, 62.0, 52.0, 215.0);

const QUADROTOR: [Part; 14] = [
    part([0.0, 0.0, 0.0], [0.17, 0.11, 0.075], WHITE),
    part([0.14, 0.0, 0.07], [0.05, 0.05, 0.05], BLACK),
    jointed([0.0, 0.0, 0.0], [0.36, 0.025, 0.02], GREY, Joint::Turned(FRAC_PI_4)),
    jointed([0.0, 0.0, 0.0], [0.36, 0.025, 0.02], GREY, Joint::Turned(-FRAC_PI_4)),
    part([0.25, 0.25, -0.03], [0.035, 0.035, 0.04], MOTOR),
    part([0.25, -0.25, -0.03], [0.035, 0.035, 0.04], MOTOR),
    part([-0.25, 0.25, -0.03], [0.035, 0.035, 0.04], MOTOR),
    part([-0.25, -0.25, -0.03], [0.035, 0.035, 0.04], MOTOR),
    part([0.25, 0.25, -0.07], [0.14, 0.14, 0.012], GREY),
    part([0.25, -0.25, -0.07], [0.14, 0.14, 0.012], GREY),
    part([-0.25, 0.25, -0.07], [0.14, 0.14, 0.012], GREY),
    part([-0.25, -0.25, -0.07], [0.14, 0.14, 0.012], GREY),
    part([0.0, 0.13, 0.14], [0.17, 0.014, 0.014], GREY),
    part([0.0, -0.13, 0.14], [0.17, 0.014, 0.014], GREY),
];

const FIXED_WING: [Part; 7] = [
    part([0.05, 0.0, 0.0], [0.24, 0.045, 0.05], WHITE),
    part([0.06, 0.0, -0.04], [0.075, 0.5, 0.014], WHITE),
    part([-0.25, 0.0, -0.01], [0.24, 0.014, 0.014], GREY),
    jointed([-0.45, 0.07, -0.05], [0.045, 0.11, 0.01], RED, Joint::Tilted(-0.65)),
    jointed([-0.45, -0.07, -0.05], [0.045, 0.11, 0.01], RED, Joint::Tilted(0.65)),
    part([-0.13, 0.0, -0.06], [0.05, 0.03, 0.03], MOTOR),
    part([0.22, 0.0, 0.045], [0.035, 0.035, 0.035], BLACK),
];

const BIRD: [Part; 7] = [
    part([0.0, 0.0, 0.0], [0.18, 0.058, 0.055], PLUMAGE),
    part([0.19, 0.0, -0.015], [0.055, 0.036, 0.036], PLUMAGE),
    part([-0.22, 0.0, 0.0], [0.10, 0.06, 0.014], FEATHER),
    jointed(
        [0.03, 0.15, -0.02],
        [0.075, 0.15, 0.016],
        FEATHER,
        Joint::InnerWing(1.0),
    ),
    jointed(
        [0.03, -0.15, -0.02],
        [0.075, 0.15, 0.016],
        FEATHER,
        Joint::InnerWing(-1.0),
    ),
    jointed(
        [0.01, 0.36, -0.02],
        [0.055, 0.14, 0.012],
        FEATHER,
        Joint::OuterWing(1.0),
    ),
    jointed(
        [0.01, -0.36, -0.02],
        [0.055, 0.14, 0.012],
        FEATHER,
        Joint::OuterWing(-1.0),
    ),
];

const AEROPLANE: [Part; 10] = [
    part([-0.03, 0.0, 0.0], [0.37, 0.055, 0.06], WHITE),
    part([0.29, 0.0, 0.0], [0.08, 0.05, 0.052], MOTOR),
    part([0.12, 0.0, -0.045], [0.09, 0.048, 0.035], GLASS),
    part([0.09, 0.0, -0.075], [0.075, 0.5, 0.014], WHITE),
    part([-0.35, 0.0, -0.02], [0.05, 0.17, 0.010], WHITE),
    part([-0.35, 0.0, -0.09], [0.065, 0.010, 0.09], RED),
    part([0.375, 0.0, 0.0], [0.006, 0.09, 0.09], GREY),
    part([0.05, 0.09, 0.12], [0.024, 0.012, 0.024], BLACK),
    part([0.05, -0.09, 0.12], [0.024, 0.012, 0.024], BLACK),
    part([0.27, 0.0, 0.11], [0.020, 0.010, 0.020], BLACK),
];

const HELICOPTER: [Part; 11] = [
    part([0.05, 0.0, 0.02], [0.20, 0.085, 0.095], OLIVE),
    part([0.18, 0.0, 0.005], [0.085, 0.072, 0.07], GLASS),
    part([-0.32, 0.0, -0.02], [0.26, 0.024, 0.026], OLIVE),
    part([-0.55, 0.0, -0.06], [0.045, 0.010, 0.085], OLIVE),
    part([-0.56, 0.025, -0.05], [0.085, 0.006, 0.085], GREY),
    part([-0.04, 0.0, -0.075], [0.10, 0.055, 0.04], MOTOR),
    part([0.0, 0.0, -0.10], [0.018, 0.018, 0.06], BLACK),
    jointed([0.0, 0.0, -0.15], [0.5, 0.022, 0.011], BLACK, Joint::Spins(0.0)),
    jointed([0.0, 0.0, -0.15], [0.5, 0.022, 0.011], BLACK, Joint::Spins(FRAC_PI_2)),
    part([0.05, 0.085, 0.15], [0.18, 0.010, 0.010], BLACK),
    part([0.05, -0.085, 0.15], [0.18, 0.010, 0.010], BLACK),
];
