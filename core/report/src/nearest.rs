//! Who is nearest to whom at one moment.
//!
//! Must never do: take places of different moments.

use serde::Serialize;
use skein_domain::{PositionNed, VehicleId};

/// The nearest other vehicle of one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Nearest {
    /// Of which vehicle.
    pub vehicle: VehicleId,
    /// The other one.
    pub other: VehicleId,
    /// How far it is away, in metres, in space.
    pub distance_m: f64,
}

/// Of each vehicle the nearest other one; of none if it is alone. Sorted from south to north a vehicle looks to both sides only as far as the
/// nearest that it has found.
#[must_use]
pub fn nearest(places: &[(VehicleId, PositionNed)]) -> Vec<Nearest> {
    let mut sorted: Vec<&(VehicleId, PositionNed)> = places.iter().filter(|(_, place)| place.is_finite()).collect();
    sorted.sort_by(|a, b| a.1.north_m.total_cmp(&b.1.north_m));
    let found = sorted.iter().enumerate().filter_map(|(at, (vehicle, place))| {
        let (south, north) = sorted.split_at(at);
        let mut best: Option<Nearest> = None;
        let mut look = |others: &mut dyn Iterator<Item = &&(VehicleId, PositionNed)>| {
            for (other, there) in others {
                let reach_m = best.map_or(f64::INFINITY, |best| best.distance_m);
                if (there.north_m - place.north_m).abs() >= reach_m {
                    return;
                }
                let distance_m = place.distance_m(there);
                if distance_m < reach_m {
                    best = Some(Nearest {
                        vehicle: *vehicle,
                        other: *other,
                        distance_m,
                    });
                }
            }
        };
        look(&mut north.iter().skip(1));
        look(&mut south.iter().rev());
        best
    });
    found.collect()
}

#[cfg(test)]
mod tests {
    //! The quick way finds what the slow one does.

    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn it_is_what_comparing_all_pairs_gives(
            places in prop::collection::vec((-50.0..50.0f64, -50.0..50.0f64, -30.0..0.0f64), 0..40),
        ) {
            let places: Vec<(VehicleId, PositionNed)> = places
                .iter()
                .enumerate()
                .map(|(n, (north_m, east_m, down_m))| (VehicleId(n as u16), PositionNed::new(*north_m, *east_m, *down_m)))
                .collect();
            let found = nearest(&places);
            prop_assert_eq!(found.len(), if places.len() < 2 { 0 } else { places.len() });
            for (vehicle, place) in &places {
                let others = places.iter().filter(|(other, _)| other != vehicle);
                let least = others.map(|(_, there)| place.distance_m(there)).min_by(f64::total_cmp);
                let quick = found.iter().find(|near| near.vehicle == *vehicle).map(|near| near.distance_m);
                prop_assert_eq!(quick, least);
            }
        }
    }
}
