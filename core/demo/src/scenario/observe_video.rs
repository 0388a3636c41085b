//! Observation UAVs keep their cameras on the leader along a route, and their video is received and decoded all the while, as a ground station does.

use super::{Flight, Setup, tour};
use crate::layout::{self, Layout};
use crate::referee::Referee;
use crate::report::{Criterion, counted, measured};
use crate::scenario_runner::ScenarioRunner;
use anyhow::Context;
use parking_lot::Mutex;
use skein_domain::{FormationRequest, NodeTime, Shape, VehicleId};
use skein_runtime::{NodeHandle, Rendition};
use skein_video::H264Decoder;
use std::sync::Arc;
use tokio::task::JoinHandle;

/// What the cameras give in this flight.
const PICTURES_HZ: f64 = 30.0;
const SIZE_PX: (u32, u32) = (640, 480);
/// So many pictures a second have to be seen of each camera. Each is drawn and encoded on the computer that also flies the vehicles.
const SEEN_HZ: f64 = 15.0;

/// What was seen of one camera.
#[derive(Debug, Clone, Copy, Default)]
struct VideoSeen {
    pictures: u64,
    damaged: u64,
    first: Option<NodeTime>,
    last: Option<NodeTime>,
    longest_gap_s: f64,
}

impl VideoSeen {
    fn rate_hz(&self) -> Option<f64> {
        let over_s = self.last?.seconds_since(self.first?);
        (over_s > 0.0).then(|| self.pictures.saturating_sub(1) as f64 / over_s)
    }
}

/// The flight and what was seen.
pub struct ObserveVideo {
    layout: Layout,
    seen: Vec<(VehicleId, Arc<Mutex<VideoSeen>>)>,
}

impl ObserveVideo {
    /// With legs of the layout's length.
    pub fn new(layout: Layout) -> Self {
        Self {
            layout,
            seen: Vec::new(),
        }
    }

    /// Begins to look at all cameras.
    fn look(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<Vec<JoinHandle<()>>> {
        let mut watching = Vec::new();
        for camera in runner.node.streams().videos() {
            let seen = Arc::new(Mutex::new(VideoSeen::default()));
            self.seen.push((camera.vehicle, seen.clone()));
            let node = runner.node.clone();
            let decoder = H264Decoder::new().context("a decoder")?;
            watching.push(tokio::spawn(watch(node, camera.vehicle, camera.payload, decoder, seen)));
        }
        runner.say(&format!("the video of {} cameras is received", watching.len()));
        Ok(watching)
    }
}

async fn watch(
    node: NodeHandle,
    vehicle: VehicleId,
    payload: String,
    mut decoder: H264Decoder,
    seen: Arc<Mutex<VideoSeen>>,
) {
    // A camera that is not there shows in the criteria.
    let Ok(mut viewer) = node.streams().watch_video(vehicle, &payload, Rendition::OF_CAMERA) else {
        return;
    };
    loop {
        let frame = viewer.next().await.frame;
        let decoded = tokio::task::block_in_place(|| decoder.decode(&frame.bytes));
        let mut seen = seen.lock();
        match decoded {
            Ok(Some(_)) => seen.pictures += 1,
            Ok(None) => {}
            Err(_) => seen.damaged += 1,
        }
        let gap_s = seen.last.map_or(0.0, |last| frame.taken.seconds_since(last));
        seen.longest_gap_s = seen.longest_gap_s.max(gap_s);
        seen.first.get_or_insert(frame.taken);
        seen.last = Some(frame.taken);
    }
}

impl Flight for ObserveVideo {
    fn prepare(&self, setup: &mut Setup) {
        let payloads = setup.node.adopt.iter_mut().flat_map(|rule| &mut rule.payloads);
        for camera in payloads.filter(|payload| payload.plugin == "camera") {
            camera.config = serde_json::json!({
                "source": "synthetic", "rate_hz": PICTURES_HZ, "width_px": SIZE_PX.0, "height_px": SIZE_PX.1,
            });
        }
    }

    async fn fly(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        runner.take_off_all(layout::HEIGHT_M).await?;
        let wedge = FormationRequest::new(Shape::Wedge, layout::SPACING_M);
        runner.form("Wedge", wedge).await?;
        tour::look_at_leader(runner).await?;
        let watching = self.look(runner)?;
        let route = self.layout.way_out(runner.leader_position()?);
        runner.begin_route("north, east and half-way south", &route).await?;
        let flown = runner
            .route_end(self.layout.leg_m * 3.0 / layout::SPEED_M_S + 40.0)
            .await;
        watching.iter().for_each(JoinHandle::abort);
        flown?;
        runner.land_in_grid().await
    }

    fn criteria(&self, referee: &Referee) -> Vec<Criterion> {
        let seen: Vec<VideoSeen> = self.seen.iter().map(|(_, seen)| *seen.lock()).collect();
        let slowest_hz = seen
            .iter()
            .map(|one| one.rate_hz().unwrap_or(0.0))
            .min_by(f64::total_cmp);
        let longest_s = seen.iter().map(|one| one.longest_gap_s).max_by(f64::total_cmp);
        let damaged: u64 = seen.iter().map(|one| one.damaged).sum();
        let figures = referee.figures();
        vec![
            counted("cameras whose video was received", seen.len()).at_least(1.0, ""),
            measured("pictures per second of the slowest camera", slowest_hz).at_least(SEEN_HZ, "/s"),
            measured("longest time without a picture", longest_s).at_most(1.0, "s"),
            measured("pictures that could not be decoded", Some(damaged as f64)).at_most(0.0, ""),
            measured(
                "gimbals off the leader, root mean square",
                figures.pointing.rms().map(f64::to_degrees),
            )
            .at_most(5.0, "deg"),
        ]
    }
}
