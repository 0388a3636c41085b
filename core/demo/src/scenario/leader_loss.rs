//! The leader falls silent in the middle of its route, and flies on by itself: another leads, nobody's setpoint jumps, the route is
//! flown to its end. Then the leader is replaced on purpose, at speed.

use super::{Flight, Setup, swarm_origin};
use crate::layout::{HEIGHT_M, SPACING_M};
use crate::referee::{Errors, Referee, vehicle};
use crate::report::{Criterion, happened, measured};
use crate::scenario_runner::ScenarioRunner;
use crate::steps::{SetpointStep, StepWatch};
use anyhow::{Context, bail};
use skein_domain::exchange::Severity;
use skein_domain::{FlightState, FormationRequest, NodeTime, Route, Shape, VehicleId};
use skein_sim::Fault;
use skein_view::{EventKind, EventRecord};
use std::sync::Arc;

/// Speed of the leader in metres per second.
const SPEED_M_S: f64 = 5.0;
/// Radius of corners in metres.
const CORNER_RADIUS_M: f64 = 15.0;
/// One control period is 20 ms; the loss is looked for once in each, and so are the states it is seen in.
const SUCCESSION_LIMIT_MS: f64 = 60.0;
/// A leader not heard for so long is lost, in seconds.
const LOST_AFTER_S: f64 = 0.6;
/// A step of a setpoint that is no jump, beyond what its speed explains, in metres.
const STEP_LIMIT_M: f64 = 0.5;
/// Setpoints are looked at for so long after the loss, in seconds.
const LOOKED_AT_S: f64 = 2.0;
/// So close to its slot a follower is in it, in metres.
const IN_SLOT_M: f64 = 0.5;
/// So long after another leads, at most, everyone has gone around the silent one and is in its slot, in seconds.
const WHOLE_AGAIN_S: f64 = 15.0;

/// The flight and what it showed.
#[derive(Default)]
pub struct LeaderLoss {
    /// From the declared loss to the new intent, and from the intent to the successor's own word, in milliseconds.
    intent_ms: Option<f64>,
    leads_ms: Option<f64>,
    at_loss: Option<SetpointStep>,
    at_replacement: Option<SetpointStep>,
    whole_again_s: Option<f64>,
    end_off_m: Option<f64>,
    after_loss: Option<(Errors, Errors)>,
    after_replacement: Option<(Errors, Errors)>,
    replaced: bool,
}

impl LeaderLoss {
    /// The leader falls silent; gives it and its successor.
    async fn lose_leader(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<(VehicleId, VehicleId)> {
        let lost = runner.leader()?;
        let system_id = lost.system_id.0;
        runner.referee.excuse(system_id);
        let before = runner.node.events_after(0).last().map_or(0, |e| e.seq);
        let watch = StepWatch::begin(&runner.node, Some(lost.id), SPEED_M_S);
        runner.say(&format!("the leader, vehicle {}, falls silent", lost.id));
        runner.simulation()?.inflict(system_id, Fault::Silent(true))?;
        let lost = lost.id;
        runner
            .until(10.0, "another leader", |fleet| {
                let leader = fleet.vehicles.iter().find(|v| v.is_leader);
                leader.is_some_and(|v| v.id != lost && v.flight_state == FlightState::Leading)
            })
            .await?;
        let fleet = runner.node.snapshot();
        let heard = fleet.vehicles.iter().find(|v| v.id == lost).map(|v| v.link.last_heard);
        let due = heard
            .context("the lost leader is not in the picture")?
            .plus_seconds(runner.node.config().coordinator.leader_lost_after_s);
        let events = runner.node.events_after(before);
        let successor = runner.leader()?.id;
        self.measure(runner, &events, (lost, due), successor)?;
        runner.pause(LOOKED_AT_S).await;
        self.at_loss = watch.end(runner);
        Ok((lost, successor))
    }

    /// The silent one stops in their way: they go around it, and are in their places again before the first corner.
    async fn whole_again(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        let since_s = runner.elapsed_s();
        runner
            .until(2.0 * WHOLE_AGAIN_S, "everyone in its slot again", |_| {
                runner.referee.farthest_from_slot_m() < IN_SLOT_M
            })
            .await?;
        let after_s = runner.elapsed_s() - since_s + LOOKED_AT_S;
        runner.say(&format!("all are in their slots, {after_s:.1} s after the loss"));
        self.whole_again_s = Some(after_s);
        Ok(())
    }

    fn measure(
        &mut self,
        runner: &ScenarioRunner<'_>,
        events: &[Arc<EventRecord>],
        (lost, due): (VehicleId, NodeTime),
        successor: VehicleId,
    ) -> anyhow::Result<()> {
        let intent = events
            .iter()
            .find(|e| e.kind == EventKind::Formation && e.severity == Severity::Advisory)
            .context("no event tells of the lost leader")?;
        // Whatever came first: that it was not heard for so long, or that it was taken out of its lead (an old position, a lost link).
        let out = events
            .iter()
            .filter(|e| e.vehicle == Some(lost) && e.severity == Severity::Critical && e.time.0 <= intent.time.0);
        let declared = out.map(|e| e.time).max_by_key(|time| time.0).unwrap_or(due);
        let leads = events.iter().find(|e| {
            let leads = EventKind::FlightState {
                state: FlightState::Leading,
            };
            e.vehicle == Some(successor) && e.kind == leads
        });
        let leads = leads.context("no event tells of the new leader")?;
        let intent_ms = intent.time.seconds_since(declared) * 1e3;
        let leads_ms = leads.time.seconds_since(intent.time) * 1e3;
        runner.say(&format!(
            "vehicle {successor} leads: intent {intent_ms:.0} ms after the loss was declared, taken up {leads_ms:.0} ms later"
        ));
        (self.intent_ms, self.leads_ms) = (Some(intent_ms), Some(leads_ms));
        Ok(())
    }

    /// Another leader by order, while the formation is at speed.
    async fn replace_leader(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        let present = runner.leader()?.id;
        let formation = runner
            .node
            .snapshot()
            .formation
            .clone()
            .context("no formation is flown")?;
        let next = formation.members.iter().copied().find(|id| *id != present);
        let next = next.context("nobody else could lead")?;
        let request = FormationRequest {
            leader: Some(next),
            ..FormationRequest::new(Shape::Wedge, SPACING_M)
        };
        let watch = StepWatch::begin(&runner.node, None, SPEED_M_S);
        runner.form("Wedge behind another leader", request).await?;
        self.at_replacement = watch.end(runner);
        self.replaced = runner.leader()?.id == next;
        Ok(())
    }
}

impl Flight for LeaderLoss {
    fn prepare(&self, setup: &mut Setup) {
        setup.node.swarm.origin = Some(swarm_origin());
        // Sooner than the followers carry on what they last knew of their leader, which is a second: no setpoint is frozen meanwhile.
        setup.node.coordinator.leader_lost_after_s = LOST_AFTER_S;
    }

    async fn fly(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        runner.take_off_all(HEIGHT_M).await?;
        let wedge = FormationRequest::new(Shape::Wedge, SPACING_M);
        runner.form("Wedge", wedge).await?;
        let start = runner.leader_position()?;
        let at = |north: f64, east: f64| start.moved(nalgebra::Vector3::new(north, east, 0.0));
        let out = Route {
            waypoints: vec![at(130.0, 0.0), at(130.0, 60.0), at(100.0, 60.0)],
            speed_m_s: SPEED_M_S,
            corner_radius_m: CORNER_RADIUS_M,
        };
        runner.begin_route("north, east and south", &out).await?;
        runner.pause(6.0).await;
        let (lost, successor) = self.lose_leader(runner).await?;
        self.whole_again(runner).await?;
        runner.referee.next_part();
        runner.route_end(90.0).await?;
        self.after_loss = Some(runner.referee.next_part());
        if runner.leader()?.id != successor {
            bail!("the successor did not fly the route to its end");
        }
        let truth = runner.referee.truth();
        let end = out.waypoints.last().copied().unwrap_or(start);
        self.end_off_m = vehicle(&truth, successor).map(|v| v.position.distance_m(&end));
        runner.say(&format!(
            "vehicle {successor} is at the end of its predecessor's route, {:.2} m off",
            self.end_off_m.unwrap_or(f64::INFINITY)
        ));
        let back = Route {
            waypoints: vec![at(50.0, 60.0), at(50.0, 0.0)],
            ..out
        };
        runner.begin_route("south and west", &back).await?;
        runner.pause(3.0).await;
        self.replace_leader(runner).await?;
        runner.route_end(60.0).await?;
        self.after_replacement = Some(runner.referee.next_part());
        runner.bring_back(lost).await?;
        runner.land().await
    }

    fn criteria(&self, _referee: &Referee) -> Vec<Criterion> {
        let step = |step: &Option<SetpointStep>| step.map(|s| s.beyond_m);
        let part = |part: &Option<(Errors, Errors)>| {
            let (straight, turning) = part.unzip();
            (straight.and_then(|e| e.rms()), turning.and_then(|e| e.rms()))
        };
        let ((straight, turning), (later, _)) = (part(&self.after_loss), part(&self.after_replacement));
        vec![
            measured("loss of the leader declared until new intent", self.intent_ms).at_most(SUCCESSION_LIMIT_MS, "ms"),
            measured("new intent until the successor leads", self.leads_ms).at_most(SUCCESSION_LIMIT_MS, "ms"),
            measured(
                "largest jump of a setpoint when the leader was lost",
                step(&self.at_loss),
            )
            .at_most(STEP_LIMIT_M, "m"),
            measured("all in their slots again after the loss", self.whole_again_s).at_most(WHOLE_AGAIN_S, "s"),
            measured("successor off the end of the route", self.end_off_m).at_most(1.0, "m"),
            measured("error after the loss, straight, root mean square", straight).at_most(1.0, "m"),
            measured("error after the loss, turning, root mean square", turning).at_most(1.5, "m"),
            happened("leader replaced on purpose", self.replaced),
            measured(
                "largest jump of a setpoint when the leader was replaced",
                step(&self.at_replacement),
            )
            .at_most(STEP_LIMIT_M, "m"),
            measured("error after the replacement, straight, root mean square", later).at_most(1.0, "m"),
        ]
    }
}
