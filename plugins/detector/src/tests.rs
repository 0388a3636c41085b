//! Eye, model, joining rule and worker, each without a host.

mod eyes;
mod joins;
mod models;
mod pictures;
mod workers;

use crate::eye::Eye;
use crate::fault::ModelFault;
use crate::model::OnnxModel;
use crate::settings::Settings;
use skein_domain::NodeTime;
use skein_domain::payload::{FrameHeader, PixelFormat};
use std::path::Path;

const WIDTH: usize = 64;
const HEIGHT: usize = 48;

/// A model of `tests/models`, which `make.py` there writes.
fn settings(model: &str) -> Settings {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/tests/models");
    Settings {
        path: folder.join(format!("{model}.onnx")),
        ..Settings::default()
    }
}

fn model(name: &str) -> Result<OnnxModel, ModelFault> {
    OnnxModel::of(&settings(name))
}

fn eye(name: &str) -> Eye {
    Eye::new(&settings(name), model(name).expect("is a model"), 0).expect("sees")
}

/// A grey picture of that brightness, the `index`-th of thirty in a second.
fn frame(index: u32, brightness: u8) -> (FrameHeader, Vec<u8>) {
    let header = FrameHeader {
        sequence: u64::from(index),
        time: NodeTime(0).plus_seconds(1.0 + f64::from(index) / 30.0),
        width_px: WIDTH as u32,
        height_px: HEIGHT as u32,
        format: PixelFormat::Gray8,
        camera: "front".to_owned(),
        ..FrameHeader::default()
    };
    // A little different each time, as a sensor is.
    let pixels = (0..WIDTH * HEIGHT).map(|at| brightness.saturating_add(u8::from(at as u32 % 7 == index % 7)));
    (header, pixels.collect())
}
