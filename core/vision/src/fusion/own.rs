//! Vehicles of the swarm that sensors see: they are known by their telemetry, and are no tracks.

use super::joining::ENOUGH;
use super::tracklet::{Belongs, Tracklet};
use super::{Observation, OwnVehicle, SwarmTracker};
use nalgebra::Matrix3;
use skein_domain::VehicleId;

/// Share of sightings that a vehicle of the swarm has to explain.
const OWN_SHARE: f64 = 0.7;
/// And how far off they may be, in standard deviations.
const OWN_DEVIATIONS: f64 = 3.5;
/// And how far at most, in radians: one that is near could be anywhere else.
const WIDEST_RAD: f64 = 0.5;
/// What a track took is a vehicle of ours if it is nearer to it than this, in standard deviations of this share of the vehicle's error.
const SURELY_DEVIATIONS: f64 = 1.5;
const SURELY: f64 = 0.4;
/// A vehicle so near to a sensor carries it, in metres: it explains nothing, or it would explain everything.
const CARRIES_M: f64 = 2.5;

impl SwarmTracker {
    /// What vehicles of the swarm explain belongs to them, for as long as they do.
    pub(super) fn leave_out_own(&mut self, own: &[OwnVehicle]) {
        let stolen = self.of_ours_alone(own);
        for tracklet in &mut self.tracklets {
            match tracklet.belongs {
                // What a track took by mistake is given back.
                Belongs::Track(track) => {
                    if let Some((_, vehicle)) = stolen.iter().find(|(id, _)| *id == track) {
                        tracklet.belongs = Belongs::Own(*vehicle);
                    }
                }
                Belongs::Nothing if tracklet.sightings.len() >= ENOUGH => {
                    if let Some(vehicle) = own.iter().find(|vehicle| explains(vehicle, tracklet)) {
                        tracklet.belongs = Belongs::Own(vehicle.id);
                    }
                }
                Belongs::Own(id)
                    if !own
                        .iter()
                        .any(|vehicle| vehicle.id == id && explains(vehicle, tracklet)) =>
                {
                    tracklet.belongs = Belongs::Nothing;
                }
                _ => {}
            }
        }
    }

    /// Tracks of which every sensor sees a vehicle of ours, each with one of these. A thing before which one of ours flies past is seen beside it by another
    /// camera.
    fn of_ours_alone(&self, own: &[OwnVehicle]) -> Vec<(u64, VehicleId)> {
        let of_ours = |id: u64| {
            let seen = self
                .tracklets
                .iter()
                .filter(|tracklet| tracklet.belongs == Belongs::Track(id));
            let mut vehicle = None;
            for tracklet in seen {
                let surely = |of: &&OwnVehicle| explains_within(of, tracklet, SURELY * of.error_m, SURELY_DEVIATIONS);
                let enough = tracklet.sightings.len() >= ENOUGH;
                vehicle = Some(own.iter().find(surely).filter(|_| enough)?.id);
            }
            vehicle
        };
        let tracks = self.tracks.iter().map(|track| track.id);
        tracks.filter_map(|id| Some((id, of_ours(id)?))).collect()
    }
}

/// Whether a vehicle of the swarm is what most of the sightings saw.
fn explains(vehicle: &OwnVehicle, tracklet: &Tracklet) -> bool {
    explains_within(vehicle, tracklet, vehicle.error_m, OWN_DEVIATIONS)
}

/// Whether a vehicle of the swarm, which may be so far from where its telemetry says it is, is what most of the sightings saw.
fn explains_within(vehicle: &OwnVehicle, tracklet: &Tracklet, error_m: f64, deviations: f64) -> bool {
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
        off < deviations
    });
    fits.count() as f64 >= OWN_SHARE * tracklet.sightings.len() as f64
}
