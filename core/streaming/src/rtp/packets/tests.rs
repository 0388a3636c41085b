//! What a receiver puts together is what was sent, in packets that the network carries whole.

use super::*;
use skein_video::{Coding, h264};
use str0m::format::CodecExtra;
use str0m::unversioned::{Depacketizer, H264Depacketizer};

/// A picture of NAL units of these types and lengths.
fn picture(taken_us: u64, units: &[(u8, usize)]) -> EncodedFrame {
    let mut bytes = Vec::new();
    for (kind, len) in units {
        bytes.extend(h264::START_CODE);
        // Never two zeros in a row, which a NAL unit does not have either.
        bytes.extend((0..*len).map(|at| if at == 0 { 0x60 | kind } else { (at % 251) as u8 | 1 }));
    }
    EncodedFrame {
        coding: Coding::H264,
        sequence: 0,
        taken: NodeTime(taken_us),
        width_px: 640,
        height_px: 480,
        key: true,
        bytes: bytes.into(),
    }
}

struct Header {
    marker: bool,
    sequence: u16,
    timestamp: u32,
    source: u32,
}

fn header(packet: &[u8]) -> Header {
    let number = |at: usize| u32::from_be_bytes(packet[at..at + 4].try_into().unwrap());
    assert_eq!((packet[0], packet[1] & 0x7f), (0x80, 96), "version 2, payload type 96");
    Header {
        marker: packet[1] & 0x80 != 0,
        sequence: u16::from_be_bytes([packet[2], packet[3]]),
        timestamp: number(4),
        source: number(8),
    }
}

fn received(packets: &[Vec<u8>]) -> Vec<Vec<u8>> {
    let (mut depacketizer, mut bytes) = (H264Depacketizer::default(), Vec::new());
    for packet in packets {
        depacketizer
            .depacketize(&packet[HEADER_BYTES..], &mut bytes, &mut CodecExtra::None)
            .unwrap();
    }
    h264::units(&bytes).into_iter().map(|unit| unit.bytes).collect()
}

#[test]
fn whatever_its_size_a_picture_arrives_as_it_was_sent() {
    let mut packets = Packets::new(7);
    let room = LONGEST_BYTES - HEADER_BYTES;
    for len in [
        2,
        100,
        room - 1,
        room,
        room + 1,
        2 * room - 4,
        2 * room - 3,
        2 * room,
        70_000,
    ] {
        let frame = picture(1, &[(7, 12), (8, 5), (6, 40), (5, len)]);
        let sent = packets.of(&frame);
        assert!(sent.iter().all(|packet| packet.len() <= LONGEST_BYTES), "{len}");
        let units: Vec<Vec<u8>> = h264::units(&frame.bytes).into_iter().map(|unit| unit.bytes).collect();
        // Parameter sets go together, before the slice.
        let mut arrived = received(&sent);
        arrived.sort();
        let mut expected = units;
        expected.sort();
        assert!(arrived == expected, "{len}");
    }
}

#[test]
fn headers_count_on_and_tell_pictures_apart() {
    let mut packets = Packets::new(0xdead_beef);
    packets.sequence = u16::MAX - 1;
    let first = packets.of(&picture(1_000_000, &[(5, 3_000)]));
    let second = packets.of(&picture(1_100_000, &[(1, 10)]));
    let headers: Vec<Header> = first.iter().chain(&second).map(|packet| header(packet)).collect();
    let of = |field: fn(&Header) -> u32| headers.iter().map(field).collect::<Vec<u32>>();
    assert_eq!(of(|header| header.sequence.into()), [65_534, 65_535, 0, 1]);
    assert_eq!(of(|header| header.marker.into()), [0, 0, 1, 1]);
    assert_eq!(of(|header| header.timestamp), [90_000, 90_000, 90_000, 99_000]);
    assert!(headers.iter().all(|header| header.source == 0xdead_beef));
}

#[test]
fn after_weeks_the_timestamp_wraps_and_goes_on() {
    let days_30_us = 30 * 86_400 * 1_000_000_u64;
    let (one, next) = (
        timestamp(NodeTime(days_30_us)),
        timestamp(NodeTime(days_30_us + 40_000)),
    );
    assert_eq!(next.wrapping_sub(one), 3_600);
}

#[test]
fn no_moment_is_too_late() {
    assert_eq!(timestamp(NodeTime(10)), 0);
    assert_eq!(timestamp(NodeTime(1_000_000)), 90_000);
    // 2^64 - 1 µs are more units than 32 bits hold: they wrap around
    assert_eq!(
        timestamp(NodeTime(u64::MAX)),
        ((u128::from(u64::MAX) * 9 / 100) % (1 << 32)) as u32
    );
}
