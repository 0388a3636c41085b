//! The snapshot: the flight state with a version in front.

use crate::flight::Flight;
use minicbor::{Decoder, Encoder};

/// Changes when an older snapshot would be misunderstood. Fields that are only added keep it.
pub(crate) const SNAPSHOT_VERSION: u32 = 1;

/// The bytes of a flight state.
pub(crate) fn encode(flight: &Flight) -> Vec<u8> {
    let mut encoder = Encoder::new(Vec::new());
    let encoded = encoder
        .array(2)
        .and_then(|e| e.u32(SNAPSHOT_VERSION))
        .and_then(|e| e.encode(flight))
        .is_ok();
    // Writing into a vector does not fail; if it did, no snapshot would be better than half of one.
    if encoded { encoder.into_writer() } else { Vec::new() }
}

/// The flight state in these bytes, or why there is none.
pub(crate) fn decode(bytes: &[u8]) -> Result<Flight, String> {
    let mut decoder = Decoder::new(bytes);
    let version = decoder
        .array()
        .and_then(|_| decoder.u32())
        .map_err(|e| format!("no version: {e}"))?;
    if version != SNAPSHOT_VERSION {
        return Err(format!("version {version}, not {SNAPSHOT_VERSION}"));
    }
    decoder.decode().map_err(|e| format!("not decodable: {e}"))
}
