//! Payloads that are framed as they are: the same bytes as the library makes, and nothing that cannot be a message.

use super::*;
use crate::frame::each_in_datagram;
use crate::metrics::EndpointCounters;
use mavlink::dialects::common::{GIMBAL_MANAGER_SET_PITCHYAW_DATA, MavMessage};
use mavlink::{MavlinkVersion, Message};
use proptest::prelude::*;

fn drained(outbox: &mut Outbox) -> Vec<u8> {
    let mut bytes = Vec::new();
    outbox.drain(|frame| bytes.extend_from_slice(frame));
    bytes
}

#[test]
fn every_message_of_the_protocol_description_is_framed_as_the_library_does() {
    for id in MavMessage::all_ids() {
        let message = MavMessage::default_message_from_id(*id).unwrap();
        let mut payload = [0; 255];
        let len = message.ser(MavlinkVersion::V2, &mut payload);
        let mut raw = MAVLinkV2MessageRaw::new();
        let mut outbox = Outbox::new(245, 190);
        raw.serialize_message(outbox.header, &message);
        // Zeroes that were not cut off are.
        let longest = payload_len(*id).unwrap();
        assert!(len <= longest, "{id}");
        outbox.push_payload(*id, &payload[..longest]).unwrap();
        assert_eq!(drained(&mut outbox), raw.raw_bytes(), "{id}");
    }
}

#[test]
fn lengths_count_extensions() {
    for (id, len) in [(0, 9), (77, 10), (109, 9), (285, 49), (287, 23), (323, 147), (259, 237)] {
        assert_eq!(payload_len(id), Some(len), "{id}");
    }
}

#[test]
fn what_cannot_be_a_message_is_refused_and_leaves_nothing_behind() {
    let mut outbox = Outbox::new(245, 190);
    let unknown = outbox.push_payload(16_000_000, &[1]);
    assert!(matches!(unknown, Err(Refusal::NotSupported { .. })), "{unknown:?}");
    let long = outbox.push_payload(287, &[1; 24]);
    assert!(matches!(long, Err(Refusal::InvalidValue { .. })), "{long:?}");
    assert!(outbox.is_empty());
    outbox.push(&GIMBAL_MANAGER_SET_PITCHYAW_DATA::default());
    outbox.push_payload(287, &[]).unwrap();
    let mut sequences = Vec::new();
    let bytes = drained(&mut outbox);
    each_in_datagram(&bytes, &mut EndpointCounters::default(), |_, frame| {
        sequences.push(frame.header.sequence);
    });
    assert_eq!(sequences, [0, 1], "one count for all that is sent");
}

proptest! {
    #[test]
    fn whatever_is_framed_is_read_again(at in 0..MavMessage::all_ids().len(), bytes in prop::collection::vec(any::<u8>(), 0..=255)) {
        let id = MavMessage::all_ids()[at];
        let mut outbox = Outbox::new(245, 190);
        let framed = outbox.push_payload(id, &bytes);
        prop_assert_eq!(framed.is_ok(), bytes.len() <= payload_len(id).unwrap());
        if framed.is_err() {
            return Ok(());
        }
        let (mut counters, mut read) = (EndpointCounters::default(), Vec::new());
        each_in_datagram(&drained(&mut outbox), &mut counters, |_, frame| {
            read.push((frame.header.message_id, frame.known, frame.payload.to_vec()));
        });
        let [(read_id, true, payload)] = read.as_slice() else {
            return Err(TestCaseError::fail(format!("{read:?}")));
        };
        prop_assert_eq!(*read_id, id);
        prop_assert!(bytes.starts_with(payload) || payload.as_slice() == [0]);
        prop_assert!(bytes.iter().skip(payload.len()).all(|byte| *byte == 0));
    }
}
