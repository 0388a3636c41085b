//! Recorded flights of a real PX4: 8 bytes of time (big-endian, microseconds), then one frame, over and over.

use flate2::read::GzDecoder;
use skein_domain::NodeTime;
use std::io::Read;
use std::path::Path;

/// One frame of a recording.
pub struct Recorded {
    /// Seconds since the recording began.
    pub time_s: f64,
    /// The frame.
    pub bytes: Vec<u8>,
}

impl Recorded {
    pub fn now(&self) -> NodeTime {
        // Node time is never zero where something has happened.
        NodeTime::from_seconds(100.0 + self.time_s)
    }

    pub fn system_id(&self) -> u8 {
        self.bytes[5]
    }

    pub fn message_id(&self) -> u32 {
        u32::from_le_bytes([self.bytes[7], self.bytes[8], self.bytes[9], 0])
    }

    pub fn payload(&self) -> &[u8] {
        &self.bytes[10..10 + usize::from(self.bytes[1])]
    }
}

/// Reads a recording from `tests/data`.
pub fn read(name: &str) -> Vec<Recorded> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data")
        .join(format!("{name}.tlog.gz"));
    let mut bytes = Vec::new();
    GzDecoder::new(std::fs::File::open(&path).unwrap())
        .read_to_end(&mut bytes)
        .unwrap();
    let mut frames = Vec::new();
    let mut rest = bytes.as_slice();
    let mut began = None;
    while rest.len() > 8 {
        let (stamp, behind) = rest.split_at(8);
        let stamp = u64::from_be_bytes(stamp.try_into().unwrap());
        assert_eq!(behind[0], 0xFD, "{name}: MAVLink 2 throughout");
        let signature = if behind[2] & 1 == 1 { 13 } else { 0 };
        let (frame, behind) = behind.split_at(12 + usize::from(behind[1]) + signature);
        let began = *began.get_or_insert(stamp);
        frames.push(Recorded {
            time_s: (stamp - began) as f64 * 1e-6,
            bytes: frame.to_vec(),
        });
        rest = behind;
    }
    assert!(rest.is_empty(), "{name}: a whole number of frames");
    frames
}
