//! Who takes part changes while the formation flies: one is told to hold, two take off and join, another leads, one lands, one falls
//! silent, and the one that holds is called back. Everyone who remains is in its slot each time.

use super::{Flight, Setup, swarm_origin};
use crate::layout::{HEIGHT_M, SETTLE_S, SPACING_M};
use crate::referee::Referee;
use crate::report::{Criterion, counted, happened, measured};
use crate::scenario_runner::ScenarioRunner;
use crate::steps::{SetpointStep, StepWatch};
use anyhow::{Context, bail};
use skein_domain::{FormationRequest, HeadingRequest, Route, Shape, VehicleCommand, VehicleId};
use skein_sim::Fault;

/// Speed of the leader in metres per second: slow, so that all of it happens not far from the field.
const SPEED_M_S: f64 = 3.0;
/// Radius of corners in metres.
const CORNER_RADIUS_M: f64 = 12.0;
/// So many stay on the ground at first.
const ON_GROUND: usize = 2;
/// Who is nearer to its slot than this is in it, in metres.
const IN_SLOT_M: f64 = 0.5;
/// After a change everyone is in its slot at the latest so much later than planned, in seconds.
const LATE_S: f64 = 10.0;
/// The longest time a change may take until everyone is in its slot, in seconds.
const CHANGE_LIMIT_S: f64 = 15.0;
/// Fewer would leave no formation.
const FEWEST: usize = 5;

/// The flight and what it showed.
#[derive(Default)]
pub struct JoinLeave {
    left_s: Option<f64>,
    joined_s: Option<f64>,
    lost_s: Option<f64>,
    roles_swapped: bool,
    at_swap: Option<SetpointStep>,
    gatherings: usize,
    /// The longest time from a change until everyone was in its slot, in seconds.
    latest_s: f64,
}

/// A wedge that always faces north: one that turned with the course would have to leave those who are still far off all the speed that
/// they would need in a turn.
fn wedge() -> FormationRequest {
    FormationRequest {
        heading: HeadingRequest::Fixed { heading_deg: 0.0 },
        ..FormationRequest::new(Shape::Wedge, SPACING_M)
    }
}

impl JoinLeave {
    /// Waits until exactly these take part, the change is over and everyone is in its slot; gives the seconds until they took part.
    async fn gathered(
        &mut self,
        runner: &ScenarioRunner<'_>,
        label: &str,
        expected: &[VehicleId],
    ) -> anyhow::Result<f64> {
        let asked_s = runner.elapsed_s();
        let mut expected = expected.to_vec();
        expected.sort_unstable();
        let take_part = |fleet: &skein_view::FleetSnapshot| {
            fleet.formation.as_ref().is_some_and(|f| {
                let mut members = f.members.clone();
                members.sort_unstable();
                members == expected
            })
        };
        runner
            .until(30.0, &format!("formation of {expected:?}: {label}"), take_part)
            .await?;
        let took_s = runner.elapsed_s() - asked_s;
        let settled = |fleet: &skein_view::FleetSnapshot| {
            let formation = fleet.formation.as_ref();
            formation.is_some_and(|f| fleet.time.seconds_since(f.settled_at) > SETTLE_S)
        };
        runner.until(60.0, "the end of the change", settled).await?;
        // Whoever gave way to one that left comes later than planned: how late is a figure of its own.
        let until_s = runner.elapsed_s() + LATE_S;
        while runner.referee.farthest_from_slot_m() > IN_SLOT_M && runner.elapsed_s() < until_s {
            runner.pause(0.1).await;
        }
        self.latest_s = self.latest_s.max(runner.elapsed_s() - asked_s);
        let worst_m = runner.referee.slots_reached(label);
        runner.say(&format!(
            "{label}: regrouped after {took_s:.1} s, in their slots after {:.1} s; of {} the farthest is {worst_m:.2} m from its slot{}",
            runner.elapsed_s() - asked_s,
            expected.len(),
            runner.giving_way()
        ));
        self.gatherings += 1;
        Ok(took_s)
    }

    /// Followers as the formation has them now, the last first.
    fn followers(runner: &ScenarioRunner<'_>) -> anyhow::Result<(VehicleId, Vec<VehicleId>)> {
        let fleet = runner.node.snapshot();
        let formation = fleet.formation.as_ref().context("no formation is flown")?;
        let leader = formation.leader.context("nobody leads")?;
        let mut followers: Vec<VehicleId> = formation.members.iter().copied().filter(|id| *id != leader).collect();
        followers.sort_unstable_by(|a, b| b.cmp(a));
        Ok((leader, followers))
    }

    /// One holds, two come up from the ground.
    async fn leave_and_join(
        &mut self,
        runner: &ScenarioRunner<'_>,
        newcomers: &[VehicleId],
    ) -> anyhow::Result<VehicleId> {
        let (leader, followers) = Self::followers(runner)?;
        let holds = *followers.first().context("nobody follows")?;
        runner.say(&format!("vehicle {holds} is told to hold: it leaves"));
        runner.command(&[holds], VehicleCommand::Hold).await?;
        let mut members: Vec<VehicleId> = followers.iter().copied().filter(|id| *id != holds).collect();
        members.push(leader);
        self.left_s = Some(self.gathered(runner, "without the one that holds", &members).await?);
        let named: Vec<String> = newcomers.iter().map(ToString::to_string).collect();
        runner.say(&format!("vehicles {} take off to join", named.join(" and ")));
        runner.take_off(newcomers, HEIGHT_M).await?;
        members.extend(newcomers);
        let up_s = runner.elapsed_s();
        self.gathered(runner, "with two more", &members).await?;
        self.joined_s = Some(runner.elapsed_s() - up_s);
        Ok(holds)
    }

    /// Another leads; the former leader takes a slot.
    async fn swap_roles(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        let (leader, followers) = Self::followers(runner)?;
        let next = *followers.last().context("nobody follows")?;
        runner.say(&format!("vehicle {next} is to lead instead of {leader}"));
        let request = FormationRequest {
            leader: Some(next),
            members: Some(followers.iter().copied().chain([leader]).collect()),
            ..wedge()
        };
        let watch = StepWatch::begin(&runner.node, None, SPEED_M_S);
        runner.form("Wedge, roles swapped", request).await?;
        self.at_swap = watch.end(runner);
        let (now, others) = Self::followers(runner)?;
        self.roles_swapped = now == next && others.contains(&leader);
        Ok(())
    }

    /// One lands where it is, one falls silent; gives the silent one.
    async fn land_and_lose(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<VehicleId> {
        let (leader, followers) = Self::followers(runner)?;
        let (lands, falls_silent) = match followers.as_slice() {
            [first, second, ..] => (*first, *second),
            _ => bail!("too few follow"),
        };
        runner.say(&format!("vehicle {lands} is told to land: it leaves"));
        let fleet = runner.node.snapshot();
        if let Some(vehicle) = fleet.vehicles.iter().find(|v| v.id == lands) {
            runner.referee.may_land(vehicle.system_id.0);
        }
        runner.command(&[lands], VehicleCommand::Land).await?;
        let without = |gone: &[VehicleId]| -> Vec<VehicleId> {
            let stay = followers.iter().copied().filter(|id| !gone.contains(id));
            stay.chain([leader]).collect()
        };
        self.gathered(runner, "without the one that lands", &without(&[lands]))
            .await?;
        let fleet = runner.node.snapshot();
        let silent = fleet.vehicles.iter().find(|v| v.id == falls_silent);
        let system_id = silent.context("the vehicle is not in the picture")?.system_id.0;
        runner.say(&format!("vehicle {falls_silent} falls silent"));
        runner.referee.excuse(system_id);
        runner.simulation()?.inflict(system_id, Fault::Silent(true))?;
        let stay = without(&[lands, falls_silent]);
        self.lost_s = Some(self.gathered(runner, "without the silent one", &stay).await?);
        Ok(falls_silent)
    }
}

impl Flight for JoinLeave {
    fn prepare(&self, setup: &mut Setup) {
        setup.node.swarm.origin = Some(swarm_origin());
    }

    async fn fly(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        if runner.vehicles < FEWEST {
            bail!("this scenario needs {FEWEST} vehicles at least");
        }
        runner.referee.cruise(SPEED_M_S);
        runner.find_all().await?;
        let ids = runner.ids();
        let (first, newcomers) = ids.split_at(runner.vehicles - ON_GROUND);
        runner.say(&format!("{} take off, {ON_GROUND} stay on the ground", first.len()));
        runner.take_off(first, HEIGHT_M).await?;
        runner.referee.airborne();
        runner.form("Wedge", wedge()).await?;
        let start = runner.leader_position()?;
        let at = |north: f64, east: f64| start.moved(nalgebra::Vector3::new(north, east, 0.0));
        let route = Route {
            waypoints: vec![at(70.0, 0.0), at(70.0, 50.0), at(20.0, 50.0)],
            speed_m_s: SPEED_M_S,
            corner_radius_m: CORNER_RADIUS_M,
        };
        runner.begin_route("round the field", &route).await?;
        runner.pause(5.0).await;
        let holds = self.leave_and_join(runner, newcomers).await?;
        self.swap_roles(runner).await?;
        let silent = self.land_and_lose(runner).await?;
        let (leader, mut members) = Self::followers(runner)?;
        members.extend([leader, holds]);
        runner.say(&format!("vehicle {holds} is called back"));
        let request = FormationRequest {
            members: Some(members.clone()),
            ..wedge()
        };
        runner.form("Wedge, with the one that held", request).await?;
        self.gathered(runner, "with the one that held", &members).await?;
        runner.route_end(60.0).await?;
        runner.bring_back(silent).await?;
        runner.land_in_grid().await
    }

    fn criteria(&self, _referee: &Referee) -> Vec<Criterion> {
        vec![
            counted("changes of who takes part", self.gatherings).at_least(5.0, ""),
            measured("told to hold until the others regroup", self.left_s).at_most(2.0, "s"),
            measured("from hovering until in a slot of the formation", self.joined_s).at_most(25.0, "s"),
            measured("fallen silent until the others regroup", self.lost_s).at_most(3.0, "s"),
            measured(
                "longest change until everyone is in its slot",
                Some(self.latest_s).filter(|_| self.gatherings > 0),
            )
            .at_most(CHANGE_LIMIT_S, "s"),
            happened("roles swapped", self.roles_swapped),
            measured(
                "largest jump of a setpoint when roles were swapped",
                self.at_swap.map(|s| s.beyond_m),
            )
            .at_most(0.5, "m"),
        ]
    }
}
