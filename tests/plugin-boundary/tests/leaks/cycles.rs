//! A thousand versions of one plugin, each found, made an instance of, exchanged for the next and forgotten: what stays is the libraries, as
//! documented, and nothing else.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use skein_plugin_host::{Catalog, Isolation, Runners, Trust};
use skein_testkit::{eventually, patience};
use skein_tests_plugin_boundary::{create_uav, example_c};
use std::io::Write;
use std::path::Path;
use std::time::Duration;

const CYCLES: usize = 1_000;
/// Versions loaded before the counting begins, so that what is made once is there.
const WARM_UP: usize = 20;

fn open_files() -> usize {
    std::fs::read_dir("/proc/self/fd").unwrap().count()
}

fn threads() -> usize {
    std::fs::read_dir("/proc/self/task").unwrap().count()
}

/// Memory that is this process's own, in KiB. A library's code is mapped from its file and shared.
fn own_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("RssAnon:")).unwrap();
    line.split_ascii_whitespace().nth(1).unwrap().parse().unwrap()
}

/// A version with other bytes: what follows the last section of a library is read by nobody.
fn install(number: usize, original: &[u8], folder: &Path) {
    let beside = folder.join("next");
    let mut file = std::fs::File::create(&beside).unwrap();
    file.write_all(original).unwrap();
    write!(file, "version {number}").unwrap();
    drop(file);
    std::fs::rename(beside, folder.join("libversions.so")).unwrap();
}

#[tokio::test]
async fn a_thousand_versions_leave_their_libraries_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let built = tempfile::tempdir().unwrap();
    // The smallest plugin there is: each version keeps its file on the disk for as long as this process runs.
    let original = std::fs::read(example_c(built.path())).unwrap();
    install(0, &original, folder.path());
    let catalog = Catalog::discover(&[folder.path().to_owned()], Trust::default());
    let name = catalog.plugins().first().unwrap().manifest().name.clone();
    let runners = Runners::new(1, Duration::from_secs(2));
    let mut instance = None;
    let mut before = (0, 0, 0);
    for number in 1..=WARM_UP + CYCLES {
        install(number, &original, folder.path());
        assert_eq!(catalog.rescan().len(), 1, "version {number} is found");
        // After a removal the name is a new one, whose first version is active at once.
        let candidate = catalog.candidate(&name);
        let next = candidate.clone().or_else(|| catalog.get(&name)).unwrap();
        let new = runners
            .create(next.clone(), Isolation::InProcess, create_uav(1, "{}", None))
            .await
            .unwrap();
        new.snapshot().await.unwrap();
        // The former version's instance ends here.
        instance = Some(new);
        if candidate.is_some() {
            assert!(catalog.activate(&name, &next));
        }
        if number % 10 == 0 {
            assert!(catalog.remove(&name));
        }
        if number == WARM_UP {
            before = (open_files(), threads(), own_kib());
        }
    }
    drop(instance);
    let (files, threads_before, kib) = before;
    // The last instance ends on its own thread, and lets go of its version there.
    eventually(patience(), "as many files and threads as before", async || {
        (open_files() <= files && threads() <= threads_before).then_some(())
    })
    .await;
    let per_version_kib = own_kib().saturating_sub(kib) / CYCLES as u64;
    println!(
        "{per_version_kib} KiB of own memory stay per version of a library of {} KiB",
        original.len() / 1024
    );
    assert!(
        per_version_kib <= original.len() as u64 / 1024,
        "{per_version_kib} KiB per version are more than the library itself"
    );
}
