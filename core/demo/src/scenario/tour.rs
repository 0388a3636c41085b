//! The tour, which is flown if nothing else is asked for: take off, form up, follow a leader along a route and back, land each on its spot.

use super::Flight;
use crate::layout::{self, Layout};
use crate::referee::Referee;
use crate::report::{Criterion, at_most};
use crate::stage::Stage;
use anyhow::bail;
use skein_domain::payload::{PayloadKind, Target};
use skein_domain::{FormationRequest, PositionNed, Route, Shape, VehicleCommand, VehicleId};
use skein_runtime::Targets;
use skein_view::VehicleSnapshot;

/// The flight.
pub struct Tour {
    layout: Layout,
}

impl Tour {
    /// With legs of the layout's length.
    pub fn new(layout: Layout) -> Self {
        Self { layout }
    }

    /// Vehicles with a gimbal keep it on the leader from here on.
    async fn look_at_leader(&self, stage: &Stage<'_>) -> anyhow::Result<()> {
        let fleet = stage.node.snapshot();
        let leader = stage.leader()?.id;
        let carries_gimbal =
            |v: &&VehicleSnapshot| !v.is_leader && v.payloads.iter().any(|p| p.kind == PayloadKind::Gimbal);
        let observers: Vec<VehicleId> = fleet.vehicles.iter().filter(carries_gimbal).map(|v| v.id).collect();
        if observers.is_empty() {
            return Ok(());
        }
        let command = VehicleCommand::LookAt {
            target: Target::Vehicle { vehicle: leader },
        };
        for receipt in stage.node.command(&Targets::Vehicles(observers.clone()), command).await {
            if let Some(refusal) = receipt.refusal {
                bail!("vehicle {} refuses to look at the leader: {refusal}", receipt.vehicle);
            }
        }
        stage.say(&format!("{} gimbals turn to the leader", observers.len()));
        stage.referee.expect_gimbals(leader, observers);
        Ok(())
    }

    async fn form(&self, stage: &Stage<'_>, shape: Shape) -> anyhow::Result<()> {
        let request = FormationRequest::new(shape, layout::SPACING_M);
        stage.form(&format!("{shape:?}"), request).await.map(drop)
    }

    async fn route(
        &self,
        stage: &Stage<'_>,
        what: &str,
        plan: impl Fn(&Layout, PositionNed) -> Route,
    ) -> anyhow::Result<()> {
        let route = plan(&self.layout, stage.leader_position()?);
        stage.begin_route(what, &route).await?;
        let length_m = self.layout.leg_m * 3.0;
        stage.route_end(length_m / layout::SPEED_M_S + 40.0).await
    }
}

impl Flight for Tour {
    async fn fly(&mut self, stage: &Stage<'_>) -> anyhow::Result<()> {
        stage.take_off_all(layout::HEIGHT_M).await?;
        self.form(stage, Shape::Wedge).await?;
        self.look_at_leader(stage).await?;
        let home = stage.leader_position()?;
        self.route(stage, "north, east and half-way south", |layout, start| {
            layout.way_out(start)
        })
        .await?;
        self.form(stage, Shape::Line).await?;
        self.form(stage, Shape::Circle).await?;
        self.form(stage, Shape::Wedge).await?;
        self.route(stage, "back over the field", |layout, start| {
            layout.way_back(start, home)
        })
        .await?;
        self.form(stage, Shape::Grid).await?;
        stage.land().await
    }

    fn criteria(&self, referee: &Referee) -> Vec<Criterion> {
        let figures = referee.figures();
        let mut criteria = vec![
            at_most(
                "formation error in straight legs, root mean square",
                figures.straight.rms(),
                0.5,
                "m",
            ),
            at_most(
                "formation error in turns, root mean square",
                figures.turning.rms(),
                1.5,
                "m",
            ),
        ];
        if figures.expects_gimbals() {
            criteria.push(at_most(
                "gimbals off what they look at, root mean square",
                figures.pointing.rms().map(f64::to_degrees),
                5.0,
                "deg",
            ));
        }
        criteria
    }
}
