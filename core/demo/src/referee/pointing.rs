//! How well gimbals stay on what they are to look at, from the simulator's truth.

use super::{Figures, vehicle};
use skein_domain::VehicleId;
use skein_sim::TruthFrame;

/// A gimbal may take so long to turn to its target, in seconds.
pub const TURNING_S: f64 = 5.0;

/// Whose gimbals are to be on whom.
#[derive(Debug, Clone)]
pub struct Looks {
    /// Who is looked at.
    pub leader: VehicleId,
    /// Who looks.
    pub observers: Vec<VehicleId>,
    /// From when on it counts, in seconds of the simulation.
    pub from_s: f64,
}

/// Measures the angle between each gimbal's axis and the direction to its target, until the landing.
pub fn watch(figures: &mut Figures, truth: &TruthFrame) {
    if !figures.landings.is_empty() {
        return;
    }
    let Some(looks) = figures.looks.clone().filter(|looks| truth.time_s >= looks.from_s) else {
        return;
    };
    let Some(target) = vehicle(truth, looks.leader) else {
        return;
    };
    for observer in looks.observers.iter().filter_map(|id| vehicle(truth, *id)) {
        let Some(gimbal) = observer.gimbal else { continue };
        let to_target = target.position.vector() - observer.position.vector();
        let (sin_pitch, cos_pitch) = gimbal.pitch_rad.sin_cos();
        let (sin_yaw, cos_yaw) = gimbal.yaw_north_rad.sin_cos();
        let axis = nalgebra::Vector3::new(cos_pitch * cos_yaw, cos_pitch * sin_yaw, -sin_pitch);
        let angle_rad = to_target.angle(&axis);
        if angle_rad.is_finite() {
            figures.pointing.add(angle_rad);
        }
    }
}
