//! The committed TypeScript and OpenAPI files say what the Rust types say. `SKEIN_REGENERATE=1` writes them anew.
#![allow(
    clippy::unwrap_used,
    reason = "what tests share may stop at the first surprise, as they do"
)]

use std::path::{Path, PathBuf};

/// Compares a committed file with what it should be, or writes it if that is asked for.
fn check(path: &Path, should: &str) {
    if std::env::var_os("SKEIN_REGENERATE").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, should).unwrap();
        return;
    }
    let is = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        is == should,
        "{} is out of date: run `SKEIN_REGENERATE=1 cargo test -p skein-api --test generated` and commit it",
        path.display()
    );
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

#[test]
fn committed_typescript_is_up_to_date() {
    let folder = repository().join(skein_api::generated::FOLDER);
    let files = skein_api::generated::files();
    for file in &files {
        check(&folder.join(file.name), &file.text);
    }
    for entry in std::fs::read_dir(&folder).unwrap() {
        let name = entry.unwrap().file_name();
        assert!(
            files.iter().any(|file| name == file.name),
            "{} is not generated: it belongs elsewhere",
            name.display()
        );
    }
}

#[test]
fn committed_openapi_document_is_up_to_date() {
    check(
        &repository().join("core/api/openapi.json"),
        &skein_api::openapi::document(),
    );
}
