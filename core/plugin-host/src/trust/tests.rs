//! Lists and signatures, and whose files are taken.

use super::*;
use std::os::unix::fs::PermissionsExt;

const BYTES: &[u8] = b"the bytes of a library";
const KEY: &str = "RWRza2VpbnRzdNaf9Y4pTRE5lPyqz3KftYmT623tEahrmx05rviG/qDy";
const SIGNATURE: &str = "untrusted comment: signature
RURza2VpbnRzdLIMJoLCA8eaE6ETy4OSmZnbuN6xTPC6f1BOsrY2c4REaoZMBrNGWSroWyn6CidtAv00JPSyaME55Wj4FoYngw4=
trusted comment: for tests
TAERESXEuh/lhnvNayeNX6rb9yy/5B0WR6IvMda7jt0y9A6L4CO1aEU6ejrm12DcxkLIIprG5kY1v0xsPIz5CA==
";

fn refusal(trust: &Trust, path: &Path, bytes: &[u8]) -> String {
    match trust.check(path, bytes, &sha256_hex(bytes)) {
        Err(LoadError::NotTrusted { detail, sha256 }) => {
            assert_eq!(sha256.len(), 64);
            detail
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn digests_are_the_usual_ones() {
    assert_eq!(
        sha256_hex(b"abc"),
        "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    );
}

#[test]
fn without_a_list_or_a_key_all_are_taken() {
    let sha256 = sha256_hex(BYTES);
    assert!(Trust::default().check(Path::new("/nowhere"), BYTES, &sha256).is_ok());
}

#[test]
fn a_list_lets_only_its_own_through() {
    let trust = Trust {
        allow_sha256: vec!["00".to_owned(), format!(" {} ", sha256_hex(BYTES).to_uppercase())],
        minisign_public_key: None,
    };
    assert!(trust.check(Path::new("/nowhere"), BYTES, &sha256_hex(BYTES)).is_ok());
    assert_eq!(
        refusal(&trust, Path::new("/nowhere"), b"others"),
        "its digest is not on the list"
    );
}

#[test]
fn a_signature_must_be_there_and_right() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path().join("libx.so");
    let signature = directory.path().join("libx.so.minisig");
    let mut trust = Trust {
        allow_sha256: Vec::new(),
        minisign_public_key: Some(KEY.to_owned()),
    };
    assert!(refusal(&trust, &path, BYTES).contains("cannot be read"));
    std::fs::write(&signature, "garbage").expect("written");
    assert!(refusal(&trust, &path, BYTES).contains("its signature is none"));
    std::fs::write(&signature, SIGNATURE).expect("written");
    assert!(trust.check(&path, BYTES, &sha256_hex(BYTES)).is_ok());
    assert!(refusal(&trust, &path, b"other bytes").contains("its signature is not right"));
    // On the list is enough.
    trust.allow_sha256.push(sha256_hex(b"other bytes"));
    assert!(trust.check(&path, b"other bytes", &sha256_hex(b"other bytes")).is_ok());
    trust.minisign_public_key = Some("no key".to_owned());
    assert!(refusal(&trust, &path, BYTES).contains("the public key of the configuration is none"));
}

fn set_mode(path: &Path, mode: u32) {
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).expect("mode is set");
}

#[test]
fn directories_above_count_unless_they_are_sticky() {
    let top = tempfile::tempdir().expect("a directory");
    let top = top.path().canonicalize().expect("is there");
    let directory = top.join("a/b");
    std::fs::create_dir_all(&directory).expect("made");
    assert!(refuse_directory_of_others(&directory).is_ok());
    set_mode(&top, 0o777);
    assert!(matches!(
        refuse_directory_of_others(&directory),
        Err(LoadError::WritableByOthers { path, mode: 0o777 }) if path == top
    ));
    set_mode(&top, 0o1777);
    assert!(refuse_directory_of_others(&directory).is_ok(), "as /tmp");
    assert!(
        refuse_directory_of_others(&top).is_err(),
        "anyone can put a library into it"
    );
}

#[test]
fn groups_and_owners_count() {
    let directory = tempfile::tempdir().expect("a directory");
    let directory = directory.path().canonicalize().expect("is there");
    set_mode(&directory, 0o775);
    assert!(refuse_directory_of_others(&directory).is_ok(), "our own group");
    // Giving things away is root's privilege.
    if own_uid() == 0 {
        std::os::unix::fs::chown(&directory, None, Some(12_345)).expect("given away");
        assert!(matches!(
            refuse_directory_of_others(&directory),
            Err(LoadError::WritableByOthers { mode: 0o775, .. })
        ));
        set_mode(&directory, 0o755);
        assert!(refuse_directory_of_others(&directory).is_ok());
        std::os::unix::fs::chown(&directory, Some(12_345), None).expect("given away");
        assert!(matches!(
            refuse_directory_of_others(&directory),
            Err(LoadError::NotOurs { uid: 12_345, .. })
        ));
    }
    assert!(is_ours(0, 5) && is_ours(5, 5) && !is_ours(6, 5) && !is_ours(6, 0));
}
