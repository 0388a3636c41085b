//! What the model reports of itself: what it observes, from where, and whether it sees it.

use schemars::JsonSchema;
use serde::Serialize;
use skein_plugin_sdk::domain::payload::Target;

/// What the vehicle looks at.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct ObservationState {
    /// What it is doing.
    pub activity: Activity,
    /// What it looks at.
    pub target: Option<Target>,
    /// Horizontal distance to it in metres, to a tenth.
    pub distance_m: Option<f64>,
    /// Horizontal distance to keep in metres.
    pub stand_off_m: Option<f64>,
    /// Height over it in metres, to a tenth.
    pub height_m: Option<f64>,
    /// It stands still, since its target is not known well enough to fly by.
    pub waits: bool,
    /// It is within the camera's field of view. Nothing is known of what may stand in between.
    pub in_view: bool,
    /// The gimbal that is used.
    pub gimbal: Option<String>,
    /// The camera that is used.
    pub camera: Option<String>,
    /// The camera records or takes pictures.
    pub recording: bool,
    /// The radio warns that the vehicle is about to leave its range.
    pub radio_warning: bool,
}

/// What the model is doing beside flying.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Activity {
    /// Looks at nothing in particular.
    #[default]
    None,
    /// Looks at something without flying for it.
    Looking,
    /// On its way to where it observes from.
    Approaching,
    /// Keeps its distance and looks.
    Observing,
}

/// To a tenth: a report is made when it changes.
pub(crate) fn tenth(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}
