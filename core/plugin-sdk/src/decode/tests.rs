//! Batches of this version, of a newer one, and broken ones.

use super::*;
use minicbor::Encoder;
use skein_domain::exchange::OwnState;
use skein_domain::{CommandId, VehicleCommand};

fn batch() -> EventBatch {
    let command = VehicleCommand::TakeOff { height_m: 5.0 };
    let events = vec![
        Event::Own(OwnState::default()),
        Event::Command {
            id: CommandId(3),
            command,
            not_before: NodeTime(4),
        },
        Event::Tick,
    ];
    EventBatch {
        now: NodeTime(9),
        events,
    }
}

#[test]
fn the_same_as_the_derived_decoder() {
    for batch in [batch(), EventBatch::default()] {
        let bytes = minicbor::to_vec(&batch).expect("encodes");
        assert_eq!(event_batch(&bytes).expect("decodes"), batch);
    }
}

#[test]
fn events_of_a_newer_host_are_left_out() {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes);
    encoder
        .array(3)
        .expect("encodes")
        .u64(9)
        .expect("encodes")
        .array(4)
        .expect("encodes");
    for event in batch().events {
        encoder.encode(&event).expect("encodes");
        if matches!(event, Event::Own(_)) {
            // Event 9999 with a map in it.
            encoder
                .array(2)
                .expect("encodes")
                .u32(9999)
                .expect("encodes")
                .map(1)
                .expect("encodes");
            encoder.str("new").expect("encodes").f64(1.5).expect("encodes");
        }
    }
    encoder.str("a new field").expect("encodes");
    assert_eq!(event_batch(&bytes).expect("decodes"), batch());
}

#[test]
fn broken_bytes_are_an_error_and_no_panic() {
    let bytes = minicbor::to_vec(batch()).expect("encodes");
    for cut in 0..bytes.len() {
        assert!(event_batch(&bytes[..cut]).is_err(), "cut at {cut}");
    }
    // A list that announces more than there is does not make room for it.
    assert!(event_batch(&[0x82, 0x00, 0x9b, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff]).is_err());
}
