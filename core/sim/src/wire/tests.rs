//! Frames: several in one datagram, signed ones, and acknowledgements of commands nobody knows.

use super::*;
use mavlink::dialects::common::{HEARTBEAT_DATA, MavType};

fn header() -> MavHeader {
    MavHeader {
        system_id: 9,
        component_id: 3,
        sequence: 5,
    }
}

fn heartbeat() -> Vec<u8> {
    let mut bytes = Vec::new();
    write_frame(
        &mut bytes,
        header(),
        &HEARTBEAT_DATA {
            mavtype: MavType::MAV_TYPE_GCS,
            ..HEARTBEAT_DATA::default()
        },
    );
    bytes
}

fn read(bytes: &[u8]) -> Vec<(Sender, Incoming)> {
    let mut found = Vec::new();
    read_frames(bytes, |sender, message| found.push((sender, message)));
    found
}

#[test]
fn several_frames_in_one_datagram_are_all_found() {
    let mut bytes = heartbeat();
    bytes.extend([0xFD, 0xFE, 1, 2, 3]);
    bytes.extend(heartbeat());
    bytes.extend(&heartbeat()[..9]);
    let sender = Sender {
        system_id: 9,
        component_id: 3,
    };
    let expected = (sender, Incoming::Heartbeat { vehicle_type: 6 });
    assert_eq!(read(&bytes), [expected.clone(), expected]);
}

#[test]
fn a_signed_frame_is_read_and_its_signature_passed_over() {
    let plain = heartbeat();
    let mut signed = plain[..plain.len() - 2].to_vec();
    signed[2] = 1;
    let crc = calculate_crc(&signed[1..], 50);
    signed.extend(crc.to_le_bytes());
    signed.extend([0xFD; 13]);
    signed.extend(heartbeat());
    assert_eq!(read(&signed).len(), 2);
}

#[test]
fn a_frame_that_asks_for_more_than_we_know_is_skipped() {
    let mut bytes = heartbeat();
    bytes[2] = 0x80;
    bytes.extend(heartbeat());
    assert_eq!(read(&bytes).len(), 1);
}

#[test]
fn a_command_that_nobody_knows_is_acknowledged_with_its_number() {
    let mut bytes = Vec::new();
    let to = Sender {
        system_id: 245,
        component_id: 190,
    };
    write_frame(
        &mut bytes,
        header(),
        &Acknowledgement {
            command: 31_999,
            result: 3,
            to,
        },
    );
    assert_eq!(bytes[1], 10);
    assert_eq!(bytes[10..13], [0xFF, 0x7C, 3]);
    assert_eq!(bytes[18..20], [245, 190]);
    let crc = calculate_crc(&bytes[1..20], 143);
    assert_eq!(bytes[20..22], crc.to_le_bytes());
}
