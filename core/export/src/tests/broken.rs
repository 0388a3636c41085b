//! Recordings that something is wrong with: each fault is named, and nothing ends the program.

use super::flight::Flight;
use super::{findings, folder, open, recorded};
use crate::{Format, Overview, cut, export, merge, redecide};
use proptest::prelude::*;
use skein_domain::NodeTime;
use skein_recording::Select;
use skein_recording::{
    Audit, AuditChain, AuditRecord, Encoded, FORMAT, Header, RecorderState, Recording, TimeBase, Topic, Writer,
};
use std::path::{Path, PathBuf};

#[test]
fn a_file_that_was_cut_off_is_told_as_that() {
    let (_folder, path) = recorded(Flight {
        finishes: false,
        ..Flight::default()
    });
    let recording = open(&path);
    let found = findings(std::slice::from_ref(&recording));
    assert!(
        found.len() == 1 && found[0].contains("the program ended while it was written"),
        "{found:?}"
    );
    assert_eq!(Overview::of(&recording).vehicles, [1, 2, 3]);
}

#[test]
fn a_gap_is_told_with_its_place() {
    let (_folder, path) = recorded(Flight {
        gap_at: Some(7),
        ..Flight::default()
    });
    let found = findings(&[open(&path)]);
    assert!(
        found.len() == 1 && found[0].contains("at 6.9 s: nothing was recorded for 1.1 s"),
        "{found:?}"
    );
}

#[test]
fn a_count_that_is_not_what_the_file_holds_is_told() {
    let (_folder, path) = recorded(Flight::default());
    let mut bytes = std::fs::read(&path).expect("is read");
    // MCAP: the footer (a u64, a u64 and a u32) stands before eight octets of magic, and says first where the summary begins.
    let number = |bytes: &[u8], at: usize| {
        let eight = bytes[at..at + 8].try_into().expect("eight octets");
        usize::try_from(u64::from_le_bytes(eight)).expect("fits")
    };
    let mut at = number(&bytes, bytes.len() - 28);
    while bytes[at] != mcap::records::op::STATISTICS {
        at += 9 + number(&bytes, at + 1);
    }
    // Its map of counts comes last: of the first channel the number, then the count.
    let count = at + 9 + 46 + 2;
    bytes[count] = bytes[count].wrapping_add(1);
    std::fs::write(&path, &bytes).expect("is written");
    let found = findings(&[open(&path)]);
    assert!(found.len() == 1 && found[0].contains("its summary says"), "{found:?}");
    // A summary without counts says nothing that could be wrong: here the record is of a kind that only its writer knows.
    bytes[at] = 0x80;
    std::fs::write(&path, &bytes).expect("is written");
    assert_eq!(findings(&[open(&path)]), Vec::<String>::new());
}

#[test]
fn on_the_ground_there_is_less_to_record() {
    let folder = folder();
    let message = |_| (Topic::Clock, b"{}".to_vec());
    let path = of_messages_every(folder.path(), &[0, 1, 2].map(message), 2_000_000);
    assert_eq!(findings(&[open(&path)]), Vec::<String>::new());
    let folder = tempfile::tempdir().expect("a folder");
    let path = of_messages_every(folder.path(), &[0, 1, 2].map(message), 3_000_000);
    assert_eq!(findings(&[open(&path)]).len(), 2);
}

/// A recording of these messages, a tenth of a second apart.
fn of_messages(folder: &Path, messages: &[(Topic, Vec<u8>)]) -> PathBuf {
    of_messages_every(folder, messages, 100_000)
}

fn of_messages_every(folder: &Path, messages: &[(Topic, Vec<u8>)], period_us: u64) -> PathBuf {
    let path = folder.join("made.mcap");
    let header = Header {
        format: FORMAT,
        version: "0.1.0".into(),
        node: None,
        name: "alone".into(),
        swarm: String::new(),
        base: TimeBase {
            node: NodeTime(0),
            unix_ns: 1_000_000_000,
        },
    };
    let mut writer = Writer::create(&path, header).expect("begins");
    for (number, (topic, bytes)) in (0_u64..).zip(messages) {
        let at = NodeTime(number * period_us);
        let message = Encoded {
            topic: topic.clone(),
            at,
            bytes: bytes.clone(),
        };
        writer.write(&message, at).expect("takes it");
    }
    writer.finish().expect("ends");
    path
}

fn audits(change: impl FnOnce(&mut Vec<AuditRecord>)) -> Vec<(Topic, Vec<u8>)> {
    let mut chain = AuditChain::default();
    let mut records: Vec<AuditRecord> = (0..5)
        .map(|n| {
            chain.add(Audit {
                time: NodeTime(n),
                who: "Ada".into(),
                ..Audit::default()
            })
        })
        .collect();
    change(&mut records);
    let bytes = |record| serde_json::to_vec(record).expect("encodes");
    records.iter().map(|record| (Topic::Audit, bytes(record))).collect()
}

#[test]
fn the_first_broken_record_of_an_audit_is_named() {
    let told = |messages: &[(Topic, Vec<u8>)]| {
        let folder = folder();
        findings(&[open(&of_messages(folder.path(), messages))])
    };
    assert_eq!(told(&audits(|_| {})), Vec::<String>::new());
    let found = told(&audits(|records| records[2].audit.who = "Eve".into()));
    assert!(
        found.len() == 1 && found[0].contains("audit record 2 was changed"),
        "{found:?}"
    );
    let found = told(&audits(|records| {
        records.remove(1);
    }));
    assert!(
        found.len() == 1 && found[0].contains("audit record 2 does not follow"),
        "{found:?}"
    );
    let found = told(&[(Topic::Audit, b"{}".to_vec()), (Topic::Audit, b"[".to_vec())]);
    assert!(found.len() == 1 && found[0].contains("cannot be read"), "{found:?}");
}

#[test]
fn what_the_recorder_dropped_is_told() {
    let state = |dropped| {
        let state = RecorderState {
            dropped,
            ..RecorderState::default()
        };
        (Topic::Recorder, serde_json::to_vec(&state).expect("encodes"))
    };
    let folder = folder();
    let found = findings(&[open(&of_messages(folder.path(), &[state(4), state(4), state(11)]))]);
    assert!(
        found.len() == 1 && found[0].contains("7 messages were dropped"),
        "{found:?}"
    );
}

#[test]
fn messages_that_are_not_what_their_topic_says_are_counted() {
    let folder = folder();
    let path = of_messages(
        folder.path(),
        &[
            (Topic::Events, b"{}".to_vec()),
            (Topic::Telemetry(skein_domain::VehicleId(1)), b"\xff".to_vec()),
        ],
    );
    let refused = export(&open(&path), Format::Csv, &folder.path().join("tables"), &mut |_| {});
    assert!(refused.is_err_and(|error| error.to_string().contains("holds no telemetry")));
    assert_eq!(Overview::with_events(&open(&path)).events["unreadable"], 1);
}

/// Everything that can be made of a file.
fn make_all(path: &Path, folder: &Path) {
    let Ok(recording) = Recording::open(path) else {
        return;
    };
    let _ = Overview::with_events(&recording);
    let _ = findings(std::slice::from_ref(&recording));
    let _ = redecide(&recording, &mut |_| {});
    for format in [
        Format::Csv,
        Format::Parquet,
        Format::Kml,
        Format::Gpx,
        Format::Rosbag,
        Format::Tlog,
    ] {
        let _ = export(&recording, format, &folder.join(format!("{format:?}")), &mut |_| {});
    }
    let part = folder.join("part.mcap");
    if cut(&recording, 0.0, 1e9, &part, &mut |_| {}).is_ok_and(|written| written.messages > 0) {
        assert!(Recording::open(&part).is_ok());
    }
    let _ = merge(
        std::slice::from_ref(&recording),
        &folder.join("merged.mcap"),
        &mut |_| {},
    );
}

/// A short flight, and what its messages say.
fn short() -> (tempfile::TempDir, PathBuf, Vec<(Topic, Vec<u8>)>) {
    let (folder, path) = recorded(Flight {
        seconds: 2,
        ..Flight::default()
    });
    let recording = open(&path);
    let messages = recording.messages(Select::default()).filter_map(Result::ok);
    let messages = messages
        .filter_map(|message| Some((message.topic?, message.bytes)))
        .collect();
    (folder, path, messages)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn no_damage_of_a_file_ends_the_program(
        hits in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12),
        keep in 0.0f64..1.3,
    ) {
        let (folder, path, _) = short();
        let mut bytes = std::fs::read(&path).expect("is there");
        for (at, value) in hits {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        bytes.truncate((bytes.len() as f64 * keep) as usize);
        std::fs::write(&path, bytes).expect("is written");
        make_all(&path, folder.path());
    }

    #[test]
    fn no_number_in_a_message_ends_the_program(
        which in any::<prop::sample::Index>(),
        digit in any::<prop::sample::Index>(),
        number in prop::sample::select(vec!["-1", "1e300", "18446744073709551615", "0", "null", "-1e-300", "9007199254740993"]),
    ) {
        let (folder, _, mut messages) = short();
        let which = which.index(messages.len());
        let (_, bytes) = &mut messages[which];
        let text = String::from_utf8(bytes.clone()).expect("is text");
        // One number of it becomes another.
        let is_number = |c: char| c.is_ascii_digit() || "+-.e".contains(c);
        let starts: Vec<usize> = text.match_indices(':').map(|(at, _)| at + 1)
            .filter(|at| text[*at..].starts_with(|c: char| c.is_ascii_digit() || c == '-')).collect();
        let at = starts[digit.index(starts.len())];
        let end = text[at..].find(|c| !is_number(c)).map_or(text.len(), |length| at + length);
        *bytes = format!("{}{number}{}", &text[..at], &text[end..]).into_bytes();
        let path = of_messages(folder.path(), &messages);
        make_all(&path, folder.path());
    }
}
