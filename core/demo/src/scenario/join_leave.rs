//! Who takes part changes while the formation flies: one is told to hold, two take off and join, another leads, one lands, one falls
//! silent, and the one that holds is called back. Everyone who remains is in its slot each time.

use super::{Flight, Setup, swarm_origin};
use crate::layout::{HEIGHT_M, SETTLE_S, SPACING_M};
use crate::referee::Referee;
use crate::report::{Criterion, at_least, at_most};
use crate::stage::Stage;
use crate::steps::{Step, StepWatch};
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
    at_swap: Option<Step>,
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
    async fn gathered(&mut self, stage: &Stage<'_>, label: &str, expected: &[VehicleId]) -> anyhow::Result<f64> {
        let asked_s = stage.elapsed_s();
        let mut expected = expected.to_vec();
        expected.sort_unstable();
        let take_part = |fleet: &skein_view::FleetSnapshot| {
            fleet.formation.as_ref().is_some_and(|f| {
                let mut members = f.members.clone();
                members.sort_unstable();
                members == expected
            })
        };
        stage
            .until(30.0, &format!("formation of {expected:?}: {label}"), take_part)
            .await?;
        let took_s = stage.elapsed_s() - asked_s;
        let settled = |fleet: &skein_view::FleetSnapshot| {
            let formation = fleet.formation.as_ref();
            formation.is_some_and(|f| fleet.time.seconds_since(f.settled_at) > SETTLE_S)
        };
        stage.until(60.0, "the end of the change", settled).await?;
        // Whoever gave way to one that left comes later than planned: how late is a figure of its own.
        let until_s = stage.elapsed_s() + LATE_S;
        while stage.referee.farthest_from_slot_m() > IN_SLOT_M && stage.elapsed_s() < until_s {
            stage.pause(0.1).await;
        }
        self.latest_s = self.latest_s.max(stage.elapsed_s() - asked_s);
        let worst_m = stage.referee.slots_reached(label);
        stage.say(&format!(
            "{label}: regrouped after {took_s:.1} s, in their slots after {:.1} s; of {} the farthest is {worst_m:.2} m from its slot{}",
            stage.elapsed_s() - asked_s,
            expected.len(),
            stage.giving_way()
        ));
        self.gatherings += 1;
        Ok(took_s)
    }

    /// Followers as the formation has them now, the last first.
    fn followers(stage: &Stage<'_>) -> anyhow::Result<(VehicleId, Vec<VehicleId>)> {
        let fleet = stage.node.snapshot();
        let formation = fleet.formation.as_ref().context("no formation is flown")?;
        let leader = formation.leader.context("nobody leads")?;
        let mut followers: Vec<VehicleId> = formation.members.iter().copied().filter(|id| *id != leader).collect();
        followers.sort_unstable_by(|a, b| b.cmp(a));
        Ok((leader, followers))
    }

    /// One holds, two come up from the ground.
    async fn leave_and_join(&mut self, stage: &Stage<'_>, newcomers: &[VehicleId]) -> anyhow::Result<VehicleId> {
        let (leader, followers) = Self::followers(stage)?;
        let holds = *followers.first().context("nobody follows")?;
        stage.say(&format!("vehicle {holds} is told to hold: it leaves"));
        stage.command(&[holds], VehicleCommand::Hold).await?;
        let mut members: Vec<VehicleId> = followers.iter().copied().filter(|id| *id != holds).collect();
        members.push(leader);
        self.left_s = Some(self.gathered(stage, "without the one that holds", &members).await?);
        let named: Vec<String> = newcomers.iter().map(ToString::to_string).collect();
        stage.say(&format!("vehicles {} take off to join", named.join(" and ")));
        stage.take_off(newcomers, HEIGHT_M).await?;
        members.extend(newcomers);
        let up_s = stage.elapsed_s();
        self.gathered(stage, "with two more", &members).await?;
        self.joined_s = Some(stage.elapsed_s() - up_s);
        Ok(holds)
    }

    /// Another leads; the former leader takes a slot.
    async fn swap_roles(&mut self, stage: &Stage<'_>) -> anyhow::Result<()> {
        let (leader, followers) = Self::followers(stage)?;
        let next = *followers.last().context("nobody follows")?;
        stage.say(&format!("vehicle {next} is to lead instead of {leader}"));
        let request = FormationRequest {
            leader: Some(next),
            members: Some(followers.iter().copied().chain([leader]).collect()),
            ..wedge()
        };
        let watch = StepWatch::begin(&stage.node, None, SPEED_M_S);
        stage.form("Wedge, roles swapped", request).await?;
        self.at_swap = watch.end(stage);
        let (now, others) = Self::followers(stage)?;
        self.roles_swapped = now == next && others.contains(&leader);
        Ok(())
    }

    /// One lands where it is, one falls silent; gives the silent one.
    async fn land_and_lose(&mut self, stage: &Stage<'_>) -> anyhow::Result<VehicleId> {
        let (leader, followers) = Self::followers(stage)?;
        let (lands, falls_silent) = match followers.as_slice() {
            [first, second, ..] => (*first, *second),
            _ => bail!("too few follow"),
        };
        stage.say(&format!("vehicle {lands} is told to land: it leaves"));
        let fleet = stage.node.snapshot();
        if let Some(vehicle) = fleet.vehicles.iter().find(|v| v.id == lands) {
            stage.referee.may_land(vehicle.system_id.0);
        }
        stage.command(&[lands], VehicleCommand::Land).await?;
        let without = |gone: &[VehicleId]| -> Vec<VehicleId> {
            let stay = followers.iter().copied().filter(|id| !gone.contains(id));
            stay.chain([leader]).collect()
        };
        self.gathered(stage, "without the one that lands", &without(&[lands]))
            .await?;
        let fleet = stage.node.snapshot();
        let silent = fleet.vehicles.iter().find(|v| v.id == falls_silent);
        let system_id = silent.context("the vehicle is not in the picture")?.system_id.0;
        stage.say(&format!("vehicle {falls_silent} falls silent"));
        stage.referee.excuse(system_id);
        stage.simulation()?.inflict(system_id, Fault::Silent(true))?;
        let stay = without(&[lands, falls_silent]);
        self.lost_s = Some(self.gathered(stage, "without the silent one", &stay).await?);
        Ok(falls_silent)
    }
}

impl Flight for JoinLeave {
    fn prepare(&self, setup: &mut Setup) {
        setup.node.swarm.origin = Some(swarm_origin());
    }

    async fn fly(&mut self, stage: &Stage<'_>) -> anyhow::Result<()> {
        if stage.vehicles < FEWEST {
            bail!("this scenario needs {FEWEST} vehicles at least");
        }
        stage.referee.cruise(SPEED_M_S);
        stage.find_all().await?;
        let ids = stage.ids();
        let (first, newcomers) = ids.split_at(stage.vehicles - ON_GROUND);
        stage.say(&format!("{} take off, {ON_GROUND} stay on the ground", first.len()));
        stage.take_off(first, HEIGHT_M).await?;
        stage.referee.airborne();
        stage.form("Wedge", wedge()).await?;
        let start = stage.leader_position()?;
        let at = |north: f64, east: f64| start.moved(nalgebra::Vector3::new(north, east, 0.0));
        let route = Route {
            waypoints: vec![at(70.0, 0.0), at(70.0, 50.0), at(20.0, 50.0)],
            speed_m_s: SPEED_M_S,
            corner_radius_m: CORNER_RADIUS_M,
        };
        stage.begin_route("round the field", &route).await?;
        stage.pause(5.0).await;
        let holds = self.leave_and_join(stage, newcomers).await?;
        self.swap_roles(stage).await?;
        let silent = self.land_and_lose(stage).await?;
        let (leader, mut members) = Self::followers(stage)?;
        members.extend([leader, holds]);
        stage.say(&format!("vehicle {holds} is called back"));
        let request = FormationRequest {
            members: Some(members.clone()),
            ..wedge()
        };
        stage.form("Wedge, with the one that held", request).await?;
        self.gathered(stage, "with the one that held", &members).await?;
        stage.route_end(60.0).await?;
        stage.bring_back(silent).await?;
        stage.land_in_grid().await
    }

    fn criteria(&self, _referee: &Referee) -> Vec<Criterion> {
        vec![
            at_least("changes of who takes part", Some(self.gatherings as f64), 5.0, ""),
            at_most("told to hold until the others regroup", self.left_s, 2.0, "s"),
            at_most(
                "from hovering until in a slot of the formation",
                self.joined_s,
                25.0,
                "s",
            ),
            at_most("fallen silent until the others regroup", self.lost_s, 3.0, "s"),
            at_most(
                "longest change until everyone is in its slot",
                Some(self.latest_s).filter(|_| self.gatherings > 0),
                CHANGE_LIMIT_S,
                "s",
            ),
            at_least("roles swapped", Some(f64::from(u8::from(self.roles_swapped))), 1.0, ""),
            at_most(
                "largest jump of a setpoint when roles were swapped",
                self.at_swap.map(|s| s.beyond_m),
                0.5,
                "m",
            ),
        ]
    }
}
