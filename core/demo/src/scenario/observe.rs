//! An intruder that no radio hears of: cameras find it, two observation UAVs are sent to look at it from two sides, and keep it in the middle of their
//! pictures. The battery of one runs low, and another takes its place.
//!
//! Vehicles that fly as PX4's own simulation does (`--airframe sih`) have no gimbal, as there: their cameras look at the ground when they lean forward.
//!
//! Must never do: tell the swarm anything of the intruder; what it knows it has seen.

use super::{Flight, Setup, swarm_origin};
use crate::fleet::quick;
use crate::referee::{Errors, Referee, vehicle};
use crate::report::{Criterion, counted, measured};
use crate::scenario_runner::ScenarioRunner;
use anyhow::{Context, bail};
use skein_config::{AdoptionRule, Isolation, PayloadRule};
use skein_domain::payload::{CameraPose, PayloadKind, TrackEstimate};
use skein_domain::{EnergyLevel, PositionNed, SystemId, VehicleCommand, VehicleId};
use skein_runtime::{NodeHandle, ObserveRequest};
use skein_sim::{Airframe, Fault, VehicleTruth};
use skein_sim_payloads::scene::{ObjectPath, SceneObject, TargetKind, project};
use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

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
const FIELD_OF_VIEW_RAD: f64 = 1.2;
/// What is farther than this from all that is there is nothing that is there, in metres, once it has been known for so long, in seconds.
const FALSE_FROM_M: f64 = 15.0;
const FALSE_AFTER_S: f64 = 2.0;
/// How long they look before the battery of one runs low, and after another has taken its place, in seconds.
const LOOKED_AT_S: f64 = 60.0;
const LOOKED_AT_THEN_S: f64 = 30.0;
/// The battery of one has this charge, and loses so much a second, until it must return soon.
const CHARGE: f64 = 0.6;
const CHARGE_LOST: f64 = 0.02;

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
    /// Looks at cameras on gimbals that were to have it in view, and those in which it was in the middle third of the picture.
    pictures: u64,
    centred: u64,
    /// The same of fixed cameras, and those in which it was in the picture.
    fixed_pictures: u64,
    in_picture: u64,
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

/// Where in a vehicle's picture something is, from the middle and in widths and heights of it, by where its gimbal truly points, or how the vehicle says that it
/// leans if it has none; and whether it has one.
fn in_picture_of(vehicle: &VehicleTruth, node: &NodeHandle, at: &PositionNed) -> (bool, Option<(f64, f64)>) {
    let snapshot = node.snapshot();
    let shown = snapshot
        .vehicles
        .iter()
        .find(|shown| shown.system_id.0 == vehicle.system_id);
    let has_gimbal = shown.is_some_and(|shown| shown.payloads.iter().any(|p| p.kind == PayloadKind::Gimbal));
    let level = CameraPose {
        position: vehicle.position,
        field_of_view_rad: FIELD_OF_VIEW_RAD,
        ..CameraPose::default()
    };
    let pose = if has_gimbal {
        vehicle.gimbal.map(|gimbal| CameraPose {
            pitch_rad: gimbal.pitch_rad,
            yaw_rad: gimbal.yaw_north_rad,
            ..level
        })
    } else {
        shown.map(|shown| CameraPose {
            roll_rad: f64::from(shown.roll_rad),
            pitch_rad: f64::from(shown.pitch_rad),
            yaw_rad: vehicle.yaw_rad,
            ..level
        })
    };
    let (width_px, height_px) = SIZE_PX;
    let off = |px: f64, of: u32| px / f64::from(of) - 0.5;
    let seen = pose.and_then(|pose| project(&pose, at, width_px, height_px));
    (
        has_gimbal,
        seen.map(|(x_px, y_px)| (off(x_px, width_px), off(y_px, height_px))),
    )
}

impl Observe {
    /// Looks at the track, and at what these see of it, for a while, ten times a second.
    async fn watch(&mut self, runner: &ScenarioRunner<'_>, by: &[VehicleId], seconds: f64) {
        let mut clock = tokio::time::interval(Duration::from_millis(100));
        let until_s = runner.elapsed_s() + seconds;
        while runner.elapsed_s() < until_s {
            clock.tick().await;
            self.looks += 1;
            self.count_ghosts(runner);
            let at = objects()[0].at(runner.node.now().as_seconds()).position;
            let truth = runner.referee.truth();
            for observer in by.iter().filter_map(|id| vehicle(&truth, *id)) {
                let (has_gimbal, off) = in_picture_of(observer, &runner.node, &at);
                let within = |part: f64| off.is_some_and(|(x, y)| x.abs() <= part && y.abs() <= part);
                if has_gimbal {
                    self.pictures += 1;
                    self.centred += u64::from(within(1.0 / 6.0));
                } else {
                    self.fixed_pictures += 1;
                    self.in_picture += u64::from(within(0.5));
                }
            }
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
        let objects = objects().map(|object| object.at(now_s).position);
        let vehicles = vehicles.iter().map(|vehicle| vehicle.position);
        let places: Vec<PositionNed> = objects.into_iter().chain(vehicles).collect();
        for track in snapshot.tracks.iter().filter(|track| !track.guessed_range) {
            let nearest_m = places.iter().map(|place| place.distance_m(&track.track.position));
            if nearest_m.fold(f64::INFINITY, f64::min) > FALSE_FROM_M {
                *self.ghosts.entry(track.track.track).or_default() += 1;
            }
        }
    }

    /// Cameras find it, and two vehicles are sent to look at it.
    async fn send(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<Vec<VehicleId>> {
        runner
            .until(60.0, "the intruder found, and its place known", |_| {
                let found = intruder(&runner.node).map(|(track, _)| track.track.track);
                found.is_some_and(|track| runner.node.observers_of(track).is_ok())
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
        let both = || sent.iter().all(|id| is_in_place(runner, *id));
        runner.until(90.0, "both in their places", |_| both()).await?;
        runner.say("both are in their places");
        Ok(sent)
    }

    /// The battery of one who looks runs low; somebody else is there in its place before long. Gives who looks then.
    async fn relieve(&mut self, runner: &ScenarioRunner<'_>, sent: &[VehicleId]) -> anyhow::Result<Vec<VehicleId>> {
        let tired = *sent.first().context("nobody looks")?;
        let energy = || {
            let fleet = runner.node.snapshot();
            let vehicle = fleet.vehicles.iter().find(|v| v.id == tired);
            vehicle.map(|v| (v.system_id, v.energy.map(|energy| energy.level)))
        };
        let (SystemId(system_id), _) = energy().context("the observer is not in the picture")?;
        // It may land by itself from here on.
        runner.referee.may_land(system_id);
        let mut charge = CHARGE;
        let is_low = |level: Option<EnergyLevel>| level.is_some_and(|level| level != EnergyLevel::Ok);
        while !energy().is_some_and(|(_, level)| is_low(level)) {
            runner.simulation()?.inflict(system_id, Fault::BatteryCharge(charge))?;
            charge -= CHARGE_LOST;
            if charge <= 0.0 {
                bail!("vehicle {tired} has an empty battery and nobody minds");
            }
            runner.pause(1.0).await;
        }
        runner.say(&format!("the battery of vehicle {tired}, which looks at it, runs low"));
        let since_s = runner.elapsed_s();
        let other = || {
            let mut others = runner.ids().into_iter().filter(|id| !sent.contains(id));
            others.find(|id| is_in_place(runner, *id))
        };
        runner
            .until(90.0, "another vehicle in its place", |_| other().is_some())
            .await?;
        let successor = other();
        let after_s = runner.elapsed_s() - since_s;
        runner.say(&format!("another one is in its place, {after_s:.1} s later"));
        self.relieved_after_s = Some(after_s);
        let stay = sent.iter().copied().filter(|id| *id != tired);
        Ok(stay.chain(successor).collect())
    }
}

/// Whether a vehicle is where it looks at the intruder from, and sees it.
fn is_in_place(runner: &ScenarioRunner<'_>, id: VehicleId) -> bool {
    let Some((track, _)) = intruder(&runner.node) else {
        return false;
    };
    let near = |place: PositionNed| place.horizontal_distance_m(&track.track.position) < STAND_OFF_M + NEAR_M;
    observers(&track).contains(&id) && runner.position(id).is_ok_and(near)
}

/// An observer: camera, eyes for what the camera gives, and a gimbal if there is one.
fn equip(rule: &mut AdoptionRule, has_gimbal: bool) {
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
        "field_of_view_rad": FIELD_OF_VIEW_RAD, "clock": false, "noise_levels": 2.0, "clouds": 0.3, "objects": objects(),
    });
    if !has_gimbal {
        rule.model_config
            .insert("fixed_camera_pitch_rad".to_owned(), 0.0.into());
    }
    let gimbal = has_gimbal.then(|| payload("gimbal", "gimbal", serde_json::json!({})));
    rule.payloads = gimbal.into_iter().collect();
    rule.payloads.extend([
        payload("camera", "camera", camera),
        payload("eyes", "detector", serde_json::json!({ "camera": "camera" })),
        payload("radio", "radio", serde_json::json!({})),
    ]);
}

impl Flight for Observe {
    fn prepare(&self, setup: &mut Setup) {
        setup.node.swarm.origin = Some(swarm_origin());
        // Who looks at a track of the swarm's own making flies by it.
        setup.node.tracking.steer_by_fused = true;
        let has_gimbals = setup.simulation.airframe != Airframe::Sih;
        for (index, rule) in setup.node.adopt.iter_mut().enumerate() {
            if (1..=OBSERVERS).contains(&index) {
                equip(rule, has_gimbals);
            } else if rule.model == "observation-uav" {
                // Who has a camera without eyes for what it gives is of no use here.
                "generic-uav".clone_into(&mut rule.model);
                rule.model_config = serde_json::from_value(quick("generic-uav")).unwrap_or_default();
                rule.payloads.clear();
            }
        }
    }

    async fn fly(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        runner.find_all().await?;
        if runner.ids().len() <= OBSERVERS {
            bail!("this is flown with {} vehicles at least: add --vehicles", OBSERVERS + 1);
        }
        runner.take_off_all(HEIGHT_M).await?;
        let sent = self.send(runner).await?;
        self.watch(runner, &sent, LOOKED_AT_S).await;
        let then = self.relieve(runner, &sent).await?;
        self.watch(runner, &then, LOOKED_AT_THEN_S).await;
        // Told and not judged: it is this computer's pace.
        if let Some((median_us, most_us)) = runner.node.seen_counts().camera_to_track_us {
            let (median_ms, most_ms) = (median_us / 1_000, most_us / 1_000);
            runner.say(&format!(
                "from picture to track: median {median_ms} ms, 95 % within {most_ms} ms"
            ));
        }
        runner.say("enough seen: all return");
        let fleet = runner.node.snapshot();
        for vehicle in &fleet.vehicles {
            runner.referee.may_land(vehicle.system_id.0);
        }
        // The tired one may be home already.
        let flying = fleet.vehicles.iter().filter(|vehicle| vehicle.armed);
        let flying: Vec<VehicleId> = flying.map(|vehicle| vehicle.id).collect();
        runner.command(&flying, VehicleCommand::Return).await?;
        runner.all_down(120.0).await
    }

    fn criteria(&self, _: &Referee) -> Vec<Criterion> {
        let long = (FALSE_AFTER_S * 10.0) as u64;
        let ghosts = self.ghosts.values().filter(|looks| **looks > long).count();
        let percent = |part: u64, whole: u64| (whole > 0).then(|| 100.0 * part as f64 / whole as f64);
        let view = if self.fixed_pictures > 0 {
            measured(
                "intruder in the pictures of fixed cameras",
                percent(self.in_picture, self.fixed_pictures),
            )
            .at_least(90.0, "%")
        } else {
            measured(
                "intruder in the middle third of the pictures",
                percent(self.centred, self.pictures),
            )
            .at_least(90.0, "%")
        };
        vec![
            measured("intruder's track off the intruder, root mean square", self.errors.rms()).at_most(3.0, "m"),
            measured(
                "time in which a camera saw the intruder",
                percent(self.seen, self.looks),
            )
            .at_least(90.0, "%"),
            view,
            counted("numbers under which the intruder was known", self.numbers.len()).at_most(1.0, ""),
            measured("low battery until another one looks", self.relieved_after_s).at_most(60.0, "s"),
            counted("tracks of what is not there", ghosts).at_most(6.0, ""),
        ]
    }
}
