//! A change is traced to the right crates.

use super::*;

fn concerned(files: &[&str]) -> Vec<String> {
    let workspace = Workspace::load().expect("cargo describes the workspace");
    let files: Vec<String> = files.iter().map(|file| (*file).to_owned()).collect();
    let changed = changed_packages(&workspace, &files);
    with_dependants(&workspace, &changed)
        .into_iter()
        .map(str::to_owned)
        .collect()
}

#[test]
fn a_change_concerns_its_crate_and_those_that_use_it() {
    let concerned = concerned(&["core/safety/src/gate.rs"]);
    for name in ["skein-safety", "skein-runtime", "skein-api", "skein"] {
        assert!(
            concerned.iter().any(|found| found == name),
            "{name} uses skein-safety: {concerned:?}"
        );
    }
    for name in ["skein-domain", "skein-plugin-abi", "xtask"] {
        assert!(
            !concerned.iter().any(|found| found == name),
            "{name} does not: {concerned:?}"
        );
    }
}

#[test]
fn a_file_belongs_to_the_innermost_crate() {
    assert_eq!(
        concerned(&["plugins/generic-uav/cdylib/src/lib.rs"]),
        ["generic-uav-plugin"]
    );
}

#[test]
fn a_root_file_concerns_all_and_a_document_none() {
    let all = Workspace::load().expect("cargo describes the workspace").packages.len();
    assert_eq!(concerned(&["Cargo.lock"]).len(), all);
    assert!(concerned(&["README.md"]).is_empty());
}
