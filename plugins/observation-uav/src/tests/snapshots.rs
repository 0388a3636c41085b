//! Restarts: a restored instance goes on with its observation as if nothing had happened.

use super::rig::{Rig, THE_TRACK, create};
use crate::Settings;
use proptest::prelude::*;
use skein_plugin_sdk::UavModel;
use skein_plugin_sdk::domain::payload::Target;
use skein_plugin_sdk::domain::{FlightState, PositionNed, VehicleCommand};

fn restart(rig: &mut Rig) {
    let snapshot = rig.model.snapshot();
    rig.model = create(Settings::default(), Some(snapshot.clone()), rig.now.plus_seconds(0.07));
    assert_eq!(rig.model.snapshot(), snapshot, "nothing is lost or added");
}

#[test]
fn an_observation_goes_on_after_a_restart() {
    let mut rig = Rig::with_track(50.0, 20.0);
    rig.track.as_mut().expect("is there").velocity.y = 3.0;
    let began_s = rig.now.as_seconds();
    let id = rig.observe(THE_TRACK, Some(18.0), Some(12.0));
    for _ in 0..30 {
        rig.run(0.7);
        restart(&mut rig);
    }
    assert!(rig.is_done(id));
    assert_eq!(rig.report()["activity"], "observing");
    assert!((rig.distance_m(rig.track.expect("is there")) - 18.0).abs() < 2.0);
    assert!((rig.position.z + 12.0).abs() < 1.0);
    rig.assert_smooth_since(began_s);
    assert_eq!(rig.progress(id).len(), 2, "said once");
}

#[test]
fn a_snapshot_that_is_of_no_use_starts_from_what_the_vehicle_does() {
    let mut rig = Rig::with_track(50.0, 20.0);
    rig.observe(THE_TRACK, None, None);
    rig.run(3.0);
    let mut snapshot = rig.model.snapshot();
    assert_eq!(snapshot[1], 1, "the version");
    snapshot[1] = 9;
    rig.model = create(Settings::default(), Some(snapshot), rig.now);
    rig.run(4.0);
    assert_eq!(rig.state, FlightState::Holding);
    assert!(rig.velocity.norm() < 0.1);
}

#[derive(Debug, Clone)]
enum Happening {
    Observe(Option<(f64, f64)>, f64, Option<f64>),
    LookAt(f64, f64),
    Command(VehicleCommand),
    TrackGone,
    TrackMoves(f64, f64),
    Run,
}

fn happening() -> impl Strategy<Value = Happening> {
    let metres = -80.0..80.0f64;
    prop_oneof![
        3 => (prop::option::of((metres.clone(), metres.clone())), 5.0..40.0f64, prop::option::of(2.0..30.0f64))
            .prop_map(|(place, stand_off_m, height_m)| Happening::Observe(place, stand_off_m, height_m)),
        2 => (metres.clone(), metres.clone()).prop_map(|(n, e)| Happening::LookAt(n, e)),
        1 => prop::sample::select(vec![VehicleCommand::Hold, VehicleCommand::StopObserving, VehicleCommand::Land])
            .prop_map(Happening::Command),
        1 => Just(Happening::TrackGone),
        2 => (-5.0..5.0f64, -5.0..5.0f64).prop_map(|(n, e)| Happening::TrackMoves(n, e)),
        2 => Just(Happening::Run),
    ]
}

fn happen(rig: &mut Rig, happening: &Happening) -> Option<skein_plugin_sdk::domain::CommandId> {
    let place = |n: f64, e: f64| Target::Place {
        position: PositionNed::new(n, e, 0.0),
    };
    match *happening {
        Happening::Observe(at, stand_off_m, height_m) => {
            let target = at.map_or(THE_TRACK, |(n, e)| place(n, e));
            return Some(rig.observe(target, Some(stand_off_m), height_m));
        }
        Happening::LookAt(n, e) => return Some(rig.command(VehicleCommand::LookAt { target: place(n, e) })),
        Happening::Command(command) => return Some(rig.command(command)),
        Happening::TrackGone => rig.track = None,
        Happening::TrackMoves(n, e) => {
            let velocity = nalgebra::Vector3::new(n, e, 0.0);
            let position = rig
                .track
                .map_or(nalgebra::Vector3::new(20.0, 0.0, 0.0), |track| track.position);
            rig.track = Some(super::rig::Mover { position, velocity });
        }
        Happening::Run => {}
    }
    None
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 120, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn whatever_happens_a_snapshot_is_complete_and_commands_end_once(
        happenings in prop::collection::vec((happening(), 0.02..4.0f64), 1..25),
    ) {
        let mut rig = Rig::with_track(30.0, -10.0);
        let mut commands = Vec::new();
        for (what, seconds) in &happenings {
            commands.extend(happen(&mut rig, what));
            rig.run(*seconds);
            restart(&mut rig);
        }
        for (_, effect) in &rig.log {
            if let skein_plugin_sdk::domain::exchange::Effect::Setpoint(setpoint) = effect {
                prop_assert!(setpoint.is_well_formed());
            }
        }
        rig.run(10.0);
        for id in commands {
            let progress = rig.progress(id);
            let executing = skein_plugin_sdk::domain::exchange::CommandProgress::Executing;
            let ends = progress.iter().filter(|p| **p != executing).count();
            prop_assert!(ends <= 1, "{}: {:?}", id, progress);
            prop_assert!(!progress.is_empty(), "{} was lost", id);
        }
    }

    #[test]
    fn garbage_is_no_snapshot_and_no_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..300),
        damage in any::<(prop::sample::Index, u8)>(),
        damaged in any::<bool>(),
    ) {
        let mut rig = Rig::with_track(30.0, -10.0);
        rig.observe(THE_TRACK, None, None);
        rig.run(1.0);
        let mut snapshot = rig.model.snapshot();
        if damaged {
            let at = damage.0.index(snapshot.len());
            snapshot[at] = damage.1;
        } else {
            snapshot = bytes;
        }
        rig.model = create(Settings::default(), Some(snapshot), rig.now);
        rig.run(1.0);
    }
}
