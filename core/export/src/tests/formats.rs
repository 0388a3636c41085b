//! What is written in others' formats, as far as libraries at hand read it; their own programs read it in `tests/interop`.

use super::flight::{BEGIN_UNIX_NS, Flight, ORIGIN, position};
use super::{open, recorded};
use crate::{Exported, Format, export};
use mavlink::dialects::common::MavMessage;
use mavlink::{MavlinkVersion, Message as _};
use parquet::file::reader::{FileReader, SerializedFileReader};
use quick_xml::events::Event;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

fn written(format: Format) -> (TempDir, PathBuf, Exported) {
    let (folder, path) = recorded(Flight::default());
    let out = folder.path().join("out");
    let exported = export(&open(&path), format, &out, &mut |_| {}).expect("is written");
    assert_eq!((exported.unreadable, exported.damage.len()), (0, 0));
    (folder, out, exported)
}

#[test]
fn tables_have_a_row_for_each_message() {
    let (_folder, out, exported) = written(Format::Csv);
    let expected = [("events", 20), ("setpoints", 600), ("telemetry", 600)];
    let expected: BTreeMap<String, u64> = expected.map(|(name, count)| (name.to_owned(), count)).into();
    assert_eq!(exported.counts, expected);
    let mut reader = csv::Reader::from_path(out.join("telemetry.csv")).expect("opens");
    let names = reader.headers().expect("names").clone();
    let rows: Vec<_> = reader.records().collect::<Result<_, _>>().expect("rows");
    assert_eq!(rows.len(), 600);
    let value = |row: usize, name: &str| {
        let column = names.iter().position(|known| known == name).expect(name);
        rows[row].get(column).expect("a cell").to_owned()
    };
    let at = position(2, 0.0);
    assert_eq!(value(1, "time_utc"), "2026-11-28T10:00:00.000000Z");
    assert_eq!(
        (value(1, "vehicle").as_str(), value(1, "battery_remaining").as_str()),
        ("2", "0.8")
    );
    assert_eq!(value(1, "north_m").parse(), Ok(at.north_m));
    assert_eq!(
        (value(1, "armed").as_str(), value(1, "mode").as_str()),
        ("true", "offboard")
    );
    assert_eq!(value(1, "link_round_trip_s"), "");
    let mut events = csv::Reader::from_path(out.join("events.csv")).expect("opens");
    let texts: Vec<String> = events.records().map(|row| row.expect("a row")[7].to_owned()).collect();
    assert!(texts[3].contains("in second 3: <a> \"quoted\" text"), "{}", texts[3]);
}

#[test]
fn tables_by_column_hold_the_same() {
    let (_folder, out, _) = written(Format::Parquet);
    let file = std::fs::File::open(out.join("telemetry.parquet")).expect("opens");
    let reader = SerializedFileReader::new(file).expect("is Parquet");
    assert_eq!(reader.metadata().file_metadata().num_rows(), 600);
    let row = reader
        .get_row_iter(None)
        .expect("rows")
        .nth(1)
        .expect("a row")
        .expect("is read");
    let columns: BTreeMap<_, _> = row
        .get_column_iter()
        .map(|(name, value)| (name.as_str(), value.to_string()))
        .collect();
    assert_eq!(columns["north_m"].parse(), Ok(position(2, 0.0).north_m));
    assert_eq!(
        (columns["link_round_trip_s"].as_str(), columns["vehicle"].as_str()),
        ("null", "2")
    );
}

/// Elements of an XML file with their text, in order.
fn elements(path: &Path) -> Vec<(String, String)> {
    let text = std::fs::read_to_string(path).expect("is text");
    let mut reader = quick_xml::Reader::from_str(&text);
    let (mut open, mut all): (Vec<String>, Vec<(String, String)>) = (Vec::new(), Vec::new());
    loop {
        match reader.read_event().expect("is XML") {
            Event::Start(start) => {
                let name = start.name().as_ref().to_owned();
                open.push(name.clone());
                all.push((name, String::new()));
            }
            Event::Text(text) if !open.is_empty() => {
                if let Some((_, last)) = all.last_mut() {
                    last.push_str(&text);
                }
            }
            Event::End(end) => {
                let name = open.pop().expect("was begun");
                assert_eq!(end.name().as_ref(), name);
            }
            Event::Eof => break,
            _ => {}
        }
    }
    assert!(open.is_empty());
    all
}

fn count(elements: &[(String, String)], name: &str) -> usize {
    elements.iter().filter(|(known, _)| known == name).count()
}

#[test]
fn tracks_are_xml_with_a_point_for_each_place() {
    let (_folder, out, exported) = written(Format::Gpx);
    assert_eq!(exported.counts["vehicle 3"], 200);
    let gpx = elements(&out);
    assert_eq!(
        (count(&gpx, "trk"), count(&gpx, "trkpt"), count(&gpx, "time")),
        (3, 600, 601)
    );
    let height = gpx
        .iter()
        .find(|(name, _)| name == "ele")
        .map(|(_, text)| text.parse::<f64>());
    assert_eq!(height, Some(Ok(ORIGIN.altitude_amsl_m + 10.0)));
    let (_folder, out, _) = written(Format::Kml);
    let kml = elements(&out);
    assert_eq!(
        (count(&kml, "Placemark"), count(&kml, "gx:coord"), count(&kml, "when")),
        (3, 600, 600)
    );
    assert!(kml.iter().any(|(name, text)| name == "name" && text == "uav-2"));
}

#[test]
fn a_bag_has_its_topics_with_schemas() {
    let (_folder, out, exported) = written(Format::Rosbag);
    assert_eq!(
        (
            exported.counts["/skein/uav_1/pose"],
            exported.counts["/tf"],
            exported.counts["/rosout"]
        ),
        (200, 200, 20)
    );
    let metadata = std::fs::read_to_string(out.join("metadata.yaml")).expect("is there");
    let total: u64 = exported.counts.values().sum();
    assert!(metadata.contains(&format!("  message_count: {total}\n")), "{metadata}");
    let bytes = std::fs::read(out.join("out_0.mcap")).expect("is there");
    let mut read = 0;
    for message in mcap::MessageStream::new(&bytes).expect("is MCAP") {
        let message = message.expect("is whole");
        let schema = message.channel.schema.clone().expect("a schema");
        assert_eq!(
            (schema.encoding.as_str(), message.channel.message_encoding.as_str()),
            ("ros2msg", "cdr")
        );
        assert!(!schema.data.is_empty(), "{}", schema.name);
        assert_eq!(&message.data[..4], [0, 1, 0, 0]);
        read += 1;
    }
    assert_eq!(read, total);
}

#[test]
fn logs_are_frames_with_their_times() {
    let (_folder, out, exported) = written(Format::Tlog);
    let bytes = std::fs::read(out.join("vehicle-2.tlog")).expect("is there");
    let (mut rest, mut kinds, mut frames) = (bytes.as_slice(), BTreeMap::<&str, u32>::new(), 0);
    while let Some((time, after)) = rest.split_first_chunk::<8>() {
        let time_us = u64::from_be_bytes(*time);
        let begin_us = BEGIN_UNIX_NS / 1_000;
        assert!((begin_us..begin_us + 20_000_000).contains(&time_us));
        // Magic, length, two of flags, sequence, system, component, three of the message's number; a checksum of two at the end.
        let &[0xFD, length, 0, 0, sequence, 2, 1, low, middle, 0, ..] = after else {
            panic!("no frame of this vehicle: {:?}", after.get(..10));
        };
        assert_eq!(sequence, (frames % 256) as u8);
        let end = 12 + usize::from(length);
        let number = u32::from(low) | u32::from(middle) << 8;
        let message = MavMessage::parse(MavlinkVersion::V2, number, &after[10..end - 2]).expect("is known");
        *kinds.entry(message.message_name()).or_default() += 1;
        rest = &after[end..];
        frames += 1;
    }
    assert_eq!(rest, [0_u8; 0]);
    assert_eq!(frames, exported.counts["vehicle 2"]);
    for (kind, count) in [
        ("ATTITUDE", 200),
        ("LOCAL_POSITION_NED", 200),
        ("GLOBAL_POSITION_INT", 200),
        ("POSITION_TARGET_LOCAL_NED", 200),
        ("HEARTBEAT", 20),
        ("SYS_STATUS", 20),
        ("GPS_RAW_INT", 20),
        // Five events of two frames.
        ("STATUSTEXT", 10),
    ] {
        assert_eq!(kinds[kind], count, "{kind}: {kinds:?}");
    }
}
