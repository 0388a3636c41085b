//! Shows the pictures of a clip to a detector plugin, one after the other, and waits for what it says of each.
//!
//! Must never do: let the detector drop a picture for want of time: here it has all it needs.

use super::clips::Clip;
use super::report::Watched;
use anyhow::{Context, bail, ensure};
use skein_domain::exchange::{Create, Effect, Event, EventBatch};
use skein_domain::payload::{DetectorState, Finding, FrameHeader, PixelFormat};
use skein_domain::{Incarnation, NodeTime, SystemId, VehicleId};
use skein_plugin_host::{Frame, FrameSource, Instance, Isolation, Plugin, PluginKind, RunnerSettings, Runners, Trust};
use skein_video::{H264Decoder, Mp4Reader, Rgb};
use skein_vision::{Bounds, ToldBox, TrueBox};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Nobody flies here: a slow computer may take its time.
const CALL_DEADLINE: Duration = Duration::from_secs(10);
/// A detector that says nothing of a picture for so long does not see it at all.
const LOOK_WITHIN: Duration = Duration::from_secs(60);
/// How often it is asked whether it has looked.
const ASK_EVERY: Duration = Duration::from_micros(500);

/// A detector that can be shown clips.
pub(super) struct Eye {
    runners: Arc<Runners>,
    plugin: Arc<Plugin>,
    config: serde_json::Map<String, serde_json::Value>,
}

impl Eye {
    /// # Errors
    ///
    /// There is no such plugin, or it is no detector.
    pub(super) fn load(path: &Path, config: &str) -> anyhow::Result<Self> {
        let plugin = Plugin::load_trusted(path, &Trust::default())
            .with_context(|| format!("{}: build it with `cargo xtask build-plugins`", path.display()))?;
        ensure!(
            plugin.manifest().kind == PluginKind::DETECTOR,
            "{} is no detector",
            path.display()
        );
        let config = serde_json::from_str(config).context("--config is no JSON object")?;
        let runners = Runners::with_settings(RunnerSettings {
            call_deadline: CALL_DEADLINE,
            create_deadline: CALL_DEADLINE,
            ..RunnerSettings::default()
        });
        Ok(Self {
            runners,
            plugin,
            config,
        })
    }

    /// The configuration for the clips of one camera.
    fn config(&self, camera: &str) -> String {
        let mut config = self.config.clone();
        if self.plugin.manifest().name == "detector" && !config.contains_key("path") {
            config.entry("model").or_insert_with(|| camera.into());
        }
        serde_json::Value::Object(config).to_string()
    }

    /// Shows a clip to a new instance.
    ///
    /// # Errors
    ///
    /// The video cannot be read, or the detector fails.
    pub(super) async fn watch(&self, mut clip: Clip) -> anyhow::Result<Watched> {
        let create = Create {
            vehicle: VehicleId(1),
            incarnation: Incarnation(1),
            config_json: self.config(&clip.camera),
            snapshot: None,
            now: NodeTime(0),
            payload: Some("detector".to_owned()),
            system_id: Some(SystemId(1)),
        };
        let instance = self
            .runners
            .create(self.plugin.clone(), Isolation::InProcess, create)
            .await?;
        let mut video = Mp4Reader::open(&clip.path)?;
        let renumbered = clip.number_from_zero(video.len());
        let (mut decoder, mut watched) = (H264Decoder::for_files()?, Watched::new(&clip, renumbered));
        let mut showing = Showing {
            instance,
            source: FrameSource::new()?,
            shown_s: video.shown_s().to_vec(),
            clip,
        };
        for index in 0..video.len() {
            let coded = video.coded(index)?;
            let begun = Instant::now();
            let decoded = decoder.decode_rgb(&coded);
            watched.decoding_s += begun.elapsed().as_secs_f64();
            // One that cannot be decoded is passed over, as a camera's is.
            if let Ok(Some(picture)) = decoded {
                showing.show(&picture, &mut watched).await?;
            }
        }
        for picture in decoder.remaining_rgb() {
            showing.show(&picture, &mut watched).await?;
        }
        if watched.pictures.is_empty() {
            bail!("no picture of {} can be decoded", showing.clip.path.display());
        }
        watched.undecoded = (video.len() - watched.pictures.len().min(video.len())) as u64;
        Ok(watched)
    }
}

/// A clip that is being shown to an instance.
struct Showing {
    instance: Instance,
    source: FrameSource,
    shown_s: Vec<f64>,
    clip: Clip,
}

impl Showing {
    async fn show(&mut self, picture: &Rgb, watched: &mut Watched) -> anyhow::Result<()> {
        let number = watched.pictures.len();
        let at_s = self.shown_s.get(number).copied().unwrap_or_default();
        let header = FrameHeader {
            sequence: number as u64 + 1,
            // Not the beginning of time: a detector that was never shown anything says that.
            time: NodeTime(0).plus_seconds(1.0 + at_s),
            width_px: picture.width_px,
            height_px: picture.height_px,
            format: PixelFormat::Rgb8,
            camera: self.clip.camera.clone(),
            ..FrameHeader::default()
        };
        let frame = self.source.frame(header, &picture.rgb)?;
        let begun = Instant::now();
        let (said, stages) = look(&self.instance, frame).await?;
        watched.looking_s += begun.elapsed().as_secs_f64();
        for (stage, took_s) in stages {
            *watched.stages_s.entry(stage).or_default() += took_s;
        }
        let truth = self.clip.truth.get(&number).map(|bounds| TrueBox {
            thing: 0,
            class: self.clip.label.clone(),
            bounds: *bounds,
        });
        let told = watched.names.told(&said.findings);
        watched.pictures.push((truth.into_iter().collect(), told));
        Ok(())
    }
}

/// How long each part of looking takes, as a detector says itself, in seconds.
type Stages = BTreeMap<String, f64>;

/// Shows one picture, and waits for what is said of it.
async fn look(instance: &Instance, frame: Arc<Frame>) -> anyhow::Result<(DetectorState, Stages)> {
    let time = frame.header.time;
    let begun = Instant::now();
    let mut events = vec![Event::Frame(frame.header.clone()), Event::Tick];
    let mut frames = vec![frame];
    while begun.elapsed() < LOOK_WITHIN {
        let batch = EventBatch {
            now: time.plus_seconds(begun.elapsed().as_secs_f64()),
            events: std::mem::replace(&mut events, vec![Event::Tick]),
        };
        let answer = instance.call(batch, &frames).await?;
        frames.clear();
        for effect in answer.effects {
            let Effect::Report { state_json } = effect else {
                continue;
            };
            let said: serde_json::Value = serde_json::from_str(&state_json)?;
            let fault = said.get("fault").and_then(|fault| fault.as_str()).unwrap_or_default();
            ensure!(fault.is_empty(), "the detector says: {fault}");
            let stages = said.get("stages").cloned();
            let stages = stages.and_then(|stages| serde_json::from_value(stages).ok());
            let said: DetectorState = serde_json::from_value(said).context("its state is not a detector's")?;
            if said.time == time {
                return Ok((said, stages.unwrap_or_default()));
            }
        }
        tokio::time::sleep(ASK_EVERY).await;
    }
    bail!(
        "the detector says nothing of a picture within {} s",
        LOOK_WITHIN.as_secs()
    );
}

/// Numbers for the names that a detector gives.
#[derive(Debug, Default)]
pub(super) struct Names(BTreeMap<String, u64>);

impl Names {
    fn told(&mut self, findings: &[Finding]) -> Vec<ToldBox> {
        // Where a detector only thinks that something is there still, it has found nothing.
        let found = |finding: &&Finding| finding.is_sound() && finding.coasted_s == 0.0;
        let sound = findings.iter().filter(found);
        let told = sound.map(|finding| {
            let next = self.0.len() as u64 + 1;
            ToldBox {
                track: *self.0.entry(finding.id.clone()).or_insert(next),
                class: finding.class.clone(),
                score: finding.score,
                bounds: Bounds {
                    center_x_px: finding.center_x_px,
                    center_y_px: finding.center_y_px,
                    width_px: finding.width_px,
                    height_px: finding.height_px,
                },
            }
        });
        told.collect()
    }
}
