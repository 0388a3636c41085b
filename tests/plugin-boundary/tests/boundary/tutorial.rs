//! The commands of `plugins/TUTORIAL.md` work as they stand there.

use skein_tests_plugin_boundary::sh_blocks;
use std::process::Command;

#[test]
#[ignore = "long: part of `cargo xtask test plugin-boundary`"]
fn its_commands_work() {
    let text = std::fs::read_to_string(skein_testkit::repository().join("plugins/TUTORIAL.md")).expect("is there");
    let blocks = sh_blocks(&text);
    assert!(blocks.len() >= 6, "{} blocks", blocks.len());
    let skein = skein_testkit::skein_binary();
    let folder = tempfile::tempdir().expect("can be made");
    // One build directory for both crates, which is kept: else every run would compile everything they need twice.
    let target = skein.parent().expect("lies in a folder").join("tutorial");
    // As one who reads it types them: in one shell, each after the other, stopping at the first that fails.
    let script = blocks
        .concat()
        .replace("target/debug/", &format!("{}/debug/", target.display()));
    let mut path = vec![skein.parent().expect("lies in a folder").to_owned()];
    path.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()));
    let output = Command::new("sh")
        .args(["-eux", "-c", &script])
        .current_dir(folder.path())
        .env("PATH", std::env::join_paths(path).expect("can be joined"))
        .env("CARGO_TARGET_DIR", &target)
        .env_remove("RUSTFLAGS")
        .output()
        .expect("a shell can be started");
    let said = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}\n{errors}");
    for expected in [
        "log-keeper 0.1.0 (uav_model)",
        "my-light 0.1.0 (gimbal)",
        "in a process of its own",
        "log-keeper           0.1.0",
        "The flight met all criteria.",
    ] {
        assert!(said.contains(expected), "{expected:?} is not in:\n{said}\n{errors}");
    }
}
