//! What is repeated is what the participant said of itself, and nothing else.

use super::{Prefix, Said, caller, said};
use proptest::prelude::{any, proptest};
use std::net::{Ipv4Addr, SocketAddrV4};

const NAME: Prefix = *b"participant!";
const OTHER: Prefix = *b"another one.";

fn call() -> Vec<u8> {
    caller(&NAME, SocketAddrV4::new(Ipv4Addr::LOCALHOST, 12_345), 7)
}

/// A submessage, lowest octet first.
fn submessage(kind: u8, flags: u8, body: &[u8]) -> Vec<u8> {
    let length = u16::try_from(body.len()).unwrap().to_le_bytes();
    [&[kind, flags | 1][..], &length[..], body].concat()
}

/// A call with something before its one submessage.
fn with_before(before: &[u8]) -> Vec<u8> {
    let call = call();
    [&call[..20], before, &call[20..]].concat()
}

#[test]
fn an_announcement_is_repeated_word_for_word() {
    let stamp = submessage(0x09, 0, &[1, 2, 3, 4, 5, 6, 7, 8]);
    for words in [call(), with_before(&stamp)] {
        assert_eq!(said(&words, &NAME), Some(Said::Here(words.clone())));
        assert_eq!(said(&words, &OTHER), None);
    }
}

#[test]
fn whom_it_was_for_is_left_out() {
    let destination = submessage(0x0e, 0, &OTHER);
    let invalid_stamp = submessage(0x09, 2, &[]);
    let words = with_before(&[destination, invalid_stamp.clone()].concat());
    assert_eq!(said(&words, &NAME), Some(Said::Here(with_before(&invalid_stamp))));
}

#[test]
fn what_another_one_says_is_not_repeated() {
    let source = submessage(0x0c, 0, &[&[0; 8][..], &OTHER[..]].concat());
    assert_eq!(said(&with_before(&source), &NAME), None);
}

#[test]
fn a_participant_that_goes_is_noticed() {
    let mut gone = call();
    // A key instead of data.
    gone[21] = 0x01 | 0x08;
    assert_eq!(said(&gone, &NAME), Some(Said::Gone));
}

#[test]
fn samples_of_other_topics_are_left_out() {
    let mut other = call();
    // The writer of another topic.
    other[20 + 4 + 11] = 0xc3;
    assert_eq!(said(&other, &NAME), None);
    let both = [&other[..], &call()[20..]].concat();
    assert_eq!(said(&both, &NAME), Some(Said::Here(call())));
}

#[test]
fn the_last_submessage_may_leave_its_length_out() {
    let mut words = call();
    words[22..24].copy_from_slice(&[0, 0]);
    assert_eq!(said(&words, &NAME), Some(Said::Here(words.clone())));
}

proptest! {
    #[test]
    fn anything_may_come(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let _ = said(&bytes, &NAME);
        let ours = [b"RTPS\x02\x03\0\0", &NAME[..], &bytes[..]].concat();
        if let Some(Said::Here(words)) = said(&ours, &NAME) {
            assert!(words.len() <= ours.len());
            assert_eq!(said(&words, &NAME), Some(Said::Here(words.clone())));
        }
    }

    #[test]
    fn what_is_cut_short_or_changed_does_no_harm(at in 0..148_usize, to in any::<u8>()) {
        let call = call();
        let cut = said(&call[..at.min(call.len() - 1)], &NAME);
        assert!(!matches!(&cut, Some(Said::Here(_))), "{cut:?}");
        let mut changed = call.clone();
        let at = at % call.len();
        changed[at] = to;
        if let Some(Said::Here(words)) = said(&changed, &NAME) {
            assert!(words.len() <= changed.len());
        }
    }
}
