//! No moment of an intent is left behind.

use super::*;
use crate::{
    FormationHeading, KeepingLaw, NodeTime, OffsetFrd, PositionNed, Route, TrajectoryPiece, VehicleId, VehicleTask,
};
use std::collections::BTreeMap;

fn everything(at: NodeTime) -> Intent {
    let slot = SlotMove {
        from: OffsetFrd::default(),
        to: OffsetFrd::default(),
        detour_up_m: 0.0,
        start: at,
        duration_s: 3.0,
    };
    let keeping = Keeping {
        law: KeepingLaw::Distances,
        neighbours: Vec::new(),
        leader: None,
        start: at,
    };
    let piece = TrajectoryPiece {
        duration_s: 1.0,
        north: vec![1.0],
        east: vec![2.0],
        down: vec![3.0],
    };
    let trajectory = Trajectory {
        start: at,
        pieces: vec![piece],
        yaw_rad: None,
    };
    let route = Route {
        waypoints: vec![PositionNed::default()],
        speed_m_s: 2.0,
        corner_radius_m: 1.0,
    };
    let heading = FormationHeading::Course { max_rate_rad_s: 0.3 };
    let tasks = [
        Task::Lead { route: None, heading },
        Task::Follow { leader: None, slot },
        Task::Hold,
        Task::Keep(keeping),
        Task::Fly(trajectory),
    ];
    let anchor = AnchorPlan::Path {
        route,
        from: PositionNed::default(),
        heading_rad: 0.0,
        heading,
        acceleration_m_s2: 2.0,
        climb_m_s: 1.0,
        descent_m_s: 1.0,
        start: at,
    };
    Intent {
        version: 7,
        leader: None,
        anchor: Some(anchor),
        tasks: (1..)
            .map(VehicleId)
            .zip(tasks)
            .map(|(id, task)| (id, VehicleTask { version: 7, task }))
            .collect::<BTreeMap<_, _>>(),
    }
}

#[test]
fn every_moment_of_an_intent_is_moved_and_nothing_else() {
    let mut moved = everything(NodeTime(5_000_000));
    moved.put_on_clock_ahead_by(-1_500_000);
    assert_eq!(moved, everything(NodeTime(3_500_000)));
    let text = format!("{moved:?}");
    assert!(!text.contains("5000000"), "a moment was left behind: {text}");
}
