//! What can be set.

use schemars::JsonSchema;
use serde::Deserialize;

/// Settings of the model.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// How it flies: the settings of `generic-uav`.
    pub flight: generic_uav::Settings,
    /// Horizontal distance to keep to what is observed, where the command names none, in metres.
    #[schemars(range(min = 1.0))]
    pub stand_off_m: f64,
    /// No command may ask for a smaller distance, in metres.
    #[schemars(range(min = 1.0))]
    pub stand_off_min_m: f64,
    /// Where the command names a height over the target, it leads no lower than this above the origin of the swarm frame, in metres. Where it
    /// names none, the vehicle goes no lower than it was.
    #[schemars(range(min = 0.0))]
    pub lowest_m: f64,
    /// Horizontal speed not to be exceeded while observing, in metres per second. It must be above that of what is observed.
    #[schemars(range(min = 0.1))]
    pub speed_m_s: f64,
    /// What is observed may be so far from where it was expected before the flight is planned anew, in metres.
    #[schemars(range(min = 0.0))]
    pub replan_distance_m: f64,
    /// What was not seen for so long is gone, in seconds.
    #[schemars(range(min = 0.1))]
    pub target_timeout_s: f64,
    /// How long the way to the stand-off distance may take before the command counts as failed, in seconds.
    #[schemars(range(min = 1.0))]
    pub approach_timeout_s: f64,
    /// The gimbal is not told more often than this, in seconds.
    #[schemars(range(min = 0.02))]
    pub gimbal_interval_s: f64,
    /// The gimbal is told again when the direction has changed by this much, in radians.
    #[schemars(range(min = 0.0))]
    pub gimbal_step_rad: f64,
    /// How fast the vehicle turns its nose to what it looks at, where no gimbal does it, in radians per second.
    #[schemars(range(min = 0.01))]
    pub yaw_rate_rad_s: f64,
    /// Horizontal field of view where the camera does not tell its own, in radians.
    #[schemars(range(min = 0.01, max = 3.0))]
    pub field_of_view_rad: f64,
    /// Where a camera without a gimbal looks, in radians above the horizon.
    #[schemars(range(min = -1.58, max = 1.58))]
    pub fixed_camera_pitch_rad: f64,
    /// What the camera does while something is observed.
    pub camera: OnObserving,
    /// Time between two pictures, in seconds.
    #[schemars(range(min = 0.0))]
    pub picture_interval_s: f64,
    /// Whether the camera's first stream runs while something is observed.
    pub stream: bool,
    /// What is done when the radio warns that the vehicle is about to leave its range while it observes something.
    pub on_radio_warning: OnRadioWarning,
}

/// What the camera does while something is observed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OnObserving {
    /// Nothing by itself.
    #[default]
    Nothing,
    /// It records.
    Record,
    /// It takes pictures.
    Pictures,
}

/// What is done when the radio warns. An operator is told in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OnRadioWarning {
    /// Nothing else.
    #[default]
    Tell,
    /// The observation is broken off; the vehicle holds.
    Hold,
    /// The observation is broken off; the vehicle flies home and lands.
    Return,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            flight: generic_uav::Settings::default(),
            stand_off_m: 15.0,
            stand_off_min_m: 5.0,
            lowest_m: 5.0,
            speed_m_s: 9.0,
            replan_distance_m: 0.5,
            target_timeout_s: 3.0,
            approach_timeout_s: 180.0,
            gimbal_interval_s: 0.2,
            gimbal_step_rad: 0.01,
            yaw_rate_rad_s: 0.8,
            field_of_view_rad: 1.0,
            fixed_camera_pitch_rad: -0.5,
            camera: OnObserving::Nothing,
            picture_interval_s: 2.0,
            stream: false,
            on_radio_warning: OnRadioWarning::Tell,
        }
    }
}

impl Settings {
    /// The flight's settings; its camera looks out of a formation unless said otherwise.
    pub(crate) fn flight(&self) -> generic_uav::Settings {
        generic_uav::Settings {
            keeps_view: Some(self.flight.keeps_view.unwrap_or(true)),
            ..self.flight
        }
    }

    /// Whether every value can be worked with; else which cannot. The flight's are checked by `generic-uav`.
    pub fn check(&self) -> Result<(), String> {
        let at_least = [
            ("stand_off_m", self.stand_off_m, self.stand_off_min_m),
            ("stand_off_min_m", self.stand_off_min_m, 1.0),
            ("lowest_m", self.lowest_m, 0.0),
            ("speed_m_s", self.speed_m_s, 0.1),
            ("replan_distance_m", self.replan_distance_m, 0.0),
            ("target_timeout_s", self.target_timeout_s, 0.1),
            ("approach_timeout_s", self.approach_timeout_s, 1.0),
            ("gimbal_interval_s", self.gimbal_interval_s, 0.02),
            ("gimbal_step_rad", self.gimbal_step_rad, 0.0),
            ("yaw_rate_rad_s", self.yaw_rate_rad_s, 0.01),
            ("field_of_view_rad", self.field_of_view_rad, 0.01),
            ("fixed_camera_pitch_rad", self.fixed_camera_pitch_rad, -1.58),
            ("picture_interval_s", self.picture_interval_s, 0.0),
        ];
        for (key, value, least) in at_least {
            if !(value.is_finite() && value >= least) {
                return Err(format!("{key} = {value}: it must be at least {least}"));
            }
        }
        Ok(())
    }
}
