//! Every shape there is, changed in flight: behind a leader on its route, about a virtual leader on a path, about something that moves
//! and whose place is told five times a second, about a fixed place; and one shape with other parameters, step by step.

use super::car::Car;
use super::{Flight, Setup, swarm_origin};
use crate::layout::SPACING_M;
use crate::referee::{Errors, Referee};
use crate::report::{Criterion, counted, measured};
use crate::scenario_runner::ScenarioRunner;
use skein_domain::{FormationAnchor, FormationRequest, HeadingRequest, OffsetFrd, PositionNed, Route, Shape};
use std::collections::HashSet;

/// Height of the flight in metres: a sphere hangs some metres below its anchor.
const HEIGHT_M: f64 = 10.0;
/// Speed of every anchor in metres per second.
const SPEED_M_S: f64 = 4.0;
/// Radius of corners in metres.
const CORNER_RADIUS_M: f64 = 15.0;
/// So much straight flight of each part is judged, in looks at the truth at each follower: 50 are a second.
const STRAIGHT_LOOKS: u64 = 50;
/// It flies straight on no longer than this for it, in seconds.
const STRAIGHT_S: f64 = 7.0;
/// Name of the moving reference.
const CAR: &str = "car";
/// In this share of the flight, all vehicles together, may the separation filter change what is flown: changes of shape are planned so
/// that it seldom has to. Its events are no measure: one tells of a tenth of a second or of ten.
const FILTERED_PERCENT: f64 = 2.0;

/// Shapes flown behind the leader, about the path, about the reference and about the place.
const BEHIND_LEADER: [Shape; 6] = [
    Shape::Line,
    Shape::Column,
    Shape::Wedge,
    Shape::EchelonLeft,
    Shape::EchelonRight,
    Shape::Diamond,
];
const ON_PATH: [Shape; 3] = [Shape::Circle, Shape::Arc, Shape::Square];
const ABOUT_CAR: [Shape; 3] = [Shape::Grid, Shape::Box, Shape::Sphere];
const AT_PLACE: [Shape; 2] = [Shape::Helix, Shape::Free];

/// A change of one parameter, and what it is called.
type Morph = (&'static str, fn(&mut FormationRequest));
const MORPHS: [Morph; 4] = [
    ("wider", |r| r.spacing_m *= 1.2),
    ("turned", |r| r.rotation_deg = 45.0),
    ("larger", |r| r.scale = 1.25),
    ("stepped in height", |r| r.altitude_step_m = 0.5),
];

/// The flight and what it showed.
#[derive(Default)]
pub struct Formations {
    heading: HeadingRequest,
    shapes: HashSet<Shape>,
    morphs: usize,
    behind_leader: Option<(Errors, Errors)>,
    on_path: Option<(Errors, Errors)>,
    about_car: Option<(Errors, Errors)>,
    off_car: Errors,
    filtered: Option<f64>,
}

impl Formations {
    async fn shapes(
        &mut self,
        runner: &ScenarioRunner<'_>,
        shapes: &[Shape],
        anchor: &FormationAnchor,
    ) -> anyhow::Result<()> {
        for shape in shapes {
            let request = FormationRequest {
                heading: self.heading,
                ..request(*shape, runner.vehicles, anchor.clone())
            };
            runner.form(&format!("{shape:?}"), request).await?;
            self.shapes.insert(*shape);
        }
        Ok(())
    }

    /// Some straight flight in which nothing changes, so that it can be judged.
    async fn straight_on(runner: &ScenarioRunner<'_>) {
        let enough = STRAIGHT_LOOKS * (runner.vehicles as u64 - 1);
        let until_s = runner.elapsed_s() + STRAIGHT_S;
        while runner.referee.figures().straight.samples < enough && runner.elapsed_s() < until_s {
            runner.pause(0.1).await;
        }
    }

    /// What a part of the flight came to.
    fn end_part(&self, runner: &ScenarioRunner<'_>, what: &str) -> (Errors, Errors) {
        let (straight, turning) = runner.referee.next_part();
        let rms_m = |errors: &Errors| {
            errors
                .rms()
                .map_or_else(|| "not seen".to_owned(), |m| format!("{m:.2} m"))
        };
        runner.say(&format!(
            "{what}: off their slots {} straight, {} in turns (root mean square)",
            rms_m(&straight),
            rms_m(&turning)
        ));
        (straight, turning)
    }

    /// The leader flies three legs; the shapes change meanwhile.
    async fn behind_leader(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        // The long shapes would swing their ends out in a turn with all the speed there is: they keep facing north.
        self.heading = HeadingRequest::Fixed { heading_deg: 0.0 };
        self.shapes(runner, &BEHIND_LEADER[..1], &FormationAnchor::Leader)
            .await?;
        let start = runner.leader_position()?;
        let route = route(&start, &[(80.0, 0.0), (80.0, 45.0), (35.0, 45.0)]);
        runner
            .begin_route("north, east and south, changing its formation", &route)
            .await?;
        self.shapes(runner, &BEHIND_LEADER[1..2], &FormationAnchor::Leader)
            .await?;
        Self::straight_on(runner).await;
        self.shapes(runner, &BEHIND_LEADER[2..], &FormationAnchor::Leader)
            .await?;
        runner.route_end(60.0).await?;
        self.heading = HeadingRequest::Auto;
        self.behind_leader = Some(self.end_part(runner, "behind the leader"));
        Ok(())
    }

    /// A virtual leader flies three legs from where the formation is, the first the way it faces; the square's parameters change one after the other.
    async fn on_path(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        let start = runner.leader_position()?;
        let route = route(&start, &[(50.0, 0.0), (50.0, 50.0), (20.0, 50.0)]);
        let length_m = 50.0 + 50.0 + 30.0;
        let anchor = FormationAnchor::Path { route };
        let began_s = runner.elapsed_s();
        self.shapes(runner, &ON_PATH[..1], &anchor).await?;
        Self::straight_on(runner).await;
        self.shapes(runner, &ON_PATH[1..], &anchor).await?;
        let mut square = request(Shape::Square, runner.vehicles, anchor);
        for (label, morph) in MORPHS {
            morph(&mut square);
            runner.form(&format!("Square, {label}"), square.clone()).await?;
            self.morphs += 1;
        }
        // It set off once the circle was formed.
        let left_s = length_m / SPEED_M_S + 6.0 - (runner.elapsed_s() - began_s);
        runner.pause(left_s).await;
        self.on_path = Some(self.end_part(runner, "about the virtual leader"));
        Ok(())
    }

    /// Something drives along, told five times a second without its velocity.
    async fn about_car(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        let anchor = runner.node.slots().map(|slots| slots.anchor.position);
        let start = anchor.unwrap_or_default();
        let car = Car::drive(runner.node.clone(), CAR, start, SPEED_M_S);
        runner.pause(1.0).await;
        let anchor = FormationAnchor::Reference { name: CAR.into() };
        self.shapes(runner, &ABOUT_CAR[..1], &anchor).await?;
        Self::straight_on(runner).await;
        self.shapes(runner, &ABOUT_CAR[1..], &anchor).await?;
        runner
            .until(40.0, "the car at the end of its way", |_| car.arrived())
            .await?;
        self.off_car = car.stop();
        self.about_car = Some(self.end_part(runner, "about the moving reference"));
        Ok(())
    }
}

/// A shape with usual parameters.
fn request(shape: Shape, vehicles: usize, anchor: FormationAnchor) -> FormationRequest {
    FormationRequest {
        offsets: (shape == Shape::Free).then(|| zigzag(vehicles)),
        anchor,
        ..FormationRequest::new(shape, SPACING_M)
    }
}

/// A list of offsets as an operator would give it: two staggered rows, each next place a little higher.
fn zigzag(vehicles: usize) -> Vec<OffsetFrd> {
    (0..vehicles)
        .map(|i| {
            let side = if i % 2 == 0 { 0.0 } else { 5.0 };
            OffsetFrd::new(-3.5 * i as f64, side, -0.3 * i as f64)
        })
        .collect()
}

/// Waypoints given relative to the start.
fn route(start: &PositionNed, offsets_m: &[(f64, f64)]) -> Route {
    Route {
        waypoints: offsets_m
            .iter()
            .map(|(north, east)| start.moved(nalgebra::Vector3::new(*north, *east, 0.0)))
            .collect(),
        speed_m_s: SPEED_M_S,
        corner_radius_m: CORNER_RADIUS_M,
    }
}

impl Flight for Formations {
    fn prepare(&self, setup: &mut Setup) {
        setup.node.swarm.origin = Some(swarm_origin());
    }

    async fn fly(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        runner.referee.cruise(SPEED_M_S);
        runner.take_off_all(HEIGHT_M).await?;
        self.behind_leader(runner).await?;
        self.on_path(runner).await?;
        self.about_car(runner).await?;
        let place = FormationAnchor::Place {
            position: PositionNed::new(20.0, 20.0, runner.ground_down_m() - HEIGHT_M),
            // A quarter turn to the left from the way the reference went.
            heading_deg: Some(90.0),
        };
        self.shapes(runner, &AT_PLACE, &place).await?;
        self.filtered = runner.referee.figures().filtered_percent();
        // Out of the offsets they were given, which leave room on the ground.
        runner.land().await
    }

    fn criteria(&self, _referee: &Referee) -> Vec<Criterion> {
        let straight = |part: &Option<(Errors, Errors)>| part.as_ref().and_then(|(straight, _)| straight.rms());
        let turning = |part: &Option<(Errors, Errors)>| part.as_ref().and_then(|(_, turning)| turning.rms());
        let mut criteria = vec![
            counted("shapes formed", self.shapes.len()).at_least(Shape::ALL.len() as f64, ""),
            counted("parameters changed in flight", self.morphs).at_least(MORPHS.len() as f64, ""),
        ];
        let parts = [
            ("behind the leader", &self.behind_leader),
            ("about a virtual leader", &self.on_path),
            ("about a moving reference", &self.about_car),
        ];
        for (what, part) in parts {
            let name = |when: &str| format!("error {what}, {when}, root mean square");
            criteria.push(measured(name("straight"), straight(part)).at_most(1.0, "m"));
            criteria.push(measured(name("turning"), turning(part)).at_most(1.5, "m"));
        }
        criteria.push(
            measured(
                "anchor off the reference it is told of, root mean square",
                self.off_car.rms(),
            )
            .at_most(1.5, "m"),
        );
        criteria.push(
            measured("of all flight changed by the separation filter", self.filtered).at_most(FILTERED_PERCENT, "%"),
        );
        criteria
    }
}
