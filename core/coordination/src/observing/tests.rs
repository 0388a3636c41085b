//! Tests of who observes, from where, and who takes over.

use super::*;
use proptest::prelude::*;

fn candidate(id: u16, north_m: f64) -> Candidate {
    Candidate {
        vehicle: VehicleId(id),
        position: Some(PositionNed::new(north_m, 0.0, -20.0)),
        unfit: None,
        flies: true,
        battery: Some(0.8),
        energy: Some(EnergyLevel::Ok),
        gimbal_camera: true,
        busy: None,
    }
}

const TARGET: PositionNed = PositionNed::new(0.0, 0.0, -20.0);

fn order(candidates: &[Candidate]) -> Vec<u16> {
    ranked(&TARGET, candidates)
        .into_iter()
        .map(|one| one.vehicle.0)
        .collect()
}

#[test]
fn the_best_placed_comes_first_and_who_cannot_be_asked_last() {
    let near = candidate(3, 30.0);
    let far = candidate(1, 900.0);
    let busy = Candidate {
        busy: Some("in the formation".to_owned()),
        ..candidate(2, 30.0)
    };
    let empty = Candidate {
        energy: Some(EnergyLevel::ReplanSoon),
        ..candidate(4, 10.0)
    };
    let lost = Candidate {
        unfit: Some("it is not heard".to_owned()),
        ..candidate(5, 5.0)
    };
    let all = [lost, empty, busy, far, near];
    assert_eq!(order(&all), [3, 2, 1, 5, 4]);
    let proposals = ranked(&TARGET, &all);
    assert_eq!(proposals[4].unfit.as_deref(), Some("its charge is low (replan_soon)"));
    assert!(proposals.iter().all(|one| (0.0..=1.0).contains(&one.score)));
}

fn observation(by: &[u16]) -> TrackObservation {
    TrackObservation {
        track: 1_000_001,
        by: by.iter().map(|id| (VehicleId(*id), f64::from(*id))).collect(),
        stand_off_m: None,
    }
}

const WELL: ObserverState = ObserverState {
    heard: true,
    energy: Some(EnergyLevel::Ok),
    refused: false,
    left: false,
};

fn states(of: &[(u16, ObserverState)]) -> BTreeMap<VehicleId, ObserverState> {
    of.iter().map(|(id, state)| (VehicleId(*id), *state)).collect()
}

#[test]
fn who_is_low_or_lost_is_relieved_by_the_next_best_from_beside_its_place() {
    let proposals = ranked(
        &TARGET,
        &[
            candidate(1, 5.0),
            candidate(2, 6.0),
            candidate(3, 50.0),
            candidate(4, 90.0),
        ],
    );
    let low = ObserverState {
        energy: Some(EnergyLevel::ReplanSoon),
        ..WELL
    };
    let lost = ObserverState { heard: false, ..WELL };
    let both = changes(&observation(&[1, 2]), &states(&[(1, low), (2, lost)]), &proposals, &[]);
    let hand_over = |from: u16, why, to: Option<u16>| Change::HandOver {
        from: VehicleId(from),
        why,
        to: to.map(VehicleId),
        // Beside it, away from the other one.
        bearing_rad: f64::from(from) + if from == 1 { -BESIDE_RAD } else { BESIDE_RAD },
    };
    assert_eq!(
        both,
        [
            hand_over(1, Unable::LowCharge, Some(3)),
            hand_over(2, Unable::Lost, Some(4))
        ]
    );
    // Who has just refused is passed over; with nobody left nobody is named.
    let refused = [VehicleId(3), VehicleId(4)];
    let nobody = changes(
        &observation(&[1, 2]),
        &states(&[(1, low), (2, WELL)]),
        &proposals,
        &refused,
    );
    assert_eq!(nobody, [hand_over(1, Unable::LowCharge, None)]);
    // Who refuses to take over is passed over for the next.
    let unwilling = ObserverState { refused: true, ..WELL };
    let next = changes(
        &observation(&[3]),
        &states(&[(3, unwilling)]),
        &proposals,
        &[VehicleId(3)],
    );
    assert_eq!(next, [hand_over(3, Unable::Refused, Some(1))]);
    let left = ObserverState { left: true, ..WELL };
    let gone = changes(&observation(&[1]), &states(&[(1, left)]), &proposals, &[]);
    assert_eq!(gone, [Change::Left(VehicleId(1))]);
    assert!(changes(&observation(&[1, 2]), &states(&[(1, WELL), (2, WELL)]), &proposals, &[]).is_empty());
}

/// The smaller angle between two bearings.
fn between(a: f64, b: f64) -> f64 {
    let off = (a - b).rem_euclid(TAU);
    off.min(TAU - off)
}

fn bearing(target: &PositionNed, place: &PositionNed) -> f64 {
    let way = place.vector() - target.vector();
    way.y.atan2(way.x)
}

proptest! {
    #[test]
    fn sides_are_spread_evenly_and_nobody_passes_another(
        places in prop::collection::vec((-300.0..300.0f64, -300.0..300.0f64), 1..9),
    ) {
        let vehicles: Vec<(VehicleId, PositionNed)> = places
            .iter()
            .enumerate()
            .map(|(index, (north, east))| (VehicleId(index as u16 + 1), PositionNed::new(*north, *east, -20.0)))
            .collect();
        let given = sides(&TARGET, &vehicles);
        prop_assert_eq!(given.len(), vehicles.len());
        let apart = if given.len() == 2 { FRAC_PI_2 } else { TAU / given.len() as f64 };
        for pair in given.windows(2) {
            prop_assert!((between(pair[0].1, pair[1].1) - apart.min(TAU - apart)).abs() < 1e-9);
        }
        let of = |id: VehicleId| vehicles.iter().find(|(of, _)| *of == id).expect("is one of them").1;
        if let [only] = given.as_slice() {
            prop_assert!(between(only.1, bearing(&TARGET, &of(only.0))) < 1e-9, "one alone stays on its side");
        }
        // In the order in which they stand around the target: going around once passes each present bearing once.
        let mut around = 0.0;
        for (index, (id, _)) in given.iter().enumerate() {
            let next = given[(index + 1) % given.len()].0;
            around += (bearing(&TARGET, &of(next)) - bearing(&TARGET, &of(*id))).rem_euclid(TAU);
        }
        prop_assert!(given.len() == 1 || (around - TAU).abs() < 1e-6, "{around}");
    }

    #[test]
    fn more_charge_or_less_way_is_never_worse(battery in 0.0..1.0f64, more in 0.0..0.5f64, north_m in 1.0..500.0f64, nearer in 0.0..1.0f64) {
        let worse = Candidate { battery: Some(battery), ..candidate(1, north_m) };
        let better = Candidate { battery: Some((battery + more).min(1.0)), ..candidate(2, north_m * nearer) };
        let proposals = ranked(&TARGET, &[worse.clone(), better.clone()]);
        let score = |id: u16| proposals.iter().find(|one| one.vehicle == VehicleId(id)).expect("is there").score;
        prop_assert!(score(2) >= score(1) - 1e-12);
    }
}
