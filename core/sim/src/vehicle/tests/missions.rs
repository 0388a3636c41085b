//! Missions: taken in with losses and nonsense on the way, refused with the right word, flown.

use super::rig::{Rig, quiet};
use crate::vehicle::LinkKind::Onboard;
use mavlink::dialects::common::*;
use skein_domain::FlightMode;

const ROUTE: MavMissionType = MavMissionType::MAV_MISSION_TYPE_MISSION;

fn count(count: u16) -> MISSION_COUNT_DATA {
    MISSION_COUNT_DATA {
        count,
        target_system: 1,
        target_component: 1,
        mission_type: ROUTE,
        ..MISSION_COUNT_DATA::default()
    }
}

/// A waypoint so far north of where the vehicle is.
fn waypoint(rig: &Rig, seq: u16, north_m: f64) -> MISSION_ITEM_INT_DATA {
    let here = rig.truth().geodetic;
    MISSION_ITEM_INT_DATA {
        seq,
        command: MavCmd::MAV_CMD_NAV_WAYPOINT,
        frame: MavFrame::MAV_FRAME_GLOBAL,
        param4: f32::NAN,
        x: ((here.latitude_deg + north_m / 111_195.0) * 1e7) as i32,
        y: (here.longitude_deg * 1e7) as i32,
        z: here.altitude_amsl_m as f32,
        target_system: 1,
        target_component: 1,
        autocontinue: 1,
        mission_type: ROUTE,
        ..MISSION_ITEM_INT_DATA::default()
    }
}

fn requests(rig: &Rig) -> Vec<u16> {
    let seq = |m: &MavMessage| match m {
        MavMessage::MISSION_REQUEST_INT(r) => Some(r.seq),
        _ => None,
    };
    rig.received.iter().filter_map(|(_, _, m)| seq(m)).collect()
}

fn answer(rig: &Rig) -> Option<MavMissionResult> {
    rig.last(|m| match m {
        MavMessage::MISSION_ACK(a) => Some(a.mavtype),
        _ => None,
    })
}

fn upload(rig: &mut Rig, items: &[MISSION_ITEM_INT_DATA]) {
    rig.send(Onboard, &count(items.len() as u16));
    rig.run(0.02);
    for item in items {
        rig.send(Onboard, item);
        rig.run(0.02);
    }
    assert_eq!(answer(rig), Some(MavMissionResult::MAV_MISSION_ACCEPTED));
}

#[test]
fn an_item_that_does_not_come_is_asked_for_again_and_the_last_may_be_sent_twice() {
    let mut rig = Rig::ready(&quiet());
    rig.send(Onboard, &count(2));
    rig.run(0.6);
    assert_eq!(requests(&rig), [0, 0, 0], "every quarter of a second");
    let (first, second) = (waypoint(&rig, 0, 10.0), waypoint(&rig, 1, 20.0));
    rig.send(Onboard, &second);
    rig.send(Onboard, &first);
    rig.run(0.05);
    assert_eq!(requests(&rig).last(), Some(&1), "out of turn is passed over");
    rig.send(Onboard, &second);
    assert_eq!(answer(&rig), Some(MavMissionResult::MAV_MISSION_ACCEPTED));
    rig.received.clear();
    rig.send(Onboard, &second);
    assert_eq!(answer(&rig), Some(MavMissionResult::MAV_MISSION_ACCEPTED), "once more");
    rig.send(Onboard, &first);
    assert_eq!(answer(&rig), Some(MavMissionResult::MAV_MISSION_ERROR), "no transfer");
}

#[test]
fn refusals_have_their_word() {
    let mut rig = Rig::ready(&quiet());
    rig.send(Onboard, &count(501));
    assert_eq!(answer(&rig), Some(MavMissionResult::MAV_MISSION_NO_SPACE));
    rig.send(Onboard, &count(2));
    rig.run(0.02);
    rig.send(Onboard, &waypoint(&rig, 0, 10.0));
    rig.run(0.02);
    rig.send(Onboard, &count(3));
    rig.run(0.02);
    assert_eq!(answer(&rig), Some(MavMissionResult::MAV_MISSION_ERROR), "busy");
    assert!(rig.heard("WPM: REJ. CMD: Busy"));
    rig.run(5.5);
    assert!(rig.heard("Operation timeout"));
    rig.send(Onboard, &count(4));
    rig.run(0.02);
    let cancel = MISSION_ACK_DATA {
        target_system: 1,
        target_component: 1,
        mavtype: MavMissionResult::MAV_MISSION_OPERATION_CANCELLED,
        mission_type: ROUTE,
        ..MISSION_ACK_DATA::default()
    };
    rig.send(Onboard, &cancel);
    let asked = requests(&rig).len();
    rig.run(1.0);
    assert_eq!(requests(&rig).len(), asked, "cancelled");
    rig.send(Onboard, &count(1));
    rig.run(0.02);
    let body = MISSION_ITEM_INT_DATA {
        frame: MavFrame::MAV_FRAME_LOCAL_NED,
        ..waypoint(&rig, 0, 10.0)
    };
    rig.send(Onboard, &body);
    assert_eq!(answer(&rig), Some(MavMissionResult::MAV_MISSION_UNSUPPORTED_FRAME));
    rig.send(Onboard, &count(1));
    rig.run(0.02);
    let jump = MISSION_ITEM_INT_DATA {
        command: MavCmd::MAV_CMD_DO_JUMP,
        ..waypoint(&rig, 0, 10.0)
    };
    rig.send(Onboard, &jump);
    assert_eq!(answer(&rig), Some(MavMissionResult::MAV_MISSION_UNSUPPORTED));
}

#[test]
fn a_mission_is_flown_point_by_point_and_goes_on_where_it_was_left() {
    let mut rig = Rig::flying(&quiet(), 10.0);
    assert_eq!(
        rig.set_mode(4, 4),
        Some(MavResult::MAV_RESULT_TEMPORARILY_REJECTED),
        "none is there"
    );
    let start = rig.truth().position;
    let speed = MISSION_ITEM_INT_DATA {
        command: MavCmd::MAV_CMD_DO_CHANGE_SPEED,
        frame: MavFrame::MAV_FRAME_MISSION,
        param1: 1.0,
        param2: 3.0,
        ..waypoint(&rig, 1, 0.0)
    };
    let items = [waypoint(&rig, 0, 20.0), speed, waypoint(&rig, 2, 50.0)];
    upload(&mut rig, &items);
    assert_eq!(rig.set_mode(4, 4), Some(MavResult::MAV_RESULT_ACCEPTED));
    assert!(
        rig.run_until(20.0, |t| t.position.north_m > start.north_m + 25.0)
            .is_some()
    );
    assert_eq!(rig.set_mode(4, 3), Some(MavResult::MAV_RESULT_ACCEPTED));
    rig.run(5.0);
    let state = |rig: &Rig| {
        rig.last(|m| match m {
            MavMessage::MISSION_CURRENT(c) => Some((c.seq, c.total, c.mission_state)),
            _ => None,
        })
    };
    assert_eq!(state(&rig), Some((2, 3, MissionState::MISSION_STATE_PAUSED)));
    assert_eq!(rig.set_mode(4, 4), Some(MavResult::MAV_RESULT_ACCEPTED));
    let mut fastest_m_s: f64 = 0.0;
    let there = rig.run_until(30.0, |t| {
        fastest_m_s = fastest_m_s.max(t.velocity.norm());
        t.position.north_m > start.north_m + 48.0
    });
    assert!(there.is_some() && (2.5..3.6).contains(&fastest_m_s), "{fastest_m_s}");
    rig.run(5.0);
    let t = rig.truth();
    assert!(
        (t.position.north_m - start.north_m - 50.0).abs() < 0.5,
        "{:?}",
        t.position
    );
    assert_eq!(t.mode, FlightMode::Mission, "it holds there");
    assert_eq!(state(&rig).unwrap().2, MissionState::MISSION_STATE_COMPLETE);
    let reached: Vec<u16> = rig
        .received
        .iter()
        .filter_map(|(_, link, m)| match m {
            MavMessage::MISSION_ITEM_REACHED(r) if *link == Onboard => Some(r.seq),
            _ => None,
        })
        .collect();
    let mut once = reached.clone();
    once.dedup();
    assert_eq!(once, [0, 1, 2]);
    assert!(reached.len() > 6, "it is said several times: {reached:?}");
}
