//! Versions of real libraries in a directory: found, activated, rolled back, removed, and judged whole or not at all.

#[path = "host/orders.rs"]
mod orders;

use orders::{camera, create, library, runners};
use skein_plugin_host::{Catalog, Isolation, LoadError, Plugin, Trust};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// The library with this at its end: another file that does the same.
fn version(tail: &str) -> Vec<u8> {
    let mut bytes = std::fs::read(library()).expect("is there");
    bytes.extend(tail.as_bytes());
    bytes
}

/// Exchanges a file in one step, as an installer should.
fn install(directory: &Path, name: &str, bytes: &[u8]) {
    let beside = directory.join(format!("{name}.new"));
    std::fs::write(&beside, bytes).expect("written");
    std::fs::rename(&beside, directory.join(name)).expect("renamed");
}

fn is(plugin: Option<Arc<Plugin>>, expected: &Arc<Plugin>) -> bool {
    plugin.is_some_and(|plugin| Arc::ptr_eq(&plugin, expected))
}

#[tokio::test]
async fn versions_come_go_and_come_back() {
    let directory = tempfile::tempdir().expect("a directory");
    let catalog = Catalog::discover(&[directory.path().to_owned()], Trust::default());
    assert!(catalog.plugins().is_empty() && catalog.rescan().is_empty());

    install(directory.path(), "libcam.so", &version("1"));
    let one = catalog.rescan().pop().expect("is found");
    assert!(is(catalog.get("test-camera"), &one), "the first is active at once");
    assert!(catalog.rescan().is_empty(), "it has not changed");
    assert!(catalog.candidate("test-camera").is_none() && catalog.previous("test-camera").is_none());

    install(directory.path(), "libcam.so", &version("2"));
    let two = catalog.rescan().pop().expect("is found");
    assert_ne!(one.sha256(), two.sha256());
    assert!(is(catalog.get("test-camera"), &one) && is(catalog.candidate("test-camera"), &two));
    assert_eq!(catalog.versions("test-camera").len(), 2);

    // Both run beside each other.
    let runners = runners(Duration::from_secs(10));
    let older = runners
        .create(Arc::clone(&one), Isolation::InProcess, create("{}", Some(b"state")))
        .await;
    let snapshot = older.expect("is created").snapshot().await.expect("answers");
    let newer = runners
        .create(Arc::clone(&two), Isolation::InProcess, create("{}", Some(&snapshot)))
        .await;
    assert_eq!(
        newer.expect("is created").snapshot().await.as_deref(),
        Ok(b"state".as_slice())
    );

    assert!(catalog.activate("test-camera", &two));
    assert!(is(catalog.get("test-camera"), &two) && is(catalog.previous("test-camera"), &one));
    assert!(catalog.candidate("test-camera").is_none());
    assert!(catalog.activate("test-camera", &one), "rolled back");
    assert!(is(catalog.get("test-camera"), &one) && is(catalog.candidate("test-camera"), &two));
    assert!(!catalog.activate("test-camera", &camera()), "a stranger");
    assert!(!catalog.activate("nobody", &one));

    // The old file comes back: nothing is loaded again.
    catalog.activate("test-camera", &two);
    install(directory.path(), "libcam.so", &version("1"));
    assert!(catalog.rescan().is_empty());
    assert!(is(catalog.candidate("test-camera"), &one));

    assert!(catalog.remove("test-camera") && !catalog.remove("test-camera"));
    assert!(catalog.get("test-camera").is_none() && catalog.versions("test-camera").is_empty());
    assert!(catalog.rescan().is_empty(), "its file has not changed");
    install(directory.path(), "libcam.so", &version("3"));
    assert_eq!(catalog.rescan().len(), 1);
    assert_eq!(catalog.plugins().len(), 1);
}

#[test]
fn of_two_files_at_the_beginning_the_first_counts_and_a_later_one_is_a_candidate() {
    let directory = tempfile::tempdir().expect("a directory");
    install(directory.path(), "liba.so", &version("a"));
    install(directory.path(), "libb.so", &version("b"));
    let catalog = Catalog::discover(&[directory.path().to_owned()], Trust::default());
    let problems = catalog.problems();
    assert!(
        matches!(&problems[..], [p] if matches!(&p.error, LoadError::DuplicateName { first, .. } if first.ends_with("liba.so")))
    );
    install(directory.path(), "libc.so", &version("c"));
    assert_eq!(catalog.rescan().len(), 1);
    assert_eq!(catalog.plugins().len(), 1);
    let candidate = catalog.candidate("test-camera").expect("is one");
    assert!(candidate.path().ends_with("libc.so"));
    assert_eq!(catalog.problems().len(), 1, "the one of the beginning is still there");
}

#[test]
fn problems_last_until_their_cause_is_gone() {
    use std::os::unix::fs::PermissionsExt;
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path().join("libcam.so");
    let set_mode = |mode| std::fs::set_permissions(&path, std::fs::Permissions::from_mode(mode)).expect("mode is set");
    install(directory.path(), "libcam.so", &version("1"));
    set_mode(0o646);
    let catalog = Catalog::discover(&[directory.path().to_owned()], Trust::default());
    assert!(matches!(
        catalog.problems()[0].error,
        LoadError::WritableByOthers { .. }
    ));
    set_mode(0o644);
    assert_eq!(catalog.rescan().len(), 1);
    assert!(catalog.problems().is_empty());
    // Cut off while it is exchanged in place: the version that is loaded stays, the file is named.
    let whole = std::fs::read(&path).expect("is there");
    std::fs::write(&path, &whole[..whole.len() / 2]).expect("written");
    assert!(catalog.rescan().is_empty());
    assert!(matches!(catalog.problems()[0].error, LoadError::NotLoadable { .. }));
    assert!(catalog.get("test-camera").is_some());
    std::fs::remove_file(&path).expect("is removed");
    assert!(catalog.rescan().is_empty() && catalog.problems().is_empty());
    assert!(catalog.get("test-camera").is_some());
}

#[test]
fn only_what_is_trusted_is_loaded() {
    let directory = tempfile::tempdir().expect("a directory");
    install(directory.path(), "libcam.so", &version("1"));
    let digest = camera().sha256().to_owned();
    let trust = Trust {
        allow_sha256: vec![digest],
        minisign_public_key: None,
    };
    let catalog = Catalog::discover(&[directory.path().to_owned()], trust);
    assert!(catalog.plugins().is_empty());
    assert!(matches!(catalog.problems()[0].error, LoadError::NotTrusted { .. }));
    install(directory.path(), "libcam.so", &version(""));
    assert_eq!(catalog.rescan().len(), 1);
}

#[test]
fn a_file_that_is_written_to_is_taken_whole_or_not_at_all() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path().join("libcam.so");
    let versions = [version("1"), version("2")];
    let digests = versions.each_ref().map(|bytes| {
        std::fs::write(&path, bytes).expect("written");
        Plugin::load(&path).expect("is whole").sha256().to_owned()
    });
    let (stop, stopped) = std::sync::mpsc::channel::<()>();
    let write_to = path.clone();
    let writer = std::thread::spawn(move || {
        let mut turn = 0;
        while stopped.try_recv() == Err(std::sync::mpsc::TryRecvError::Empty) {
            std::fs::write(&write_to, &versions[turn % 2]).expect("written in place");
            turn += 1;
        }
    });
    let mut refused = 0;
    for _ in 0..100 {
        match Plugin::load(&path) {
            Ok(plugin) => assert!(
                digests.iter().any(|digest| digest == plugin.sha256()),
                "a mixture was loaded"
            ),
            Err(LoadError::ChangedWhileRead | LoadError::NotLoadable { .. } | LoadError::MissingSymbol) => refused += 1,
            Err(error) => panic!("{error:?}"),
        }
    }
    drop(stop);
    writer.join().expect("ends");
    assert!(refused > 0, "nothing was ever written meanwhile");
}
