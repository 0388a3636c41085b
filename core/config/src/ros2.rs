//! `[ros2]`: how the swarm shows itself to ROS 2, and what makes these values wrong.
//!
//! Must never do: switch it on by itself.

use crate::problem::Problem;
use serde::{Deserialize, Serialize};

/// `[ros2]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ros2Settings {
    /// Whether vehicles and swarm are nodes of ROS 2.
    pub enabled: bool,
    /// Namespace that everything is under.
    pub namespace: String,
    /// Poses, odometry and transforms per second and vehicle; never more than there are snapshots.
    pub motion_rate_hz: f64,
    /// Whether poses and odometry are repeated until they arrive.
    pub reliable_motion: bool,
    /// States, fixes, batteries, gimbals and the formation per second.
    pub status_rate_hz: f64,
    /// Pictures per second and camera; 0: none.
    pub image_rate_hz: f64,
    /// Whether commands are taken as services.
    pub services: bool,
    /// Whether velocities are taken.
    pub cmd_vel: bool,
    /// A velocity is good for so long, in seconds.
    pub cmd_vel_valid_s: f64,
    /// Height of a take-off that names none, in metres above the launch place.
    pub take_off_height_m: f64,
}

impl Default for Ros2Settings {
    fn default() -> Self {
        Self {
            enabled: false,
            namespace: "skein".to_owned(),
            motion_rate_hz: 20.0,
            reliable_motion: false,
            status_rate_hz: 2.0,
            image_rate_hz: 2.0,
            services: true,
            cmd_vel: true,
            cmd_vel_valid_s: 0.5,
            take_off_height_m: 10.0,
        }
    }
}

impl Ros2Settings {
    /// Everything that is wrong with it.
    pub(crate) fn problems(&self, problems: &mut Vec<Problem>) {
        let mut wrong = |key: &str, message: String| {
            problems.push(Problem {
                key: format!("ros2.{key}"),
                message,
            });
        };
        let letter = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let begins_well = self.namespace.starts_with(|c: char| c.is_ascii_alphabetic());
        if !begins_well
            || self.namespace.len() > 64
            || !self.namespace.chars().all(letter)
            || self.namespace.contains("__")
        {
            wrong(
                "namespace",
                "choose 1 to 64 letters, digits and single _, a letter first".to_owned(),
            );
        }
        for (key, value, low, high) in [
            ("motion_rate_hz", self.motion_rate_hz, 0.1, 50.0),
            ("status_rate_hz", self.status_rate_hz, 0.1, 10.0),
            ("image_rate_hz", self.image_rate_hz, 0.0, 30.0),
            ("cmd_vel_valid_s", self.cmd_vel_valid_s, 0.1, 2.0),
            ("take_off_height_m", self.take_off_height_m, 1.0, 120.0),
        ] {
            if !(low..=high).contains(&value) {
                wrong(key, format!("{value} is not between {low} and {high}"));
            }
        }
    }
}

#[cfg(test)]
mod tests;
