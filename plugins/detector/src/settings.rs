//! The configuration of the detector plugin.

use schemars::JsonSchema;
use serde::Deserialize;
use skein_vision::PictureSettings;
use std::path::PathBuf;

/// Configuration of the detector. Every key may be left out.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// The vehicle's camera whose pictures are looked at; empty: the only one.
    pub camera: String,
    /// The model that comes with the plugin: for visible light or infrared. Of no meaning with `path`.
    pub model: Model,
    /// Another model, in ONNX: input [1, 3, height, width], output [1, 4 + classes, boxes], as YOLOv8 and YOLO11 are exported.
    pub path: PathBuf,
    /// The classes of that model, in the order of its scores.
    pub classes: Vec<String>,
    /// What runs the model.
    pub runtime: Runtime,
    /// ONNX Runtime's library, of version 1.17 or newer. Empty: what `ORT_DYLIB_PATH` says, or the system's `libonnxruntime.so`.
    pub library: PathBuf,
    /// Look for what moves, too: things of a few pixels, which no model knows by their looks.
    pub motion: bool,
    /// A box with this score may begin a track.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub certain_score: f64,
    /// A box with this score may go on with one.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub doubtful_score: f64,
    /// What the model finds is called a drone where it is this sure that there is something; else it is told as `unknown`. Left out: 0.5 for the
    /// infrared model that comes with the plugin, 0.25 for the visible one, and 0 for another.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub drone_score: Option<f64>,
    /// A track of which nothing is found ends after this, in seconds.
    #[schemars(range(min = 0.05, max = 60.0))]
    pub coast_s: f64,
    /// Looking at a picture should take no longer, in seconds. Ten times as long is told as a fault.
    #[schemars(range(min = 0.001, max = 10.0))]
    pub budget_s: f64,
}

/// The models that come with the plugin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Model {
    /// For cameras of visible light.
    #[default]
    Visible,
    /// For thermal cameras.
    Infrared,
}

/// What a model can be run by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Runtime {
    /// ONNX Runtime where its library is found, and rten where not.
    #[default]
    Auto,
    /// rten, which is built into the plugin.
    Rten,
    /// ONNX Runtime: two to three times as quick on x86-64. It is C++ in the plugin's process.
    #[serde(rename = "onnxruntime")]
    Onnx,
}

/// What our own models tell apart, in the order of their scores.
const CLASSES: [&str; 4] = ["drone", "bird", "airplane", "helicopter"];

impl Default for Settings {
    fn default() -> Self {
        Self {
            camera: String::new(),
            model: Model::default(),
            path: PathBuf::new(),
            classes: CLASSES.map(str::to_owned).to_vec(),
            runtime: Runtime::default(),
            library: PathBuf::new(),
            motion: true,
            certain_score: 0.35,
            doubtful_score: 0.1,
            drone_score: None,
            coast_s: 1.0,
            budget_s: 0.1,
        }
    }
}

impl Settings {
    /// Whether every value can be worked with; else which cannot.
    pub(crate) fn check(&self) -> Result<(), String> {
        for (key, value, low, high) in [
            ("certain_score", self.certain_score, 0.01, 1.0),
            ("doubtful_score", self.doubtful_score, 0.01, 1.0),
            ("drone_score", self.drone_score(), 0.0, 1.0),
            ("coast_s", self.coast_s, 0.05, 60.0),
            ("budget_s", self.budget_s, 0.001, 10.0),
        ] {
            if !(low..=high).contains(&value) {
                return Err(format!("{key} = {value}: it must be within {low} and {high}"));
            }
        }
        if self.doubtful_score > self.certain_score {
            return Err("doubtful_score must not be above certain_score".to_owned());
        }
        let mut known = std::collections::BTreeSet::new();
        if self.classes.is_empty()
            || !self
                .classes
                .iter()
                .all(|class| !class.is_empty() && known.insert(class))
        {
            return Err("classes: one name for each score of the model, none twice".to_owned());
        }
        if self.own_model().is_some() && self.classes != CLASSES {
            return Err("classes are those of the model at path; without path they are the plugin's own".to_owned());
        }
        Ok(())
    }

    /// Whether a model of the plugin's own looks.
    pub(crate) fn own_model(&self) -> Option<Model> {
        self.path.as_os_str().is_empty().then_some(self.model)
    }

    pub(crate) fn drone_score(&self) -> f64 {
        self.drone_score.unwrap_or(match self.own_model() {
            Some(Model::Infrared) => 0.5,
            Some(Model::Visible) => 0.25,
            None => 0.0,
        })
    }

    pub(crate) fn tracking(&self) -> PictureSettings {
        PictureSettings {
            certain_score: self.certain_score,
            doubtful_score: self.doubtful_score,
            coast_s: self.coast_s,
            ..PictureSettings::default()
        }
    }
}
