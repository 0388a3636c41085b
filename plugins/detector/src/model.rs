//! A model in ONNX: one picture in, boxes with scores out.
//!
//! Input `[1, 3, height, width]`, float32, red, green and blue from 0 to 1. Output `[1, 4 + classes, boxes]`, float32: for each box the middle,
//! the width and the height in pixels of the input, and a score from 0 to 1 for each class. That is what YOLOv8 and YOLO11 are exported as.
//!
//! Must never do: trust a shape or a number that a model gives.

use crate::fault::ModelFault;
use crate::net::Net;
use crate::picture::Picture;
use crate::settings::{Model, Settings};
use fast_image_resize::images::{TypedImage, TypedImageRef};
use fast_image_resize::pixels::U8x3;
use fast_image_resize::{FilterType, ResizeAlg, ResizeOptions, Resizer};
use rten_tensor::NdTensor;
use rten_tensor::prelude::*;
use skein_vision::{Bounds, ClassScores, Found};

/// Boxes that share more of their area than this are one thing.
const SAME_OVERLAP: f64 = 0.5;
/// A file larger than this is no model for a small computer, in bytes.
const MOST_BYTES: u64 = 512 << 20;
/// Larger inputs are not believed, in pixels.
const MOST_PIXELS: usize = 4 << 20;
/// More boxes than this are not looked at.
const MOST_BOXES: usize = 200_000;
/// What is around a picture of another shape than the model's.
const AROUND: f32 = 114.0 / 255.0;
/// Of our own, by camera.
const VISIBLE: &[u8] = include_bytes!("../models/visible.onnx");
const INFRARED: &[u8] = include_bytes!("../models/infrared.onnx");

/// A model that is ready to run.
pub(crate) struct OnnxModel {
    net: Net,
    width: usize,
    height: usize,
    classes: Vec<String>,
}

impl OnnxModel {
    /// The one that the settings name.
    ///
    /// # Errors
    ///
    /// It cannot be read, or is not of the shape that is wanted.
    pub(crate) fn of(settings: &Settings) -> Result<Self, ModelFault> {
        let bytes = if settings.path.as_os_str().is_empty() {
            match settings.model {
                Model::Visible => VISIBLE.to_vec(),
                Model::Infrared => INFRARED.to_vec(),
            }
        } else {
            let fault = |why: String| ModelFault::File {
                path: settings.path.display().to_string(),
                why,
            };
            let file = std::fs::metadata(&settings.path).map_err(|error| fault(error.to_string()))?;
            // A device has no end.
            if !file.is_file() {
                return Err(fault("it is no file".to_owned()));
            }
            let size = file.len();
            if size > MOST_BYTES {
                return Err(fault(format!("it has {size} bytes, more than {MOST_BYTES}")));
            }
            std::fs::read(&settings.path).map_err(|error| fault(error.to_string()))?
        };
        Self::new(bytes, settings)
    }

    /// # Errors
    ///
    /// As above.
    pub(crate) fn new(onnx: Vec<u8>, settings: &Settings) -> Result<Self, ModelFault> {
        let net = Net::load(onnx, settings)?;
        let shape = net.input_sizes();
        let sizes: Option<Vec<usize>> = shape.iter().copied().collect();
        let (width, height) = match sizes.as_deref() {
            Some([1, 3, height, width]) if (1..=MOST_PIXELS).contains(&(height * width)) => (*width, *height),
            _ => return Err(ModelFault::Input(format!("{shape:?}"))),
        };
        let mut model = Self {
            net,
            width,
            height,
            classes: settings.classes.clone(),
        };
        // Whether its output is of the right shape shows when it is run.
        model.boxes(NdTensor::zeros([1, 3, height, width]), 1.0)?;
        Ok(model)
    }

    /// What is in a picture, with a score of `least` or more.
    ///
    /// # Errors
    ///
    /// The model fails, or gives what cannot be true.
    pub(crate) fn find(&mut self, picture: &Picture, least: f64) -> Result<Vec<Found>, ModelFault> {
        let fitted = Fitted::new(picture, self.width, self.height);
        let found = self.boxes(fitted.input(picture, self.width, self.height)?, least)?;
        let found = found.into_iter().map(|found| fitted.back(found));
        Ok(apart(found.collect()))
    }

    /// What runs it.
    pub(crate) fn runtime(&self) -> &'static str {
        self.net.runtime()
    }

    fn boxes(&mut self, input: NdTensor<f32, 4>, least: f64) -> Result<Vec<Found>, ModelFault> {
        let output = self.net.run(input)?;
        let wrong = |output: String| ModelFault::Output {
            output,
            classes: self.classes.len(),
        };
        let [one, rows, boxes] = output.shape();
        if one != 1 || rows != 4 + self.classes.len() || boxes > MOST_BOXES {
            return Err(wrong(format!("{:?}", output.shape())));
        }
        let mut found = Vec::new();
        for index in 0..boxes {
            let at = |row: usize| f64::from(output[[0, row, index]]);
            let scores = (0..self.classes.len()).map(|class| at(4 + class));
            let best = scores.clone().fold(0.0, f64::max);
            if (0..rows).any(|row| !at(row).is_finite()) {
                return Err(ModelFault::NotNumbers);
            }
            if best >= least {
                let named = self.classes.iter().cloned().zip(scores);
                found.push(Found {
                    bounds: Bounds {
                        center_x_px: at(0),
                        center_y_px: at(1),
                        width_px: at(2),
                        height_px: at(3),
                    },
                    scores: ClassScores::all(named),
                });
            }
        }
        found.retain(|found| found.bounds.is_sound());
        Ok(found)
    }
}

/// How a picture lies in the model's input: as large as it fits, in the middle.
struct Fitted {
    scale: f64,
    left: f64,
    top: f64,
}

impl Fitted {
    fn new(picture: &Picture, width: usize, height: usize) -> Self {
        let (from_width, from_height) = (picture.width as f64, picture.height as f64);
        let scale = (width as f64 / from_width).min(height as f64 / from_height);
        Self {
            scale,
            left: ((width as f64 - from_width * scale) / 2.0).floor(),
            top: ((height as f64 - from_height * scale) / 2.0).floor(),
        }
    }

    fn input(&self, picture: &Picture, width: usize, height: usize) -> Result<NdTensor<f32, 4>, ModelFault> {
        let inner = |size: usize, most: usize| ((size as f64 * self.scale).round() as usize).clamp(1, most);
        let (inner_width, inner_height) = (inner(picture.width, width), inner(picture.height, height));
        let resized = if (inner_width, inner_height) == (picture.width, picture.height) {
            None
        } else {
            Some(resized(picture, inner_width, inner_height)?)
        };
        let rgb = resized.as_deref().unwrap_or(&picture.rgb);
        let mut input = NdTensor::full([1, 3, height, width], AROUND);
        let plane = height * width;
        let Some(data) = input.data_mut() else {
            return Err(ModelFault::Failed("its input is not in one piece".to_owned()));
        };
        let (left, top) = (self.left as usize, self.top as usize);
        for (y, row) in rgb.chunks_exact(3 * inner_width).enumerate() {
            let start = (top + y) * width + left;
            for (x, pixel) in row.chunks_exact(3).enumerate() {
                for (channel, value) in pixel.iter().enumerate() {
                    data[channel * plane + start + x] = f32::from(*value) / 255.0;
                }
            }
        }
        Ok(input)
    }

    fn back(&self, mut found: Found) -> Found {
        let bounds = &mut found.bounds;
        bounds.center_x_px = (bounds.center_x_px - self.left) / self.scale;
        bounds.center_y_px = (bounds.center_y_px - self.top) / self.scale;
        bounds.width_px /= self.scale;
        bounds.height_px /= self.scale;
        found
    }
}

/// The picture in another size: each pixel the mean of those that it covers.
fn resized(picture: &Picture, width: usize, height: usize) -> Result<Vec<u8>, ModelFault> {
    let failed = |why: String| ModelFault::Failed(format!("the picture cannot be made to fit: {why}"));
    // For this kind of pixel alone: for all kinds the library is compiled for minutes.
    let from = TypedImageRef::<U8x3>::from_buffer(picture.width as u32, picture.height as u32, &picture.rgb);
    let from = from.map_err(|error| failed(error.to_string()))?;
    let mut rgb = vec![0; 3 * width * height];
    let to = TypedImage::<U8x3>::from_buffer(width as u32, height as u32, &mut rgb);
    let mut to = to.map_err(|error| failed(error.to_string()))?;
    let options = ResizeOptions::new().resize_alg(ResizeAlg::Convolution(FilterType::Bilinear));
    Resizer::new()
        .resize_typed(&from, &mut to, &options)
        .map_err(|error| failed(error.to_string()))?;
    Ok(rgb)
}

/// Of boxes that lie over each other the one with the best score.
fn apart(mut found: Vec<Found>) -> Vec<Found> {
    let score = |found: &Found| found.scores.best().map_or(0.0, |(_, score)| score);
    found.sort_by(|a, b| score(b).total_cmp(&score(a)));
    let mut kept: Vec<Found> = Vec::new();
    for one in found {
        if !kept
            .iter()
            .any(|other| other.bounds.overlap(&one.bounds) > SAME_OVERLAP)
        {
            kept.push(one);
        }
    }
    kept
}
