//! Decoding of an event batch that may come from a newer host: events this SDK has no word for are left out.

use minicbor::Decoder;
use minicbor::decode::Error;
use skein_domain::NodeTime;
use skein_domain::exchange::{Event, EventBatch};

/// Room is made for no more events than this before they are decoded.
const MAX_ROOM: u64 = 32;

/// As the derived decoder, but an event whose number, or a number inside it, is not known is skipped instead of spoiling the batch.
pub(crate) fn event_batch(bytes: &[u8]) -> Result<EventBatch, Error> {
    let mut decoder = Decoder::new(bytes);
    if decoder.array()?.is_some_and(|fields| fields < 2) {
        return Err(Error::message("an event batch has two fields"));
    }
    let now: NodeTime = decoder.decode()?;
    let mut left = decoder
        .array()?
        .ok_or_else(|| Error::message("a list of events has a length"))?;
    // What is announced need not be there.
    let mut events = Vec::with_capacity(left.min(MAX_ROOM) as usize);
    while left > 0 {
        left -= 1;
        let start = decoder.position();
        match decoder.decode::<Event>() {
            Ok(event) => events.push(event),
            Err(error) if error.is_unknown_variant() => {
                decoder.set_position(start);
                decoder.skip()?;
            }
            Err(error) => return Err(error),
        }
    }
    Ok(EventBatch { now, events })
}

#[cfg(test)]
mod tests;
