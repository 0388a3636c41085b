//! Vehicles with different limits fly together: heavy camera carriers among quadrotors. The formation goes as fast as the slowest,
//! nobody is left behind, and no carrier has another vehicle in its view.

use super::{Flight, Setup, swarm_origin};
use crate::layout::{HEIGHT_M, SPACING_M};
use crate::referee::{Errors, Referee, vehicle};
use crate::report::{Criterion, counted, measured};
use crate::scenario_runner::ScenarioRunner;
use anyhow::Context;
use nalgebra::Vector3;
use parking_lot::Mutex;
use skein_domain::{FormationRequest, PositionNed, Route, Shape, VehicleId};
use skein_runtime::NodeHandle;
use skein_sim::{Airframe, TruthFrame, VehicleStart};
use std::sync::Arc;

/// Largest speed of a carrier in metres per second.
const CARRIER_M_S: f64 = 5.0;
/// What the operator asks for, in metres per second.
const ASKED_M_S: f64 = 9.0;
/// Radius of corners in metres.
const CORNER_RADIUS_M: f64 = 15.0;
/// Half of what a carrier's camera sees, in degrees, without what its nose may sway.
const VIEW_HALF_DEG: f64 = 25.0;
/// After a change of shape views count when it has been over for so long, in seconds.
const SETTLED_S: f64 = 1.0;

/// Every third vehicle is a carrier.
fn is_carrier(system_id: u8) -> bool {
    system_id % 3 == 2
}

#[derive(Default)]
struct MixedSeen {
    /// Smallest angle between a carrier's nose and another vehicle, in radians.
    nearest_rad: Option<f64>,
    /// Largest speed of the leader in metres per second.
    fastest_m_s: Option<f64>,
}

/// The flight and what it showed.
#[derive(Default)]
pub struct Mixed {
    seen: Arc<Mutex<MixedSeen>>,
    flown_m_s: Option<f64>,
    errors: Option<(Errors, Errors)>,
    carriers: usize,
}

/// One look at the truth.
fn look(seen: &mut MixedSeen, truth: &TruthFrame, node: &NodeHandle) {
    let now = node.now();
    let Some(slots) = node.slots().filter(|s| now.seconds_since(s.settled_at) > SETTLED_S) else {
        return;
    };
    let Some(leader) = slots.leader.and_then(|id| vehicle(truth, id)) else {
        return;
    };
    let speed_m_s = leader.velocity.vector().xy().norm();
    seen.fastest_m_s = Some(seen.fastest_m_s.map_or(speed_m_s, |fastest| fastest.max(speed_m_s)));
    let members: Vec<VehicleId> = slots.slots.iter().map(|(id, _)| *id).chain(slots.leader).collect();
    let all: Vec<_> = members.iter().filter_map(|id| vehicle(truth, *id)).collect();
    for carrier in all.iter().filter(|v| is_carrier(v.system_id)) {
        let nose = Vector3::new(carrier.yaw_rad.cos(), carrier.yaw_rad.sin(), 0.0);
        for other in all.iter().filter(|v| v.system_id != carrier.system_id) {
            let angle_rad = nose.angle(&(other.position.vector() - carrier.position.vector()));
            seen.nearest_rad = Some(seen.nearest_rad.map_or(angle_rad, |nearest| nearest.min(angle_rad)));
        }
    }
}

impl Flight for Mixed {
    fn prepare(&self, setup: &mut Setup) {
        setup.node.swarm.origin = Some(swarm_origin());
        let limits = serde_json::json!({ "flight": {
            "max_speed_m_s": CARRIER_M_S,
            "cruise_speed_m_s": 4.0,
            "acceleration_m_s2": 1.2,
            "climb_m_s": 1.2,
            "descent_m_s": 0.8,
        } });
        for (rule, system_id) in setup.node.adopt.iter_mut().zip(1u8..) {
            if is_carrier(system_id) {
                rule.model = "observation-uav".into();
                // Numbers in a table of tables: nothing in it that the other form could not hold.
                rule.model_config = serde_json::from_value(limits.clone()).unwrap_or_default();
            }
        }
        // The carriers are as their airframe makes them.
        setup.simulation.parameters.clear();
        let columns = f64::from(setup.vehicles).sqrt().ceil().max(1.0) as u8;
        setup.simulation.starts = (0..setup.vehicles)
            .map(|i| VehicleStart {
                system_id: Some(i + 1),
                position: PositionNed::new(
                    f64::from(i / columns) * SPACING_M,
                    f64::from(i % columns) * SPACING_M,
                    0.0,
                ),
                airframe: if is_carrier(i + 1) {
                    Airframe::CameraCarrier
                } else {
                    Airframe::Quadrotor
                },
                ..VehicleStart::default()
            })
            .collect();
    }

    async fn fly(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        runner.take_off_all(HEIGHT_M).await?;
        self.carriers = runner.ids().iter().filter(|id| id.0 % 3 == 2).count();
        let (seen, node) = (self.seen.clone(), runner.node.clone());
        let wedge = runner
            .form("Wedge", FormationRequest::new(Shape::Wedge, SPACING_M))
            .await?;
        runner.say(&format!(
            "{} camera carriers: the formation can go at {:.1} m/s",
            self.carriers, wedge.max_speed_m_s
        ));
        runner
            .simulation()?
            .observe(Box::new(move |truth| look(&mut seen.lock(), truth, &node)))?;
        let start = runner.leader_position()?;
        let at = |north: f64, east: f64| start.moved(Vector3::new(north, east, 0.0));
        let route = Route {
            waypoints: vec![at(80.0, 0.0), at(80.0, 60.0), at(30.0, 60.0)],
            speed_m_s: ASKED_M_S,
            corner_radius_m: CORNER_RADIUS_M,
        };
        let flown = runner.begin_route("north, east and south", &route).await?;
        self.flown_m_s = Some(flown.speed_m_s);
        runner.referee.cruise(flown.speed_m_s);
        runner.pause(8.0).await;
        runner
            .form("Line", FormationRequest::new(Shape::Line, SPACING_M))
            .await
            .context("on the route")?;
        runner.route_end(90.0).await?;
        self.errors = Some(runner.referee.next_part());
        runner.land_in_grid().await
    }

    fn criteria(&self, _referee: &Referee) -> Vec<Criterion> {
        let seen = self.seen.lock();
        let (straight, turning) = self.errors.unzip();
        vec![
            counted("camera carriers", self.carriers).at_least(1.0, ""),
            measured("speed of the route as it is flown", self.flown_m_s).at_most(CARRIER_M_S, "m/s"),
            measured("largest speed of the leader", seen.fastest_m_s).at_most(CARRIER_M_S + 0.3, "m/s"),
            measured(
                "formation error in straight legs, root mean square",
                straight.and_then(|e| e.rms()),
            )
            .at_most(0.5, "m"),
            measured(
                "formation error in turns, root mean square",
                turning.and_then(|e| e.rms()),
            )
            .at_most(1.5, "m"),
            measured(
                "smallest angle between a carrier's nose and another vehicle",
                seen.nearest_rad.map(f64::to_degrees),
            )
            .at_least(VIEW_HALF_DEG, "deg"),
        ]
    }
}
