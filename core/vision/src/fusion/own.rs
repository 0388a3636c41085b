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

/// One that explains what a sensor calls by one name does not explain what the same sensor calls by another and sees farther from it by so many standard
/// deviations of a sighting: a vehicle is one thing.
const CLEARLY_FARTHER: f64 = 3.0;

impl SwarmTracker {
    /// What vehicles of the swarm explain belongs to them, for as long as they do.
    pub(super) fn leave_out_own(&mut self, own: &[OwnVehicle]) {
        for index in 0..self.tracklets.len() {
            let belongs = self.with_own(index, own);
            self.tracklets[index].belongs = belongs;
        }
    }

    /// To what a tracklet belongs if the swarm's vehicles are looked at.
    fn with_own(&self, index: usize, own: &[OwnVehicle]) -> Belongs {
        let tracklet = &self.tracklets[index];
        let is = |vehicle: &&OwnVehicle, error_m: f64| {
            explains(vehicle, tracklet, error_m) && !self.has_a_nearer(index, vehicle)
        };
        let loosely = |vehicle: &&OwnVehicle| is(vehicle, vehicle.error_m);
        let surely = |vehicle: &&OwnVehicle| is(vehicle, SURELY * vehicle.error_m);
        let enough = tracklet.sightings.len() >= ENOUGH;
        let taken = match tracklet.belongs {
            Belongs::Nothing if enough => own.iter().find(loosely),
            // A track that a sensor's sightings of a vehicle of ours went to by mistake gives them back.
            Belongs::Track(_) if enough => own.iter().find(surely),
            Belongs::Own(id) => {
                let mut of_it = own.iter().filter(|vehicle| vehicle.id == id);
                // What a track of ours predicts as well passes by.
                let stays =
                    |vehicle: &&OwnVehicle| loosely(vehicle) && (surely(vehicle) || !self.is_predicted(tracklet));
                return of_it
                    .find(stays)
                    .map_or(Belongs::Nothing, |vehicle| Belongs::Own(vehicle.id));
            }
            _ => None,
        };
        taken.map_or(tracklet.belongs, |vehicle| Belongs::Own(vehicle.id))
    }

    /// Whether the sensor sees something else much nearer to where the vehicle is.
    fn has_a_nearer(&self, index: usize, vehicle: &OwnVehicle) -> bool {
        let tracklet = &self.tracklets[index];
        let Some((off, noise)) = miss(vehicle, tracklet) else {
            return false;
        };
        let others = self.tracklets.iter().filter(|other| {
            let apart_s = other.seen().seconds_since(tracklet.seen()).abs();
            other.name != tracklet.name && other.sensor == tracklet.sensor && apart_s < self.settings.sight_lost_s
        });
        let mut misses = others.filter_map(|other| miss(vehicle, other));
        misses.any(|(other, other_noise)| off - other > CLEARLY_FARTHER * noise.hypot(other_noise))
    }
}

/// How far on average a tracklet's sightings are from where the vehicle is by its telemetry, and one sighting's standard deviation: in radians of bearings, in metres
/// of positions.
fn miss(vehicle: &OwnVehicle, tracklet: &Tracklet) -> Option<(f64, f64)> {
    let each = tracklet.sightings.iter().map(|(time, seen)| {
        let place = vehicle.at(*time);
        match seen {
            Observation::Bearing {
                origin,
                direction,
                error_rad,
                ..
            } => ((place - origin).angle(direction), *error_rad),
            Observation::Position { position, covariance } => {
                ((position - place).norm(), (covariance.trace() / 3.0).max(0.0).sqrt())
            }
        }
    });
    let count = tracklet.sightings.len();
    let (off, noise) = each.fold((0.0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1));
    (count > 0).then(|| (off / count as f64, noise / count as f64))
}

/// Whether a vehicle of the swarm, which may be so far from where its telemetry says it is, is what most of the sightings saw.
fn explains(vehicle: &OwnVehicle, tracklet: &Tracklet, error_m: f64) -> bool {
    let fits = tracklet.sightings.iter().filter(|(time, seen)| {
        let place = vehicle.at(*time);
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
