//! Every recorded frame decodes or is known to be unknown; none is misread.

use crate::log;
use mavlink::dialects::common::MavMessage;
use mavlink::{MavlinkVersion, Message};
use skein_link_mavlink::EndpointCounters;
use skein_link_mavlink::frame::{StreamBuffer, each_in_datagram};
use std::collections::BTreeSet;

const RECORDINGS: [(&str, usize); 4] = [
    ("plain-flight", 32_364),
    ("refusals-flight", 33_074),
    ("setpoint-loss-flight", 32_518),
    ("three-vehicles-one-port", 83_750),
];

/// Messages outside of the `common` dialect that a PX4 of that time sends.
const UNKNOWN: [u32; 9] = [8, 290, 291, 380, 410, 411, 436, 441, 514];

#[test]
fn every_frame_is_found_and_read_as_it_was_meant() {
    let mut unknown = BTreeSet::new();
    for (name, count) in RECORDINGS {
        let frames = log::read(name);
        assert_eq!(frames.len(), count, "{name}");
        let mut counters = EndpointCounters::default();
        for frame in &frames {
            let mut found = 0;
            each_in_datagram(&frame.bytes, &mut counters, |_, got| {
                found += 1;
                assert_eq!(got.header.system_id, frame.system_id());
                assert_eq!(got.header.message_id, frame.message_id());
                assert_eq!(got.payload, frame.payload());
                if got.known {
                    let message = MavMessage::parse(MavlinkVersion::V2, got.header.message_id, got.payload);
                    match message {
                        Ok(message) => assert_written_back(&message, got.payload),
                        Err(error) => assert!(is_unknown_command(frame), "{name} {:?}: {error}", got.header),
                    }
                } else {
                    unknown.insert(got.header.message_id);
                }
            });
            assert_eq!(found, 1, "{name}");
        }
        let faults = [counters.bad_crc, counters.truncated, counters.stray_bytes];
        assert_eq!(faults, [0, 0, 0], "{name}");
        assert_eq!(counters.frames_in, count as u64);
    }
    assert!(unknown.iter().all(|id| UNKNOWN.contains(id)), "{unknown:?}");
}

/// A field read from the wrong place would not come back to where it was.
fn assert_written_back(message: &MavMessage, payload: &[u8]) {
    let mut written = [0; 255];
    let len = message.ser(MavlinkVersion::V2, &mut written);
    let significant = |bytes: &[u8]| bytes.iter().rposition(|&b| b != 0).map_or(0, |last| last + 1);
    assert_eq!(
        &written[..significant(&written[..len])],
        &payload[..significant(payload)],
        "{message:?}"
    );
}

/// Command 31999 does not exist; it was asked for to see the answer. The link reads commands and answers by number.
fn is_unknown_command(frame: &log::Recorded) -> bool {
    let number_at = match frame.message_id() {
        76 => 28,
        77 => 0,
        _ => return false,
    };
    frame.payload()[number_at..number_at + 2] == 31_999_u16.to_le_bytes()
}

#[test]
fn a_stream_cut_anywhere_gives_the_same_frames() {
    let frames = log::read("setpoint-loss-flight");
    let whole: Vec<u8> = frames.iter().flat_map(|frame| frame.bytes.iter().copied()).collect();
    for cut in [1, 7, 64, 1000, 4096] {
        let mut counters = EndpointCounters::default();
        let mut buffer = StreamBuffer::default();
        let mut found = 0;
        let mut rest = whole.as_slice();
        while !rest.is_empty() {
            let count = cut.min(rest.len()).min(buffer.space().len());
            buffer.space()[..count].copy_from_slice(&rest[..count]);
            rest = &rest[count..];
            buffer.advance(count, &mut counters, |_, got| {
                let expected = &frames[found];
                assert_eq!(
                    (got.header.message_id, got.payload),
                    (expected.message_id(), expected.payload())
                );
                found += 1;
            });
        }
        assert_eq!(found, frames.len(), "cut every {cut} bytes");
        assert_eq!((counters.bad_crc, counters.stray_bytes), (0, 0));
    }
}
