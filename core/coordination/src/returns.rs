//! How several vehicles return at once: each gets a height and a landing place of its own, flown in legs.
//!
//! Must never do: keep a vehicle from returning. Whose place is not known returns as its model does by itself.

use crate::ways;
use skein_config::ReturningSettings;
use skein_domain::{PositionNed, VehicleCommand, VehicleId};
use skein_flight::return_plan::{self, Homing, ReturnSettings, ReturnWay};
use skein_safety::{Fences, Gate};
use skein_view::PeerSnapshot;
use std::collections::{BTreeMap, VecDeque};

/// The legs home of all of these that are in the air and whose way is known.
pub fn legs(
    gate: &Gate,
    peers: &PeerSnapshot,
    settings: &ReturningSettings,
    ids: &[VehicleId],
) -> BTreeMap<VehicleId, VecDeque<VehicleCommand>> {
    let homing: Vec<Homing> = ids
        .iter()
        .filter_map(|id| {
            let entry = peers.entry(*id).filter(|e| e.airborne)?;
            Some(Homing {
                vehicle: *id,
                position: entry.kinematics?.position,
                home: entry.home?,
            })
        })
        .collect();
    let ways = return_plan::plan(
        &homing,
        &ReturnSettings {
            height_m: settings.height_m,
            layer_gap_m: settings.layer_gap_m,
            landing_spacing_m: settings.landing_spacing_m,
            ceiling_down_m: ceiling_down_m(gate, settings, &homing),
        },
    );
    homing
        .iter()
        .zip(&ways)
        .map(|(from, way)| (way.vehicle, legs_of(gate.fences(), &from.position, way)))
        .collect()
}

/// The greatest height at which all of them may be over their launch places, looked for height by height; none if there is no limit as
/// far up as is needed.
fn ceiling_down_m(gate: &Gate, settings: &ReturningSettings, homing: &[Homing]) -> Option<f64> {
    let highest_home_down_m = homing.iter().map(|h| h.home.down_m).reduce(f64::min)?;
    let height = |layer: usize| highest_home_down_m - settings.height_m - layer as f64 * settings.layer_gap_m;
    let permitted = |down_m: f64| {
        homing
            .iter()
            .all(|h| gate.goal(&PositionNed { down_m, ..h.home }).is_ok())
    };
    let layers = (0..homing.len()).take_while(|layer| permitted(height(*layer))).count();
    (layers < homing.len()).then(|| height(layers.max(1) - 1))
}

/// Up or down to its height, over its place (around what is closed), down. Where no way is found the straight one is tried: the gate
/// stops it in front of what is closed, and an operator sees why.
fn legs_of(fences: &Fences, from: &PositionNed, way: &ReturnWay) -> VecDeque<VehicleCommand> {
    let level = |place: &PositionNed| PositionNed {
        down_m: way.cruise_down_m,
        ..*place
    };
    let fly = |position: PositionNed| VehicleCommand::GoTo {
        position,
        yaw_rad: None,
        speed_m_s: None,
    };
    let (start, over) = (level(from), level(&way.spot));
    let between = ways::waypoints(fences, &start, &over).unwrap_or_else(|_| vec![over]);
    std::iter::once(start)
        .chain(between)
        .map(fly)
        .chain([VehicleCommand::LandAt { spot: way.spot }])
        .collect()
}
