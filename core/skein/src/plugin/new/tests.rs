//! What is written names what it should. That it builds, passes its tests and is taken by a node is shown by `tests/plugin-boundary`.

use super::{Kind, Sdk, cargo_toml, check_name, library, named, type_name};

#[test]
fn names_are_checked() {
    for name in ["light", "my-light-2", "a"] {
        assert!(check_name(name).is_ok(), "{name}");
    }
    let long = "x".repeat(65);
    for name in [
        "", "Light", "2light", "-light", "light-", "my_light", "../light", "serde", "ä", &long,
    ] {
        assert!(check_name(name).is_err(), "{name}");
    }
}

#[test]
fn types_and_files_follow_the_name() {
    assert_eq!(type_name("my-light-2"), "MyLight2Plugin");
    assert_eq!(type_name("state"), "StatePlugin");
    assert_eq!(library("my-light"), "libmy_light.so");
}

#[test]
fn nothing_of_the_templates_names_is_left() {
    for (kind, files) in [(Kind::Camera, super::PAYLOAD), (Kind::UavModel, super::UAV_MODEL)] {
        for (path, text) in files {
            let text = named(text, "my-eye", kind);
            assert!(
                !text.contains("IndicatorLight") && !text.contains("LogBookUav"),
                "{path}"
            );
            assert!(!text.contains("GIMBAL"), "{path}");
        }
    }
}

#[test]
fn the_versions_are_those_of_this_program() {
    let tree = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let ours = std::fs::read_to_string(tree.join("Cargo.toml")).expect("is there");
    let written = cargo_toml("my-eye", Kind::UavModel, &Sdk::Tree(tree));
    for name in ["minicbor", "schemars", "serde", "serde_json"] {
        let line = written.lines().find(|line| line.starts_with(&format!("{name} = ")));
        let line = line.expect("is a dependency");
        assert!(
            ours.lines().any(|own| own == line),
            "{line} is not what the workspace has"
        );
    }
}

#[test]
fn a_path_may_have_anything_in_it() {
    let odd = Sdk::Tree(std::path::PathBuf::from(r#"/tmp/a "b" \c"#));
    let line = odd.dependency("skein-plugin-sdk", "core/plugin-sdk");
    assert_eq!(
        line,
        r#"skein-plugin-sdk = { path = "/tmp/a \"b\" \\c/core/plugin-sdk" }"#
    );
}
