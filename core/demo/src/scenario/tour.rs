//! The tour, which is flown if nothing else is asked for: take off, form up, follow a leader along a route and back, land each on its spot.

use super::Flight;
use crate::layout::{self, Layout};
use crate::referee::Referee;
use crate::report::{Criterion, measured};
use crate::scenario_runner::ScenarioRunner;
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

    async fn form(&self, runner: &ScenarioRunner<'_>, shape: Shape) -> anyhow::Result<()> {
        let request = FormationRequest::new(shape, layout::SPACING_M);
        runner.form(&format!("{shape:?}"), request).await.map(drop)
    }

    async fn route(
        &self,
        runner: &ScenarioRunner<'_>,
        what: &str,
        plan: impl Fn(&Layout, PositionNed) -> Route,
    ) -> anyhow::Result<()> {
        let route = plan(&self.layout, runner.leader_position()?);
        runner.begin_route(what, &route).await?;
        let length_m = self.layout.leg_m * 3.0;
        runner.route_end(length_m / layout::SPEED_M_S + 40.0).await
    }
}

/// Vehicles with a gimbal keep it on the leader from here on.
pub(super) async fn look_at_leader(runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
    let fleet = runner.node.snapshot();
    let leader = runner.leader()?.id;
    let carries_gimbal =
        |v: &&VehicleSnapshot| !v.is_leader && v.payloads.iter().any(|p| p.kind == PayloadKind::Gimbal);
    let observers: Vec<VehicleId> = fleet.vehicles.iter().filter(carries_gimbal).map(|v| v.id).collect();
    if observers.is_empty() {
        return Ok(());
    }
    let command = VehicleCommand::LookAt {
        target: Target::Vehicle { vehicle: leader },
    };
    for receipt in runner
        .node
        .command(&Targets::Vehicles(observers.clone()), command)
        .await
    {
        if let Some(refusal) = receipt.refusal {
            bail!("vehicle {} refuses to look at the leader: {refusal}", receipt.vehicle);
        }
    }
    runner.say(&format!("{} gimbals turn to the leader", observers.len()));
    runner.referee.expect_gimbals(leader, observers);
    Ok(())
}

impl Flight for Tour {
    async fn fly(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        runner.take_off_all(layout::HEIGHT_M).await?;
        self.form(runner, Shape::Wedge).await?;
        look_at_leader(runner).await?;
        let home = runner.leader_position()?;
        self.route(runner, "north, east and half-way south", |layout, start| {
            layout.way_out(start)
        })
        .await?;
        self.form(runner, Shape::Line).await?;
        self.form(runner, Shape::Circle).await?;
        self.form(runner, Shape::Wedge).await?;
        self.route(runner, "back over the field", |layout, start| {
            layout.way_back(start, home)
        })
        .await?;
        self.form(runner, Shape::Grid).await?;
        runner.land().await
    }

    fn criteria(&self, referee: &Referee) -> Vec<Criterion> {
        let figures = referee.figures();
        let mut criteria = vec![
            measured(
                "formation error in straight legs, root mean square",
                figures.straight.rms(),
            )
            .at_most(0.5, "m"),
            measured("formation error in turns, root mean square", figures.turning.rms()).at_most(1.5, "m"),
        ];
        if figures.expects_gimbals() {
            criteria.push(
                measured(
                    "gimbals off what they look at, root mean square",
                    figures.pointing.rms().map(f64::to_degrees),
                )
                .at_most(5.0, "deg"),
            );
        }
        criteria
    }
}
