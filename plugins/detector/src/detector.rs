//! The plugin: frames in, what is in them out.

use crate::eye::{Eye, Look};
use crate::model::OnnxModel;
use crate::report::{DetectorReport, PictureFault};
use crate::settings::Settings;
use crate::worker::Worker;
use minicbor::{Decode, Encode};
use schemars::JsonSchema;
use serde::Deserialize;
use skein_domain::exchange::{Create, Event};
use skein_domain::manifest::EffectKind;
use skein_domain::payload::{FrameHeader, PixelFormat};
use skein_domain::{CommandId, NodeTime};
use skein_plugin_sdk::{CreateError, Effects, Payload, PayloadManifest, PluginKind, frames, saved};

/// Changes when an older snapshot would be misunderstood. Fields that are only added keep it.
const SNAPSHOT_VERSION: u32 = 1;
/// A camera that gives no picture for so long is told of, in seconds.
const MISSING_AFTER_S: f64 = 3.0;
/// A look that takes so many times its budget is a fault.
const MUCH_TOO_LONG: f64 = 10.0;
/// How the mean of what a look takes follows the newest.
const TAKES_SHARE: f64 = 0.1;

/// It takes no commands.
#[derive(Debug, Deserialize, JsonSchema)]
pub enum NoCommand {}

/// A detector of one vehicle.
#[derive(Debug)]
pub struct Detector {
    settings: Settings,
    worker: Worker,
    core: Core,
    report: DetectorReport,
    /// When a picture came last.
    heard: Option<NodeTime>,
}

/// What outlives a restart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Encode, Decode)]
struct Core {
    /// Tracks of a new instance are numbered on from here, so that none is taken for an earlier one.
    #[n(0)]
    last_id: u64,
}

impl Payload for Detector {
    type Config = Settings;
    type Command = NoCommand;
    type State = DetectorReport;
    type Occurrence = ();

    const MANIFEST: PayloadManifest = PayloadManifest {
        kind: PluginKind::DETECTOR,
        name: "detector",
        version: env!("CARGO_PKG_VERSION"),
        description: "Finds UAVs, birds, aeroplanes and helicopters in a camera's pictures, by a model in ONNX and by what moves, and follows them.",
        effects: &[EffectKind::Report],
        mavlink_messages: &[],
        tick_rate_hz: 50,
    };

    fn create(create: Create, settings: Settings) -> Result<Self, CreateError> {
        settings.check().map_err(CreateError::new)?;
        let core: Core = saved::restored(SNAPSHOT_VERSION, create.snapshot.as_deref()).unwrap_or_default();
        let model = OnnxModel::of(&settings).map_err(|fault| CreateError::new(fault.to_string()))?;
        let runtime = model.runtime().to_owned();
        let eye = Eye::new(&settings, model, core.last_id).map_err(|fault| CreateError::new(fault.to_string()))?;
        let worker =
            Worker::start(eye).map_err(|error| CreateError::new(format!("no thread to look with: {error}")))?;
        Ok(Self {
            settings,
            worker,
            core,
            report: DetectorReport {
                runtime,
                ..DetectorReport::default()
            },
            heard: None,
        })
    }

    fn command(&mut self, _: NodeTime, _: CommandId, command: NoCommand, _: &mut Effects) {
        match command {}
    }

    fn handle(&mut self, now: NodeTime, events: &[Event], effects: &mut Effects) {
        for event in events {
            if let Event::Frame(header) = event {
                self.bring(now, header);
            }
        }
        let before = (self.report.fault.clone(), self.report.picture_fault);
        let looks = self.worker.take();
        let looked = !looks.is_empty();
        for look in looks {
            self.seen(look);
        }
        self.judge(now);
        if looked || before != (self.report.fault.clone(), self.report.picture_fault) {
            effects.report(&self.report);
        }
    }

    fn snapshot(&self) -> Vec<u8> {
        saved::encode(SNAPSHOT_VERSION, &self.core)
    }
}

impl Detector {
    fn bring(&mut self, now: NodeTime, header: &FrameHeader) {
        let meant = self.settings.camera.is_empty() || self.settings.camera == header.camera;
        // A camera gives its pictures decoded beside the encoded ones.
        if meant && header.format != PixelFormat::H264 {
            let brought = frames::read(header, |bytes| self.worker.bring(header, bytes));
            if brought.is_some() {
                self.heard = Some(now);
            }
        }
    }

    fn seen(&mut self, look: Look) {
        let report = &mut self.report;
        report.looked += 1;
        let share = TAKES_SHARE.max(1.0 / report.looked as f64);
        report.takes_s += share * (look.took_s - report.takes_s);
        report.stages.blend(&look.stages, share);
        report.found = look.found;
        report.picture_fault = look.picture_fault;
        report.fault = look.fault.map(|fault| fault.to_string()).unwrap_or_default();
        if look.took_s > MUCH_TOO_LONG * self.settings.budget_s {
            report.fault = too_long(self.settings.budget_s);
        }
        self.core.last_id = look.last_id;
    }

    /// What shows by what does not happen.
    fn judge(&mut self, now: NodeTime) {
        if let Some(why) = self.worker.broken() {
            // The supervision starts a new instance, with a new thread.
            panic!("the thread that looks at pictures has ended: {why}");
        }
        self.report.dropped = self.worker.dropped();
        let busy_s = self.worker.busy_for().as_secs_f64();
        if busy_s > MUCH_TOO_LONG * self.settings.budget_s {
            self.report.fault = too_long(self.settings.budget_s);
        }
        let heard = *self.heard.get_or_insert(now);
        if now.seconds_since(heard) > MISSING_AFTER_S {
            self.report.picture_fault = Some(PictureFault::Missing);
            self.report.found.findings.clear();
        }
    }
}

fn too_long(budget_s: f64) -> String {
    format!(
        "looking at a picture takes more than ten times its budget of {budget_s} s: a smaller model or smaller pictures are needed"
    )
}
