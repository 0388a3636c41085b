//! What can be wrong with a model.
//!
//! Must never do: stand for a fault of the camera's pictures.

use thiserror::Error;

/// Why a model is of no use.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub(crate) enum ModelFault {
    /// There is no such file, or none that can be read.
    #[error("the model at {path} cannot be read: {why}")]
    File {
        /// Where.
        path: String,
        /// Why not.
        why: String,
    },
    /// It is no model that can be run.
    #[error("the model cannot be read: {0}")]
    Unreadable(String),
    /// Its input is not a picture.
    #[error("the model's input is {0}, not [1, 3, height, width]")]
    Input(String),
    /// Its output is not boxes.
    #[error("the model's output is {output}, not [1, 4 + {classes} classes, boxes]")]
    Output {
        /// What it is.
        output: String,
        /// How many classes are named.
        classes: usize,
    },
    /// Its output has another shape than one of boxes.
    #[error("the model's output is {0}, not three-dimensional")]
    Shape(String),
    /// The runtime that is asked for is not there.
    #[error("ONNX Runtime cannot be loaded: {0}")]
    Runtime(String),
    /// It gives no numbers.
    #[error("the model gives numbers that are none")]
    NotNumbers,
    /// It could not be run.
    #[error("the model failed: {0}")]
    Failed(String),
}
