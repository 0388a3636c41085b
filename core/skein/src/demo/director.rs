//! The director: gives the demonstration's commands, one after the other, through the same handle as the API, and waits until what
//! was asked is the case. Says what goes on.

use super::layout::{self, Layout};
use super::referee::{Landing, Referee};
use anyhow::{Context, bail};
use skein_domain::payload::{PayloadKind, Target};
use skein_domain::{FlightState, FormationRequest, PositionNed, Refusal, Shape, SwarmFrame, VehicleCommand, VehicleId};
use skein_runtime::{FleetSnapshot, NodeHandle, RestartRecord, Targets, VehicleSnapshot};
use std::time::Duration;
use tokio::time::Instant;

/// The director of one flight.
pub struct Director<'a> {
    node: NodeHandle,
    layout: &'a Layout,
    referee: &'a Referee,
    started: Instant,
    /// Seconds from the first command to the last disarming.
    pub flight_s: Option<f64>,
}

impl<'a> Director<'a> {
    /// A director that has not begun.
    pub fn new(node: NodeHandle, layout: &'a Layout, referee: &'a Referee) -> Self {
        Self {
            node,
            layout,
            referee,
            started: Instant::now(),
            flight_s: None,
        }
    }

    /// Actors and plugins that were started more than once, in words.
    pub fn restarts(&self) -> Vec<String> {
        let fleet = self.node.snapshot();
        let vehicles = fleet.vehicles.iter().flat_map(|v| {
            let payloads = v.payloads.iter().map(|payload| payload.plugin.as_actor());
            [v.actor.clone(), v.model.as_actor()].into_iter().chain(payloads)
        });
        vehicles
            .chain(fleet.actors.iter().cloned())
            .filter(|health| health.incarnation.0 > 1)
            .map(|h| {
                format!(
                    "{} (incarnation {}, last error: {})",
                    h.name, h.incarnation, h.last_error
                )
            })
            .collect()
    }

    /// Restarts of plugin instances.
    pub fn plugin_restarts(&self) -> Vec<RestartRecord> {
        self.node.restarts()
    }

    fn say(&self, what: &str) {
        println!("{:6.1} s  {what}", self.started.elapsed().as_secs_f64());
    }

    /// The whole flight.
    ///
    /// # Errors
    /// When something that should happen does not, or is refused.
    pub async fn fly(&mut self) -> anyhow::Result<()> {
        let count = self.layout.vehicles;
        self.say("waiting for the vehicles");
        self.until(30.0, "all vehicles found and ready to arm", |fleet| {
            fleet.vehicles.len() == count && fleet.vehicles.iter().all(|v| v.ready_to_arm == Some(true))
        })
        .await?;
        self.say(&format!(
            "{count} vehicles found and ready; arming and taking off, one after the other"
        ));
        self.command(VehicleCommand::TakeOff {
            height_m: layout::HEIGHT_M,
        })
        .await?;
        let up_s = 40.0 + self.layout.take_off_stagger_s * count as f64;
        self.until(up_s, "all vehicles up and holding", |fleet| {
            fleet.vehicles.iter().all(|v| v.flight_state == FlightState::Holding)
        })
        .await?;
        self.referee.airborne();
        self.form(Shape::Wedge).await?;
        self.look_at_leader().await?;
        let home = self.leader_position()?;
        self.route("north, east and half-way south", |layout, start| layout.way_out(start))
            .await?;
        self.form(Shape::Line).await?;
        self.form(Shape::Circle).await?;
        self.form(Shape::Wedge).await?;
        self.route("back over the field", |layout, start| layout.way_back(start, home))
            .await?;
        self.form(Shape::Grid).await?;
        self.land().await?;
        self.flight_s = Some(self.started.elapsed().as_secs_f64());
        self.say("all landed and disarmed");
        Ok(())
    }

    /// Vehicles with a gimbal keep it on the leader from here on.
    async fn look_at_leader(&self) -> anyhow::Result<()> {
        let fleet = self.node.snapshot();
        let leader = fleet.vehicles.iter().find(|v| v.is_leader).map(|v| v.id);
        let leader = leader.context("nobody leads")?;
        let carries_gimbal =
            |v: &&VehicleSnapshot| !v.is_leader && v.payloads.iter().any(|p| p.kind == PayloadKind::Gimbal);
        let observers: Vec<VehicleId> = fleet.vehicles.iter().filter(carries_gimbal).map(|v| v.id).collect();
        if observers.is_empty() {
            return Ok(());
        }
        let command = VehicleCommand::LookAt {
            target: Target::Vehicle { vehicle: leader },
        };
        for receipt in self.node.command(&Targets::Vehicles(observers.clone()), command).await {
            if let Some(refusal) = receipt.refusal {
                bail!("vehicle {} refuses to look at the leader: {refusal}", receipt.vehicle);
            }
        }
        self.say(&format!("{} gimbals turn to the leader", observers.len()));
        self.referee.expect_gimbals(leader, observers);
        Ok(())
    }

    async fn form(&self, shape: Shape) -> anyhow::Result<()> {
        let request = FormationRequest::new(shape, layout::SPACING_M);
        let receipt = self.retried(|| self.node.set_formation(request.clone())).await?;
        self.say(&format!(
            "{shape:?} {}: {:.1} s, at least {:.1} m apart on the way",
            behind(receipt.leader),
            receipt.duration_s,
            receipt.planned_min_distance_m
        ));
        tokio::time::sleep(Duration::from_secs_f64(receipt.duration_s + layout::SETTLE_S)).await;
        let worst_m = self.referee.slots_reached(&format!("{shape:?}"));
        self.say(&format!(
            "{shape:?} formed: the farthest vehicle is {worst_m:.2} m from its slot"
        ));
        Ok(())
    }

    async fn route(
        &self,
        what: &str,
        plan: impl Fn(&Layout, PositionNed) -> skein_domain::Route,
    ) -> anyhow::Result<()> {
        let route = plan(self.layout, self.leader_position()?);
        let length_m = self.layout.leg_m * 3.0;
        self.say(&format!(
            "the leader flies {what} at {:.0} m/s, the others follow",
            route.speed_m_s
        ));
        let route = self.retried(|| self.node.set_route(route.clone())).await?;
        let limit_s = length_m / layout::SPEED_M_S + 40.0;
        self.until(limit_s, "the leader at the end of its route", |fleet| {
            fleet
                .formation
                .as_ref()
                .is_some_and(|f| f.route.as_ref() == Some(&route) && f.route_finished)
        })
        .await?;
        tokio::time::sleep(Duration::from_secs_f64(layout::SETTLE_S)).await;
        Ok(())
    }

    /// Everyone lands on the spot under its slot in the grid over the field.
    async fn land(&self) -> anyhow::Result<()> {
        let frame = self.node.snapshot().frame.context("the swarm frame is not known")?;
        let spots = self.spots(&frame)?;
        self.referee.expect_landings(&spots);
        self.say("landing, each on its spot");
        for landing in &spots {
            let targets = Targets::Vehicles(vec![landing.vehicle]);
            let command = VehicleCommand::LandAt { spot: landing.spot };
            for receipt in self.node.command(&targets, command).await {
                if let Some(refusal) = receipt.refusal {
                    bail!("vehicle {} does not land: {refusal}", receipt.vehicle);
                }
            }
        }
        self.until(60.0, "all vehicles landed and disarmed", |fleet| {
            fleet
                .vehicles
                .iter()
                .all(|v| !v.armed && v.flight_state == FlightState::Idle)
        })
        .await
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
        let mut spots: Vec<Landing> = slots.leader.map(|leader| spot(leader, slots.anchor.position)).into_iter().collect();
        for (vehicle, slot) in &slots.slots {
            spots.push(spot(*vehicle, slots.anchor.position.moved(slot.to.rotated(heading))));
        }
        Ok(spots)
    }

    /// Height of the field in the swarm frame, from the leader's launch place.
    fn ground_down_m(&self) -> f64 {
        let fleet = self.node.snapshot();
        let home = fleet.vehicles.first().and_then(|v| v.home).zip(fleet.frame);
        home.map_or(0.0, |(home, frame)| frame.position(&home).down_m)
    }

    fn leader_position(&self) -> anyhow::Result<PositionNed> {
        let fleet = self.node.snapshot();
        let leader = fleet
            .vehicles
            .iter()
            .find(|v| v.is_leader)
            .context("there is no leader")?;
        Ok(leader.kinematics.context("the leader has no position")?.position)
    }

    async fn command(&self, command: VehicleCommand) -> anyhow::Result<()> {
        for receipt in self.node.command(&Targets::All, command).await {
            if let Some(refusal) = receipt.refusal {
                bail!("vehicle {} refuses to {}: {refusal}", receipt.vehicle, command.name());
            }
        }
        Ok(())
    }

    /// Asks again for a moment when a part is just being restarted, as an operator would.
    async fn retried<T, F: Future<Output = Result<T, Refusal>>>(&self, ask: impl Fn() -> F) -> anyhow::Result<T> {
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

    async fn until(&self, patience_s: f64, what: &str, is_so: impl Fn(&FleetSnapshot) -> bool) -> anyhow::Result<()> {
        let deadline = Instant::now() + Duration::from_secs_f64(patience_s);
        let mut poll = tokio::time::interval(Duration::from_millis(100));
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

/// Behind whom a formation flies, in words.
fn behind(leader: Option<VehicleId>) -> String {
    leader.map_or_else(|| "about its anchor".to_owned(), |id| format!("behind vehicle {id}"))
}
