//! The long runs of `test --all`: soak flights, fuzzing, slow scenes of the bus. Tens of minutes, so no part of CI.
//!
//! Must never do: hold a criterion of its own; the demo's referee and the properties judge.

use crate::report::Report;
use crate::step::Step;
use crate::tally::Runner;
use crate::workspace::Workspace;
use std::path::Path;
use std::process::Command;

/// How long each coverage-guided fuzz target runs.
const FUZZ_SECONDS: u32 = 120;
/// Drawn flights of swarms, each judged by the truth.
const SEEDS: &str = "10000..13000";
/// Inputs per property; the tests themselves ask for 256.
const CASES: &str = "20000";
/// Crates whose properties feed bytes or text from outside.
const TAKE_FOREIGN_INPUT: [&str; 6] = [
    "skein-link-mavlink",
    "skein-link-dds",
    "skein-config",
    "skein-domain",
    "skein-plugin-abi",
    "skein-plugin-host",
];
/// Crates whose own tests are in part so long that the unit tier leaves them out.
const HAVE_LONG_TESTS: [&str; 1] = ["skein-bench"];
/// The flights, each with its report; a row of them in place of one long flight, which would show nothing new after two minutes. The
/// scenarios are flown by the tier e2e.
const FLIGHTS: [(&str, &[&str]); 8] = [
    ("soak-50", &["--vehicles", "50"]),
    ("soak-50-faults", &["--vehicles", "50", "--faults", "--seed", "2"]),
    ("soak-20-faults", &["--vehicles", "20", "--faults", "--seed", "3"]),
    ("soak-12-faults", &["--vehicles", "12", "--faults", "--seed", "4"]),
    (
        "soak-6-faults",
        &["--vehicles", "6", "--faults", "--seed", "5", "--seconds", "200"],
    ),
    ("soak-6", &["--vehicles", "6", "--seed", "6", "--seconds", "200"]),
    (
        "soak-6-plugins",
        &[
            "--vehicles",
            "6",
            "--faults",
            "plugins",
            "--seed",
            "7",
            "--seconds",
            "200",
        ],
    ),
    (
        "soak-20-plugins",
        &["--vehicles", "20", "--faults", "plugins", "--seed", "8"],
    ),
];

/// Runs them all. `tell` says to a command where the artefacts under test are.
pub fn run(workspace: &Workspace, report: &mut Report, tell: impl Fn(&mut Command)) {
    let built = report.check("soak: program built", "mend the compile error above", || {
        crate::demo::build_for(workspace, &[])
    });
    if built {
        for (name, arguments) in FLIGHTS {
            let file = workspace.target.join("xtask").join(format!("{name}.json"));
            let advice = format!("{} holds every figure of the flight", file.display());
            report.step(name, &advice, Step::new(flight(workspace, arguments, &file)));
        }
    }
    let mut properties = workspace.cargo();
    properties
        .arg("test")
        .args(TAKE_FOREIGN_INPUT.iter().flat_map(|name| ["-p", name]))
        .arg("--no-fail-fast");
    properties.env("PROPTEST_CASES", CASES);
    tell(&mut properties);
    let advice = "proptest prints the smallest failing input; commit the regression file it wrote";
    report.step(
        &format!("fuzz: properties, {CASES} cases"),
        advice,
        Step::tests(properties, Runner::CargoTest),
    );
    let mut drawn = workspace.cargo();
    drawn.args(["test", "--release", "-p", "skein-seeded", "--", "--nocapture"]);
    drawn.env("SKEIN_SEEDS", SEEDS);
    report.step(
        &format!("seeded: flights {SEEDS}"),
        "`skein replay-seed N` flies a seed named above again",
        Step::tests(drawn, Runner::CargoTest),
    );
    let mut left_out = workspace.cargo();
    left_out
        .arg("test")
        .args(HAVE_LONG_TESTS.iter().flat_map(|name| ["-p", name]))
        .args(["--no-fail-fast", "--", "--ignored", "--test-threads", "1"]);
    report.step(
        "unit: what takes long",
        "the failing tests are named above",
        Step::tests(left_out, Runner::CargoTest),
    );
    containers(workspace, report);
    fuzz_targets(workspace, report);
    miri(workspace, report);
    if is_installed("cargo-deny") {
        let mut advisories = workspace.cargo();
        advisories.args(["deny", "check", "advisories"]);
        // changes without our doing, and needs the network: no part of CI
        report.step(
            "advisories",
            "update the crate named, or say in deny.toml why it does not touch us",
            Step::new(advisories),
        );
    }
}

/// Packages and images for both architectures, from what is built here; they need root and Debian's packages.
fn containers(workspace: &Workspace, report: &mut Report) {
    for (task, arguments) in [("packages", &["packages", "--check"][..]), ("images", &["images"][..])] {
        let mut command = workspace.cargo();
        command.args(["run", "-q", "-p", "xtask", "--"]).args(arguments);
        let advice = format!("run it alone: cargo xtask {}", arguments.join(" "));
        report.step(&format!("{task}: amd64, arm64"), &advice, Step::new(command));
    }
}

/// The two sides of the boundary under Miri, if it is there: it is a component of nightly Rust.
fn miri(workspace: &Workspace, report: &mut Report) {
    let there = Command::new("cargo")
        .args(["+nightly", "miri", "--version"])
        .output()
        .is_ok_and(|output| output.status.success());
    if !there {
        report.left_out("miri", "it is not installed (rustup +nightly component add miri)");
        return;
    }
    let mut command = Command::new("cargo");
    command
        .args([
            "+nightly",
            "miri",
            "test",
            "-p",
            "skein-plugin-abi",
            "-p",
            "skein-plugin-sdk",
        ])
        .env("MIRIFLAGS", "-Zmiri-disable-isolation")
        .env("CARGO_TARGET_DIR", workspace.target.join("miri"))
        .current_dir(&workspace.root);
    report.step(
        "miri",
        "Miri names the undefined behaviour above",
        Step::tests(command, Runner::CargoTest),
    );
}

fn flight(workspace: &Workspace, arguments: &[&str], report_file: &Path) -> Command {
    let mut command = Command::new(workspace.target.join("release/skein"));
    command
        .arg("demo")
        .args(arguments)
        .arg("--headless")
        .arg("--report")
        .arg(report_file);
    command
}

/// Whether a program is on the search path.
pub fn is_installed(program: &str) -> bool {
    std::env::var_os("PATH")
        .is_some_and(|path| std::env::split_paths(&path).any(|folder| folder.join(program).is_file()))
}

/// Runs the coverage-guided fuzz targets, if the tool for it is there.
fn fuzz_targets(workspace: &Workspace, report: &mut Report) {
    let folder = workspace.root.join("tests/fuzz");
    if !is_installed("cargo-fuzz") {
        report.left_out(
            "fuzz: targets",
            "cargo-fuzz is not installed (cargo install cargo-fuzz; it needs nightly Rust)",
        );
        return;
    }
    let targets = std::fs::read_dir(folder.join("fuzz_targets"))
        .into_iter()
        .flatten()
        .flatten();
    for name in targets.filter_map(|entry| Some(entry.path().file_stem()?.to_string_lossy().into_owned())) {
        let mut fuzz = Command::new("cargo");
        fuzz.args(["+nightly", "fuzz", "run", "--fuzz-dir"])
            .arg(&folder)
            .arg(&name);
        fuzz.args(["--", &format!("-max_total_time={FUZZ_SECONDS}")])
            .current_dir(&workspace.root);
        report.step(
            &format!("fuzz: {name}"),
            "the input that broke it is in tests/fuzz/artifacts",
            Step::new(fuzz),
        );
    }
}
