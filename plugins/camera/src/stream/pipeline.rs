//! A pipeline of GStreamer that gives H.264: cameras on a computer's own ports, and its encoders.
//!
//! Must never do: wait for a pipeline without an end, or leave one that runs.

use super::{Coded, Outlet, StreamFault};
use gstreamer::prelude::*;
use gstreamer::{ClockTime, MessageType, MessageView, ParseContext, ParseFlags, Pipeline, State};
use gstreamer_app::AppSink;
use std::time::{Duration, Instant};
use thiserror::Error;

/// What makes access units of what the configured pipeline gives, with parameter sets before each key picture.
const BEHIND: &str = "h264parse config-interval=-1 ! video/x-h264,stream-format=byte-stream,alignment=au ! appsink name=skein sync=false max-buffers=8";
const SINK: &str = "skein";
/// A pipeline that gives nothing for so long is made anew.
const SILENT_AFTER: Duration = Duration::from_secs(5);
/// How often it is looked for faults, and whether anybody still wants the stream.
const LOOK_EVERY: ClockTime = ClockTime::from_mseconds(100);

/// Why a pipeline gives nothing.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub(crate) enum PipelineFault {
    #[error("GStreamer does not start: {0}")]
    Library(String),
    #[error("GStreamer has no element {0}: a package of its plugins is missing, or the name is wrong")]
    NoElement(String),
    #[error("the pipeline cannot be made: {0}")]
    Unmade(String),
    #[error("{element} of the pipeline: {reason}")]
    Element { element: String, reason: String },
    #[error("the pipeline does not start")]
    Unstarted,
    #[error("the pipeline gave no picture within {within_s} s")]
    Silent { within_s: u64 },
    #[error("the pipeline has ended")]
    Ended,
}

/// Reads until nobody wants it any more.
pub(super) fn read(description: &str, outlet: &Outlet) -> Result<(), StreamFault> {
    Ok(give_all(description, outlet)?)
}

fn give_all(description: &str, outlet: &Outlet) -> Result<(), PipelineFault> {
    gstreamer::init().map_err(|error| PipelineFault::Library(error.message().to_owned()))?;
    let running = Running::start(description)?;
    let mut last_picture = Instant::now();
    while outlet.is_wanted() {
        if let Some(sample) = running.sink.try_pull_sample(LOOK_EVERY) {
            last_picture = Instant::now();
            let readable = sample.buffer().and_then(|buffer| buffer.map_readable().ok());
            let bytes = readable.map(|bytes| bytes.to_vec()).unwrap_or_default();
            if !outlet.give(Ok(Coded::at_once(bytes))) {
                break;
            }
        }
        running.check()?;
        if last_picture.elapsed() >= SILENT_AFTER {
            let within_s = SILENT_AFTER.as_secs();
            return Err(PipelineFault::Silent { within_s });
        }
    }
    Ok(())
}

/// A pipeline that ends with this value.
struct Running {
    pipeline: Pipeline,
    sink: AppSink,
}

impl Running {
    fn start(description: &str) -> Result<Self, PipelineFault> {
        let mut context = ParseContext::new();
        let whole = format!("{description} ! {BEHIND}");
        let made = gstreamer::parse::launch_full(&whole, Some(&mut context), ParseFlags::FATAL_ERRORS);
        let element = made.map_err(|error| match context.missing_elements() {
            missing if missing.is_empty() => PipelineFault::Unmade(error.message().to_owned()),
            missing => PipelineFault::NoElement(missing.join(", ")),
        })?;
        let pipeline = element.downcast::<Pipeline>();
        let pipeline = pipeline.map_err(|_| PipelineFault::Unmade("it is no chain of elements".to_owned()))?;
        let sink = pipeline.by_name(SINK).and_then(|sink| sink.downcast::<AppSink>().ok());
        let sink = sink.ok_or_else(|| PipelineFault::Unmade(format!("the name {SINK} is taken")))?;
        let running = Self { pipeline, sink };
        if running.pipeline.set_state(State::Playing).is_err() {
            // Why is on the bus.
            running.check()?;
            return Err(PipelineFault::Unstarted);
        }
        Ok(running)
    }

    /// Whether it goes on; else why not.
    fn check(&self) -> Result<(), PipelineFault> {
        let bus = self.pipeline.bus();
        let message = bus.and_then(|bus| bus.pop_filtered(&[MessageType::Error, MessageType::Eos]));
        match message.as_ref().map(|message| message.view()) {
            None => Ok(()),
            Some(MessageView::Error(error)) => {
                let element = error.src().map(|element| element.name().to_string());
                Err(PipelineFault::Element {
                    element: element.unwrap_or_default(),
                    reason: error.error().message().to_owned(),
                })
            }
            Some(_) => Err(PipelineFault::Ended),
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // What does not end now has its device taken from it when the process ends.
        let _ = self.pipeline.set_state(State::Null);
    }
}

#[cfg(test)]
mod tests;
