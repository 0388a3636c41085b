//! A change is traced to the right crates.

use super::*;

fn changed(files: &[&str]) -> Vec<String> {
    let workspace = Workspace::load().expect("cargo describes the workspace");
    let files: Vec<String> = files.iter().map(|file| (*file).to_owned()).collect();
    let changed = changed_packages(&workspace, &files);
    changed.into_iter().map(str::to_owned).collect()
}

#[test]
fn a_file_belongs_to_the_innermost_crate() {
    assert_eq!(
        changed(&["plugins/generic-uav/cdylib/src/lib.rs"]),
        ["generic-uav-plugin"]
    );
}

#[test]
fn a_root_file_concerns_all_and_a_document_none() {
    let all = Workspace::load().expect("cargo describes the workspace").packages.len();
    assert_eq!(changed(&["Cargo.lock"]).len(), all);
    assert!(changed(&["README.md"]).is_empty());
}
