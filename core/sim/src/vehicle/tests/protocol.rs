//! Rates, parameters, texts, clocks and plans on the wire.

use super::rig::{Rig, command_frame, quiet};
use crate::vehicle::LinkKind::{GroundStation, Onboard};
use mavlink::dialects::common::*;
use mavlink::types::CharArray;
use skein_domain::{LocalFrame, LocalPositionNed};

const ACCEPTED: Option<MavResult> = Some(MavResult::MAV_RESULT_ACCEPTED);

#[test]
fn default_rates_are_those_of_px4() {
    let mut rig = Rig::ready(&quiet());
    rig.run(20.0);
    let onboard = [
        (30, 100.0),
        (33, 50.0),
        (32, 30.0),
        (24, 8.0),
        (74, 10.0),
        (245, 5.0),
        (1, 5.0),
        (0, 1.0),
        (147, 0.5),
    ];
    for (id, hz) in onboard {
        let found = rig.rate_hz(Onboard, id, 20.0);
        assert!(
            (found - hz).abs() <= hz * 0.03 + 0.06,
            "message {id}: {found} Hz, not {hz}"
        );
    }
    let ground = [
        (30, 50.0),
        (33, 50.0),
        (32, 50.0),
        (24, 5.0),
        (74, 4.0),
        (245, 1.0),
        (1, 1.0),
        (0, 1.0),
    ];
    for (id, hz) in ground {
        let found = rig.rate_hz(GroundStation, id, 20.0);
        assert!(
            (found - hz).abs() <= hz * 0.03 + 0.06,
            "message {id}: {found} Hz, not {hz}"
        );
    }
    let all = rig
        .received
        .iter()
        .filter(|(t, l, _)| *l == Onboard && *t > rig.time_s - 10.0)
        .count();
    assert!((350..460).contains(&(all / 10)), "{} messages per second", all / 10);
}

#[test]
fn rates_are_set_switched_off_and_put_back() {
    let mut rig = Rig::ready(&quiet());
    let set = |rig: &mut Rig, us: f32| rig.command(511, [32.0, us, 0.0, 0.0, 0.0, 0.0, 0.0]);
    for (us, hz) in [(20_000.0, 50.0), (200_000.0, 5.0), (-1.0, 0.0), (0.0, 30.0)] {
        assert_eq!(set(&mut rig, us), ACCEPTED);
        rig.run(4.2);
        let found = rig.rate_hz(Onboard, 32, 4.0);
        assert!((found - hz).abs() <= hz * 0.03 + 0.3, "{us} us: {found} Hz, not {hz}");
    }
    assert_eq!(
        rig.rate_hz(GroundStation, 32, 4.0).round(),
        50.0,
        "the other link is not touched"
    );
    assert_eq!(
        rig.command(511, [4321.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        Some(MavResult::MAV_RESULT_FAILED)
    );
    assert_eq!(rig.command(510, [32.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]), ACCEPTED);
    let interval = rig.last(|m| match m {
        MavMessage::MESSAGE_INTERVAL(i) => Some((i.message_id, i.interval_us)),
        _ => None,
    });
    assert_eq!(interval, Some((32, 33_333)));
}

#[test]
fn messages_are_sent_on_request() {
    let mut rig = Rig::ready(&quiet());
    assert_eq!(rig.command(512, [148.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]), ACCEPTED);
    let version = rig.last(|m| match m {
        MavMessage::AUTOPILOT_VERSION(v) => Some(v.flight_sw_version),
        _ => None,
    });
    assert_eq!(version, Some(17_956_928));
    assert_eq!(
        rig.command(512, [4321.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        Some(MavResult::MAV_RESULT_DENIED)
    );
}

fn parameter(rig: &Rig, name: &str) -> Vec<PARAM_VALUE_DATA> {
    let is_it = |m: &MavMessage| match m {
        MavMessage::PARAM_VALUE(v) if v.param_id.to_str() == Ok(name) => Some(v.clone()),
        _ => None,
    };
    rig.received
        .iter()
        .filter(|(_, l, _)| *l == Onboard)
        .filter_map(|(_, _, m)| is_it(m))
        .collect()
}

fn set(name: &str, value: f32, param_type: MavParamType) -> PARAM_SET_DATA {
    PARAM_SET_DATA {
        param_value: value,
        target_system: 1,
        target_component: 1,
        param_id: CharArray::from(name),
        param_type,
    }
}

#[test]
fn parameters_travel_as_their_bytes() {
    use MavParamType::{MAV_PARAM_TYPE_INT32 as INT, MAV_PARAM_TYPE_REAL32 as REAL};
    let mut rig = Rig::ready(&quiet());
    rig.send(Onboard, &set("COM_OBL_RC_ACT", f32::from_bits(5), INT));
    let echoes = parameter(&rig, "COM_OBL_RC_ACT");
    assert_eq!(echoes.len(), 2, "each set is answered twice");
    assert_eq!(echoes[0].param_value.to_bits(), 5);
    // Five as a float in an integer's place is stored as it came.
    rig.send(Onboard, &set("COM_OBL_RC_ACT", 5.0, INT));
    assert_eq!(
        parameter(&rig, "COM_OBL_RC_ACT")
            .last()
            .map(|p| p.param_value.to_bits()),
        Some(1_084_227_584)
    );
    // The wrong type is passed over in silence.
    let before = parameter(&rig, "COM_OBL_RC_ACT").len();
    rig.send(Onboard, &set("COM_OBL_RC_ACT", 0.0, REAL));
    rig.run(0.2);
    assert_eq!(parameter(&rig, "COM_OBL_RC_ACT").len(), before);
    rig.send(Onboard, &set("MIS_TAKEOFF_ALT", 7.5, REAL));
    assert_eq!(
        parameter(&rig, "MIS_TAKEOFF_ALT").last().map(|p| p.param_value),
        Some(7.5)
    );
}

#[test]
fn the_whole_list_comes_and_single_ones_by_name_and_index() {
    let mut rig = Rig::ready(&quiet());
    rig.received.clear();
    rig.send(
        Onboard,
        &PARAM_REQUEST_LIST_DATA {
            target_system: 1,
            target_component: 1,
        },
    );
    rig.run(2.0);
    let mut seen: Vec<u16> = Vec::new();
    let mut count = 0;
    for (_, _, m) in &rig.received {
        if let MavMessage::PARAM_VALUE(v) = m {
            seen.push(v.param_index);
            count = v.param_count;
        }
    }
    assert!(count > 40);
    assert_eq!(seen, (0..count).collect::<Vec<_>>());
    let read = |index, name: &str| PARAM_REQUEST_READ_DATA {
        param_index: index,
        target_system: 1,
        target_component: 1,
        param_id: CharArray::from(name),
    };
    rig.received.clear();
    rig.send(Onboard, &read(-1, "MPC_XY_CRUISE"));
    let by_name = parameter(&rig, "MPC_XY_CRUISE");
    assert_eq!(by_name.len(), 1);
    rig.send(Onboard, &read(by_name[0].param_index as i16, ""));
    assert_eq!(parameter(&rig, "MPC_XY_CRUISE").len(), 2);
    rig.send(Onboard, &read(-1, "_HASH_CHECK"));
    assert_eq!(parameter(&rig, "_HASH_CHECK").len(), 1);
}

#[test]
fn texts_come_only_where_a_ground_station_listens() {
    let mut rig = Rig::new(&quiet());
    rig.ground_station = false;
    rig.run(1.0);
    rig.arm();
    assert!(rig.texts().is_empty());
    rig.ground_station = true;
    rig.run(0.1);
    rig.arm();
    assert_eq!(rig.texts(), ["Arming denied: Resolve system health failures first\t"]);
    let chunks: Vec<_> = rig
        .received
        .iter()
        .filter(|(_, _, m)| matches!(m, MavMessage::STATUSTEXT(_)))
        .collect();
    assert_eq!(chunks.len(), 2, "52 characters in two chunks");
    assert!(
        chunks.iter().all(|(_, link, _)| *link == Onboard),
        "the other link has heard no ground station"
    );
}

#[test]
fn the_clock_is_told_when_asked_for() {
    let mut rig = Rig::ready(&quiet());
    rig.received.clear();
    rig.send(
        Onboard,
        &TIMESYNC_DATA {
            tc1: 0,
            ts1: 42,
            ..TIMESYNC_DATA::default()
        },
    );
    let answer = rig.last(|m| match m {
        MavMessage::TIMESYNC(t) if t.tc1 != 0 => Some((t.tc1, t.ts1)),
        _ => None,
    });
    let (tc1, ts1) = answer.expect("answers at once");
    assert_eq!(ts1, 42);
    assert!((tc1 as f64 * 1e-9 - rig.time_s).abs() < 0.005);
}

#[test]
fn it_starts_without_a_plan_and_keeps_no_fence() {
    let mut rig = Rig::ready(&quiet());
    rig.send(
        Onboard,
        &MISSION_REQUEST_LIST_DATA {
            target_system: 1,
            target_component: 1,
            ..Default::default()
        },
    );
    let count = rig.last(|m| match m {
        MavMessage::MISSION_COUNT(c) => Some((c.count, c.target_system)),
        _ => None,
    });
    assert_eq!(count, Some((0, 245)));
    let offer = MISSION_COUNT_DATA {
        count: 3,
        target_system: 1,
        target_component: 1,
        mission_type: MavMissionType::MAV_MISSION_TYPE_FENCE,
        ..Default::default()
    };
    rig.send(Onboard, &offer);
    let answer = rig.last(|m| match m {
        MavMessage::MISSION_ACK(a) => Some(a.mavtype),
        _ => None,
    });
    assert_eq!(answer, Some(MavMissionResult::MAV_MISSION_UNSUPPORTED));
}

#[test]
fn acknowledgements_take_some_milliseconds() {
    let mut rig = Rig::ready(&quiet());
    let asked = rig.time_s;
    rig.command(512, [148.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let (when, _, _) = rig
        .received
        .iter()
        .rev()
        .find(|(_, _, m)| matches!(m, MavMessage::COMMAND_ACK(_)))
        .expect("ack");
    let delay = when - asked;
    assert!((0.002..0.02).contains(&delay), "{delay}");
}

#[test]
fn both_positions_tell_of_the_same_origin() {
    let mut rig = Rig::flying(&crate::SimSettings::default(), 5.0);
    rig.command(511, [32.0, 4_000.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    rig.run(1.0);
    let place = rig.last(|m| match m {
        MavMessage::GLOBAL_POSITION_INT(g) => Some(skein_domain::Geodetic {
            latitude_deg: f64::from(g.lat) * 1e-7,
            longitude_deg: f64::from(g.lon) * 1e-7,
            altitude_amsl_m: f64::from(g.alt) * 1e-3,
        }),
        _ => None,
    });
    let own = LocalPositionNed::from(rig.own_position());
    let swarm = skein_domain::SwarmFrame::new(crate::SimSettings::default().origin);
    let found = swarm.position(&LocalFrame::from_pair(&place.expect("global position"), &own).origin);
    let truth = rig.truth();
    assert!(
        found.distance_m(&truth.local_origin) < 0.08,
        "{found:?} {:?}",
        truth.local_origin
    );
    // It stands 20 m north, 30 m west and 7 m above the simulation's origin, so its own origin is there too.
    assert!((found.vector() - nalgebra::Vector3::new(20.0, -30.0, -7.0)).norm() < 0.4);
}

#[test]
fn rubbish_between_frames_and_old_frames_do_no_harm() {
    let mut rig = Rig::ready(&quiet());
    let arm = command_frame(1, 1, 400, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let mut wrong = arm.clone();
    *wrong.last_mut().expect("bytes") ^= 1;
    rig.send_bytes(Onboard, &wrong);
    rig.send_bytes(Onboard, &arm[..20]);
    rig.run(0.1);
    assert!(!rig.truth().armed, "wrong checksum, or half a frame");
    // The same command as MAVLink 1, with rubbish before it that begins like a frame.
    let payload = &arm[10..arm.len() - 2];
    let mut old = vec![0xFE, payload.len() as u8, 3, 245, 190, 76];
    old.extend(payload);
    let crc = mavlink::calculate_crc(&old[1..], 152);
    old.extend(crc.to_le_bytes());
    let mut datagram = vec![0xFD, 0x09, 0x00, 0xFE, 0x55];
    datagram.extend(old);
    rig.send_bytes(Onboard, &datagram);
    rig.run(0.1);
    assert!(rig.truth().armed);
}
