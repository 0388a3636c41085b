//! What runs a model: rten, which is built into the plugin, or ONNX Runtime where its library is installed.
//!
//! Must never do: load a library from anywhere but where the settings, `ORT_DYLIB_PATH` or the system's own search say it is.

use crate::fault::ModelFault;
use crate::settings::{Runtime, Settings};
use ort::environment::Environment;
use ort::session::Session;
use ort::value::TensorRef;
use rten::{Dimension, RunOptions, ThreadPool};
use rten_tensor::NdTensor;
use rten_tensor::prelude::*;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

/// As the system finds it.
const LIBRARY: &str = "libonnxruntime.so";

/// A model that is ready to run, on one thread: the others of the computer fly.
pub(crate) enum Net {
    Rten(Box<rten::Model>, Arc<ThreadPool>),
    OnnxRuntime(Session),
}

impl Net {
    /// # Errors
    ///
    /// It is no model, or the runtime that is asked for cannot be had.
    pub(crate) fn load(onnx: Vec<u8>, settings: &Settings) -> Result<Self, ModelFault> {
        match settings.runtime {
            Runtime::Rten => Self::rten(onnx),
            Runtime::Onnx => Self::onnx_runtime(&onnx, settings),
            Runtime::Auto => Self::onnx_runtime(&onnx, settings).or_else(|_| Self::rten(onnx)),
        }
    }

    fn rten(onnx: Vec<u8>) -> Result<Self, ModelFault> {
        let net = rten::Model::load(onnx).map_err(|error| ModelFault::Unreadable(error.to_string()))?;
        Ok(Self::Rten(Box::new(net), Arc::new(ThreadPool::with_num_threads(1))))
    }

    fn onnx_runtime(onnx: &[u8], settings: &Settings) -> Result<Self, ModelFault> {
        let environment = environment(settings).map_err(ModelFault::Runtime)?;
        let session = || -> ort::Result<Session> {
            let builder = Session::builder(environment)?;
            let mut builder = builder.with_intra_threads(1).map_err(ort::Error::<()>::from)?;
            builder.commit_from_memory(onnx)
        };
        let session = session().map_err(|error| ModelFault::Unreadable(error.to_string()))?;
        Ok(Self::OnnxRuntime(session))
    }

    /// What runs it, in a word.
    pub(crate) fn runtime(&self) -> &'static str {
        match self {
            Self::Rten(..) => "rten",
            Self::OnnxRuntime(_) => "onnxruntime",
        }
    }

    /// The sizes of its first input, as far as they are fixed.
    pub(crate) fn input_sizes(&self) -> Vec<Option<usize>> {
        match self {
            Self::Rten(net, _) => {
                let fixed = |dimension: &Dimension| match dimension {
                    Dimension::Fixed(size) => Some(*size),
                    Dimension::Symbolic(_) => None,
                };
                net.input_shape(0).unwrap_or_default().iter().map(fixed).collect()
            }
            Self::OnnxRuntime(session) => {
                let shape = session.inputs().first().and_then(|input| input.dtype().tensor_shape());
                let sizes = shape.map(|shape| shape.iter().map(|size| usize::try_from(*size).ok()).collect());
                sizes.unwrap_or_default()
            }
        }
    }

    /// Its first output for a picture.
    ///
    /// # Errors
    ///
    /// It fails, or gives something else than numbers in three dimensions.
    pub(crate) fn run(&mut self, input: NdTensor<f32, 4>) -> Result<NdTensor<f32, 3>, ModelFault> {
        match self {
            Self::Rten(net, threads) => {
                let options = RunOptions::default().with_thread_pool(Some(threads.clone()));
                let output = net.run_one(input.into(), Some(options));
                let output = output.map_err(|error| ModelFault::Failed(error.to_string()))?;
                output.try_into().map_err(|error| ModelFault::Shape(format!("{error}")))
            }
            Self::OnnxRuntime(session) => {
                let failed = |error: ort::Error| ModelFault::Failed(error.to_string());
                let (shape, numbers) = (input.shape(), input.to_vec());
                let input = TensorRef::from_array_view((shape, numbers.as_slice())).map_err(failed)?;
                let outputs = session.run(ort::inputs![input]).map_err(failed)?;
                let first = outputs.values().next();
                let first = first.ok_or_else(|| ModelFault::Shape("nothing".to_owned()))?;
                let (shape, numbers) = first.try_extract_tensor::<f32>().map_err(failed)?;
                let sizes: Vec<usize> = shape.iter().filter_map(|size| usize::try_from(*size).ok()).collect();
                let sizes: [usize; 3] = sizes
                    .try_into()
                    .map_err(|sizes| ModelFault::Shape(format!("{sizes:?}")))?;
                Ok(NdTensor::from_data(sizes, numbers.to_vec()))
            }
        }
    }
}

/// ONNX Runtime in this process, or why it cannot be had. A process has one, and keeps the first that could be loaded.
fn environment(settings: &Settings) -> Result<&'static Environment, String> {
    static LOADED: OnceLock<(PathBuf, Environment)> = OnceLock::new();
    let asked = (!settings.library.as_os_str().is_empty()).then(|| settings.library.clone());
    if LOADED.get().is_none() {
        let from_variable = || std::env::var_os("ORT_DYLIB_PATH").map(PathBuf::from);
        let library = asked.clone().or_else(from_variable).unwrap_or_else(|| LIBRARY.into());
        let builder = ort::init_from(&library).map_err(|error| error.to_string())?;
        let environment = builder.build().map_err(|error| error.to_string())?;
        LOADED.get_or_init(|| (library, environment));
    }
    match LOADED.get() {
        Some((library, environment)) if asked.is_none_or(|asked| asked == *library) => Ok(environment),
        Some((library, _)) => Err(format!("{} is in use already", library.display())),
        None => Err("it is gone".to_owned()),
    }
}
