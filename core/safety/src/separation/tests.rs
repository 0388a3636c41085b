//! Separation: what is refused, what is not, and that a far peer costs nothing but a look.

use super::*;
use proptest::prelude::*;
use skein_domain::{PositionNed, VelocityNed};

const NOW: NodeTime = NodeTime(10_000_000);
const OWN: VehicleId = VehicleId(1);
const LIMIT_M: f64 = 2.0;
const HORIZON_S: f64 = 0.8;

fn moving(position: [f64; 3], velocity: [f64; 3]) -> VehicleKinematics {
    let vector = |[x, y, z]: [f64; 3]| Vector3::new(x, y, z);
    VehicleKinematics {
        position: vector(position).into(),
        velocity: vector(velocity).into(),
        yaw_rad: 0.0,
        measured: NOW,
    }
}

fn peer(id: u16, position: [f64; 3], velocity: [f64; 3]) -> Peer {
    Peer {
        id: VehicleId(id),
        kinematics: moving(position, velocity),
        airborne: true,
    }
}

fn judge(own: &VehicleKinematics, setpoint: &Setpoint, peers: &[Peer]) -> Option<Refusal> {
    Motion::new(own, setpoint, 10.0, NOW).too_close(OWN, peers, LIMIT_M, HORIZON_S, NOW)
}

fn fly(velocity: [f64; 3]) -> Setpoint {
    let [n, e, d] = velocity;
    Setpoint {
        velocity: Some(VelocityNed::new(n, e, d)),
        ..Setpoint::default()
    }
}

#[test]
fn flying_into_a_standing_peer_is_refused_with_the_distance() {
    let own = moving([0.0; 3], [5.0, 0.0, 0.0]);
    let peers = [peer(7, [4.0, 1.5, 0.0], [0.0; 3]), peer(8, [4.0, -1.0, 0.0], [0.0; 3])];
    let refused = judge(&own, &fly([5.0, 0.0, 0.0]), &peers);
    // 0.8 s bring it beside both; the nearer one is named.
    assert_eq!(
        refused,
        Some(Refusal::TooClose {
            other: VehicleId(8),
            distance_m: 1.0,
            limit_m: LIMIT_M
        })
    );
}

#[test]
fn what_is_beyond_the_horizon_on_the_ground_or_oneself_is_no_reason() {
    let own = moving([0.0; 3], [5.0, 0.0, 0.0]);
    let ahead = fly([5.0, 0.0, 0.0]);
    assert_eq!(judge(&own, &ahead, &[peer(7, [6.5, 0.0, 0.0], [0.0; 3])]), None);
    assert_eq!(
        judge(
            &own,
            &ahead,
            &[Peer {
                airborne: false,
                ..peer(7, [4.0, 0.0, 0.0], [0.0; 3])
            }]
        ),
        None
    );
    assert_eq!(judge(&own, &ahead, &[peer(OWN.0, [4.0, 0.0, 0.0], [0.0; 3])]), None);
    assert_eq!(
        judge(&own, &ahead, &[peer(7, [4.0, 0.0, -3.0], [0.0; 3])]),
        None,
        "three metres above"
    );
}

#[test]
fn going_apart_standing_still_and_flying_in_step_are_allowed_however_close() {
    let beside = [peer(7, [0.0, 1.2, 0.0], [0.0; 3])];
    let own = moving([0.0; 3], [0.0; 3]);
    assert_eq!(judge(&own, &fly([0.0, -2.0, 0.0]), &beside), None);
    assert_eq!(
        judge(&own, &Setpoint::hold(PositionNed::default(), None), &beside),
        None
    );
    let in_step = [peer(7, [1.5, 0.0, 0.0], [10.0, 0.0, 0.0])];
    assert_eq!(
        judge(&moving([0.0; 3], [10.0, 0.0, 0.0]), &fly([10.0, 0.0, 0.0]), &in_step),
        None
    );
    // The other comes: holding on is not what brings them together.
    let comes = [peer(7, [3.0, 0.0, 0.0], [-5.0, 0.0, 0.0])];
    assert_eq!(judge(&own, &Setpoint::hold(PositionNed::default(), None), &comes), None);
}

#[test]
fn a_far_goal_behind_a_peer_is_refused() {
    let own = moving([0.0; 3], [0.0; 3]);
    let to = Setpoint::hold(PositionNed::new(30.0, 0.0, 0.0), None);
    assert!(judge(&own, &to, &[peer(7, [5.0, 0.0, 0.0], [0.0; 3])]).is_some());
    assert_eq!(judge(&own, &to, &[peer(7, [-5.0, 0.0, 0.0], [0.0; 3])]), None);
}

#[test]
fn an_older_measurement_is_carried_on() {
    let own = moving([0.0; 3], [5.0, 0.0, 0.0]);
    let mut ahead = peer(7, [4.0, 0.0, 0.0], [5.0, 0.0, 0.0]);
    assert_eq!(judge(&own, &fly([5.0, 0.0, 0.0]), &[ahead]), None);
    // Measured 0.4 s ago it comes towards us: it is 2 m nearer by now.
    ahead.kinematics = VehicleKinematics {
        measured: NOW.plus_seconds(-0.4),
        ..moving([8.0, 0.0, 0.0], [-5.0, 0.0, 0.0])
    };
    assert!(judge(&own, &fly([1.0, 0.0, 0.0]), &[ahead]).is_some());
    ahead.kinematics.measured = NOW;
    assert_eq!(judge(&own, &fly([1.0, 0.0, 0.0]), &[ahead]), None);
}

fn vector(limit: f64) -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-limit..limit)
}

proptest! {
    #[test]
    fn the_box_never_hides_a_peer(
        own_velocity in vector(8.0), peers in prop::collection::vec((vector(12.0), vector(8.0)), 1..30),
        goal in prop::option::of(vector(15.0)),
    ) {
        let own = moving([0.0; 3], own_velocity);
        let setpoint = Setpoint { position: goal.map(|g| Vector3::from(g).into()), ..fly(own_velocity) };
        let all: Vec<Peer> = peers.iter().zip(2..).map(|((p, v), id)| peer(id, *p, *v)).collect();
        let motion = Motion::new(&own, &setpoint, 10.0, NOW);
        let least_m = all
            .iter()
            .map(|peer| {
                let there = peer.kinematics.position.vector();
                motion.closest_m(&there, &peer.kinematics.velocity.vector(), LIMIT_M, HORIZON_S)
            })
            .fold(f64::INFINITY, f64::min);
        match judge(&own, &setpoint, &all) {
            Some(Refusal::TooClose { distance_m, limit_m, .. }) => {
                prop_assert_eq!((distance_m, limit_m), (least_m, LIMIT_M));
                prop_assert!(least_m < LIMIT_M);
            }
            None => prop_assert!(least_m >= LIMIT_M),
            other => prop_assert!(false, "{other:?}"),
        }
    }

    #[test]
    fn what_is_allowed_does_not_bring_them_below_the_limit(
        own_velocity in vector(8.0), place in vector(12.0), velocity in vector(8.0),
    ) {
        let own = moving([0.0; 3], own_velocity);
        let away_m = Vector3::from(place).norm();
        let towards_m_s = Vector3::from(own_velocity).dot(&Vector3::from(place)) / away_m;
        if away_m < LIMIT_M || towards_m_s <= STILL_M_S {
            return Ok(());
        }
        if judge(&own, &fly(own_velocity), &[peer(2, place, velocity)]).is_none() {
            for k in 0..=80 {
                let t = HORIZON_S * f64::from(k) / 80.0;
                let apart = Vector3::from(place) + (Vector3::from(velocity) - Vector3::from(own_velocity)) * t;
                prop_assert!(apart.norm() >= LIMIT_M - STILL_M_S * HORIZON_S);
            }
        }
    }

    #[test]
    fn odd_numbers_of_a_peer_neither_panic_nor_hide_the_others(
        odd in prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300]), axis in 0_usize..6,
    ) {
        let mut state = [4.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        state[axis] = odd;
        let broken = peer(7, [state[0], state[1], state[2]], [state[3], state[4], state[5]]);
        let own = moving([0.0; 3], [5.0, 0.0, 0.0]);
        let refused = judge(&own, &fly([5.0, 0.0, 0.0]), &[broken, peer(8, [4.0, 1.0, 0.0], [0.0; 3])]);
        prop_assert!(refused.is_some());
    }
}
