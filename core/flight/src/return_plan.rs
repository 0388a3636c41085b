//! How a swarm returns together: each at a height of its own, to a landing place of its own.
//!
//! Must never do: lead two vehicles through each other's heights. Who is higher now flies home higher.

use skein_domain::{PositionNed, VehicleId};

/// A vehicle that is to return.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Homing {
    /// Which.
    pub vehicle: VehicleId,
    /// Where it is.
    pub position: PositionNed,
    /// Where it was launched.
    pub home: PositionNed,
}

/// How they return.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReturnSettings {
    /// Height of the lowest of them above the highest launch place, in metres.
    pub height_m: f64,
    /// Vertical distance between two of them in metres.
    pub layer_gap_m: f64,
    /// Distance between two landing places in metres.
    pub landing_spacing_m: f64,
    /// No one flies higher than this, as down coordinate in metres, if there is a ceiling.
    pub ceiling_down_m: Option<f64>,
}

/// The way of one of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReturnWay {
    /// Which.
    pub vehicle: VehicleId,
    /// Height on the way, as down coordinate in metres.
    pub cruise_down_m: f64,
    /// Where it lands.
    pub spot: PositionNed,
    /// Another one flies at the same height: the ceiling leaves no room for one each.
    pub shares_height: bool,
}

/// Rings around a launch place that are searched for a free landing place.
const RINGS: u32 = 64;

/// The ways of all, in the order in which they were given. Places that are not finite stay as they are: the gate refuses them.
#[must_use]
pub fn plan(all: &[Homing], settings: &ReturnSettings) -> Vec<ReturnWay> {
    let highest_home_down_m = all.iter().map(|h| h.home.down_m).fold(f64::INFINITY, f64::min);
    let lowest_down_m = highest_home_down_m - settings.height_m;
    let layers = layers(all.len(), lowest_down_m, settings);
    let mut by_height: Vec<usize> = (0..all.len()).collect();
    // Lowest first; of two at one height the smaller id stays lower.
    by_height.sort_by(|&a, &b| match (all.get(a), all.get(b)) {
        (Some(a), Some(b)) => b
            .position
            .down_m
            .total_cmp(&a.position.down_m)
            .then(a.vehicle.cmp(&b.vehicle)),
        _ => std::cmp::Ordering::Equal,
    });
    let mut layer_of = vec![0_usize; all.len()];
    for (rank, &index) in by_height.iter().enumerate() {
        if let Some(layer) = layer_of.get_mut(index) {
            *layer = rank * layers / all.len().max(1);
        }
    }
    let mut spots: Vec<PositionNed> = Vec::with_capacity(all.len());
    all.iter()
        .zip(layer_of)
        .map(|(homing, layer)| {
            let spot = free_spot(&homing.home, &spots, settings.landing_spacing_m);
            spots.push(spot);
            ReturnWay {
                vehicle: homing.vehicle,
                cruise_down_m: lowest_down_m - layer as f64 * settings.layer_gap_m,
                spot,
                shares_height: layers < all.len(),
            }
        })
        .collect()
}

/// How many heights there are room for: one each, or as many as the ceiling leaves.
fn layers(count: usize, lowest_down_m: f64, settings: &ReturnSettings) -> usize {
    let Some(ceiling_down_m) = settings.ceiling_down_m else {
        return count.max(1);
    };
    let room = (lowest_down_m - ceiling_down_m) / settings.layer_gap_m;
    // Written so that what is not a number leaves one.
    let fitting = if room >= 1.0 { room.floor() as usize + 1 } else { 1 };
    fitting.min(count.max(1))
}

/// The launch place, or the nearest place beside it that is far enough from all that are taken.
fn free_spot(home: &PositionNed, taken: &[PositionNed], spacing_m: f64) -> PositionNed {
    let is_free = |spot: &PositionNed| taken.iter().all(|other| spot.horizontal_distance_m(other) >= spacing_m);
    if is_free(home) || !home.is_finite() {
        return *home;
    }
    for ring in 1..=RINGS {
        let places = 6 * ring;
        let radius_m = f64::from(ring) * spacing_m;
        for place in 0..places {
            let (east, north) = (std::f64::consts::TAU * f64::from(place) / f64::from(places)).sin_cos();
            let spot = PositionNed {
                north_m: home.north_m + north * radius_m,
                east_m: home.east_m + east * radius_m,
                ..*home
            };
            if is_free(&spot) {
                return spot;
            }
        }
    }
    *home
}

#[cfg(test)]
mod tests;
