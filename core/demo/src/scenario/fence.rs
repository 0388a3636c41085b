//! A zone to stay in and two to keep out of: goals where nobody may be are refused with the zone's name, a goal behind a zone is reached
//! around it, a vehicle at full speed stops inside, a route that would lead somebody's place out is refused, and when the boundary is drawn in
//! on the way, whose places are beyond it fly along inside.

use super::{Flight, Setup, swarm_origin};
use crate::layout::{HEIGHT_M, SPACING_M};
use crate::referee::Referee;
use crate::report::{Criterion, counted, happened, measured};
use crate::scenario_runner::ScenarioRunner;
use anyhow::{Context, bail};
use nalgebra::Vector3;
use parking_lot::Mutex;
use skein_domain::fence::{AltitudeReference, BreachAction, FencePlan, FenceZone, ZoneKind, ZoneOutline};
use skein_domain::{FormationRequest, PositionNed, Refusal, Route, Shape, VehicleCommand, VehicleId};
use skein_sim::TruthFrame;
use std::sync::Arc;

/// The zone to stay in: south, west, north, east in metres; and how much farther east it reaches until the boundary is drawn in.
const FIELD_M: [f64; 4] = [-20.0, -20.0, 90.0, 80.0];
const DRAWN_IN_M: f64 = 10.0;
/// So far from the boundary the leader flies along it, in metres: its right arm reaches over that.
const ALONG_M: f64 = 6.0;
/// A mast: centre and radius in metres.
const MAST_M: ([f64; 2], f64) = ([45.0, 5.0], 9.0);
/// A yard: south, west, north, east in metres.
const YARD_M: [f64; 4] = [35.0, 35.0, 55.0, 50.0];
/// Full speed in metres per second.
const FULL_M_S: f64 = 11.0;
/// Speed of the formation in metres per second.
const SPEED_M_S: f64 = 4.0;

/// What the truth showed.
#[derive(Default)]
struct FenceSeen {
    watching: bool,
    /// Deepest beyond the boundary of the field, or inside of a zone to keep out of, in metres; negative: never.
    deepest_m: Option<f64>,
    /// Whose that was, and where.
    deepest_of: Option<(u8, PositionNed)>,
    /// Fastest towards the boundary, of whom is driven at it, in metres per second.
    fastest_m_s: f64,
}

/// The flight and what it showed.
#[derive(Default)]
pub struct Fence {
    seen: Arc<Mutex<FenceSeen>>,
    refused: usize,
    named: usize,
    around_off_m: Option<f64>,
    stopped_short_m: Option<f64>,
    route_refused: bool,
    slid: bool,
    reached_over_m: Option<f64>,
}

fn zone(name: &str, kind: ZoneKind, outline: ZoneOutline) -> FenceZone {
    FenceZone {
        name: name.into(),
        kind,
        outline,
        floor_m: None,
        ceiling_m: None,
        altitude_reference: AltitudeReference::Origin,
        action: BreachAction::Hold,
    }
}

fn rectangle([south, west, north, east]: [f64; 4]) -> ZoneOutline {
    ZoneOutline::LocalPolygon {
        corners_m: vec![[south, west], [south, east], [north, east], [north, west]],
    }
}

/// All zones, with the field as large as this.
fn zones(field_m: [f64; 4]) -> Vec<FenceZone> {
    let ([north_m, east_m], radius_m) = MAST_M;
    let mast = ZoneOutline::LocalCircle {
        centre_m: [north_m, east_m],
        radius_m,
    };
    vec![
        zone("field", ZoneKind::Inclusion, rectangle(field_m)),
        zone("mast", ZoneKind::Exclusion, mast),
        zone("yard", ZoneKind::Exclusion, rectangle(YARD_M)),
    ]
}

/// How far a place is outside of a rectangle in metres; negative inside.
fn outside_m([south, west, north, east]: [f64; 4], place: &PositionNed) -> f64 {
    let north_m = (south - place.north_m).max(place.north_m - north);
    let east_m = (west - place.east_m).max(place.east_m - east);
    north_m.max(east_m)
}

/// How far a place is where it must not be, in metres; negative where it may be.
fn breach_m(place: &PositionNed) -> f64 {
    let ([north_m, east_m], radius_m) = MAST_M;
    let in_mast_m = radius_m - (place.north_m - north_m).hypot(place.east_m - east_m);
    outside_m(FIELD_M, place).max(in_mast_m).max(-outside_m(YARD_M, place))
}

/// One look at the truth.
fn look(seen: &mut FenceSeen, truth: &TruthFrame) {
    if !seen.watching {
        return;
    }
    for vehicle in truth.vehicles.iter().filter(|v| v.alive) {
        let depth_m = breach_m(&vehicle.position);
        if seen.deepest_m.is_none_or(|deepest| depth_m > deepest) {
            seen.deepest_m = Some(depth_m);
            seen.deepest_of = Some((vehicle.system_id, vehicle.position));
        }
        seen.fastest_m_s = seen.fastest_m_s.max(vehicle.velocity.vector().xy().norm());
    }
}

impl Fence {
    /// Goals where nobody may be.
    async fn refusals(&mut self, runner: &ScenarioRunner<'_>, id: VehicleId) -> anyhow::Result<()> {
        let here = runner.position(id)?;
        let goals = [
            ("mast", MAST_M.0),
            ("yard", [45.0, 42.0]),
            ("field", [FIELD_M[2] + 10.0, 20.0]),
        ];
        for (name, [north_m, east_m]) in goals {
            let position = PositionNed::new(north_m, east_m, here.down_m);
            let command = VehicleCommand::GoTo {
                position,
                yaw_rad: None,
                speed_m_s: None,
            };
            match runner.refusal(id, command).await {
                Some(refusal @ Refusal::OutsideFence { .. }) => {
                    self.refused += 1;
                    let text = refusal.to_string();
                    self.named += usize::from(text.contains(name));
                    runner.say(&format!("a goal in or beyond the {name} is refused: {text}"));
                }
                other => runner.say(&format!("a goal in or beyond the {name} is answered with {other:?}")),
            }
        }
        Ok(())
    }

    /// A flight to a place; gives how far from it the vehicle ends, by the truth.
    async fn go_to(
        &self,
        runner: &ScenarioRunner<'_>,
        id: VehicleId,
        position: PositionNed,
        speed_m_s: f64,
    ) -> anyhow::Result<f64> {
        let command = VehicleCommand::GoTo {
            position,
            yaw_rad: None,
            speed_m_s: Some(speed_m_s),
        };
        runner.carry_out(id, command, 60.0).await?;
        runner.pause(2.0).await;
        let truth = runner.referee.truth();
        let vehicle = crate::referee::vehicle(&truth, id).context("the vehicle is not in the truth")?;
        Ok(vehicle.position.distance_m(&position))
    }

    /// A wedge whose right arm would reach over the eastern boundary, on its way when that is drawn in.
    async fn slide(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        let wedge = FormationRequest::new(Shape::Wedge, SPACING_M);
        runner.form("Wedge", wedge).await?;
        let here = runner.leader_position()?;
        let along = |east_m: f64| {
            let at = |north: f64, east: f64| PositionNed::new(north, east, here.down_m);
            Route {
                waypoints: vec![
                    at(here.north_m, east_m - 20.0),
                    at(here.north_m + 15.0, east_m),
                    at(70.0, east_m),
                ],
                speed_m_s: SPEED_M_S,
                corner_radius_m: 10.0,
            }
        };
        let near_m = FIELD_M[3] - ALONG_M;
        if let Err(refusal @ Refusal::OutsideFence { .. }) = runner.node.set_route(along(near_m + DRAWN_IN_M)).await {
            self.route_refused = refusal.to_string().contains("the place of vehicle");
            runner.say(&format!("a route too near the eastern boundary is refused: {refusal}"));
        }
        let where_it_will_be = "along where the eastern boundary will be";
        runner.begin_route(where_it_will_be, &along(near_m)).await?;
        let drawn_in = FencePlan {
            zones: zones(FIELD_M),
            ..FencePlan::default()
        };
        runner.node.set_fences(drawn_in).await?;
        runner.say(&format!("the eastern boundary is drawn in by {DRAWN_IN_M} m"));
        let mut reached_over_m = f64::NEG_INFINITY;
        let deadline_s = runner.elapsed_s() + 60.0;
        while !runner
            .node
            .snapshot()
            .formation
            .as_ref()
            .is_some_and(|f| f.route_finished)
        {
            if runner.elapsed_s() > deadline_s {
                bail!("waited 60 s for the leader at the end of its route along the boundary");
            }
            if let Some(slots) = runner.node.slots() {
                let heading_rad = slots.anchor.heading_rad;
                let places = slots
                    .slots
                    .iter()
                    .map(|(_, slot)| slots.anchor.position.moved(slot.to.rotated(heading_rad)));
                reached_over_m = places
                    .map(|place| outside_m(FIELD_M, &place))
                    .fold(reached_over_m, f64::max);
            }
            runner.pause(0.1).await;
        }
        self.slid = true;
        self.reached_over_m = Some(reached_over_m);
        runner.say(&format!(
            "the formation's slots reached {reached_over_m:.1} m over the boundary; who had them flew along on the inside"
        ));
        Ok(())
    }

    /// Back to the middle of the field, to land.
    async fn home(&self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        let here = runner.leader_position()?;
        let route = Route {
            waypoints: vec![here.moved(Vector3::new(0.0, -15.0, 0.0))],
            speed_m_s: SPEED_M_S,
            corner_radius_m: 10.0,
        };
        runner.begin_route("away from the boundary", &route).await?;
        runner.route_end(30.0).await
    }
}

impl Flight for Fence {
    fn prepare(&self, setup: &mut Setup) {
        setup.node.swarm.origin = Some(swarm_origin());
        let [south, west, north, east] = FIELD_M;
        setup.node.safety.zones = zones([south, west, north, east + DRAWN_IN_M]);
    }

    async fn fly(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        runner.referee.cruise(SPEED_M_S);
        runner.take_off_all(HEIGHT_M).await?;
        let seen = self.seen.clone();
        seen.lock().watching = true;
        runner
            .simulation()?
            .observe(Box::new(move |truth| look(&mut seen.lock(), truth)))?;
        let id = *runner.ids().last().context("there is no vehicle")?;
        self.refusals(runner, id).await?;
        let here = runner.position(id)?;
        let behind = PositionNed::new(70.0, MAST_M.0[1] + 1.0, here.down_m);
        runner.say(&format!("vehicle {id} flies to the other side of the mast"));
        match self.go_to(runner, id, behind, 6.0).await {
            Ok(off_m) => {
                self.around_off_m = Some(off_m);
                runner.say(&format!(
                    "it is there, {off_m:.2} m off its goal, without having crossed the mast's zone"
                ));
            }
            Err(error) => runner.say(&format!("not flown: {error:#}")),
        }
        let edge = PositionNed::new(FIELD_M[2] - 1.0, 60.0, here.down_m);
        let far = PositionNed::new(5.0, 60.0, here.down_m);
        self.go_to(runner, id, far, FULL_M_S).await?;
        runner.say(&format!(
            "vehicle {id} flies at the northern boundary at {FULL_M_S} m/s"
        ));
        self.seen.lock().fastest_m_s = 0.0;
        self.go_to(runner, id, edge, FULL_M_S).await?;
        let truth = runner.referee.truth();
        let vehicle = crate::referee::vehicle(&truth, id).context("the vehicle is not in the truth")?;
        self.stopped_short_m = Some(FIELD_M[2] - vehicle.position.north_m);
        runner.say(&format!(
            "it was at {:.1} m/s on the way and stands {:.2} m in front of the boundary",
            self.seen.lock().fastest_m_s,
            self.stopped_short_m.unwrap_or_default()
        ));
        self.go_to(runner, id, here, 6.0).await?;
        self.slide(runner).await?;
        self.home(runner).await?;
        runner.land_in_grid().await?;
        let seen = self.seen.lock();
        if let (Some(deepest_m), Some((id, place))) = (seen.deepest_m, seen.deepest_of) {
            runner.say(&format!(
                "nearest to where nobody may be was vehicle {id} at {:.1} m north, {:.1} m east: {:.2} m {}",
                place.north_m,
                place.east_m,
                deepest_m.abs(),
                if deepest_m > 0.0 {
                    "beyond the boundary"
                } else {
                    "were left"
                }
            ));
        }
        Ok(())
    }

    fn criteria(&self, _referee: &Referee) -> Vec<Criterion> {
        let seen = self.seen.lock();
        vec![
            counted("goals refused where nobody may be", self.refused).at_least(3.0, ""),
            counted("of them with the zone's name", self.named).at_least(3.0, ""),
            measured("off the goal behind a zone, flown around it", self.around_off_m).at_most(1.0, "m"),
            measured("left to the boundary after a flight at it", self.stopped_short_m).at_least(0.0, "m"),
            happened("route refused that leads a place over the boundary", self.route_refused),
            measured("slots that reached over the boundary", self.reached_over_m).at_least(0.5, "m"),
            happened("route along the boundary flown", self.slid),
            measured("deepest where nobody may be", seen.deepest_m).at_most(0.0, "m"),
        ]
    }
}
