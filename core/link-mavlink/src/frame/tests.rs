//! Whole, cut, damaged and meaningless bytes: what is whole is found, nothing else is, and nothing panics.

use super::*;
use mavlink::dialects::common::{ATTITUDE_DATA, LOCAL_POSITION_NED_DATA, STATUSTEXT_DATA};
use mavlink::{MAVLinkV1MessageRaw, MAVLinkV2MessageRaw, MavHeader, MessageData};
use proptest::prelude::*;

fn v2<D: MessageData>(sequence: u8, message: &D) -> Vec<u8> {
    let mut raw = MAVLinkV2MessageRaw::new();
    raw.serialize_message_data(
        MavHeader {
            system_id: 7,
            component_id: 1,
            sequence,
        },
        message,
    );
    raw.raw_bytes().to_vec()
}

fn v1<D: MessageData>(sequence: u8, message: &D) -> Vec<u8> {
    let mut raw = MAVLinkV1MessageRaw::new();
    raw.serialize_message_data(
        MavHeader {
            system_id: 7,
            component_id: 1,
            sequence,
        },
        message,
    );
    raw.raw_bytes().to_vec()
}

fn attitude(yaw: f32) -> ATTITUDE_DATA {
    ATTITUDE_DATA {
        time_boot_ms: 77,
        yaw,
        yawspeed: 1.0,
        ..ATTITUDE_DATA::default()
    }
}

/// Sequence numbers and message ids found in a datagram, and the counters.
fn found(bytes: &[u8]) -> (Vec<(u8, u32)>, EndpointCounters) {
    let mut counters = EndpointCounters::default();
    let mut found = Vec::new();
    each_in_datagram(bytes, &mut counters, |_, frame| {
        found.push((frame.header.sequence, frame.header.message_id))
    });
    (found, counters)
}

/// A frame of a message that is not in the dialect.
fn unknown(sequence: u8) -> Vec<u8> {
    let mut frame = vec![MAV_STX_V2, 3, 0, 0, sequence, 7, 1];
    frame.extend([0x39, 0x30, 0x05]);
    frame.extend([MAV_STX_V2, MAV_STX, 0x55, 0xAA, 0xBB]);
    frame
}

#[test]
fn several_frames_of_both_versions_in_one_datagram() {
    let bytes = [
        v2(1, &attitude(1.0)),
        v1(2, &attitude(2.0)),
        unknown(3),
        v2(4, &attitude(3.0)),
    ]
    .concat();
    let (found, counters) = found(&bytes);
    assert_eq!(found, [(1, 30), (2, 30), (3, 0x05_3039), (4, 30)]);
    assert_eq!((counters.frames_in, counters.unknown, counters.bad_crc), (4, 1, 0));
    assert_eq!((counters.stray_bytes, counters.truncated), (0, 0));
}

#[test]
fn a_signed_frame_is_read_and_other_flags_are_not_guessed_at() {
    let mut signed = v2(1, &attitude(1.0));
    signed[2] = FLAG_SIGNED;
    let end = signed.len() - CHECKSUM_BYTES;
    let crc = calculate_crc(&signed[1..end], ATTITUDE_DATA::EXTRA_CRC);
    signed[end..].copy_from_slice(&crc.to_le_bytes());
    signed.extend([9; SIGNATURE_BYTES]);
    let mut wide = v2(2, &attitude(1.0));
    wide[2] = 0x02;
    let (found, counters) = found(&[signed, wide, v2(3, &attitude(1.0))].concat());
    assert_eq!(found, [(1, 30), (3, 30)]);
    assert_eq!(counters.truncated, 0);
}

#[test]
fn one_damaged_frame_costs_one_frame() {
    let good = v2(2, &attitude(2.0));
    for byte in 0..good.len() {
        let mut damaged = v2(1, &attitude(1.0));
        damaged[byte] ^= 0x10;
        let (found, counters) = found(&[damaged, good.clone()].concat());
        assert_eq!(found.last(), Some(&(2, 30)), "byte {byte}: {found:?} {counters:?}");
        assert!(counters.bad_crc <= 1, "byte {byte}: {counters:?}");
        // An unknown id cannot be checked; everything else is either told or not taken for a frame.
        assert!(found.len() == 1 || counters.unknown == 1, "byte {byte}: {found:?}");
    }
}

#[test]
fn a_cut_frame_is_counted_and_hides_nothing() {
    let whole = v2(1, &attitude(1.0));
    for len in 1..whole.len() {
        let (found, counters) = found(&whole[..len]);
        assert!(found.is_empty() && counters.truncated == 1, "{len}");
    }
    // The length byte promises more than there is; the next frame is inside of what it promises.
    let mut lying = v2(1, &attitude(1.0));
    lying[1] = 255;
    let (found, counters) = found(&[lying, v2(2, &attitude(2.0))].concat());
    assert_eq!((found, counters.truncated), (vec![(2, 30)], 1));
}

#[test]
fn a_stream_resynchronises_behind_noise() {
    let text = STATUSTEXT_DATA {
        text: "a longer text, so that there is much to cut".into(),
        ..STATUSTEXT_DATA::default()
    };
    let mut bytes = vec![0, 1, MAV_STX, 2, MAV_STX_V2, 200, 3];
    bytes.extend(v2(1, &text));
    bytes.extend([MAV_STX_V2; 40]);
    for sequence in 2..40 {
        bytes.extend(v2(sequence, &attitude(1.0)));
    }
    let mut buffer = StreamBuffer::default();
    let mut counters = EndpointCounters::default();
    let mut found = Vec::new();
    for piece in bytes.chunks(11) {
        buffer.space()[..piece.len()].copy_from_slice(piece);
        buffer.advance(piece.len(), &mut counters, |_, frame| found.push(frame.header.sequence));
    }
    assert_eq!(found.first(), Some(&1));
    assert!(found.ends_with(&(20..40).collect::<Vec<u8>>()), "{found:?}");
}

proptest! {
    #[test]
    fn any_bytes_do_no_harm(bytes in prop::collection::vec(any::<u8>(), 0..MAX_DATAGRAM_BYTES)) {
        let (found, counters) = found(&bytes);
        prop_assert_eq!(found.len() as u64, counters.frames_in);
    }

    /// Bytes with many markers in them try the most.
    #[test]
    fn bytes_full_of_markers_do_no_harm(bytes in prop::collection::vec(prop::sample::select(vec![0xFD_u8, 0xFE, 0, 9, 30]), 0..600)) {
        let mut buffer = StreamBuffer::default();
        let mut counters = EndpointCounters::default();
        for piece in bytes.chunks(97) {
            buffer.space()[..piece.len()].copy_from_slice(piece);
            buffer.advance(piece.len(), &mut counters, |_, _| ());
            prop_assert!(!buffer.space().is_empty());
        }
        found(&bytes);
    }

    /// Whatever stands around it, a whole frame is found; however a stream is cut, the same frames come out of it.
    #[test]
    fn whole_frames_are_found_among_noise(
        noise in prop::collection::vec(prop::collection::vec(0_u8..0xFD, 0..20), 1..12),
        cut in 1_usize..60,
    ) {
        let local = LOCAL_POSITION_NED_DATA { x: 1.5, vz: -2.0, ..LOCAL_POSITION_NED_DATA::default() };
        let mut bytes = Vec::new();
        for (i, noise) in noise.iter().enumerate() {
            bytes.extend_from_slice(noise);
            bytes.extend(v2(i as u8, &local));
        }
        let (whole, _) = found(&bytes);
        prop_assert_eq!(whole.len(), noise.len());
        let mut buffer = StreamBuffer::default();
        let mut counters = EndpointCounters::default();
        let mut pieces = Vec::new();
        for piece in bytes.chunks(cut) {
            buffer.space()[..piece.len()].copy_from_slice(piece);
            buffer.advance(piece.len(), &mut counters, |_, f| pieces.push((f.header.sequence, f.header.message_id)));
        }
        prop_assert_eq!(pieces, whole);
    }
}
