//! Couriers over a network that loses, doubles and turns around.

use super::*;
use proptest::prelude::*;

const SENDER: Session = Session(11);
const RECEIVER: Session = Session(22);

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

fn pair() -> (Outbox, Inbox) {
    let settings = CourierSettings::default();
    (Outbox::new(settings, SENDER, NodeId(2)), Inbox::new(settings, RECEIVER))
}

#[test]
fn what_arrives_out_of_order_is_delivered_in_order() {
    let (mut outbox, mut inbox) = pair();
    for body in [b"a", b"b", b"c"] {
        outbox.post(at(0.0), body.to_vec()).unwrap();
    }
    let mut parcels = outbox.due(at(0.0));
    parcels.reverse();
    let delivered: Vec<Vec<u8>> = parcels.into_iter().flat_map(|parcel| inbox.take(parcel).unwrap().0).collect();
    assert_eq!(delivered, [b"a".to_vec(), b"b".to_vec(), b"c".to_vec()]);
}

#[test]
fn a_sender_that_was_started_again_is_heard_and_its_former_run_is_not() {
    let (mut outbox, mut inbox) = pair();
    outbox.post(at(0.0), b"old".to_vec()).unwrap();
    let old = outbox.due(at(0.0)).remove(0);
    let mut again = Outbox::new(CourierSettings::default(), Session(12), NodeId(2));
    again.post(at(1.0), b"new".to_vec()).unwrap();
    let (first, _) = inbox.take(old.clone()).unwrap();
    let (second, _) = inbox.take(again.due(at(1.0)).remove(0)).unwrap();
    assert_eq!((first, second), (vec![b"old".to_vec()], vec![b"new".to_vec()]));
    assert_eq!(inbox.take(old), None);
}

#[test]
fn a_command_for_a_receivers_former_run_is_not_delivered_to_its_next() {
    let (mut outbox, mut inbox) = pair();
    outbox.post(at(0.0), b"a".to_vec()).unwrap();
    let (_, receipt) = inbox.take(outbox.due(at(0.0)).remove(0)).unwrap();
    assert_eq!(outbox.receipt(&receipt), [(1, Outcome::Delivered)]);
    outbox.post(at(1.0), b"b".to_vec()).unwrap();
    let mut again = Inbox::new(CourierSettings::default(), Session(23));
    let (delivered, receipt) = again.take(outbox.due(at(1.0)).remove(0)).unwrap();
    assert!(delivered.is_empty());
    assert_eq!(outbox.receipt(&receipt), [(2, Outcome::NotAnswered)]);
    outbox.post(at(2.0), b"c".to_vec()).unwrap();
    let (delivered, _) = again.take(outbox.due(at(2.0)).remove(0)).unwrap();
    assert_eq!(delivered, [b"c".to_vec()]);
}

#[test]
fn who_does_not_answer_is_not_asked_without_end() {
    let (mut outbox, _) = pair();
    let settings = CourierSettings::default();
    for _ in 0..settings.most_under_way {
        outbox.post(at(0.0), Vec::new()).unwrap();
    }
    let crowded = outbox.post(at(0.0), Vec::new()).unwrap_err();
    assert_eq!(crowded.under_way, settings.most_under_way);
    assert!(outbox.expire(at(settings.give_up_after_s - 0.1)).is_empty());
    assert_eq!(outbox.expire(at(settings.give_up_after_s)).len(), settings.most_under_way);
    assert!(outbox.post(at(4.0), Vec::new()).is_ok());
}

proptest! {
    /// Each is delivered at most once and in order, whatever the network does; what is called delivered was; in the end all have ended.
    #[test]
    fn delivered_once_and_in_order(fates in prop::collection::vec((0_u8..4, 0_u8..6), 200..400), commands in 1_u64..40) {
        let (mut outbox, mut inbox) = pair();
        let (mut now_s, mut posted) = (0.0, 0);
        let mut ended: BTreeMap<u64, Outcome> = BTreeMap::new();
        let mut delivered: Vec<u64> = Vec::new();
        let (mut there, mut back): (Vec<Parcel>, Vec<Receipt>) = (Vec::new(), Vec::new());
        for (kind, choice) in fates {
            now_s += 0.03;
            if posted < commands && kind == 0 {
                posted += 1;
                outbox.post(at(now_s), posted.to_le_bytes().to_vec()).unwrap();
            }
            there.extend(outbox.due(at(now_s)));
            // One of what is under way arrives and stays, to arrive again; some are lost.
            let place = usize::from(choice) % there.len().max(1);
            if let Some(parcel) = there.get(place).cloned() {
                if let Some((bodies, receipt)) = inbox.take(parcel) {
                    delivered.extend(bodies.iter().map(|body| u64::from_le_bytes(body[..].try_into().unwrap())));
                    back.push(receipt);
                }
                if kind != 1 { there.remove(place); }
            }
            if kind == 2 { there.pop(); }
            if kind == 3 { back.pop(); }
            let place = usize::from(choice) % back.len().max(1);
            if let Some(receipt) = back.get(place).copied() {
                ended.extend(outbox.receipt(&receipt));
            }
            ended.extend(outbox.expire(at(now_s)));
        }
        ended.extend(outbox.expire(at(now_s + 10.0)));
        prop_assert!(delivered.windows(2).all(|pair| pair[0] < pair[1]), "{delivered:?}");
        prop_assert_eq!(ended.len() as u64, posted);
        for (number, outcome) in ended {
            prop_assert!(outcome != Outcome::Delivered || delivered.contains(&number), "{number}");
        }
    }
}
