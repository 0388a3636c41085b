//! The coordinator is taken away in flight: each vehicle keeps its place from its neighbours' states alone, through turns and when one
//! of them falls silent. When the coordinator comes back nobody's setpoint jumps.

use super::{Flight, Setup, swarm_origin};
use crate::layout::{HEIGHT_M, SPACING_M};
use crate::referee::{Errors, Referee, vehicle};
use crate::report::{Criterion, happened, measured};
use crate::scenario_runner::ScenarioRunner;
use crate::steps::{SetpointStep, StepWatch};
use anyhow::{Context, bail};
use parking_lot::Mutex;
use skein_domain::failsafe::TriggerMode;
use skein_domain::{FormationControl, FormationRequest, Refusal, Route, Shape, VehicleId};
use skein_runtime::{Fault, FormationSlots};
use skein_sim::TruthFrame;
use skein_view::EventKind;
use std::sync::Arc;
use std::time::Duration;

/// Speed of the leader in metres per second.
const SPEED_M_S: f64 = 4.0;
/// Radius of corners in metres.
const CORNER_RADIUS_M: f64 = 15.0;
/// Two places not farther apart than this many spacings are neighbours.
const NEIGHBOURS_WITHIN: f64 = 1.6;
/// A step of a setpoint that is no jump, beyond what its speed explains, in metres.
const STEP_LIMIT_M: f64 = 0.5;

/// Pairs of neighbours with the distance they should keep, and how far they are off it.
#[derive(Default)]
struct Shapes {
    pairs: Vec<(VehicleId, VehicleId, f64)>,
    errors: Errors,
    worst: Option<(VehicleId, VehicleId, f64)>,
}

/// The flight and what it showed.
#[derive(Default)]
pub struct NoCoordinator {
    shape: Arc<Mutex<Shapes>>,
    whole: Option<Errors>,
    without_one: Option<Errors>,
    away_s: Option<f64>,
    at_return: Option<SetpointStep>,
    route_flown: bool,
}

impl NoCoordinator {
    /// Takes the distances between neighbours from the places of the formation as it stands.
    fn keep_in_mind(&self, slots: &FormationSlots) {
        let mut places: Vec<(VehicleId, nalgebra::Vector3<f64>)> =
            slots.slots.iter().map(|(id, slot)| (*id, slot.to.vector())).collect();
        places.extend(slots.leader.map(|leader| (leader, nalgebra::Vector3::zeros())));
        let mut shape = self.shape.lock();
        for (i, (a, at)) in places.iter().enumerate() {
            for (b, other) in places.iter().skip(i + 1) {
                let distance_m = (at - other).norm();
                if distance_m < NEIGHBOURS_WITHIN * SPACING_M {
                    shape.pairs.push((*a, *b, distance_m));
                }
            }
        }
    }

    /// Begins to measure, or to measure anew; gives what was measured until now.
    fn next_part(&self, runner: &ScenarioRunner<'_>) -> Errors {
        let mut shape = self.shape.lock();
        if let Some((a, b, off_m)) = shape.worst.take() {
            runner.say(&format!("the distance of {a} and {b} was off the most: {off_m:.1} m"));
        }
        std::mem::take(&mut shape.errors)
    }

    fn leave_out(&self, id: VehicleId) {
        self.shape.lock().pairs.retain(|(a, b, _)| *a != id && *b != id);
    }

    async fn without_coordinator(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<VehicleId> {
        let leader = runner.leader()?.id;
        runner.node.inject_fault(Fault::CoordinatorAway { away: true }).await?;
        let away_since_s = runner.elapsed_s();
        runner.say("the coordinator is taken away");
        self.next_part(runner);
        let before = runner.node.events_after(0).last().map_or(0, |e| e.seq);
        runner.pause(12.0).await;
        let probe = runner.node.dissolve_formation().await;
        if !matches!(probe, Err(Refusal::NotRunning { .. } | Refusal::TimedOut { .. })) {
            bail!("the coordinator answers although it was taken away: {probe:?}");
        }
        self.whole = Some(self.next_part(runner));
        let dropped = self.drop_one(runner, leader)?;
        runner.pause(3.0).await;
        self.next_part(runner);
        let ended = || {
            let events = runner.node.events_after(before);
            let end = |e: &&Arc<skein_view::EventRecord>| {
                e.vehicle == Some(leader) && e.kind == EventKind::Formation && e.text.contains("end of the route")
            };
            events.iter().any(|e| end(&e))
        };
        runner
            .until(60.0, "the leader at the end of its route", |_| ended())
            .await?;
        self.route_flown = true;
        runner.pause(2.0).await;
        self.without_one = Some(self.next_part(runner));
        self.away_s = Some(runner.elapsed_s() - away_since_s);
        Ok(dropped)
    }

    /// The last of the formation falls silent.
    fn drop_one(&self, runner: &ScenarioRunner<'_>, leader: VehicleId) -> anyhow::Result<VehicleId> {
        let slots = runner.node.slots().context("no formation is flown")?;
        let behind = |(_, slot): &&(VehicleId, skein_domain::SlotMove)| -slot.to.forward_m;
        let last = slots.slots.iter().max_by(|a, b| behind(a).total_cmp(&behind(b)));
        let dropped = last.map(|(id, _)| *id).filter(|id| *id != leader);
        let dropped = dropped.context("there is no follower")?;
        let fleet = runner.node.snapshot();
        let system_id = fleet.vehicles.iter().find(|v| v.id == dropped).map(|v| v.system_id.0);
        let system_id = system_id.context("the follower is not in the picture")?;
        runner.say(&format!("vehicle {dropped} falls silent"));
        runner.referee.excuse(system_id);
        self.leave_out(dropped);
        runner
            .simulation()?
            .inflict(system_id, skein_sim::Fault::Silent(true))?;
        Ok(dropped)
    }
}

/// One look at the truth.
fn look(shape: &mut Shapes, truth: &TruthFrame) {
    for (a, b, wanted_m) in &shape.pairs {
        if let Some((a, b)) = vehicle(truth, *a).zip(vehicle(truth, *b)) {
            let off_m = a.position.distance_m(&b.position) - wanted_m;
            shape.errors.add(off_m);
            if shape.worst.is_none_or(|(_, _, worst_m)| off_m.abs() > worst_m.abs()) {
                shape.worst = Some((VehicleId(a.system_id.into()), VehicleId(b.system_id.into()), off_m));
            }
        }
    }
}

impl Flight for NoCoordinator {
    fn prepare(&self, setup: &mut Setup) {
        setup.node.swarm.origin = Some(swarm_origin());
        // What is shown is that the formation goes on: the failsafe policy would have it hold after a while.
        setup.node.safety.failsafe.coordinator_loss.mode = TriggerMode::WarnOnly;
    }

    async fn fly(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        runner.take_off_all(HEIGHT_M).await?;
        let request = FormationRequest {
            control: FormationControl::Distances,
            ..FormationRequest::new(Shape::Wedge, SPACING_M)
        };
        runner.form("Wedge, kept by distances", request).await?;
        runner
            .until(5.0, "members that keep their places by their neighbours", |fleet| {
                fleet.formation.as_ref().is_some_and(|f| f.keeps_itself)
            })
            .await?;
        self.keep_in_mind(&runner.node.slots().context("no formation is flown")?);
        let shape = self.shape.clone();
        runner
            .simulation()?
            .observe(Box::new(move |truth| look(&mut shape.lock(), truth)))?;
        let start = runner.leader_position()?;
        let at = |north: f64, east: f64| start.moved(nalgebra::Vector3::new(north, east, 0.0));
        let route = Route {
            waypoints: vec![at(50.0, 0.0), at(50.0, 50.0), at(0.0, 50.0), at(0.0, 20.0)],
            speed_m_s: SPEED_M_S,
            corner_radius_m: CORNER_RADIUS_M,
        };
        runner.begin_route("round the field", &route).await?;
        runner.pause(4.0).await;
        let dropped = self.without_coordinator(runner).await?;
        let watch = StepWatch::begin(&runner.node, Some(dropped), SPEED_M_S);
        runner.node.inject_fault(Fault::CoordinatorAway { away: false }).await?;
        runner.say("the coordinator comes back");
        runner.pause(4.0).await;
        self.at_return = watch.end(runner);
        tokio::time::sleep(Duration::from_millis(100)).await;
        runner.bring_back(dropped).await?;
        runner.land_in_grid().await
    }

    fn criteria(&self, _referee: &Referee) -> Vec<Criterion> {
        let rms = |errors: &Option<Errors>| errors.as_ref().and_then(Errors::rms);
        vec![
            measured("time without a coordinator", self.away_s).at_least(20.0, "s"),
            measured("distances to neighbours off, root mean square", rms(&self.whole)).at_most(2.0, "m"),
            measured(
                "the same after one fell silent, root mean square",
                rms(&self.without_one),
            )
            .at_most(2.0, "m"),
            happened("route flown to its end", self.route_flown),
            measured(
                "largest jump of a setpoint when the coordinator came back",
                self.at_return.map(|s| s.beyond_m),
            )
            .at_most(STEP_LIMIT_M, "m"),
        ]
    }
}
