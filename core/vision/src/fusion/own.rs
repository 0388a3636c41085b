//! Vehicles of the swarm that sensors see: they are known by their telemetry, and are no tracks.

use super::joining::ENOUGH;
use super::tracklet::{Belongs, Tracklet};
use super::{Observation, OwnVehicle, SwarmTracker};
use nalgebra::Matrix3;

/// Share of sightings that a vehicle of the swarm has to explain.
const OWN_SHARE: f64 = 0.7;
/// And how far off they may be, in standard deviations.
const OWN_DEVIATIONS: f64 = 3.5;
/// And how far at most, in radians: one that is near could be anywhere else.
const WIDEST_RAD: f64 = 0.5;
/// What a track took is a vehicle of ours if it is within this share of the vehicle's error.
const SURELY: f64 = 0.4;
/// A vehicle so near to a sensor carries it, in metres: it explains nothing, or it would explain everything.
const CARRIES_M: f64 = 2.5;

impl SwarmTracker {
    /// What vehicles of the swarm explain belongs to them, for as long as they do.
    pub(super) fn leave_out_own(&mut self, own: &[OwnVehicle]) {
        for tracklet in &mut self.tracklets {
            match tracklet.belongs {
                Belongs::Nothing if tracklet.sightings.len() >= ENOUGH => {
                    if let Some(vehicle) = own.iter().find(|vehicle| explains(vehicle, tracklet, vehicle.error_m)) {
                        tracklet.belongs = Belongs::Own(vehicle.id);
                    }
                }
                // A track that a sensor's sightings of a vehicle of ours went to by mistake gives them back.
                Belongs::Track(_) if tracklet.sightings.len() >= ENOUGH => {
                    let nearly = |vehicle: &&OwnVehicle| explains(vehicle, tracklet, SURELY * vehicle.error_m);
                    if let Some(vehicle) = own.iter().find(nearly) {
                        tracklet.belongs = Belongs::Own(vehicle.id);
                    }
                }
                Belongs::Own(id)
                    if !own
                        .iter()
                        .any(|vehicle| vehicle.id == id && explains(vehicle, tracklet, vehicle.error_m)) =>
                {
                    tracklet.belongs = Belongs::Nothing;
                }
                _ => {}
            }
        }
    }
}

/// Whether a vehicle of the swarm, which may be so far from where its telemetry says it is, is what most of the sightings saw.
fn explains(vehicle: &OwnVehicle, tracklet: &Tracklet, error_m: f64) -> bool {
    let fits = tracklet.sightings.iter().filter(|(time, seen)| {
        let place = vehicle.position + vehicle.velocity * time.seconds_since(vehicle.time);
        let off = match seen {
            Observation::Bearing {
                origin,
                origin_error_m,
                direction,
                error_rad,
            } => {
                let way = place - origin;
                let wide_rad = origin_error_m.hypot(error_m) / way.norm().max(0.1);
                let off_rad = way.angle(direction);
                if way.norm() > CARRIES_M && off_rad < WIDEST_RAD {
                    off_rad / error_rad.hypot(wide_rad)
                } else {
                    f64::INFINITY
                }
            }
            Observation::Position { position, covariance } => {
                let whole = covariance + Matrix3::from_diagonal_element(error_m.powi(2));
                let off = position - place;
                whole
                    .cholesky()
                    .map_or(f64::INFINITY, |whole| off.dot(&whole.solve(&off)).sqrt())
            }
        };
        off < OWN_DEVIATIONS
    });
    fits.count() as f64 >= OWN_SHARE * tracklet.sightings.len() as f64
}
