//! `[ros2]`: how the swarm shows itself to ROS 2, and what makes these values wrong.
//!
//! Must never do: switch it on by itself.

use crate::Problem;
use serde::{Deserialize, Serialize};
use std::net::IpAddr;

/// `[ros2]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ros2Settings {
    /// Whether vehicles and swarm are nodes of ROS 2.
    pub enabled: bool,
    /// Domain, as `ROS_DOMAIN_ID` has it for others.
    pub domain_id: u16,
    /// Addresses of the network interfaces it uses; loopback unless changed here.
    pub interfaces: Vec<String>,
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
            domain_id: 0,
            interfaces: vec!["127.0.0.1".to_owned()],
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
    /// The addresses of the interfaces; those that are none are left out.
    #[must_use]
    pub fn addresses(&self) -> Vec<IpAddr> {
        self.interfaces.iter().filter_map(|at| at.parse().ok()).collect()
    }

    /// Everything that is wrong with it.
    pub(crate) fn problems(&self, problems: &mut Vec<Problem>) {
        let mut wrong = |key: &str, message: String| {
            problems.push(Problem {
                key: format!("ros2.{key}"),
                message,
            });
        };
        if self.domain_id > 101 {
            wrong("domain_id", "is not between 0 and 101".to_owned());
        }
        if self.interfaces.is_empty() || self.interfaces.iter().any(|at| at.parse::<IpAddr>().is_err()) {
            wrong(
                "interfaces",
                "are IP addresses of this computer, at least one".to_owned(),
            );
        }
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
