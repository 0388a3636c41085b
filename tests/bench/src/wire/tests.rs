//! What is encoded comes back; what is damaged does not.

use super::*;
use mavlink::dialects::common::{HEARTBEAT_DATA, TIMESYNC_DATA};
use proptest::prelude::*;

fn bytes(message: &MavMessage) -> Vec<u8> {
    Encoder::new(7, AUTOPILOT_COMPONENT).encode(message, <[u8]>::to_vec)
}

proptest! {
    #[test]
    fn a_message_comes_back_and_a_damaged_one_does_not(ts1 in 1_i64.., at in any::<prop::sample::Index>(), flip in 1_u8..) {
        let message = MavMessage::TIMESYNC(TIMESYNC_DATA { ts1, ..TIMESYNC_DATA::default() });
        let mut datagram = bytes(&message);
        let frame = Frame::of(&datagram).unwrap();
        prop_assert_eq!((frame.system_id, frame.component_id, frame.message_id), (7, 1, 111));
        prop_assert_eq!(frame.message(), Some(message));
        // The two flag bytes and the sequence number are under the checksum too.
        let at = at.index(datagram.len());
        datagram[at] ^= flip;
        prop_assert!(Frame::of(&datagram).is_none(), "byte {} damaged unnoticed", at);
    }

    #[test]
    fn any_bytes_are_answered(datagram in prop::collection::vec(any::<u8>(), 0..300)) {
        let mut marked = datagram.clone();
        if let Some(first) = marked.first_mut() {
            *first = MAV_STX_V2;
        }
        prop_assert!(Frame::of(&datagram).is_none() || datagram[0] == MAV_STX_V2);
        let _ = Frame::of(&marked).and_then(|frame| frame.message());
    }
}

#[test]
fn frames_are_counted() {
    let mut encoder = Encoder::new(7, AUTOPILOT_COMPONENT);
    let heartbeat = MavMessage::HEARTBEAT(HEARTBEAT_DATA::default());
    let sequences: Vec<u8> = (0..300).map(|_| encoder.encode(&heartbeat, |bytes| bytes[4])).collect();
    assert_eq!((sequences[0], sequences[255], sequences[256]), (0, 255, 0));
}
