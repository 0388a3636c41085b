//! What makes a configuration that parses still wrong. Every problem is listed, not only the first.

mod dds;

use crate::problem::Problem;
use crate::settings::{AdoptionRule, NodeConfig, PayloadRule};

impl NodeConfig {
    /// Everything that is wrong with the values.
    #[must_use]
    pub fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        for (key, value, low, high) in self.ranges() {
            if !(low..=high).contains(&value) {
                problems.push(Problem {
                    key: key.into(),
                    message: format!("{value} is not between {low} and {high}"),
                });
            }
        }
        if self.link.own_system_id == 0 {
            problems.push(problem("link.own_system_id", "0 means everybody; choose 1 to 255"));
        }
        if self.plugins.directories.is_empty() {
            problems.push(problem("plugins.directories", "name at least one directory"));
        }
        if self.plugins.runner_threads == 0 || self.plugins.runner_threads > 64 {
            problems.push(problem("plugins.runner_threads", "choose 1 to 64"));
        }
        self.swarm.problems(&mut problems);
        self.dds_problems(&mut problems);
        self.ros2.problems(&mut problems);
        self.video.problems(&mut problems);
        self.tracking.problems(&mut problems);
        self.recorder.problems(&mut problems);
        self.upgrade.problems(&mut problems);
        if !self.web.enabled && self.swarm.id.is_none() {
            problems.push(problem(
                "web.enabled",
                "a node without a swarm can only be reached through its API",
            ));
        }
        if self.link.setpoint_valid_s * self.node.control_rate_hz < 2.0 {
            problems.push(problem(
                "link.setpoint_valid_s",
                "must be at least two control periods, or every late period would stop the vehicle",
            ));
        }
        crate::failsafe_settings::problems(&self.safety.failsafe, &mut problems);
        crate::energy_settings::problems(&self.safety.energy, &mut problems);
        crate::preflight_settings::problems(&self.safety.preflight, &mut problems);
        self.fence_problems(&mut problems);
        self.name_problems(&mut problems);
        problems
    }

    fn name_problems(&self, problems: &mut Vec<Problem>) {
        let names: Vec<&str> = self
            .endpoints
            .iter()
            .map(|e| e.name.as_deref().unwrap_or(&e.address))
            .collect();
        for (i, name) in names.iter().enumerate() {
            if names.iter().take(i).any(|earlier| earlier == name) {
                problems.push(problem(
                    &format!("endpoints[{i}]"),
                    &format!("\"{name}\" is there twice"),
                ));
            }
        }
        for (i, operator) in self.operators.iter().enumerate() {
            if let Err((key, what)) = operator.check() {
                problems.push(problem(&format!("operators[{i}].{key}"), what));
            }
        }
        for (i, rule) in self.adopt.iter().enumerate() {
            if rule.name.trim().is_empty() {
                problems.push(problem(&format!("adopt[{i}].name"), "must not be empty"));
            }
            if let Some(endpoint) = &rule.endpoint
                && !names.contains(&endpoint.as_str())
            {
                problems.push(problem(
                    &format!("adopt[{i}].endpoint"),
                    &format!("there is no endpoint \"{endpoint}\""),
                ));
            }
            payload_problems(i, rule, problems);
        }
    }

    /// Every number with the range it must be in.
    fn ranges(&self) -> Vec<(&'static str, f64, f64, f64)> {
        let (node, link, safety, coordinator) = (&self.node, &self.link, &self.safety, &self.coordinator);
        let mut ranges = vec![
            ("node.control_rate_hz", node.control_rate_hz, 5.0, 200.0),
            ("node.snapshot_rate_hz", node.snapshot_rate_hz, 0.5, 50.0),
            ("resume.within_s", self.resume.within_s, 1.0, 600.0),
            ("link.lost_after_s", link.lost_after_s, 0.2, 60.0),
            ("link.setpoint_valid_s", link.setpoint_valid_s, 0.02, 0.5),
            ("link.hold_for_s", link.hold_for_s, 0.0, 60.0),
            ("link.position_rate_hz", link.position_rate_hz, 1.0, 200.0),
            ("newcomers.probation_s", self.newcomers.probation_s, 0.0, 600.0),
            ("safety.max_speed_m_s", safety.max_speed_m_s, 0.1, 60.0),
            ("safety.max_climb_m_s", safety.max_climb_m_s, 0.1, 30.0),
            ("safety.max_descent_m_s", safety.max_descent_m_s, 0.1, 30.0),
            ("safety.min_height_m", safety.min_height_m, -1_000.0, 100.0),
            ("safety.min_separation_m", safety.min_separation_m, 0.0, 100.0),
            ("safety.separation_horizon_s", safety.separation_horizon_s, 3.0, 30.0),
            (
                "coordinator.take_off_stagger_s",
                coordinator.take_off_stagger_s,
                0.0,
                60.0,
            ),
            (
                "coordinator.transition_speed_m_s",
                coordinator.transition_speed_m_s,
                0.1,
                30.0,
            ),
            (
                "coordinator.transition_acceleration_m_s2",
                coordinator.transition_acceleration_m_s2,
                0.1,
                20.0,
            ),
            (
                "coordinator.transition_climb_m_s",
                coordinator.transition_climb_m_s,
                0.1,
                10.0,
            ),
            (
                "coordinator.transition_min_distance_m",
                coordinator.transition_min_distance_m,
                0.5,
                100.0,
            ),
            (
                "coordinator.leader_lost_after_s",
                coordinator.leader_lost_after_s,
                0.1,
                60.0,
            ),
        ];
        ranges.extend(self.plugin_ranges());
        ranges.extend(self.returning_ranges());
        if let Some(fence) = &safety.fence {
            ranges.push(("safety.fence.floor_m", fence.floor_m, -1000.0, fence.ceiling_m));
            ranges.push(("safety.fence.ceiling_m", fence.ceiling_m, fence.floor_m, 20_000.0));
        }
        ranges
    }

    fn returning_ranges(&self) -> [(&'static str, f64, f64, f64); 3] {
        let returning = &self.safety.returning;
        [
            ("safety.returning.height_m", returning.height_m, 1.0, 500.0),
            ("safety.returning.layer_gap_m", returning.layer_gap_m, 0.5, 100.0),
            (
                "safety.returning.landing_spacing_m",
                returning.landing_spacing_m,
                0.5,
                100.0,
            ),
        ]
    }

    fn plugin_ranges(&self) -> [(&'static str, f64, f64, f64); 4] {
        let plugins = &self.plugins;
        [
            ("plugins.call_deadline_s", plugins.call_deadline_s, 0.001, 1.0),
            (
                "plugins.child_memory_mib",
                plugins.child_memory_mib as f64,
                64.0,
                65_536.0,
            ),
            ("plugins.child_cpu_share", plugins.child_cpu_share, 0.01, 64.0),
            (
                "plugins.child_open_files",
                plugins.child_open_files as f64,
                16.0,
                65_536.0,
            ),
        ]
    }
}

fn payload_problems(at: usize, rule: &AdoptionRule, problems: &mut Vec<Problem>) {
    for (i, payload) in rule.payloads.iter().enumerate() {
        let key = format!("adopt[{at}].payloads[{i}]");
        if let Err(message) = payload.check() {
            problems.push(problem(&key, &message));
        }
        if rule.payloads.iter().take(i).any(|earlier| earlier.name == payload.name) {
            problems.push(problem(&key, &format!("\"{}\" is there twice", payload.name)));
        }
    }
}

impl PayloadRule {
    /// What can be said of it without its plugin.
    ///
    /// # Errors
    /// What is wrong, in a sentence.
    pub fn check(&self) -> Result<(), String> {
        let letter = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if self.name.is_empty() || self.name.len() > 32 || !self.name.chars().all(letter) {
            return Err(format!(
                "the name {:?} is not made of 1 to 32 letters, digits, - and _",
                self.name
            ));
        }
        if self.plugin.is_empty() {
            return Err("plugin must not be empty".into());
        }
        if !self.config.is_object() {
            return Err("config must be a table".into());
        }
        Ok(())
    }

    /// The plugin configuration as JSON text.
    #[must_use]
    pub fn config_json(&self) -> String {
        self.config.to_string()
    }
}

fn problem(key: &str, message: &str) -> Problem {
    Problem {
        key: key.into(),
        message: message.into(),
    }
}
