//! Archives as they are made, and as somebody else might make them: damaged, cut off, with paths and links that lead out.

use super::*;
use proptest::prelude::*;
use tempfile::TempDir;

/// How a program for this processor, or for another one, begins.
pub(crate) fn program(architecture: &str) -> Vec<u8> {
    let mut bytes = b"\x7fELF\x02\x01\x01\0\0\0\0\0\0\0\0\0\x03\0".to_vec();
    bytes.extend(match architecture {
        "x86_64" => [0x3e, 0],
        _ => [0xb7, 0],
    });
    bytes.extend(b"what it does".repeat(1000));
    bytes
}

/// A folder with a program and two plugins.
pub(crate) fn built(architecture: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join(PLUGINS)).unwrap();
    std::fs::write(folder.path().join(PROGRAM), program(architecture)).unwrap();
    for name in ["libgimbal_plugin.so", "libgeneric_uav_plugin.so"] {
        std::fs::write(folder.path().join(PLUGINS).join(name), name.repeat(500)).unwrap();
    }
    std::fs::write(folder.path().join(PLUGINS).join("notes.txt"), "not a plugin").unwrap();
    folder
}

/// An archive of such a folder.
pub(crate) fn archive(architecture: &str, version: &str) -> (TempDir, PathBuf, ArchiveInfo) {
    let folder = built(architecture);
    let path = folder.path().join("archive.tar.gz");
    let info = pack(folder.path(), version, &path).unwrap();
    (folder, path, info)
}

/// A tar made by hand: entries as they come, with a manifest of these files before them.
fn by_hand(files: Vec<PackedFile>, entries: &[(EntryType, &str, &[u8])]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("archive.tar.gz");
    let mut archive = Builder::new(GzEncoder::new(File::create(&path).unwrap(), Compression::fast()));
    let manifest = Manifest {
        format: 1,
        version: "1".into(),
        architecture: "x86_64".into(),
        files,
    };
    let text = serde_json::to_vec(&manifest).unwrap();
    archive
        .append_data(&mut header(text.len() as u64, 0o644), FILE_NAME, text.as_slice())
        .unwrap();
    for (kind, name, bytes) in entries {
        let mut header = header(bytes.len() as u64, 0o644);
        header.set_entry_type(*kind);
        // Not by the library, which would not write such a name.
        let raw = &mut header.as_old_mut().name;
        raw[..name.len()].copy_from_slice(name.as_bytes());
        if *kind == EntryType::Symlink {
            header.set_link_name("/etc/passwd").unwrap();
        }
        header.set_cksum();
        archive.append(&header, *bytes).unwrap();
    }
    archive.into_inner().unwrap().finish().unwrap();
    (folder, path)
}

fn listed(path: &str, bytes: &[u8]) -> PackedFile {
    PackedFile {
        path: path.into(),
        bytes: bytes.len() as u64,
        sha256: hexadecimal(&Sha256::digest(bytes)),
    }
}

fn unpacked(path: &Path) -> (TempDir, Result<Manifest, ArchiveError>) {
    let around = tempfile::tempdir().unwrap();
    let folder = around.path().join("version");
    std::fs::create_dir(&folder).unwrap();
    let outcome = unpack(path, &folder);
    (around, outcome)
}

#[test]
fn what_is_packed_is_unpacked_and_nothing_else() {
    let (built, path, info) = archive("x86_64", "0.2.0");
    assert_eq!((info.version.as_str(), info.architecture.as_str()), ("0.2.0", "x86_64"));
    let (around, manifest) = unpacked(&path);
    let paths: Vec<String> = manifest.unwrap().files.into_iter().map(|file| file.path).collect();
    assert_eq!(
        paths,
        [
            "skein",
            "plugins/libgeneric_uav_plugin.so",
            "plugins/libgimbal_plugin.so"
        ]
    );
    for path in paths {
        let there = std::fs::read(around.path().join("version").join(&path)).unwrap();
        assert_eq!(there, std::fs::read(built.path().join(&path)).unwrap(), "{path}");
    }
    assert!(!around.path().join("version/plugins/notes.txt").exists());
    let again = built.path().join("again.tar.gz");
    assert_eq!(
        pack(built.path(), "0.2.0", &again).unwrap().digest,
        info.digest,
        "the same files, the same archive"
    );
}

#[test]
fn an_unpacked_package_is_packed_too() {
    let built = built("aarch64");
    let root = tempfile::tempdir().unwrap();
    std::fs::create_dir_all(root.path().join("usr/bin")).unwrap();
    std::fs::create_dir_all(root.path().join("usr/lib/skein")).unwrap();
    std::fs::rename(built.path().join(PROGRAM), root.path().join(INSTALLED[0])).unwrap();
    std::fs::rename(built.path().join(PLUGINS), root.path().join(INSTALLED[1])).unwrap();
    let info = pack(root.path(), "0.2.0", &root.path().join("archive.tar.gz")).unwrap();
    assert_eq!(info.architecture, "aarch64");
}

#[test]
fn a_folder_without_a_program_or_with_a_script_makes_no_archive() {
    let built = built("x86_64");
    let path = built.path().join("archive.tar.gz");
    std::fs::write(built.path().join(PROGRAM), "#!/bin/sh\nexit 1\n").unwrap();
    assert!(matches!(pack(built.path(), "1", &path), Err(ArchiveError::Program(_))));
    std::fs::remove_file(built.path().join(PROGRAM)).unwrap();
    assert!(matches!(pack(built.path(), "1", &path), Err(ArchiveError::File { .. })));
    assert!(!path.exists());
}

#[test]
fn a_path_or_a_link_that_leads_out_is_not_followed() {
    let bytes = program("x86_64");
    let good = listed(PROGRAM, &bytes);
    for (files, entries) in [
        (
            vec![good.clone(), listed("../../escaped", b"x")],
            vec![(EntryType::Regular, "../../escaped", b"x".as_slice())],
        ),
        (
            vec![good.clone()],
            vec![(EntryType::Regular, "../../escaped", b"x".as_slice())],
        ),
        (
            vec![good.clone()],
            vec![(EntryType::Regular, "/tmp/escaped", b"x".as_slice())],
        ),
        (vec![good.clone()], vec![(EntryType::Symlink, PROGRAM, b"".as_slice())]),
        (vec![good.clone()], vec![(EntryType::Link, PROGRAM, b"".as_slice())]),
        (
            vec![good.clone()],
            vec![(EntryType::Directory, "plugins", b"".as_slice())],
        ),
        (vec![good.clone()], vec![(EntryType::Fifo, PROGRAM, b"".as_slice())]),
        // More than the manifest names.
        (
            vec![good.clone()],
            vec![
                (EntryType::Regular, PROGRAM, bytes.as_slice()),
                (EntryType::Symlink, "plugins/x", b""),
            ],
        ),
    ] {
        let (_kept, path) = by_hand(files, &entries);
        assert!(check(&path).is_err(), "{entries:?}");
        let (around, outcome) = unpacked(&path);
        assert!(outcome.is_err(), "{entries:?}");
        let outside: Vec<_> = std::fs::read_dir(around.path())
            .unwrap()
            .flatten()
            .map(|e| e.file_name())
            .collect();
        assert_eq!(outside, ["version"], "{entries:?}");
    }
}

#[test]
fn a_file_that_is_longer_shorter_or_other_is_refused() {
    let bytes = program("x86_64");
    for other in [
        [bytes.as_slice(), b"!"].concat(),
        bytes[..bytes.len() - 1].to_vec(),
        bytes.iter().rev().copied().collect(),
    ] {
        let (_kept, path) = by_hand(vec![listed(PROGRAM, &bytes)], &[(EntryType::Regular, PROGRAM, &other)]);
        assert!(check(&path).is_err());
    }
}

#[test]
fn a_program_for_another_processor_than_the_manifest_says_is_refused() {
    let bytes = program("aarch64");
    let (_kept, path) = by_hand(vec![listed(PROGRAM, &bytes)], &[(EntryType::Regular, PROGRAM, &bytes)]);
    assert!(matches!(check(&path), Err(ArchiveError::Program(_))));
}

#[test]
fn what_unpacks_to_far_more_than_it_says_is_stopped() {
    let bytes = program("x86_64");
    let zeros = vec![0; 4 << 20];
    let (_kept, path) = by_hand(
        vec![
            listed(PROGRAM, &bytes),
            PackedFile {
                bytes: 10,
                ..listed("plugins/a.so", b"")
            },
        ],
        &[
            (EntryType::Regular, PROGRAM, &bytes),
            (EntryType::Regular, "plugins/a.so", &zeros),
        ],
    );
    let (around, outcome) = unpacked(&path);
    assert!(matches!(outcome, Err(ArchiveError::Changed { .. })));
    let written = std::fs::metadata(around.path().join("version/plugins/a.so"))
        .unwrap()
        .len();
    assert!(written <= 10, "{written}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_damaged_archive_is_never_taken_for_the_one_it_was(at in any::<prop::sample::Index>(), change in 1..=255_u8, cut in any::<bool>()) {
        let (built, path, info) = archive("x86_64", "0.2.0");
        let mut bytes = std::fs::read(&path).unwrap();
        let at = at.index(bytes.len());
        if cut {
            bytes.truncate(at);
        } else {
            bytes[at] ^= change;
        }
        let damaged = built.path().join("damaged.tar.gz");
        std::fs::write(&damaged, &bytes).unwrap();
        match check(&damaged) {
            Err(_) => {}
            // What gzip does not look at (its own header): the files are the same, and the digest is another.
            Ok((_, told)) => prop_assert!(told.digest != info.digest && told.unpacked_bytes == info.unpacked_bytes),
        }
    }
}
