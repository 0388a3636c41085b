//! The model's configuration.

use schemars::JsonSchema;
use serde::Deserialize;
use skein_domain::FlightLimits;
use skein_flight::PathLimits;

/// Configuration of the generic UAV model. Every key may be left out.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Speed on the way to a place when the command gives none, in metres per second.
    #[schemars(range(min = 0.1))]
    pub cruise_speed_m_s: f64,
    /// Largest horizontal speed in metres per second. Routes, ways to places and formations keep below it, whatever is asked.
    #[schemars(range(min = 0.1))]
    pub max_speed_m_s: f64,
    /// Smallest radius of a turn in metres, for formations to be planned by; 0 if it can turn on the spot.
    #[schemars(range(min = 0.0))]
    pub min_turn_radius_m: f64,
    /// How long it can stay in the air with a full battery, in seconds; left out if that is not known.
    #[schemars(range(min = 1.0))]
    pub endurance_s: Option<f64>,
    /// Whether it carries a camera that looks out of the formation, so that its slot is chosen with nobody in its view. Left out: as the
    /// model does by itself (this one: no).
    pub keeps_view: Option<bool>,
    /// Largest planned acceleration in metres per second squared.
    #[schemars(range(min = 0.1))]
    pub acceleration_m_s2: f64,
    /// Largest planned climb rate in metres per second.
    #[schemars(range(min = 0.1))]
    pub climb_m_s: f64,
    /// Largest planned descent rate in metres per second.
    #[schemars(range(min = 0.1))]
    pub descent_m_s: f64,
    /// Speed beside the planned one with which a difference between where the vehicle is and where its plan begins is made up, at least, in
    /// metres per second. Where the plan leaves it more, some of that is used.
    #[schemars(range(min = 0.1))]
    pub catch_up_m_s: f64,
    /// Turning rate of the formation when its fixed heading is changed while leading, in radians per second.
    #[schemars(range(min = 0.01))]
    pub heading_rate_rad_s: f64,
    /// Smallest height to take off to, in metres above the launch place.
    #[schemars(range(min = 0.1))]
    pub take_off_min_height_m: f64,
    /// How long arming is tried, in seconds: the estimator of a vehicle just switched on takes some seconds to settle.
    #[schemars(range(min = 0.1))]
    pub arm_timeout_s: f64,
    /// How long a take-off may take from its acceptance to the asked height, in seconds.
    #[schemars(range(min = 0.1))]
    pub take_off_timeout_s: f64,
    /// The asked height is reached when no more than this is missing, in metres: PX4 ends its climb a little below it.
    #[schemars(range(min = 0.05))]
    pub take_off_reached_m: f64,
    /// Times an answer of the autopilot is waited for, in seconds, before it counts as none. The link repeats its requests by itself
    /// in this time.
    #[schemars(range(min = 0.1))]
    pub request_timeout_s: f64,
    /// Pause before a request that the autopilot could not follow is made again, in seconds.
    #[schemars(range(min = 0.0))]
    pub retry_pause_s: f64,
    /// How often a request is made before it counts as refused.
    #[schemars(range(min = 1))]
    pub attempts: u32,
    /// A place is reached within this distance, in metres.
    #[schemars(range(min = 0.05))]
    pub goal_radius_m: f64,
    /// How long a vehicle may take to come to its goal after the planned end of the flight, in seconds.
    #[schemars(range(min = 0.1))]
    pub goal_timeout_s: f64,
    /// How near to above its landing spot a vehicle must be before it lands, in metres.
    #[schemars(range(min = 0.05))]
    pub landing_settle_radius_m: f64,
    /// How slow it must be there, in metres per second.
    #[schemars(range(min = 0.05))]
    pub landing_settle_speed_m_s: f64,
    /// How long it may take to settle there before it lands all the same, in seconds.
    #[schemars(range(min = 0.0))]
    pub landing_settle_timeout_s: f64,
    /// How long a landing may take before its command counts as failed, in seconds. The landing goes on.
    #[schemars(range(min = 0.1))]
    pub landing_timeout_s: f64,
    /// How long the gate may refuse the setpoints of a commanded flight before the flight is broken off, in seconds.
    #[schemars(range(min = 0.0))]
    pub refusal_patience_s: f64,
    /// A follower holds when its leader's anchor is older than this, in seconds.
    #[schemars(range(min = 0.05))]
    pub anchor_max_age_s: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            cruise_speed_m_s: 5.0,
            max_speed_m_s: 12.0,
            min_turn_radius_m: 0.0,
            endurance_s: None,
            keeps_view: None,
            acceleration_m_s2: 2.0,
            // What PX4 itself allows by default is 3 and 1.5.
            climb_m_s: 2.5,
            descent_m_s: 1.5,
            catch_up_m_s: 2.0,
            heading_rate_rad_s: 0.1,
            take_off_min_height_m: 1.0,
            arm_timeout_s: 30.0,
            take_off_timeout_s: 60.0,
            take_off_reached_m: 0.4,
            request_timeout_s: 10.0,
            retry_pause_s: 1.0,
            attempts: 3,
            goal_radius_m: 0.5,
            goal_timeout_s: 30.0,
            landing_settle_radius_m: 0.25,
            landing_settle_speed_m_s: 0.3,
            landing_settle_timeout_s: 20.0,
            landing_timeout_s: 180.0,
            refusal_patience_s: 2.0,
            anchor_max_age_s: 1.0,
        }
    }
}

impl Settings {
    /// Whether every value can be worked with; else which cannot.
    pub fn check(&self) -> Result<(), String> {
        let above_zero = [
            ("cruise_speed_m_s", self.cruise_speed_m_s),
            ("max_speed_m_s", self.max_speed_m_s),
            ("endurance_s", self.endurance_s.unwrap_or(f64::MAX)),
            ("acceleration_m_s2", self.acceleration_m_s2),
            ("climb_m_s", self.climb_m_s),
            ("descent_m_s", self.descent_m_s),
            ("catch_up_m_s", self.catch_up_m_s),
            ("heading_rate_rad_s", self.heading_rate_rad_s),
            ("take_off_min_height_m", self.take_off_min_height_m),
            ("arm_timeout_s", self.arm_timeout_s),
            ("take_off_timeout_s", self.take_off_timeout_s),
            ("take_off_reached_m", self.take_off_reached_m),
            ("request_timeout_s", self.request_timeout_s),
            ("attempts", f64::from(self.attempts)),
            ("goal_radius_m", self.goal_radius_m),
            ("goal_timeout_s", self.goal_timeout_s),
            ("landing_settle_radius_m", self.landing_settle_radius_m),
            ("landing_settle_speed_m_s", self.landing_settle_speed_m_s),
            ("landing_timeout_s", self.landing_timeout_s),
            ("anchor_max_age_s", self.anchor_max_age_s),
        ];
        let not_below_zero = [
            ("min_turn_radius_m", self.min_turn_radius_m),
            ("retry_pause_s", self.retry_pause_s),
            ("landing_settle_timeout_s", self.landing_settle_timeout_s),
            ("refusal_patience_s", self.refusal_patience_s),
        ];
        for (key, value) in above_zero {
            if !(value.is_finite() && value > 0.0) {
                return Err(format!("{key} = {value}: it must be above zero"));
            }
        }
        for (key, value) in not_below_zero {
            if !(value.is_finite() && value >= 0.0) {
                return Err(format!("{key} = {value}: it must not be below zero"));
            }
        }
        Ok(())
    }

    /// What the vehicle can do, for others to plan by.
    pub(crate) fn flight_limits(&self) -> FlightLimits {
        FlightLimits {
            max_speed_m_s: self.max_speed_m_s,
            max_climb_m_s: self.climb_m_s,
            max_descent_m_s: self.descent_m_s,
            max_acceleration_m_s2: self.acceleration_m_s2,
            min_turn_radius_m: self.min_turn_radius_m,
            endurance_s: self.endurance_s,
            keeps_view: self.keeps_view.unwrap_or(false),
        }
    }

    /// What the vehicle can do along a planned way.
    pub(crate) fn path_limits(&self) -> PathLimits {
        let Self {
            acceleration_m_s2,
            climb_m_s,
            descent_m_s,
            ..
        } = *self;
        PathLimits {
            acceleration_m_s2,
            climb_m_s,
            descent_m_s,
        }
    }
}
