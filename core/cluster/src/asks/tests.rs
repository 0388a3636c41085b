//! What is asked of another node is answered once, or ended.

use super::*;
use skein_domain::{Stick, VehicleId};
use skein_state::asks::ApiRequest;

const THERE: NodeId = NodeId(2);
const HERE: NodeId = NodeId(1);

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

fn request(bytes: usize) -> Ask {
    // nothing that could be packed
    let mut state = 1_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 56) as u8
    };
    let body = (0..bytes).map(|_| next()).collect();
    Ask::Api(ApiRequest {
        method: "POST".into(),
        path: "/api/v1/commands".into(),
        content_type: None,
        console: Some("c0ffee".into()),
        traceparent: None,
        body,
    })
}

fn pieces_of(begun: Option<(u64, Sendable)>) -> Vec<Piece> {
    match begun {
        Some((_, Sendable::Pieces(pieces))) => pieces,
        _ => panic!("it goes in pieces"),
    }
}

#[test]
fn what_is_asked_in_many_pieces_arrives_whole_and_is_answered_once() {
    let (mut here, mut there) = (Asks::default(), Asks::default());
    let (sender, mut answer) = oneshot::channel();
    let pieces = pieces_of(here.begin(THERE, &request(4000), at(2.0), 300, sender));
    assert!(pieces.len() > 3, "{}", pieces.len());
    let mut asked = Vec::new();
    for piece in pieces {
        if let Some(Whole::Asked { from, id, ask }) = there.take(at(0.1), HERE, piece).expect("understood") {
            assert_eq!((from, *ask), (HERE, request(4000)));
            asked.push(id);
        }
    }
    assert_eq!(asked.len(), 1);
    let done = Answer::Done(Ok(()));
    let Ok(Sendable::Pieces(pieces)) = answering(asked[0], &done, 300) else {
        panic!("a short answer goes in pieces");
    };
    // Somebody else's answer to it does not count.
    for from in [NodeId(3), THERE] {
        assert!(answer.try_recv().is_err());
        for piece in pieces.clone() {
            here.take(at(0.2), from, piece).expect("understood");
        }
    }
    assert_eq!(answer.try_recv().expect("answered"), Ok(done));
}

#[test]
fn a_stick_goes_in_one_piece_and_arrives_as_it_was() {
    let (mut here, mut there) = (Asks::default(), Asks::default());
    let (sender, _answer) = oneshot::channel();
    let stick = Stick {
        forward_m_s: 1.5,
        right_m_s: -0.25,
        up_m_s: 0.0,
        yaw_rate_rad_s: 0.1,
    };
    let ask = Ask::Stick {
        vehicle: VehicleId(3),
        stick,
        told: at(7.0),
    };
    let pieces = pieces_of(here.begin(THERE, &ask, at(2.0), 300, sender));
    assert_eq!(pieces.len(), 1);
    let arrived = there.take(at(0.1), HERE, pieces[0].clone()).expect("understood");
    assert!(matches!(arrived, Some(Whole::Asked { ask: there, .. }) if *there == ask));
}

#[test]
fn who_does_not_answer_is_told_of_at_the_latest_when_time_is_over() {
    let mut here = Asks::default();
    let (sender, mut answer) = oneshot::channel();
    assert!(here.begin(THERE, &Ask::Dissolve, at(2.0), 300, sender).is_some());
    here.expire(at(1.9));
    assert!(answer.try_recv().is_err());
    here.expire(at(2.1));
    assert!(matches!(answer.try_recv(), Ok(Err(Refusal::NotRunning { .. }))));
}

#[test]
fn a_piece_without_a_receipt_ends_the_whole_soon() {
    let mut here = Asks::default();
    let (sender, mut answer) = oneshot::channel();
    let pieces = pieces_of(here.begin(THERE, &request(900), at(9.0), 300, sender));
    for (number, piece) in pieces.iter().enumerate() {
        here.carried(THERE, number as u64, piece);
    }
    here.command_ended(at(3.0), THERE, 0, true);
    here.command_ended(at(3.0), THERE, 1, false);
    here.expire(at(4.9));
    assert!(answer.try_recv().is_err(), "it may be there without a receipt");
    here.expire(at(5.1));
    assert!(matches!(answer.try_recv(), Ok(Err(Refusal::NotRunning { .. }))));
}

#[test]
fn what_is_large_goes_whole_and_what_is_too_large_is_said_to_be() {
    let (mut here, mut there) = (Asks::default(), Asks::default());
    let (sender, mut answer) = oneshot::channel();
    let ask = request(1 << 20);
    let Some((id, Sendable::Large(large))) = here.begin(THERE, &ask, at(2.0), 1000, sender) else {
        panic!("it goes whole");
    };
    here.carried_whole(7, id);
    let arrived = there.whole(HERE, large.id, large.is_answer, &large.packed);
    assert!(matches!(arrived, Ok(Whole::Asked { ask: there, .. }) if *there == ask));
    here.whole_ended(THERE, 7, true);
    assert!(answer.try_recv().is_err(), "it is there, and not answered yet");

    let (sender, mut answer) = oneshot::channel();
    let begun = here.begin(THERE, &ask, at(2.0), 1000, sender);
    here.carried_whole(8, begun.expect("it goes").0);
    here.whole_ended(THERE, 8, false);
    assert!(matches!(answer.try_recv(), Ok(Err(Refusal::NotRunning { .. }))));

    let (sender, mut answer) = oneshot::channel();
    assert!(
        here.begin(THERE, &request(parts::LARGEST_BYTES), at(2.0), 1000, sender)
            .is_none()
    );
    let Ok(Err(Refusal::NotPermitted { detail })) = answer.try_recv() else {
        panic!("it is refused at once");
    };
    assert!(detail.contains("too large"), "{detail}");
}
