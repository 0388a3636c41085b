//! Directories without a usable plugin; the ones with plugins are the boundary tests' matter.

use super::*;
use std::os::unix::fs::PermissionsExt;

#[test]
fn whatever_is_wrong_is_kept_and_named() {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::write(directory.path().join("libgarbage.so"), b"not a library").expect("written");
    std::fs::write(directory.path().join("README.md"), b"not looked at").expect("written");
    std::fs::create_dir(directory.path().join("libdirectory.so")).expect("made");
    let missing = directory.path().join("missing");
    let catalog = Catalog::discover(&[directory.path().to_owned(), missing.clone()], Trust::default());
    assert_eq!(catalog.plugins().len(), 0);
    let problems = catalog.problems();
    assert_eq!(problems.len(), 3, "{problems:?}");
    assert!(problems[0].path.ends_with("libdirectory.so"));
    assert!(problems[1].path.ends_with("libgarbage.so") && matches!(problems[1].error, LoadError::NotLoadable { .. }));
    assert!(problems[2].path == missing && matches!(problems[2].error, LoadError::Unreadable { .. }));
    assert!(
        problems[1]
            .to_string()
            .contains("libgarbage.so: the system's loader refuses it"),
        "{}",
        problems[1]
    );
}

#[test]
fn a_directory_that_others_may_write_is_not_entered() {
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::write(directory.path().join("libgarbage.so"), b"not a library").expect("written");
    std::fs::set_permissions(directory.path(), std::fs::Permissions::from_mode(0o777)).expect("mode is set");
    let catalog = Catalog::discover(&[directory.path().to_owned()], Trust::default());
    let problems = catalog.problems();
    assert_eq!(problems.len(), 1);
    assert!(
        matches!(problems[0].error, LoadError::WritableByOthers { .. }),
        "{problems:?}"
    );
}
