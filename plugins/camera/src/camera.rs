//! The plugin: commands in, frames and the state out.

mod frames;
mod report;

use crate::capture::Capture;
use crate::occurrence::CameraEvent;
use crate::remote::{self, Remote};
use crate::settings::{Settings, Source};
use crate::truth::CameraReport;
use frames::Frames;
use minicbor::{Decode, Encode};
use payload_mavlink::Outcome;
use report::Reporter;
use skein_domain::exchange::{Create, Event, OwnState};
use skein_domain::manifest::EffectKind;
use skein_domain::payload::CameraCommand;
use skein_domain::{CommandId, NodeTime, Refusal};
use skein_plugin_sdk::{CreateError, Effects, Payload, PayloadManifest, PluginKind, saved};

/// Changes when an older snapshot would be misunderstood. Fields that are only added keep it.
const SNAPSHOT_VERSION: u32 = 1;

/// A camera of one vehicle.
#[derive(Debug)]
pub struct Camera {
    settings: Settings,
    core: Core,
    frames: Frames,
    /// The vehicle as it was last told; every batch tells it anew.
    own: OwnState,
    reporter: Reporter,
}

/// What outlives a restart.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
struct Core {
    #[n(0)]
    capture: Capture,
    #[n(1)]
    remote: Option<Remote>,
    /// Pictures taken from the source of stills or video: it goes on behind them.
    #[n(2)]
    taken: u64,
    /// Encoded pictures given since it was first started.
    #[n(3)]
    #[cbor(default)]
    coded: u64,
}

impl Payload for Camera {
    type Config = Settings;
    type Command = CameraCommand;
    type State = CameraReport;
    type Occurrence = CameraEvent;

    const MANIFEST: PayloadManifest = PayloadManifest {
        kind: PluginKind::CAMERA,
        name: "camera",
        version: env!("CARGO_PKG_VERSION"),
        description: "A camera over MAVLink's camera protocol v2, and frames from a simulated scene, a folder of pictures or a video file.",
        effects: &[
            EffectKind::CommandProgress,
            EffectKind::Mavlink,
            EffectKind::Report,
            EffectKind::Occurrence,
            EffectKind::Frame,
        ],
        mavlink_messages: remote::MESSAGES,
        tick_rate_hz: 60,
    };

    fn create(create: Create, settings: Settings) -> Result<Self, CreateError> {
        settings.check().map_err(CreateError::new)?;
        let restored = saved::restored(SNAPSHOT_VERSION, create.snapshot.as_deref());
        let fits = |core: &Core| core.remote.is_some() == settings.steers_remote();
        let core = restored.filter(fits).unwrap_or_else(|| Core {
            capture: Capture::default(),
            remote: settings.steers_remote().then(|| Remote::new(create.system_id)),
            taken: 0,
            coded: 0,
        });
        let frames = Frames::new(&settings, create.vehicle, core.taken);
        Ok(Self {
            settings,
            core,
            frames,
            own: OwnState::default(),
            reporter: Reporter::default(),
        })
    }

    fn command(&mut self, now: NodeTime, id: CommandId, command: CameraCommand, effects: &mut Effects) {
        if let Err(refusal) = self.begin(now, id, command, effects) {
            effects.refused(id, refusal);
        }
        self.report(now, effects);
    }

    fn handle(&mut self, now: NodeTime, events: &[Event], effects: &mut Effects) {
        for event in events {
            match event {
                Event::Own(own) => self.own = *own,
                Event::Peers(peers) => self.frames.see(peers, &self.settings),
                Event::Payload(report) => self.frames.hear(report, &self.settings),
                Event::Mavlink(message) => {
                    let remote = self.core.remote.as_mut();
                    let outcome = remote.and_then(|remote| remote.hear(now, message, &self.settings, effects));
                    end(outcome, effects);
                }
                Event::Tick => self.tick(now, effects),
                _ => {}
            }
        }
        self.report(now, effects);
    }

    fn snapshot(&self) -> Vec<u8> {
        saved::encode(SNAPSHOT_VERSION, &self.core)
    }
}

fn end(outcomes: impl IntoIterator<Item = Outcome<CommandId>>, effects: &mut Effects) {
    for (id, outcome) in outcomes {
        effects.ended(id, outcome);
    }
}

impl Camera {
    /// Begins a command, or says why not.
    fn begin(
        &mut self,
        now: NodeTime,
        id: CommandId,
        command: CameraCommand,
        effects: &mut Effects,
    ) -> Result<(), Refusal> {
        self.check(command)?;
        let Some(remote) = &mut self.core.remote else {
            self.obey(now, command, effects)?;
            effects.done(id);
            return Ok(());
        };
        remote.tell(now, id, command, &self.settings)?;
        effects.executing(id);
        let outcomes = remote.work(now, &self.settings, effects);
        end(outcomes, effects);
        Ok(())
    }

    fn check(&self, command: CameraCommand) -> Result<(), Refusal> {
        match command {
            CameraCommand::TakePictures { interval_s, .. } if !(0.0..=86_400.0).contains(&interval_s) => {
                Err(Refusal::invalid("interval_s must be within 0 and 86400"))
            }
            CameraCommand::Zoom { factor } if !(1.0..=self.settings.zoom_max).contains(&factor) => Err(
                Refusal::invalid(format!("factor must be within 1 and {}", self.settings.zoom_max)),
            ),
            _ => Ok(()),
        }
    }

    /// Does what a camera without a device of its own can do: its pictures are its frames.
    fn obey(&mut self, now: NodeTime, command: CameraCommand, effects: &mut Effects) -> Result<(), Refusal> {
        let capture = &mut self.core.capture;
        match command {
            CameraCommand::TakePictures { count, interval_s } => capture.take_pictures(now, count, interval_s),
            CameraCommand::StopPictures => capture.stop_pictures(),
            CameraCommand::StartRecording => capture.start_recording(now, effects),
            CameraCommand::StopRecording => capture.stop_recording(now, effects),
            CameraCommand::SetMode { mode } => capture.set_mode(mode),
            CameraCommand::Zoom { factor } if self.settings.source == Source::Synthetic => capture.zoom = factor,
            CameraCommand::Zoom { .. } => {
                return Err(Refusal::not_supported("zoom of recorded pictures"));
            }
            CameraCommand::StartStream { .. } | CameraCommand::StopStream { .. } => {
                return Err(Refusal::not_supported("streams of a camera that is no device"));
            }
        }
        Ok(())
    }

    fn tick(&mut self, now: NodeTime, effects: &mut Effects) {
        if let Some(remote) = &mut self.core.remote {
            let outcomes = remote.work(now, &self.settings, effects);
            end(outcomes, effects);
        }
        self.give_frame(now, effects);
        self.give_coded(now, effects);
    }

    /// The zoom factor at which frames are taken.
    fn zoom(&self) -> f64 {
        let remote = self.core.remote.as_ref();
        remote
            .and_then(|remote| remote.zoom(&self.settings))
            .unwrap_or(self.core.capture.zoom)
    }

    fn field_of_view_rad(&self) -> f64 {
        self.settings
            .field_of_view_at(self.settings.field_of_view_rad, self.zoom())
    }
}
