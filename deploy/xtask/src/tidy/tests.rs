//! The repository keeps the rules, and each rule finds what it is there to find.

use super::*;
use crate::workspace::{Dependency, Package, Target};

fn file(path: &str, text: &str) -> File {
    File {
        path: path.to_owned(),
        text: text.to_owned(),
    }
}

fn package(name: &str, folder: &str) -> Package {
    Package {
        name: name.to_owned(),
        version: String::new(),
        folder: folder.to_owned(),
        dependencies: Vec::new(),
        targets: Vec::new(),
        in_real_time: Vec::new(),
    }
}

fn rules(findings: &[Finding]) -> Vec<&str> {
    findings.iter().map(|finding| finding.rule).collect()
}

#[test]
fn the_repository_is_tidy() {
    check(&Workspace::load().expect("cargo describes the workspace")).expect("see the findings above");
}

#[test]
fn a_source_file_opens_with_what_it_holds() {
    assert_eq!(
        rules(&sources::check(&file("core/x/src/a.rs", "use std::fmt;\n"))),
        ["opening"]
    );
    assert!(sources::check(&file("core/x/src/a.rs", "//! Holds it.\n")).is_empty());
}

#[test]
fn size_and_names_are_limited() {
    let long = format!("//! Long.\n{}", "\n".repeat(600));
    assert_eq!(rules(&sources::check(&file("core/x/src/a.rs", &long))), ["file-size"]);
    assert_eq!(
        rules(&sources::check(&file("core/x/src/utils.rs", "//! What?\n"))),
        ["names"]
    );
    assert_eq!(
        rules(&sources::check(&file("core/x/src/common/a.rs", "//! What?\n"))),
        ["names"]
    );
    assert_eq!(
        rules(&sources::check(&file("core/x/src/a/mod.rs", "//! What?\n"))),
        ["names"]
    );
    let main = format!("//! Wires.\n{}", "\n".repeat(149));
    assert_eq!(
        rules(&sources::check(&file("core/x/src/main.rs", &main))),
        ["main-size"]
    );
    let shim = "\n".repeat(60);
    assert_eq!(
        rules(&sources::shims(&[file("plugins/x/cdylib/src/lib.rs", &shim)])),
        ["shim-size"]
    );
}

#[test]
fn an_unsafe_block_says_why_it_is_sound() {
    let block = concat!("unsafe", " { call() }");
    let bare = format!("//! Calls.\nfn f() {{\n    {block}\n}}\n");
    let explained = format!("//! Calls.\nfn f() {{\n    // SAFETY: it is sound.\n    {block}\n}}\n");
    assert_eq!(rules(&sources::check(&file("core/x/src/a.rs", &bare))), ["safety-line"]);
    assert!(sources::check(&file("core/x/src/a.rs", &explained)).is_empty());
}

#[test]
fn a_lint_is_switched_off_with_a_reason() {
    let start = concat!("#[", "allow(");
    let bare = format!("//! A.\n{start}dead_code)]\nfn f() {{}}\n");
    let explained = format!("//! A.\n{start}\n    dead_code,\n    reason = \"kept\"\n)]\nfn f() {{}}\n");
    assert_eq!(rules(&sources::check(&file("core/x/src/a.rs", &bare))), ["lint-reason"]);
    assert!(sources::check(&file("core/x/src/a.rs", &explained)).is_empty());
}

#[test]
fn a_pure_crate_has_no_clock() {
    let text = "//! A.\nlet now = std::time::Instant::now();\n";
    assert_eq!(
        rules(&sources::check(&file("core/flight/src/a.rs", text))),
        ["pure-core"]
    );
    assert!(sources::check(&file("core/flight/src/a/tests.rs", text)).is_empty());
    assert!(sources::check(&file("core/sim/src/a.rs", text)).is_empty());
}

#[test]
fn messages_of_actors_stay_private() {
    let vehicle = || file("core/runtime/src/vehicle.rs", "//! A.\npub enum VehicleMessage {\n}\n");
    let found = |root: &str| rules(&sources::messages(&[file("core/runtime/src/lib.rs", root), vehicle()])).join(" ");
    assert_eq!(found("//! R.\npub mod vehicle;\n"), "handles");
    assert_eq!(
        found("//! R.\nmod vehicle;\npub use vehicle::VehicleMessage;\n"),
        "handles"
    );
    assert_eq!(found("//! R.\nmod vehicle;\n"), "");
}

#[test]
fn imports_point_down() {
    let runtime = package("skein-runtime", "core/runtime");
    assert!(layers::breach(&runtime, "skein-domain").is_none());
    assert!(layers::breach(&runtime, "skein-api").is_some());
    assert!(layers::breach(&runtime, "skein-testkit").is_some());
    let plugin = package("gimbal", "plugins/gimbal");
    assert!(layers::breach(&plugin, "skein-plugin-sdk").is_none());
    assert!(layers::breach(&plugin, "skein-runtime").is_some());
    let library = package("gimbal-plugin", "plugins/gimbal/cdylib");
    assert!(layers::breach(&library, "gimbal").is_none());
    assert!(layers::breach(&library, "camera").is_some());
}

#[test]
fn names_follow_from_the_folder() {
    for (folder, name) in [
        ("core/safety", "skein-safety"),
        ("core/skein", "skein"),
        ("plugins/gimbal", "gimbal"),
        ("plugins/gimbal/cdylib", "gimbal-plugin"),
        ("tests/faults", "skein-tests-faults"),
        ("tests/testkit", "skein-testkit"),
        ("tests/plugin-boundary/fixtures/hangs", "fixture-hangs"),
    ] {
        assert_eq!(manifests::wanted_name(folder).as_deref(), Some(name));
    }
}

#[test]
fn roles_rule_out_dependencies() {
    let on = |name: &str| Dependency {
        name: name.to_owned(),
        kind: None,
    };
    let manifest = |folder: &str| file(&format!("{folder}/Cargo.toml"), "[lints]\nworkspace = true\n");
    let broken = |name: &str, folder: &str, dependency: &str, source: &str| {
        let package = Package {
            dependencies: vec![on(dependency)],
            ..package(name, folder)
        };
        let workspace = Workspace {
            root: "/".into(),
            target: "/".into(),
            packages: vec![package],
        };
        let source = file(&format!("{folder}/src/lib.rs"), source);
        rules(&manifests::check(&workspace, &[manifest(folder), source])).join(" ")
    };
    for (name, folder, dependency, found) in [
        ("skein-safety", "core/safety", "tokio", "dependencies"),
        ("skein-safety", "core/safety", "thiserror", ""),
        ("skein-plugin-abi", "core/plugin-abi", "thiserror", "dependencies"),
        ("skein-sim", "core/sim", "anyhow", "dependencies"),
        ("skein", "core/skein", "anyhow", ""),
    ] {
        let source = format!("use {dependency}::A;\n");
        assert_eq!(broken(name, folder, dependency, &source), found);
    }
    let of_none = broken("skein-sim", "core/sim", "mp4-atom", "use mp4::A;\n");
    assert_eq!(of_none, "dependencies");
    assert_eq!(broken("skein-sim", "core/sim", "mp4-atom", "use mp4_atom::A;\n"), "");
}

#[test]
fn a_crate_root_forbids_unsafe_code() {
    let target = Target {
        name: "x".to_owned(),
        kind: vec!["lib".to_owned()],
        src_path: "/core/x/src/lib.rs".into(),
        test: true,
    };
    let package = Package {
        targets: vec![target],
        ..package("skein-x", "core/x")
    };
    let workspace = Workspace {
        root: "/".into(),
        target: "/".into(),
        packages: vec![package],
    };
    let found = |text: &str| sources::crate_roots(&workspace, &[file("core/x/src/lib.rs", text)]).len();
    assert_eq!(found("//! X.\n"), 1);
    assert_eq!(found("//! X.\n#![forbid(unsafe_code)]\n"), 0);
}

#[test]
fn documents_hold_no_words_of_process_and_no_commands_that_are_not() {
    let word = concat!("Mile", "stone");
    assert_eq!(
        rules(&documents::words(&file("README.md", &format!("# {word} 1\n")))),
        ["words"]
    );
    assert!(documents::words(&file("README.md", "# What it does\n")).is_empty());
    let commands = ["test".to_owned()];
    let text = concat!("run `cargo xtask", " test unit` or `cargo xtask", " fly`");
    let found = documents::commands_exist(&file("README.md", text), &commands);
    assert_eq!(rules(&found), ["commands"]);
}

#[test]
fn a_link_needs_its_file_and_its_heading() {
    let root = Workspace::load().expect("cargo describes the workspace").root;
    let whole = |text: &str| std::collections::BTreeMap::from([("README.md", text.to_owned())]);
    let found = |text: &str| {
        let file = file("deploy/a.md", text);
        rules(&documents::leads(&root, &file, &whole("# Fly it"))).join(" ")
    };
    assert_eq!(found("[a](../README.md#fly-it) [b](config) [c](https://a.b/c)"), "");
    assert_eq!(found("[a](../README.md#sail-it)"), "links");
    assert_eq!(found("[a](../NOT.md)\n\n{{#include nothing.md}}"), "links links");
}

#[test]
fn the_site_names_its_pages_and_the_names_of_ros_2() {
    let page = |name: &str, text: &str| file(&format!("{}/{name}", crate::docs::PAGES), text);
    let generated = crate::docs::GENERATED.map(|name| format!("[x]({name})")).join("\n");
    let summary = page("SUMMARY.md", &format!("[ros2](ros2.md)\n{generated}"));
    let guide = page("ros2.md", "`<vehicle>/pose`, `arm`");
    let source = |line: &str| file("core/ros2/src/vehicle.rs", line);
    let files = [summary, guide, source("pose: place.voice(\"pose\", &motion)?,")];
    assert!(documents::site(&files).is_empty() && documents::ros2_names(&files).is_empty());
    let [summary, guide, _] = files;
    let more = [
        summary,
        guide,
        page("new.md", ""),
        source("place.server::<Trigger>(\"land\")?;"),
    ];
    assert_eq!(rules(&documents::site(&more)), ["site"]);
    assert_eq!(rules(&documents::ros2_names(&more)), ["ros2-names"]);
}

#[test]
fn an_exception_needs_a_reason_and_a_cause() {
    let finding = Finding {
        path: "a.rs".to_owned(),
        line: 0,
        rule: "file-size",
        what: String::new(),
    };
    let list =
        |rule: &str, reason: &str| format!("[[exception]]\nrule = \"{rule}\"\npath = \"a.rs\"\nreason = \"{reason}\"");
    let left = |list: &str| {
        exceptions::without(list, BTreeSet::from([finding.clone()]))
            .expect("a good list")
            .len()
    };
    assert_eq!(left(""), 1);
    assert_eq!(left(&list("file-size", "one table, better read whole")), 0);
    assert_eq!(left(&list("file-size", "long")), 1);
    assert_eq!(left(&list("names", "one table, better read whole")), 2);
}

#[test]
fn tests_of_a_library_that_says_it_has_none_are_found() {
    let mut package = package("skein-x", "core/x");
    package.targets.push(Target {
        name: "skein_x".to_owned(),
        kind: vec!["lib".to_owned()],
        src_path: "core/x/src/lib.rs".into(),
        test: false,
    });
    let manifest = file("core/x/Cargo.toml", "[lints]\nworkspace = true\n");
    let mut workspace = Workspace {
        root: "/".into(),
        target: "/target".into(),
        packages: vec![package],
    };
    let tested = file("core/x/src/a.rs", "//! Holds it.\n#[cfg(test)]\nmod tests;\n");
    assert!(manifests::check(&workspace, std::slice::from_ref(&manifest)).is_empty());
    let files = [manifest, tested];
    assert_eq!(rules(&manifests::check(&workspace, &files)), ["test"]);
    workspace.packages[0].targets[0].test = true;
    assert!(manifests::check(&workspace, &files).is_empty());
}

#[test]
fn a_test_in_real_time_that_is_not_there_is_found() {
    let mut package = package("skein-x", "core/x");
    package.in_real_time = vec!["peers".to_owned()];
    let mut workspace = Workspace {
        root: "/".into(),
        target: "/target".into(),
        packages: vec![package],
    };
    assert_eq!(rules(&tiers::check(&workspace)), ["tiers"]);
    workspace.packages[0].targets.push(Target {
        name: "peers".to_owned(),
        kind: vec!["test".to_owned()],
        src_path: "core/x/tests/peers.rs".into(),
        test: true,
    });
    assert!(tiers::check(&workspace).is_empty());
}

#[test]
fn imports_inside_a_crate_do_not_go_round() {
    let circles = |files: &[(&str, &str)]| {
        let files: Vec<File> = (files.iter())
            .map(|(name, text)| file(&format!("core/x/src/{name}"), text))
            .collect();
        modules::of_crate("core/x", &files)
            .into_iter()
            .map(|finding| finding.what)
            .collect::<Vec<_>>()
    };
    let down = [
        ("a.rs", "use crate::b::B;\nuse crate::{c::C, d};\n"),
        ("b.rs", "use crate::c;\n"),
        ("c.rs", ""),
        ("d.rs", ""),
    ];
    assert_eq!(circles(&down), Vec::<String>::new());
    let round = [
        ("a.rs", "use crate::{d, b::{B, E}};\n"),
        ("b/below.rs", "use super::B;\nuse crate::c::C;\n"),
        ("b.rs", ""),
        ("c.rs", "fn f() { crate::a::f() }\n"),
    ];
    assert_eq!(circles(&round).len(), 1);
    assert!(circles(&round)[0].contains("a → b → c → a"), "{:?}", circles(&round));
    let by_the_root = [
        ("lib.rs", "mod a;\nmod b;\npub use b::{A, B};\n"),
        ("a.rs", "use crate::B;\n"),
        ("b.rs", "use super::a;\n"),
    ];
    assert!(circles(&by_the_root)[0].contains("a → b → a"));
    let in_tests = [
        ("a.rs", "use crate::b;\n"),
        ("b.rs", "#[cfg(test)]\nmod tests {\n    use crate::a;\n}\n"),
        ("b/tests.rs", "use crate::a;\n"),
    ];
    assert_eq!(circles(&in_tests), Vec::<String>::new());
}

#[test]
fn a_file_that_no_module_declares_is_found() {
    let files = [
        file("core/x/src/lib.rs", "mod a;\npub(crate) mod c;\n"),
        file("core/x/src/a.rs", "mod b;\n"),
        file("core/x/src/a/b.rs", ""),
        file("core/x/src/c.rs", "// mod d;\n"),
        file("core/x/src/c/d.rs", ""),
        file("core/x/src/bin/tool.rs", ""),
        file("core/x/src/e.rs", ""),
    ];
    let found = modules::undeclared(&files);
    let paths: Vec<_> = found.iter().map(|finding| finding.path.as_str()).collect();
    assert_eq!(paths, ["core/x/src/c/d.rs", "core/x/src/e.rs"]);
    assert_eq!(rules(&found), ["modules", "modules"]);
}

#[test]
fn a_name_that_was_given_up_does_not_come_back() {
    let old = concat!("fn f(shared: &Bo", "ard) {}\n");
    assert_eq!(rules(&retired::check(&file("core/x/src/a.rs", old))), ["retired"]);
    assert!(retired::check(&file("core/x/src/a.rs", concat!("fn f(b: &KeyBo", "ard) {}\n"))).is_empty());
}
