//! Whether the lengths that stand in a record are within it. The library makes room for a text before it looks whether there is as much: a broken length asks
//! for 4 GB.
//!
//! Must never do: judge anything but lengths.

use mcap::records::op;

/// A field of a record.
enum Field {
    /// So many octets.
    Octets(usize),
    /// A length and so many octets.
    Text,
    /// A length in octets, and in them pairs of texts.
    Pairs,
}

use Field::{Octets, Pairs, Text};

/// The fields of records with lengths in them, as the MCAP specification has them; of others none.
fn fields(opcode: u8) -> &'static [Field] {
    match opcode {
        op::HEADER => &[Text, Text],
        op::SCHEMA => &[Octets(2), Text, Text, Text],
        op::CHANNEL => &[Octets(4), Text, Text, Pairs],
        op::CHUNK => &[Octets(28), Text],
        op::MESSAGE_INDEX => &[Octets(2), Text],
        op::CHUNK_INDEX => &[Octets(32), Text, Octets(8), Text],
        op::ATTACHMENT => &[Octets(16), Text, Text],
        op::ATTACHMENT_INDEX => &[Octets(40), Text, Text],
        op::STATISTICS => &[Octets(42), Text],
        op::METADATA => &[Text, Pairs],
        op::METADATA_INDEX => &[Octets(16), Text],
        _ => &[],
    }
}

/// Whether all of them are within the record.
pub(crate) fn fit(opcode: u8, body: &[u8]) -> bool {
    let mut rest = body;
    fields(opcode).iter().all(|field| {
        let taken = match field {
            Octets(count) => take(&mut rest, *count),
            Text => text(&mut rest),
            Pairs => text(&mut rest).filter(|pairs| are_pairs(pairs)),
        };
        taken.is_some()
    })
}

fn are_pairs(mut pairs: &[u8]) -> bool {
    while !pairs.is_empty() {
        if text(&mut pairs).is_none() || text(&mut pairs).is_none() {
            return false;
        }
    }
    true
}

fn text<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let length = take(rest, 4)?.try_into().ok().map(u32::from_le_bytes)?;
    take(rest, usize::try_from(length).ok()?)
}

fn take<'a>(rest: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
    let (taken, left) = rest.split_at_checked(count)?;
    *rest = left;
    Some(taken)
}

#[cfg(test)]
mod tests {
    use super::fit;
    use mcap::records::op;

    #[test]
    fn a_length_beyond_its_record_is_found() {
        let header = [&2_u32.to_le_bytes()[..], b"ab", &1_u32.to_le_bytes(), b"c"].concat();
        assert!(fit(op::HEADER, &header));
        let broken = [&2_u32.to_le_bytes()[..], b"ab", &3_183_328_523_u32.to_le_bytes(), b"c"].concat();
        assert!(!fit(op::HEADER, &broken));
        assert!(!fit(op::HEADER, &header[..3]));
        let pairs = [&10_u32.to_le_bytes()[..], &header[..6], &u32::MAX.to_le_bytes()].concat();
        assert!(!fit(op::METADATA, &[&header[..6], &pairs[..]].concat()));
        assert!(fit(op::DATA_END, &[]));
    }
}
