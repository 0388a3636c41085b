//! Every fixture in both isolations, with the outcome that the table in `README.md` promises for it.

use skein_tests_plugin_boundary::outcome::{Fixture, Place, outcome};
use skein_tests_plugin_boundary::{fixture, fixture_names, fixture_with_other_layouts};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// In a cell: the process it happens in ends, so that it is not run there.
const NOT_CONTAINED: &str = "not contained";
/// So many fixtures there are. Count it up with each new one, and none is lost unseen.
const FIXTURES: usize = 66;
/// How many are tried at once.
const AT_ONCE: usize = 4;

/// Fixtures that are no build of a fixture's package.
const MADE: [&str; 4] = ["made_truncated", "made_not_elf", "made_empty", "made_other_layouts"];

/// A row of the table: the fixture, and how it ends in process and in a child.
struct Row {
    name: String,
    in_process: String,
    child: String,
}

fn table() -> Vec<Row> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md");
    let text = std::fs::read_to_string(path).expect("is there");
    let cells = |line: &str| -> Vec<String> { line.split('|').map(|cell| cell.trim().to_owned()).collect() };
    let rows = text.lines().filter(|line| line.starts_with("| `")).map(cells);
    // The other table has a cell less.
    rows.filter(|cells| cells.len() == 5)
        .map(|cells| Row {
            name: cells[1].trim_matches('`').to_owned(),
            in_process: cells[2].clone(),
            child: cells[3].clone(),
        })
        .collect()
}

fn fixtures() -> Vec<Fixture> {
    let libraries = fixture_names();
    let built = libraries
        .iter()
        .flat_map(|library| Fixture::all_of(library, &fixture(library)));
    let made = MADE.iter().map(|name| Fixture {
        library: (*name).to_owned(),
        way: None,
    });
    built.chain(made).collect()
}

/// The library of a fixture; those that no build makes are made here, in a folder of the test.
fn library(name: &str, folder: &Path) -> PathBuf {
    let good = || std::fs::read(fixture("nothing_wrong")).expect("is there");
    let bytes = match name {
        "made_truncated" => {
            let good = good();
            good[..good.len() / 2].to_vec()
        }
        "made_not_elf" => b"#!/bin/sh\necho no library\n".to_vec(),
        "made_empty" => Vec::new(),
        "made_other_layouts" => {
            static BUILT: OnceLock<PathBuf> = OnceLock::new();
            return BUILT.get_or_init(fixture_with_other_layouts).clone();
        }
        built => return fixture(built),
    };
    let path = folder.join(format!("lib{name}.so"));
    if !path.exists() {
        std::fs::write(&path, bytes).expect("can be written");
    }
    path
}

#[test]
fn the_table_names_every_fixture_and_no_other() {
    let mut named: Vec<_> = table().into_iter().map(|row| row.name).collect();
    let mut found: Vec<_> = fixtures().iter().map(Fixture::name).collect();
    named.sort();
    found.sort();
    assert_eq!(named, found);
    assert_eq!(found.len(), FIXTURES);
}

#[test]
fn every_fixture_ends_as_the_table_says() {
    let fixtures = fixtures();
    let mut tries = Vec::new();
    for row in table() {
        let fixture = fixtures
            .iter()
            .find(|fixture| fixture.name() == row.name)
            .expect("is there");
        for (place, expected) in [(Place::InProcess, &row.in_process), (Place::Child, &row.child)] {
            if expected != NOT_CONTAINED {
                tries.push((fixture, place, expected.clone()));
            }
        }
    }
    let folder = tempfile::tempdir().expect("can be made");
    // Built before the others are tried, and once.
    library("made_other_layouts", folder.path());
    let queue = parking_lot::Mutex::new(tries.into_iter());
    let wrong = parking_lot::Mutex::new(Vec::new());
    let work = || {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .expect("starts");
        let next = || queue.lock().next();
        while let Some((one, place, expected)) = next() {
            let path = library(&one.library, folder.path());
            let host = Path::new(env!("CARGO_BIN_EXE_boundary-host"));
            let found = runtime.block_on(outcome(&path, one, place, host));
            if found != expected {
                let line = format!("{} {place:?}: {found:?}, the table says {expected:?}", one.name());
                wrong.lock().push(line);
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..AT_ONCE {
            scope.spawn(work);
        }
    });
    let wrong = wrong.into_inner();
    assert!(
        wrong.is_empty(),
        "{} are not as they should be:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}
