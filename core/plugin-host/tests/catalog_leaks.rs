//! Many versions of a library, alone in their process: its open files and what it leaves in the temporary directory can be counted.

#[path = "host/orders.rs"]
mod orders;

use orders::{count_of, library};
use skein_plugin_host::{Catalog, Trust};
use std::time::{Duration, Instant};

/// A name that no other test in the same temporary directory uses, so that its copies can be counted.
fn file_name() -> String {
    format!("libcam-{}.so", std::process::id())
}

/// Private copies in the temporary directory.
fn copies() -> usize {
    let (name, entries) = (file_name(), std::fs::read_dir(std::env::temp_dir()).expect("is there"));
    entries
        .flatten()
        .filter(|entry| entry.path().join(&name).exists())
        .count()
}

#[test]
fn two_hundred_versions_leave_no_file_open() {
    let directory = tempfile::tempdir().expect("a directory");
    let bytes = std::fs::read(library()).expect("is there");
    let path = directory.path().join(file_name());
    let install = |life: u32| {
        let new = [&bytes[..], &life.to_le_bytes()].concat();
        std::fs::write(directory.path().join("new"), new).expect("written");
        std::fs::rename(directory.path().join("new"), &path).expect("renamed");
    };
    install(0);
    let catalog = Catalog::discover(&[directory.path().to_owned()], Trust::default());
    assert!(catalog.remove("test-camera"));
    let (before, threads, copied) = (count_of("/proc/self/fd"), count_of("/proc/self/task"), copies());
    for life in 1..=200 {
        install(life);
        let loaded = catalog.rescan();
        assert_eq!(loaded.len(), 1, "life {life}: {:?}", catalog.problems());
        if life % 10 == 0 {
            assert!(catalog.remove("test-camera"));
        } else {
            assert!(catalog.activate("test-camera", &loaded[0]));
            assert!(catalog.versions("test-camera").len() <= 4, "the oldest are let go");
        }
    }
    assert!(catalog.get("test-camera").is_none());
    assert_eq!((count_of("/proc/self/fd"), copies()), (before, copied));
    let began = Instant::now();
    while count_of("/proc/self/task") > threads {
        assert!(began.elapsed() < Duration::from_secs(60), "a thread is left");
        std::thread::yield_now(); // The last thread that loaded one is about to go.
    }
}
