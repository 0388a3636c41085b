//! Decisions that are made again come out the same, and one that was changed does not.

use super::{header, second};
use crate::decisions::{FailsafeDecision, GateState, LeadershipDecision, PeersRecord};
use crate::{Encoded, Recording, Redecided, Redecider, Select, SetpointRecord, Topic, Writer};
use skein_coordination::steering;
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{
    FailsafeSettings, LinkHealth, NodeId, NodeTime, PositionNed, Setpoint, Telemetry, VehicleId, VelocityNed,
};
use skein_failover::{Beacon, LeaderMonitor, LeaderMonitorSettings, Leadership, Standing, Term, Turn};
use skein_safety::avoidance::{Cooperation, Neighbour, NeighbourId, Surroundings};
use skein_safety::failsafe::Health;
use skein_safety::{FailsafePolicy, Limits};
use skein_view::{PeerEntry, PeerSnapshot};

const LIMITS: Limits = Limits {
    max_speed_m_s: 8.0,
    max_climb_m_s: 3.0,
    max_descent_m_s: 2.0,
    min_separation_m: 2.0,
    separation_horizon_s: 2.0,
};

fn gate() -> GateState {
    GateState {
        time: second(0),
        number: 1,
        limits: LIMITS,
        min_height_m: 1.0,
        fences: Default::default(),
        frame: None,
    }
}

/// Two vehicles that fly towards each other.
fn peers(at: NodeTime) -> PeerSnapshot {
    let kinematics = |east_m: f64, towards: f64| VehicleKinematics {
        position: PositionNed::new(0.1, east_m, -20.0 / 3.0),
        velocity: VelocityNed::new(0.0, towards, 0.0),
        yaw_rad: 0.3,
        measured: at,
    };
    let both = [
        (VehicleId(1), kinematics(0.0, 2.0)),
        (VehicleId(2), kinematics(7.0, -2.0)),
    ];
    let neighbours = both.map(|(id, of)| Neighbour {
        id: NeighbourId::Vehicle(id),
        position: of.position,
        velocity: of.velocity,
        measured: of.measured,
        uncertainty_m: 0.3,
        cooperation: Cooperation::Shares,
        airborne: true,
    });
    let gate = gate().gate().expect("is one");
    PeerSnapshot {
        made: at,
        entries: both
            .map(|(id, of)| PeerEntry {
                id,
                kinematics: Some(of),
                airborne: true,
                home: Some(PositionNed::new(0.0, 0.0, 0.0)),
                ..PeerEntry::default()
            })
            .to_vec(),
        surroundings: Surroundings::new(&neighbours, &gate.avoidance(), at),
        anchor: None,
    }
}

fn setpoint(peers: &PeerSnapshot, asked: Setpoint) -> SetpointRecord {
    let gate = gate().gate().expect("is one");
    let entry = peers.entry(VehicleId(1)).expect("is there");
    let time = peers.made.plus_seconds(0.004);
    let answer = steering::steer(&gate, entry, &asked, &peers.surroundings, time);
    SetpointRecord {
        time,
        vehicle: VehicleId(1),
        peers: Some(peers.made),
        gate: 1,
        asked,
        flown: answer.outcome.as_ref().ok().map(|steered| steered.setpoint),
        slowed: answer.slowed,
        refusal: answer.outcome.err(),
        change: None,
    }
}

fn failsafe() -> FailsafeDecision {
    let (mut policy, settings) = (FailsafePolicy::new(), FailsafeSettings::default());
    let health = |at: NodeTime| Health {
        airborne: true,
        ..Health::observed(&Telemetry::default(), &LinkHealth::default(), at)
    };
    for tick in 0..2_000u64 {
        let now = NodeTime(5_000_000 + tick * 50_000);
        let before = policy.clone();
        let events = policy.step(now, &health(now), &settings);
        if !events.is_empty() {
            return FailsafeDecision {
                time: now,
                vehicle: VehicleId(1),
                before,
                health: health(now),
                settings,
                events: serde_json::to_value(&events).expect("encodes"),
            };
        }
    }
    panic!("nothing was wrong with a vehicle that says nothing");
}

/// Node 2 misses node 1, which coordinated, and hears node 3.
fn leadership(turn: impl FnOnce(Turn) -> Turn) -> LeadershipDecision {
    let standing = |node| Standing {
        priority: 5,
        node: NodeId(node),
    };
    let term = Term {
        number: 7,
        holder: standing(1),
    };
    let mut leadership = Leadership::new(NodeId(2), Some(term));
    leadership.set_priority(Some(5));
    let mut monitor = LeaderMonitor::new(LeaderMonitorSettings::default(), second(0));
    let mut now = second(0);
    let mut pulse = 0;
    while monitor.turn(now, &leadership) != Turn::Claim {
        assert!(now < second(60), "it never is its turn");
        now = now.plus_seconds(0.1);
        monitor.look(now);
        // The one that coordinated falls silent after four seconds.
        pulse += u64::from(now < second(4));
        for from in [1, 3].into_iter().filter(|node| *node == 3 || now < second(4)) {
            let beacon = Beacon {
                from: NodeId(from),
                obeys: Some(term),
                pulse,
                standing: Some(standing(from)),
            };
            monitor.hear(now, &leadership, &beacon);
        }
    }
    LeadershipDecision {
        time: now,
        turn: turn(monitor.turn(now, &leadership)),
        monitor,
        leadership,
    }
}

fn decided(messages: &[Encoded]) -> Redecided {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("flight.mcap");
    let mut writer = Writer::create(&path, header(1)).expect("begins");
    for message in messages {
        writer.write(message, message.at).expect("takes it");
    }
    writer.finish().expect("ends");
    let recording = Recording::open(&path).expect("opens");
    let mut again = Redecider::default();
    for message in recording.messages(Select::only(Redecider::wants)) {
        again.take(&message.expect("is whole"));
    }
    again.finish()
}

fn encoded(topic: Topic, at: NodeTime, message: &impl serde::Serialize) -> Encoded {
    Encoded::json(topic, at, message).expect("encodes")
}

fn told(change: impl FnOnce(&mut SetpointRecord)) -> Vec<Encoded> {
    let peers = peers(second(1));
    let asked = Setpoint {
        velocity: Some(VelocityNed::new(0.0, 3.0, 0.0)),
        yaw_rad: Some(0.1),
        ..Setpoint::default()
    };
    let mut flown = setpoint(&peers, asked);
    assert_ne!(flown.flown, Some(asked), "nothing was changed: the test says nothing");
    change(&mut flown);
    let refused = setpoint(&peers, Setpoint::hold(PositionNed::new(f64::MAX, 0.0, 0.0), None));
    vec![
        encoded(Topic::Gate, second(0), &gate()),
        encoded(Topic::Peers, peers.made, &PeersRecord::of(&peers)),
        encoded(Topic::Setpoint(VehicleId(1)), flown.time, &flown),
        encoded(Topic::Setpoint(VehicleId(1)), refused.time, &refused),
        encoded(Topic::Failsafe, second(2), &failsafe()),
    ]
}

#[test]
fn what_was_decided_is_decided_again() {
    let again = decided(&told(|_| {}));
    assert_eq!(again.differences, []);
    assert_eq!((again.setpoints, again.failsafe, again.without_inputs), (2, 1, 0));
}

#[test]
fn another_outcome_is_told_with_its_place() {
    let again = decided(&told(|record| {
        if let Some(velocity) = record.flown.as_mut().and_then(|flown| flown.velocity.as_mut()) {
            velocity.east_m_s += 0.01;
        }
    }));
    let [difference] = again.differences.as_slice() else {
        panic!("{:?}", again.differences);
    };
    assert!(difference.place.ends_with("velocity.east_m_s"), "{difference}");
    assert_eq!(difference.vehicle, Some(VehicleId(1)));
}

#[test]
fn whose_turn_it_is_to_coordinate_is_decided_again() {
    let record = leadership(|turn| turn);
    let again = decided(&[encoded(Topic::Leadership, record.time, &record)]);
    assert_eq!((again.turns, again.without_inputs, again.differences.len()), (1, 0, 0));
    let record = leadership(|_| Turn::Wait);
    let again = decided(&[encoded(Topic::Leadership, record.time, &record)]);
    assert_eq!(again.differences.len(), 1);
    assert_eq!(
        (
            again.differences[0].recorded.as_str(),
            again.differences[0].now.as_str()
        ),
        ("\"wait\"", "\"claim\"")
    );
}

#[test]
fn a_setpoint_without_its_period_is_counted_as_that() {
    let messages: Vec<_> = told(|_| {}).into_iter().filter(|of| of.topic != Topic::Peers).collect();
    let again = decided(&messages);
    assert_eq!((again.setpoints, again.without_inputs), (0, 2));
}

#[test]
fn a_thinned_setpoint_is_counted_and_not_judged() {
    let mut record = setpoint(
        &peers(second(1)),
        Setpoint::hold(PositionNed::new(1.0 / 3.0, 0.0, -5.0), None),
    );
    record = record.thinned();
    assert_eq!(record.asked.position, Some(PositionNed::new(0.3333, 0.0, -5.0)));
    let again = decided(&[encoded(Topic::Setpoint(VehicleId(1)), second(1), &record)]);
    assert_eq!((again.thinned, again.setpoints, again.without_inputs), (1, 0, 0));
}
