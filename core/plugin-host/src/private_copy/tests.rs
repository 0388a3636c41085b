//! Which files are copied.

use super::*;

fn set_mode(path: &Path, mode: u32) {
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).expect("mode is set");
}

fn library() -> (TempDir, PathBuf) {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path().join("libx.so");
    std::fs::write(&path, b"bytes").expect("written");
    set_mode(&path, 0o644);
    (directory, path)
}

#[test]
fn the_copy_is_private_and_goes_with_the_value() {
    let (_directory, path) = library();
    let copy = PrivateCopy::of(&read(&path).expect("is read"), &path).expect("is copied");
    let copied_to = copy.path().to_owned();
    assert_eq!(std::fs::read(&copied_to).expect("is there"), b"bytes");
    let above = copied_to.parent().expect("has one").metadata().expect("is there");
    assert_eq!(
        above.permissions().mode() & 0o077,
        0,
        "others may look into the directory of the copy"
    );
    drop(copy);
    assert!(!copied_to.exists());
}

#[test]
fn what_others_may_write_is_refused() {
    let (directory, path) = library();
    set_mode(&path, 0o646);
    assert!(matches!(read(&path), Err(LoadError::WritableByOthers { mode: 0o646, path: p }) if p.ends_with("libx.so")));
    set_mode(&path, 0o644);
    set_mode(directory.path(), 0o777);
    assert!(matches!(
        read(&path),
        Err(LoadError::WritableByOthers { mode: 0o777, .. })
    ));

    // A link elsewhere does not help: it is the library's own directory that counts.
    let elsewhere = tempfile::tempdir().expect("a directory");
    let link = elsewhere.path().join("liby.so");
    std::os::unix::fs::symlink(&path, &link).expect("linked");
    assert!(matches!(
        read(&link),
        Err(LoadError::WritableByOthers { mode: 0o777, .. })
    ));
    set_mode(directory.path(), 0o755);
    assert!(read(&link).is_ok());
}

#[test]
fn a_missing_file_is_unreadable() {
    assert!(matches!(
        read(Path::new("/nowhere/libx.so")),
        Err(LoadError::Unreadable { .. })
    ));
}
