//! What every flight of the demonstration does the same way: find the vehicles, bring them up, form, fly routes, land. All through the
//! same handle as the API; each step waits until what was asked is the case, says what goes on, and breaks off when it is not.

use super::layout;
use super::referee::{Landing, Referee};
use anyhow::{Context, bail};
use skein_domain::exchange::CommandProgress;
use skein_domain::{
    FlightState, FormationRequest, LandedState, PositionNed, Refusal, Route, Shape, SwarmFrame, VehicleCommand,
    VehicleId,
};
use skein_node::tell;
use skein_runtime::{NodeHandle, Targets};
use skein_sim::{Fault, Simulation};
use skein_view::FormationReceipt;
use skein_view::{EventKind, FleetSnapshot, VehicleSnapshot};
use std::time::Duration;
use tokio::time::Instant;

/// Where a flight takes place.
pub struct ScenarioRunner<'a> {
    /// The node that flies.
    pub node: NodeHandle,
    /// What it flies in; absent for autopilots that are there without us.
    simulation: Option<&'a Simulation>,
    /// Who watches.
    pub referee: &'a Referee,
    /// How many vehicles there are.
    pub vehicles: usize,
    /// Time between two take-offs in seconds.
    pub take_off_stagger_s: f64,
    started: Instant,
}

impl<'a> ScenarioRunner<'a> {
    /// Before anything has happened.
    pub fn new(
        node: NodeHandle,
        simulation: Option<&'a Simulation>,
        referee: &'a Referee,
        vehicles: usize,
        take_off_stagger_s: f64,
    ) -> Self {
        Self {
            node,
            simulation,
            referee,
            vehicles,
            take_off_stagger_s,
            started: Instant::now(),
        }
    }

    /// What it flies in.
    ///
    /// # Errors
    /// When it flies autopilots that are there without us: nothing can be done to these.
    pub fn simulation(&self) -> anyhow::Result<&'a Simulation> {
        self.simulation
            .context("this can be flown with simulated vehicles only")
    }

    /// Seconds since the flight began.
    pub fn elapsed_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Tells the person who watches.
    pub fn say(&self, what: &str) {
        tell(format_args!("{:6.1} s  {what}", self.elapsed_s()));
    }

    /// Waits for all vehicles to be there and ready, and for nothing in the preflight report to keep them from arming.
    pub async fn find_all(&self) -> anyhow::Result<()> {
        let count = self.vehicles;
        self.say("waiting for the vehicles");
        self.until(30.0, "all vehicles found and ready to arm", |fleet| {
            let all_ready = fleet.vehicles.iter().all(|v| v.ready_to_arm == Some(true));
            fleet.vehicles.len() == count && all_ready && self.node.preflight().is_green()
        })
        .await
    }

    /// All take off, one after the other; from then on formation errors count.
    pub async fn take_off_all(&self, height_m: f64) -> anyhow::Result<()> {
        self.find_all().await?;
        let ids = self.ids();
        self.say(&format!(
            "{} vehicles found and ready; arming and taking off, one after the other",
            ids.len()
        ));
        self.take_off(&ids, height_m).await?;
        self.referee.airborne();
        Ok(())
    }

    /// These take off and hold.
    pub async fn take_off(&self, ids: &[VehicleId], height_m: f64) -> anyhow::Result<()> {
        self.command(ids, VehicleCommand::TakeOff { height_m }).await?;
        let up_s = 40.0 + height_m + self.take_off_stagger_s * ids.len() as f64;
        self.until(up_s, "all up and holding", |fleet| {
            // Who comes up while a formation flies may have joined it already.
            let up = |state| {
                matches!(
                    state,
                    FlightState::Holding | FlightState::Following | FlightState::Leading
                )
            };
            let of = |id: &VehicleId| fleet.vehicles.iter().find(|v| v.id == *id);
            ids.iter().all(|id| of(id).is_some_and(|v| up(v.flight_state)))
        })
        .await
    }

    /// Ids of all vehicles.
    pub fn ids(&self) -> Vec<VehicleId> {
        self.node.snapshot().vehicles.iter().map(|v| v.id).collect()
    }

    /// Flies a formation and waits until it is formed; the referee then looks how far each vehicle is from its slot.
    pub async fn form(&self, label: &str, request: FormationRequest) -> anyhow::Result<FormationReceipt> {
        let receipt = self.begin_form(label, request).await?;
        self.pause(receipt.duration_s + layout::SETTLE_S).await;
        // On a machine that never runs through for so long it is judged all the same.
        for _ in 0..200 {
            if !self.referee.is_disturbed() {
                break;
            }
            self.pause(0.1).await;
        }
        let worst_m = self.referee.slots_reached(label);
        self.say(&format!(
            "{label} formed: the farthest vehicle is {worst_m:.2} m from its slot{}",
            self.giving_way()
        ));
        Ok(receipt)
    }

    /// Who gives way at this moment, for a message.
    pub fn giving_way(&self) -> String {
        let fleet = self.node.snapshot();
        let gives_way = |v: &VehicleSnapshot| {
            let to = v.avoiding.as_ref()?.because.as_ref()?;
            Some(format!("; vehicle {} gives way to {to}", v.id))
        };
        fleet.vehicles.iter().filter_map(gives_way).collect()
    }

    /// Asks for a formation and says how it will go.
    pub async fn begin_form(&self, label: &str, request: FormationRequest) -> anyhow::Result<FormationReceipt> {
        let asked = self.retried(|| self.node.set_formation(request.clone())).await;
        let receipt = asked.with_context(|| format!("formation: {label}"))?;
        let behind = match receipt.leader {
            Some(leader) => format!("behind vehicle {leader}"),
            None => "about its anchor".into(),
        };
        self.say(&format!(
            "{label} {behind}: {:.1} s, at least {:.1} m apart on the way, then at most {:.1} m/s",
            receipt.duration_s,
            receipt.planned_min_distance_m.unwrap_or(f64::INFINITY),
            receipt.max_speed_m_s
        ));
        Ok(receipt)
    }

    /// Has the leader fly a route; gives it as it is flown.
    pub async fn begin_route(&self, what: &str, route: &Route) -> anyhow::Result<Route> {
        let asked = self.retried(|| self.node.set_route(route.clone())).await;
        let flown = asked.with_context(|| format!("route: {what}"))?;
        self.say(&format!(
            "the leader flies {what} at {:.1} m/s, the others follow",
            flown.speed_m_s
        ));
        // The picture may still be the one of a former route that was flown to its end.
        self.until(2.0, "the route in the picture of the fleet", |fleet| {
            let formation = fleet.formation.as_ref();
            formation.is_some_and(|f| f.route.as_ref() == Some(&flown) && !f.route_finished)
        })
        .await?;
        Ok(flown)
    }

    /// Waits until the route is flown.
    pub async fn route_end(&self, limit_s: f64) -> anyhow::Result<()> {
        self.until(limit_s, "the leader at the end of its route", |fleet| {
            fleet.formation.as_ref().is_some_and(|f| f.route_finished)
        })
        .await?;
        self.pause(layout::SETTLE_S).await;
        Ok(())
    }

    /// A level grid from which all land, each on the spot under its slot.
    pub async fn land_in_grid(&self) -> anyhow::Result<()> {
        let request = FormationRequest::new(Shape::Grid, layout::SPACING_M);
        self.form("grid over the landing spots", request).await?;
        self.land().await
    }

    /// Everyone lands on the spot under its slot.
    pub async fn land(&self) -> anyhow::Result<()> {
        let frame = self.node.snapshot().frame.context("the swarm frame is not known")?;
        // While the formation closes up some have no slot, and would not be told to land.
        let placed = self.until(5.0, "a slot for everybody in flight", |fleet| {
            let slots = self.node.slots();
            let has_slot = |id| {
                slots
                    .as_ref()
                    .is_some_and(|s| s.leader == Some(id) || s.slots.iter().any(|(of, _)| *of == id))
            };
            let flies = |v: &&VehicleSnapshot| v.flight_state.is_available_in_air();
            fleet.vehicles.iter().filter(flies).all(|v| has_slot(v.id))
        });
        // Who flies beside the formation never has one.
        let _ = placed.await;
        let spots = self.spots(&frame)?;
        self.referee.expect_landings(&spots);
        self.say("landing, each on its spot");
        for landing in &spots {
            self.command(&[landing.vehicle], VehicleCommand::LandAt { spot: landing.spot })
                .await?;
        }
        self.all_down(60.0).await
    }

    /// A vehicle that was silent is heard again, and lands where it is, if its autopilot has not landed it meanwhile.
    pub async fn bring_back(&self, id: VehicleId) -> anyhow::Result<()> {
        let fleet = self.node.snapshot();
        let vehicle = fleet.vehicles.iter().find(|v| v.id == id);
        let system_id = vehicle.context("the vehicle is not in the picture")?.system_id.0;
        self.simulation()?.inflict(system_id, Fault::Silent(false))?;
        self.say(&format!("vehicle {id} is heard again, and is to land"));
        self.until(15.0, "the link to the silent vehicle", |fleet| {
            let vehicle = fleet.vehicles.iter().find(|v| v.id == id);
            vehicle.is_some_and(|v| v.link.connected && v.age_s < 0.5)
        })
        .await?;
        self.pause(1.0).await;
        let fleet = self.node.snapshot();
        let flies = |v: &&VehicleSnapshot| v.id == id && v.armed && v.landed != LandedState::OnGround;
        if fleet.vehicles.iter().any(|v| flies(&v)) {
            // Its autopilot may be setting it down at this very moment, and there is nothing left to be told.
            if let Some(refusal) = self.refusal(id, VehicleCommand::Land).await {
                self.say(&format!("it lands by itself: {refusal}"));
            }
        } else {
            self.say("its autopilot has landed it by itself meanwhile");
        }
        self.until(60.0, "the vehicle that was silent on the ground", |fleet| {
            fleet.vehicles.iter().any(|v| v.id == id && !v.armed)
        })
        .await
    }

    /// Waits until every vehicle stands disarmed.
    pub async fn all_down(&self, patience_s: f64) -> anyhow::Result<()> {
        let excused = self.referee.figures().excused;
        self.until(patience_s, "all vehicles landed and disarmed", |fleet| {
            // Whoever was not heard while it landed may be shown as faulted.
            let down = |v: &VehicleSnapshot| v.flight_state == FlightState::Idle || excused.contains(&v.system_id.0);
            fleet.vehicles.iter().all(|v| !v.armed && down(v))
        })
        .await?;
        self.say("all landed and disarmed");
        Ok(())
    }

    /// The assigned spots: below each vehicle's slot.
    fn spots(&self, frame: &SwarmFrame) -> anyhow::Result<Vec<Landing>> {
        let slots = self.node.slots().context("no formation is flown")?;
        let heading = slots.anchor.heading_rad;
        let ground_m = self.ground_down_m();
        let spot = |vehicle: VehicleId, position: PositionNed| {
            let spot = PositionNed::new(position.north_m, position.east_m, ground_m);
            Landing {
                vehicle,
                spot,
                place: frame.geodetic(&spot),
            }
        };
        let mut spots: Vec<Landing> = slots
            .leader
            .map(|leader| spot(leader, slots.anchor.position))
            .into_iter()
            .collect();
        for (vehicle, slot) in &slots.slots {
            spots.push(spot(*vehicle, slots.anchor.position.moved(slot.to.rotated(heading))));
        }
        Ok(spots)
    }

    /// Height of the field in the swarm frame, from the first vehicle's launch place.
    pub fn ground_down_m(&self) -> f64 {
        let fleet = self.node.snapshot();
        let home = fleet.vehicles.first().and_then(|v| v.home).zip(fleet.frame);
        home.map_or(0.0, |(home, frame)| frame.position(&home).down_m)
    }

    /// Who leads.
    pub fn leader(&self) -> anyhow::Result<VehicleSnapshot> {
        let fleet = self.node.snapshot();
        let leader = fleet.vehicles.iter().find(|v| v.is_leader).cloned();
        leader.context("nobody leads")
    }

    /// Where the leader is, as the node knows it.
    pub fn leader_position(&self) -> anyhow::Result<PositionNed> {
        let kinematics = self.leader()?.kinematics;
        Ok(kinematics.context("the leader has no position")?.position)
    }

    /// Where a vehicle is, as the node knows it.
    pub fn position(&self, id: VehicleId) -> anyhow::Result<PositionNed> {
        let fleet = self.node.snapshot();
        let vehicle = fleet.vehicles.iter().find(|v| v.id == id);
        let kinematics = vehicle.and_then(|v| v.kinematics);
        Ok(kinematics
            .with_context(|| format!("vehicle {id} has no position"))?
            .position)
    }

    /// Gives a command; a refusal breaks the flight off.
    pub async fn command(&self, ids: &[VehicleId], command: VehicleCommand) -> anyhow::Result<()> {
        for receipt in self.node.command(&Targets::Vehicles(ids.to_vec()), command).await {
            if let Some(refusal) = receipt.refusal {
                bail!("vehicle {} refuses to {}: {refusal}", receipt.vehicle, command.name());
            }
        }
        Ok(())
    }

    /// Gives a command to one and waits until it is done.
    pub async fn carry_out(&self, id: VehicleId, command: VehicleCommand, patience_s: f64) -> anyhow::Result<()> {
        let before = self.node.events_after(0).last().map_or(0, |e| e.seq);
        let receipts = self.node.command(&Targets::Vehicles(vec![id]), command).await;
        let receipt = receipts.into_iter().next().context("the command was not answered")?;
        if let Some(refusal) = receipt.refusal {
            bail!("vehicle {id} refuses to {}: {refusal}", command.name());
        }
        let progress = || {
            let events = self.node.events_after(before);
            events.iter().rev().find_map(|event| match &event.kind {
                EventKind::Command { id, progress, .. } if *id == receipt.id => Some(progress.clone()),
                _ => None,
            })
        };
        let what = format!("vehicle {id} done with {}", command.name());
        self.until(patience_s, &what, |_| {
            matches!(
                progress(),
                Some(CommandProgress::Done | CommandProgress::Refused { .. })
            )
        })
        .await?;
        match progress() {
            Some(CommandProgress::Refused { refusal }) => {
                bail!("vehicle {id} breaks off {}: {refusal}", command.name())
            }
            _ => Ok(()),
        }
    }

    /// Gives a command to one; its refusal is the answer.
    pub async fn refusal(&self, id: VehicleId, command: VehicleCommand) -> Option<Refusal> {
        let receipts = self.node.command(&Targets::Vehicles(vec![id]), command).await;
        receipts.into_iter().find_map(|receipt| receipt.refusal)
    }

    /// Asks again for a moment when a part is just being restarted, as an operator would.
    pub async fn retried<T, F: Future<Output = Result<T, Refusal>>>(&self, ask: impl Fn() -> F) -> anyhow::Result<T> {
        let patience = Instant::now() + Duration::from_secs(3);
        loop {
            match ask().await {
                Ok(answer) => return Ok(answer),
                Err(Refusal::NotRunning { .. } | Refusal::WrongState { .. }) if Instant::now() < patience => {
                    tokio::time::sleep(Duration::from_millis(100)).await;
                }
                Err(refusal) => bail!("refused: {refusal}"),
            }
        }
    }

    /// Lets time pass.
    pub async fn pause(&self, seconds: f64) {
        tokio::time::sleep(Duration::from_secs_f64(seconds.max(0.0))).await;
    }

    /// Waits until something is the case.
    pub async fn until(
        &self,
        patience_s: f64,
        what: &str,
        is_so: impl Fn(&FleetSnapshot) -> bool,
    ) -> anyhow::Result<()> {
        let deadline = Instant::now() + Duration::from_secs_f64(patience_s);
        let mut poll = tokio::time::interval(Duration::from_millis(50));
        loop {
            poll.tick().await;
            let fleet = self.node.snapshot();
            if is_so(&fleet) {
                return Ok(());
            }
            if Instant::now() > deadline {
                bail!("waited {patience_s:.0} s for: {what}. {}", states(&fleet));
            }
        }
    }
}

/// Who is in which state, for a message.
fn states(fleet: &FleetSnapshot) -> String {
    let states: Vec<String> = fleet
        .vehicles
        .iter()
        .map(|v| match v.state_detail.as_str() {
            "" => format!("{}: {} in {}", v.name, v.flight_state, v.mode),
            detail => format!("{}: {} in {} ({detail})", v.name, v.flight_state, v.mode),
        })
        .collect();
    if states.is_empty() {
        "No vehicle was found.".into()
    } else {
        states.join("; ")
    }
}
