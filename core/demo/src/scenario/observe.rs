//! An intruder that no radio hears of: a radar tells of it for a while, two observation UAVs are sent to look at it from two sides, and from then on the
//! swarm knows of it by their cameras alone. One of the two falls silent, and another takes its place.
//!
//! Must never do: tell the swarm more than the radar's word; what it knows after that it has seen.

use super::{Flight, Setup, swarm_origin};
use crate::fleet::quick;
use crate::referee::{Errors, Referee};
use crate::report::{Criterion, counted, measured};
use crate::scenario_runner::ScenarioRunner;
use anyhow::{Context, bail};
use rand::{RngExt, SeedableRng};
use skein_config::{AdoptionRule, Isolation, PayloadRule};
use skein_domain::payload::TrackEstimate;
use skein_domain::{PositionNed, VehicleCommand, VehicleId};
use skein_runtime::{Detection, NodeHandle, ObserveRequest};
use skein_sim::Fault;
use skein_sim_payloads::scene::{ObjectPath, SceneObject, TargetKind};
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;
use tokio::task::JoinHandle;

/// Height of the flight in metres.
const HEIGHT_M: f64 = 20.0;
/// Two look, and a third can take a place.
const OBSERVERS: usize = 3;
/// How far they stay from the intruder, in metres.
const STAND_OFF_M: f64 = 20.0;
/// Who is nearer than this to where it should be is there, in metres.
const NEAR_M: f64 = 3.0;
/// What a camera gives, and what is done with it, share the computer that also flies the vehicles.
const PICTURES_HZ: f64 = 8.0;
const SIZE_PX: (u32, u32) = (640, 512);
/// The radar's error along each axis, in metres, and how often it tells.
const RADAR_ERROR_M: f64 = 4.0;
const RADAR_PERIOD: Duration = Duration::from_millis(500);
/// What is farther than this from all that is there is nothing that is there, in metres, once it has been known for so long, in seconds.
const FALSE_FROM_M: f64 = 15.0;
const FALSE_AFTER_S: f64 = 2.0;
/// How long cameras alone look, before and after one falls silent, in seconds.
const LOOKED_AT_S: f64 = 30.0;

/// What is there: the intruder first, and a bird.
fn objects() -> [SceneObject; 2] {
    let circle = |kind, north_m, east_m, radius_m, speed_m_s| SceneObject {
        kind,
        size_m: (kind == TargetKind::Quadrotor).then_some(1.0),
        path: ObjectPath::Circle {
            centre: PositionNed::new(north_m, east_m, -25.0),
            radius_m,
        },
        speed_m_s: Some(speed_m_s),
        phase: 0.0,
    };
    [
        circle(TargetKind::Quadrotor, 60.0, 10.0, 15.0, 3.0),
        circle(TargetKind::Bird, 110.0, -40.0, 25.0, 10.0),
    ]
}

/// The flight and what it showed.
#[derive(Default)]
pub struct Observe {
    errors: Errors,
    /// Looks at the track, and those in which a camera saw it.
    looks: u64,
    seen: u64,
    /// The numbers under which the intruder was known.
    numbers: BTreeSet<u64>,
    relieved_after_s: Option<f64>,
    /// Tracks of what is not there: for how many looks each was known.
    ghosts: BTreeMap<u64, u64>,
}

/// The track that is the intruder, if one is.
fn intruder(node: &NodeHandle) -> Option<(TrackEstimate, f64)> {
    let [intruder, _] = objects();
    let at = intruder.at(node.now().as_seconds()).position;
    let snapshot = node.snapshot();
    let off = snapshot
        .tracks
        .iter()
        .map(|track| (track, track.track.position.distance_m(&at)));
    let nearest = off.min_by(|a, b| a.1.total_cmp(&b.1));
    nearest
        .filter(|(_, off_m)| *off_m < FALSE_FROM_M)
        .map(|(track, off_m)| (track.clone(), off_m))
}

/// The vehicles whose cameras see a track.
fn observers(track: &TrackEstimate) -> Vec<VehicleId> {
    let vehicle = |sensor: &String| sensor.split_once('/')?.0.parse().ok().map(VehicleId);
    track.sensors.iter().filter_map(vehicle).collect()
}

/// Tells of the intruder as a radar would.
fn radar(node: NodeHandle) -> JoinHandle<()> {
    tokio::spawn(async move {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let mut clock = tokio::time::interval(RADAR_PERIOD);
        let variance = RADAR_ERROR_M * RADAR_ERROR_M;
        loop {
            clock.tick().await;
            let at = objects()[0].at(node.now().as_seconds()).position;
            // Evenly spread, of the same variance as is told.
            let reach_m = RADAR_ERROR_M * 3.0_f64.sqrt();
            let mut off_m = || random.random_range(-reach_m..reach_m);
            let detection = Detection {
                id: Some(1),
                age_s: 0.0,
                class: None,
                score: None,
                bearing: None,
                position: Some(at.moved(nalgebra::Vector3::new(off_m(), off_m(), off_m()))),
                covariance_m2: Some([variance, 0.0, 0.0, variance, 0.0, variance]),
            };
            // What is not taken shows in the criteria.
            let _ = node.tell_detections("radar", vec![detection]);
        }
    })
}

impl Observe {
    /// Looks at the track for a while, ten times a second.
    async fn watch(&mut self, runner: &ScenarioRunner<'_>, seconds: f64) {
        let mut clock = tokio::time::interval(Duration::from_millis(100));
        let until_s = runner.elapsed_s() + seconds;
        while runner.elapsed_s() < until_s {
            clock.tick().await;
            self.looks += 1;
            self.count_ghosts(runner);
            if let Some((track, off_m)) = intruder(&runner.node) {
                self.numbers.insert(track.track.track);
                self.errors.add(off_m);
                self.seen += u64::from(!observers(&track).is_empty());
            }
        }
    }

    fn count_ghosts(&mut self, runner: &ScenarioRunner<'_>) {
        let snapshot = runner.node.snapshot();
        let now_s = runner.node.now().as_seconds();
        let vehicles = runner.referee.truth().vehicles;
        // A vehicle that is silent is one that the swarm does not know of.
        let places: Vec<PositionNed> = objects()
            .iter()
            .map(|object| object.at(now_s).position)
            .chain(vehicles.iter().map(|vehicle| vehicle.position))
            .collect();
        for track in snapshot.tracks.iter().filter(|track| !track.guessed_range) {
            let nearest_m = places.iter().map(|place| place.distance_m(&track.track.position));
            if nearest_m.fold(f64::INFINITY, f64::min) > FALSE_FROM_M {
                *self.ghosts.entry(track.track.track).or_default() += 1;
            }
        }
    }

    /// The radar's word begins a track, and two are sent to look at it.
    async fn send(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<Vec<VehicleId>> {
        runner
            .until(20.0, "a track of what the radar tells of", |_| {
                intruder(&runner.node).is_some()
            })
            .await?;
        let (track, off_m) = intruder(&runner.node).context("the track is gone")?;
        let number = track.track.track;
        runner.say(&format!("track {number} is the intruder, {off_m:.1} m off"));
        let request = ObserveRequest {
            count: Some(2),
            stand_off_m: Some(STAND_OFF_M),
            ..ObserveRequest::default()
        };
        let asked = runner.node.observe_track(None, number, &request).await;
        let asked = asked.map_err(|refusal| anyhow::anyhow!("track {number} is not observed: {refusal}"))?;
        if let Some(refusal) = asked.iter().find_map(|asked| asked.receipt.refusal.as_ref()) {
            bail!("an observer refuses: {refusal}");
        }
        let sent: Vec<VehicleId> = asked.iter().map(|asked| asked.receipt.vehicle).collect();
        runner.say(&format!("vehicles {sent:?} are to look at it from two sides"));
        runner
            .until(90.0, "both cameras on the intruder", |_| {
                let seen_by = intruder(&runner.node).map(|(track, _)| observers(&track));
                seen_by.is_some_and(|seen_by| sent.iter().all(|vehicle| seen_by.contains(vehicle)))
            })
            .await?;
        Ok(sent)
    }

    /// One who looks falls silent; somebody else is there in his place before long.
    async fn relieve(&mut self, runner: &ScenarioRunner<'_>, sent: &[VehicleId]) -> anyhow::Result<VehicleId> {
        let lost = *sent.first().context("nobody looks")?;
        let fleet = runner.node.snapshot();
        let vehicle = fleet.vehicles.iter().find(|v| v.id == lost);
        let system_id = vehicle.context("the observer is not in the picture")?.system_id.0;
        runner.referee.excuse(system_id);
        runner.simulation()?.inflict(system_id, Fault::Silent(true))?;
        runner.say(&format!("vehicle {lost}, which looks at it, falls silent"));
        let since_s = runner.elapsed_s();
        runner
            .until(90.0, "another vehicle in its place", |_| {
                let Some((track, _)) = intruder(&runner.node) else {
                    return false;
                };
                let at = track.track.position;
                observers(&track).iter().any(|id| {
                    let place = runner.position(*id);
                    !sent.contains(id)
                        && place.is_ok_and(|place| place.horizontal_distance_m(&at) < STAND_OFF_M + NEAR_M)
                })
            })
            .await?;
        let after_s = runner.elapsed_s() - since_s;
        runner.say(&format!("another one looks at it, {after_s:.1} s later"));
        self.relieved_after_s = Some(after_s);
        Ok(lost)
    }
}

/// An observer: gimbal, camera, and eyes for what the camera gives.
fn equip(rule: &mut AdoptionRule) {
    let payload = |name: &str, plugin: &str, config: serde_json::Value| PayloadRule {
        name: name.into(),
        plugin: plugin.into(),
        isolation: Isolation::InProcess,
        transport: None,
        on_failure: skein_config::Escalation::Degrade,
        config,
    };
    "observation-uav".clone_into(&mut rule.model);
    // As quick as the demonstration's others.
    rule.model_config = serde_json::from_value(quick("observation-uav")).unwrap_or_default();
    let camera = serde_json::json!({
        "source": "synthetic", "rate_hz": PICTURES_HZ, "width_px": SIZE_PX.0, "height_px": SIZE_PX.1,
        "clock": false, "noise_levels": 2.0, "clouds": 0.3, "objects": objects(),
    });
    rule.payloads = vec![
        payload("gimbal", "gimbal", serde_json::json!({})),
        payload("camera", "camera", camera),
        payload("eyes", "detector", serde_json::json!({ "camera": "camera" })),
        payload("radio", "radio", serde_json::json!({})),
    ];
}

impl Flight for Observe {
    fn prepare(&self, setup: &mut Setup) {
        setup.node.swarm.origin = Some(swarm_origin());
        // Who looks at a track of the swarm's own making flies by it.
        setup.node.tracking.steer_by_fused = true;
        for (index, rule) in setup.node.adopt.iter_mut().enumerate() {
            if (1..=OBSERVERS).contains(&index) {
                equip(rule);
            } else if rule.model == "observation-uav" {
                // Who has a camera without eyes for what it gives is of no use here.
                "generic-uav".clone_into(&mut rule.model);
                rule.model_config = serde_json::from_value(quick("generic-uav")).unwrap_or_default();
                rule.payloads.clear();
            }
        }
    }

    async fn fly(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        runner.take_off_all(HEIGHT_M).await?;
        if runner.ids().len() <= OBSERVERS {
            bail!("this is flown with {} vehicles at least: add --vehicles", OBSERVERS + 1);
        }
        let radar = radar(runner.node.clone());
        let sent = self.send(runner).await;
        radar.abort();
        let sent = sent?;
        runner.say("both cameras have it; the radar is switched off");
        // Until what the radar told is history.
        runner.pause(5.0).await;
        self.watch(runner, LOOKED_AT_S).await;
        let lost = self.relieve(runner, &sent).await?;
        self.watch(runner, LOOKED_AT_S).await;
        runner.bring_back(lost).await?;
        runner.say("enough seen: all return");
        let home = |id: &VehicleId| *id != lost;
        let ids: Vec<VehicleId> = runner.ids().into_iter().filter(home).collect();
        for vehicle in &runner.node.snapshot().vehicles {
            runner.referee.may_land(vehicle.system_id.0);
        }
        runner.command(&ids, VehicleCommand::Return).await?;
        runner.all_down(120.0).await
    }

    fn criteria(&self, _: &Referee) -> Vec<Criterion> {
        let long = (FALSE_AFTER_S * 10.0) as u64;
        let ghosts = self.ghosts.values().filter(|looks| **looks > long).count();
        let share = (self.looks > 0).then(|| 100.0 * self.seen as f64 / self.looks as f64);
        vec![
            measured("intruder's track off the intruder, root mean square", self.errors.rms()).at_most(3.0, "m"),
            measured("time in which a camera saw the intruder", share).at_least(90.0, "%"),
            counted("numbers under which the intruder was known", self.numbers.len()).at_most(1.0, ""),
            measured("silent observer until another one looks", self.relieved_after_s).at_most(60.0, "s"),
            counted("tracks of what is not there", ghosts).at_most(3.0, ""),
        ]
    }
}
