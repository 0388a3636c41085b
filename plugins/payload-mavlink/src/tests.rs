//! Tests of messages and of commands that are asked again.

use super::*;
use mavlink::dialects::common::{COMMAND_ACK_DATA, COMMAND_LONG_DATA, MavCmd, MavResult};
use proptest::prelude::*;
use skein_domain::{NodeTime, Refusal};

const PATIENCE: Patience = Patience {
    wait_s: 1.0,
    attempts: 3,
};

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

fn command(command: MavCmd, target_component: u8) -> COMMAND_LONG_DATA {
    COMMAND_LONG_DATA {
        command,
        target_system: 1,
        target_component,
        param1: f32::NAN,
        ..COMMAND_LONG_DATA::default()
    }
}

fn zoom() -> COMMAND_LONG_DATA {
    command(MavCmd::MAV_CMD_SET_CAMERA_ZOOM, 100)
}

fn ack(command: MavCmd, result: MavResult, from: u8, to: (u8, u8)) -> MavlinkMessage {
    let data = COMMAND_ACK_DATA {
        command,
        result,
        target_system: to.0,
        target_component: to.1,
        ..COMMAND_ACK_DATA::default()
    };
    MavlinkMessage {
        system_id: 1,
        component_id: from,
        message_id: COMMAND_ACK_DATA::ID,
        payload: encode(&data),
    }
}

fn sent(effects: &mut Effects) -> Vec<COMMAND_LONG_DATA> {
    let effects = effects.take();
    let messages = effects.into_iter().filter_map(|effect| match effect {
        skein_domain::exchange::Effect::Mavlink(message) => decode(&message),
        _ => None,
    });
    messages.collect()
}

#[test]
fn asked_again_until_patience_ends() {
    let (mut requests, mut effects) = (Requests::default(), Effects::default());
    assert!(requests.ask(7_u32, &zoom()));
    let mut times = Vec::new();
    let mut outcome = Vec::new();
    for tenth in 0..60 {
        outcome.extend(requests.work(at(f64::from(tenth) * 0.1), PATIENCE, &mut effects));
        times.extend(sent(&mut effects).iter().map(|c| (tenth, c.confirmation)));
    }
    assert_eq!(times, [(0, 0), (10, 1), (20, 2)]);
    let [(7, Err(Refusal::TimedOut { after_s, .. }))] = outcome.as_slice() else {
        panic!("{outcome:?}");
    };
    assert!((after_s - 3.0).abs() < 1e-6);
}

#[test]
fn one_after_the_other() {
    let (mut requests, mut effects) = (Requests::default(), Effects::default());
    let two = [MavCmd::MAV_CMD_SET_CAMERA_ZOOM, MavCmd::MAV_CMD_SET_CAMERA_MODE];
    for (tag, which) in two.into_iter().enumerate() {
        assert!(requests.ask(tag, &command(which, 100)));
    }
    assert!(requests.work(at(0.0), PATIENCE, &mut effects).is_empty());
    assert_eq!(sent(&mut effects).len(), 1);
    // The second was not sent yet: an acknowledgement of it is not ours.
    assert_eq!(
        requests.heard(at(0.1), &ack(two[1], MavResult::MAV_RESULT_ACCEPTED, 100, (0, 0))),
        None
    );
    let first = requests.heard(at(0.1), &ack(two[0], MavResult::MAV_RESULT_ACCEPTED, 100, (0, 0)));
    assert_eq!(first, Some((0, Ok(()))));
    assert!(requests.work(at(0.1), PATIENCE, &mut effects).is_empty());
    assert_eq!(sent(&mut effects)[0].command, two[1]);
}

#[test]
fn what_answers_somebody_else_is_not_believed() {
    let (mut requests, mut effects) = (Requests::default(), Effects::default());
    let accepted = |from, to| ack(zoom().command, MavResult::MAV_RESULT_ACCEPTED, from, to);
    assert!(requests.ask(1_u8, &zoom()));
    assert!(requests.work(at(0.0), PATIENCE, &mut effects).is_empty());
    assert_eq!(
        requests.heard(at(0.1), &accepted(101, (245, 190))),
        None,
        "another component"
    );
    assert_eq!(requests.heard(at(0.1), &accepted(100, (245, 190))), Some((1, Ok(()))));
    assert_eq!(requests.own(), Some((245, 190)));
    assert!(requests.ask(2, &zoom()));
    assert!(requests.work(at(0.2), PATIENCE, &mut effects).is_empty());
    assert_eq!(
        requests.heard(at(0.3), &accepted(100, (255, 190))),
        None,
        "another ground station"
    );
    assert_eq!(requests.heard(at(0.3), &accepted(100, (245, 190))), Some((2, Ok(()))));
}

#[test]
fn progress_gives_more_time() {
    let (mut requests, mut effects) = (Requests::default(), Effects::default());
    assert!(requests.ask(1_u8, &zoom()));
    assert!(requests.work(at(0.0), PATIENCE, &mut effects).is_empty());
    let progress = ack(zoom().command, MavResult::MAV_RESULT_IN_PROGRESS, 100, (0, 0));
    assert_eq!(requests.heard(at(0.5), &progress), None);
    sent(&mut effects);
    assert!(requests.work(at(9.0), PATIENCE, &mut effects).is_empty());
    assert!(sent(&mut effects).is_empty(), "it is not asked again");
    assert_eq!(requests.work(at(11.0), PATIENCE, &mut effects).len(), 1);
}

#[test]
fn refusals_are_typed() {
    for (result, code) in [
        (MavResult::MAV_RESULT_DENIED, "autopilot"),
        (MavResult::MAV_RESULT_UNSUPPORTED, "not_supported"),
        (MavResult::MAV_RESULT_NOT_IN_CONTROL, "not_permitted"),
    ] {
        let (mut requests, mut effects) = (Requests::default(), Effects::default());
        assert!(requests.ask((), &zoom()));
        assert!(requests.work(at(0.0), PATIENCE, &mut effects).is_empty());
        let outcome = requests.heard(at(0.1), &ack(zoom().command, result, 100, (0, 0)));
        assert_eq!(outcome.map(|(_, o)| o.unwrap_err().code()), Some(code));
    }
}

#[test]
fn text_ends_at_the_first_zero() {
    assert_eq!(text(b" Skein\0\0x"), "Skein");
    assert_eq!(text(b"full"), "full");
    assert_eq!(text(&[0xff, 0]), "\u{fffd}");
}

proptest! {
    #[test]
    fn any_bytes_can_be_heard(id in prop::sample::select(vec![77_u32, 0, 259]), payload in prop::collection::vec(any::<u8>(), 0..300)) {
        let (mut requests, mut effects) = (Requests::default(), Effects::default());
        requests.ask(0_u8, &zoom());
        let _ = requests.work(at(0.0), PATIENCE, &mut effects);
        let _ = requests.heard(at(0.1), &MavlinkMessage { system_id: 1, component_id: 100, message_id: id, payload });
    }

    #[test]
    fn a_snapshot_goes_on(asked in 0_u8..5, now_s in 0.0..5.0_f64) {
        let (mut requests, mut effects) = (Requests::default(), Effects::default());
        for tag in 0..asked {
            requests.ask(tag, &zoom());
        }
        let _ = requests.work(at(now_s), PATIENCE, &mut effects);
        let bytes = minicbor::to_vec(&requests).unwrap();
        let again: Requests<u8> = minicbor::decode(&bytes).unwrap();
        prop_assert_eq!(&again, &requests);
        prop_assert_eq!(minicbor::to_vec(&again).unwrap(), bytes);
    }
}
