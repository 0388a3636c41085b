//! Shapes that keep themselves, in small seeded simulations.

mod swarm;

use super::*;
use proptest::prelude::*;
use skein_domain::telemetry::VehicleKinematics;
use swarm::{LIMITS, Swarm, World, grid, line, wedge};

fn laws() -> [KeepingLaw; 2] {
    [KeepingLaw::Distances, KeepingLaw::Bearings]
}

#[test]
fn neighbours_are_mutual_connected_and_enough() {
    for slots in [grid(9), wedge(7), line(6), swarm::cube(12), wedge(2), wedge(3), line(1)] {
        let graph = neighbours(&slots, 4);
        assert_eq!(graph.len(), slots.len());
        for (i, list) in graph.iter().enumerate() {
            assert!(list.len() >= 4.min(slots.len() - 1), "{i}: {list:?}");
            assert!(list.is_sorted() && !list.contains(&i));
            assert!(list.iter().all(|j| graph[*j].contains(&i)), "mutual");
        }
        let all: Vec<Vec<usize>> = (0..slots.len())
            .map(|i| (0..slots.len()).filter(|j| *j != i).collect())
            .collect();
        assert_eq!(distance_rank(&slots, &graph), distance_rank(&slots, &all));
        assert_eq!(bearing_rank(&slots, &graph), bearing_rank(&slots, &all));
    }
}

#[test]
fn ranks_are_those_of_rigid_shapes() {
    let cube = swarm::cube(8);
    let graph = neighbours(&cube, 4);
    assert_eq!(distance_rank(&cube, &graph), 3 * 8 - 6);
    assert_eq!(bearing_rank(&cube, &graph), 3 * 8 - 4);
    // A ring of eight is neither.
    let ring: Vec<Vec<usize>> = (0..8).map(|i| vec![(i + 7) % 8, (i + 1) % 8]).collect();
    assert!(distance_rank(&cube, &ring) < 18);
}

#[test]
fn far_groups_are_joined() {
    let slots: Vec<OffsetFrd> = (0..10)
        .map(|i| {
            OffsetFrd::new(
                if i < 5 { 0.0 } else { 1_000.0 } + f64::from(i % 5),
                f64::from(i % 3),
                0.0,
            )
        })
        .collect();
    let graph = neighbours(&slots, 2);
    let apart = |i: usize, j: usize| (i < 5) != (j < 5);
    assert!((0..10).any(|i| graph[i].iter().any(|j| apart(i, *j))));
}

#[test]
fn steps_from_the_leader_are_counted() {
    let slots = line(9);
    let members: Vec<_> = slots
        .iter()
        .enumerate()
        .map(|(i, s)| (VehicleId(i as u16 + 1), *s))
        .collect();
    let all = keepings(&members, Some(VehicleId(1)), 0.3, KeepingLaw::Bearings, NodeTime(7));
    assert_eq!(all.len(), 8, "all but the leader");
    for (id, keeping) in &all {
        assert!(*id != VehicleId(1) && keeping.leader == Some(VehicleId(1)) && keeping.start == NodeTime(7));
        let leader = keeping.neighbours.iter().find(|n| n.vehicle == VehicleId(1));
        assert!(leader.is_none_or(|n| n.hops == Some(0)));
        assert!(keeping.neighbours.iter().all(|n| n.hops.is_some()));
    }
}

#[test]
fn both_laws_bring_a_perturbed_shape_back() {
    for law in laws() {
        for (slots, name) in [
            (wedge(7), "wedge"),
            (grid(9), "grid"),
            (swarm::cube(8), "cube"),
            (line(5), "line"),
        ] {
            let mut swarm = Swarm::new(&slots, law, World::quiet(11));
            swarm.perturb(4.0);
            assert!(swarm.shape_error_m() > 1.5, "{name}: it is not perturbed");
            swarm.run(120.0, |_| VelocityNed::default());
            assert!(
                swarm.shape_error_m() < 0.1,
                "{name} {law:?}: {:.2} m",
                swarm.shape_error_m()
            );
        }
    }
}

/// North, then a quarter turn over ten seconds, and back.
fn with_turns(t_s: f64) -> VelocityNed {
    let course = (0.16 * (t_s - 20.0)).clamp(0.0, 1.57) - (0.16 * (t_s - 50.0)).clamp(0.0, 1.57);
    VelocityNed::new(5.0 * course.cos(), 5.0 * course.sin(), 0.0)
}

#[test]
fn a_shape_follows_its_leader_through_turns_with_losses() {
    for law in laws() {
        for (slots, name) in [(wedge(7), "wedge"), (grid(9), "grid")] {
            let mut swarm = Swarm::new(&slots, law, World::harsh(3));
            swarm.run(80.0, with_turns);
            // Spacing 6 m, position noise 5 % of it, every fifth message lost, 200 ms old.
            assert!(swarm.worst_m < 2.5, "{name} {law:?}: {:.2} m at worst", swarm.worst_m);
            assert!(
                swarm.shape_error_m() < 0.7,
                "{name} {law:?}: {:.2} m at the end",
                swarm.shape_error_m()
            );
            assert!(swarm.nearest_m > 3.0, "{name} {law:?}: {:.2} m apart", swarm.nearest_m);
        }
    }
}

#[test]
fn the_rest_keeps_its_shape_when_one_is_lost() {
    for law in laws() {
        let mut swarm = Swarm::new(&grid(9), law, World::harsh(5));
        swarm.run(15.0, with_turns);
        swarm.silence(4);
        swarm.run(60.0, with_turns);
        assert!(swarm.shape_error_m() < 0.8, "{law:?}: {:.2} m", swarm.shape_error_m());
    }
}

#[test]
fn without_a_leader_it_comes_to_rest() {
    for law in laws() {
        let mut swarm = Swarm::new(&wedge(7), law, World::quiet(2));
        swarm.run(20.0, |_| VelocityNed::new(5.0, 0.0, 0.0));
        assert!(swarm.slowest_m_s() > 4.5);
        swarm.silence(0);
        swarm.run(60.0, |_| VelocityNed::default());
        assert!(
            swarm.fastest_follower_m_s() < 0.2,
            "{law:?}: {:.2} m/s",
            swarm.fastest_follower_m_s()
        );
        assert!(swarm.shape_error_m() < 0.5, "{law:?}: {:.2} m", swarm.shape_error_m());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn any_start_near_the_shape_leads_to_it(seed in 0_u64..1_000_000, count in 3_usize..10, bearings: bool) {
        let law = if bearings { KeepingLaw::Bearings } else { KeepingLaw::Distances };
        let mut swarm = Swarm::new(&wedge(count), law, World::quiet(seed));
        swarm.perturb(2.5);
        // Wide shapes close the last decimetres slowly.
        swarm.run(240.0, |_| VelocityNed::new(2.0, 0.0, 0.0));
        prop_assert!(swarm.shape_error_m() < 0.15, "{:.2} m", swarm.shape_error_m());
    }

    #[test]
    fn nothing_asks_for_more_than_the_limits_or_panics(values in prop::collection::vec(
        prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(f64::MAX), Just(0.0), -50.0..50.0], 20), bearings: bool) {
        let v = |i: usize| values[i];
        let place = |vehicle: u16, i: usize| NeighbourPlace { vehicle: VehicleId(vehicle), north_m: v(i), east_m: v(i + 1), down_m: v(i + 2), hops: Some(1) };
        let peer = |id: u16, i: usize| PeerState {
            id: VehicleId(id),
            kinematics: VehicleKinematics {
                position: PositionNed::new(v(i), v(i + 1), v(i + 2)),
                velocity: VelocityNed::new(v(i + 3), v(i + 4), v(i + 5)),
                yaw_rad: 0.0,
                measured: NodeTime(900_000),
            },
            airborne: true,
        };
        let keeping = Keeping {
            law: if bearings { KeepingLaw::Bearings } else { KeepingLaw::Distances },
            neighbours: vec![place(1, 0), place(2, 3)],
            leader: None,
            start: NodeTime(0),
        };
        let here = PositionNed::new(v(6), v(7), v(8));
        let tuning = KeepingTuning::default();
        let command = command(&keeping, &here, &[peer(1, 9), peer(2, 14)], NodeTime(1_000_000), &LIMITS, &tuning);
        let velocity = command.velocity.vector();
        prop_assert!(command.velocity.is_finite() && velocity.xy().norm() <= LIMITS.max_speed_m_s + 1e-9);
        prop_assert!(velocity.z >= -LIMITS.max_climb_m_s && velocity.z <= LIMITS.max_descent_m_s);
        let graph = neighbours(&[OffsetFrd::new(v(0), v(1), v(2)), OffsetFrd::new(v(3), v(4), v(5)), OffsetFrd::default()], 4);
        prop_assert_eq!(graph.len(), 3);
    }
}
