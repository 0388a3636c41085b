//! Any file as a recording: opened, read to its end, checked, cut, merged, its decisions made again, written in every format.

#![no_main]

use libfuzzer_sys::fuzz_target;
use skein_export::{Format, Overview, check, cut, export, merge, redecide};
use skein_recording::Recording;
use std::path::Path;

/// The magic at the beginning of each MCAP file: without it nothing else is looked at.
const MAGIC: &[u8] = b"\x89MCAP0\r\n";
const FORMATS: [Format; 6] = [
    Format::Csv,
    Format::Parquet,
    Format::Kml,
    Format::Gpx,
    Format::Rosbag,
    Format::Tlog,
];

fn read(folder: &Path, path: &Path) {
    let Ok(recording) = Recording::open(path) else {
        return;
    };
    let overview = Overview::with_events(&recording);
    assert!(overview.length_s >= 0.0 && overview.length_s.is_finite());
    for topic in &overview.topics {
        assert!(topic.rate_hz(overview.length_s).is_finite());
    }
    let found = check(std::slice::from_ref(&recording), &mut |_| {});
    assert!(found.findings.iter().all(|finding| !finding.to_string().is_empty()));
    let _ = redecide(&recording, &mut |_| {});
    for (number, format) in FORMATS.into_iter().enumerate() {
        let _ = export(&recording, format, &folder.join(number.to_string()), &mut |_| {});
    }
    let part = folder.join("part.mcap");
    if cut(&recording, 0.0, 1e9, &part, &mut |_| {}).is_ok_and(|written| written.messages > 0) {
        assert!(Recording::open(&part).is_ok_and(|part| part.is_finished()));
    }
    let _ = merge(
        std::slice::from_ref(&recording),
        &folder.join("merged.mcap"),
        &mut |_| {},
    );
}

fuzz_target!(|bytes: &[u8]| {
    let Ok(folder) = tempfile::tempdir() else {
        return;
    };
    let path = folder.path().join("fuzzed.mcap");
    let whole = if bytes.starts_with(MAGIC) {
        bytes.to_vec()
    } else {
        [MAGIC, bytes].concat()
    };
    if std::fs::write(&path, whole).is_ok() {
        read(folder.path(), &path);
    }
});
