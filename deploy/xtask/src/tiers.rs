//! `test`: what CI runs, tier by tier, with the set-up each one needs.
//!
//! Must never do: pass a tier in which no test ran, or check at the desk otherwise than in CI.

mod parallel;
mod programs;

use self::programs::Built;
use crate::plugins::{self, Profile};
use crate::report::Report;
use crate::step::Step;
use crate::tally::Runner;
use crate::unsteady::History;
use crate::workspace::{Package, Workspace};
use crate::{artifacts, browser, lints, long_runs, namespaces, tidy, ui};
use anyhow::{Result, ensure};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Duration;

/// A tier of tests. `tests/README.md` says what each proves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tier {
    /// Formatting, habits, lints, licences: nothing that runs our code.
    Static,
    /// Beside the code: every crate's own tests, and the dashboard's.
    Unit,
    /// The crates' own tests in real time: links, transports and the API over sockets.
    Wire,
    /// The whole node in one process, against simulated vehicles.
    Integration,
    /// Built plugin libraries, good and misbehaving.
    PluginBoundary,
    /// Actors and plugins killed, links cut.
    Faults,
    /// Whole flights in simulated time, drawn from seeds.
    Seeded,
    /// The program as it ships.
    E2e,
    /// The program on several hosts, each a network namespace of this machine.
    Multihost,
    /// Other people's software and recordings of a real autopilot.
    Interop,
    /// The dashboard in a real browser.
    Ui,
    /// The dashboard for an hour: what it holds stays the same. A long one.
    UiSoak,
}

const ALL: [(Tier, &str); 12] = [
    (Tier::Static, "static"),
    (Tier::Unit, "unit"),
    (Tier::Wire, "wire"),
    (Tier::Integration, "integration"),
    (Tier::PluginBoundary, "plugin-boundary"),
    (Tier::Faults, "faults"),
    (Tier::Seeded, "seeded"),
    (Tier::E2e, "e2e"),
    (Tier::Multihost, "multihost"),
    (Tier::Interop, "interop"),
    (Tier::Ui, "ui"),
    (Tier::UiSoak, "ui-soak"),
];

/// The dashboard's soak is told by this variable how many seconds it is to take.
const SOAK_VARIABLE: &str = "SKEIN_SOAK_S";
const SOAK_S: u64 = 3600;
/// What it takes beside them: start, a round that is not counted, the last gesture, the end.
const AROUND_SOAK: Duration = Duration::from_secs(25 * 60);

const SEE_TESTS: &str = "the failing tests are named above; run this tier alone with";

/// Reads a tier's name from the command line.
pub fn parse(name: &str) -> Result<Tier, String> {
    ALL.iter()
        .find(|(_, known)| *known == name)
        .map(|(tier, _)| *tier)
        .ok_or_else(|| {
            let names: Vec<&str> = ALL.iter().map(|(_, name)| *name).collect();
            format!("no such tier yet; there are {}", names.join(", "))
        })
}

impl Tier {
    fn name(self) -> &'static str {
        ALL.iter().find(|(tier, _)| *tier == self).map_or("", |(_, name)| name)
    }

    /// How many of its tests run at a time. Flights are in real time and mostly wait, but one that is judged by its gaps must not be
    /// starved by others.
    fn at_a_time(self) -> &'static str {
        match self {
            Self::Unit => "4",
            Self::Wire | Self::Integration | Self::Faults => "3",
            _ => "1",
        }
    }

    /// The same, as its test programs are told it.
    fn threads(self) -> Vec<String> {
        ["--test-threads", self.at_a_time()].map(str::to_owned).into()
    }

    /// What its test programs are told besides: tests that are ignored for their length run where the tier is named, and with `--all`.
    fn told(self, whole: bool) -> Vec<String> {
        let includes = whole && self != Self::Unit;
        includes.then(|| "--include-ignored".to_owned()).into_iter().collect()
    }

    /// What to do where its tests fail.
    fn advice(self) -> String {
        format!("{SEE_TESTS} `cargo xtask test {}`", self.name())
    }

    /// Whether it takes all of the processor that it gets. The others mostly wait.
    fn is_cpu_bound(self) -> bool {
        matches!(self, Self::Static | Self::Unit | Self::Seeded)
    }

    /// Whether its tests fly in real time, so that a machine that stands still can fail them: these are tried again, alone. What is
    /// computed, or flown in simulated time, comes out the same each time: a second try could only hide that it does not.
    fn is_in_real_time(self) -> bool {
        // Playwright tries them again itself, and `web-ui/*/playwright.config.ts` says whether
        !self.is_cpu_bound() && !matches!(self, Self::Ui | Self::UiSoak)
    }

    /// Whether it runs only where it is named, and with `--all`.
    fn is_long(self) -> bool {
        matches!(self, Self::Multihost | Self::UiSoak)
    }

    /// The crate that holds the tier, if it is one.
    fn package(self) -> Option<&'static str> {
        match self {
            Self::Static | Self::Unit | Self::Wire | Self::Ui | Self::UiSoak => None,
            Self::Integration => Some("skein-tests-integration"),
            Self::PluginBoundary => Some("skein-tests-plugin-boundary"),
            Self::Faults => Some("skein-tests-faults"),
            Self::Seeded => Some("skein-seeded"),
            Self::E2e => Some("skein-tests-e2e"),
            Self::Multihost => Some("skein-tests-multihost"),
            Self::Interop => Some("skein-tests-interop"),
        }
    }
}

/// Runs the tiers named; with none, every tier.
pub fn run(workspace: &Workspace, tiers: &[Tier], long_ones_too: bool) -> Result<ExitCode> {
    #[expect(
        clippy::needless_late_init,
        reason = "the report knows how to try its tests again, and so has to be dropped first"
    )]
    let built;
    let mut report = Report::new();
    let everything = tiers.is_empty();
    let known = ALL.iter().map(|(tier, _)| *tier);
    let tiers: Vec<Tier> = known
        .filter(|tier| tiers.contains(tier) || if tier.is_long() { long_ones_too } else { everything })
        .collect();
    let needs_page = tiers
        .iter()
        .any(|tier| matches!(tier, Tier::Unit | Tier::E2e | Tier::Ui | Tier::UiSoak));
    let whole = !everything || long_ones_too;
    let run = Run {
        workspace,
        everything,
        whole,
    };
    if tiers.contains(&Tier::Static) {
        static_checks(workspace, &mut report, whole);
    }
    if tiers == [Tier::Static] {
        lints::check(workspace, &mut report);
        return Ok(report.close());
    }
    if needs_page {
        report.check("dashboard built", "run `cargo xtask build-ui`", || ui::build(workspace));
    }
    built = build_all(&run, &tiers, &mut report);
    match &built {
        Some(built) => parallel::run(&tiers, &run, built, &mut report),
        None => tiers
            .iter()
            .for_each(|tier| report.left_out(tier.name(), "the workspace does not compile")),
    }
    if let (true, Some(built)) = (long_ones_too, &built) {
        long_runs::run(workspace, &mut report, |command| {
            built.tell(command);
        });
    }
    remember_unsteady(workspace, &mut report, long_ones_too);
    Ok(report.close())
}

/// What every tier of a run is told.
struct Run<'w> {
    workspace: &'w Workspace,
    /// No tier was named.
    everything: bool,
    /// The tiers run with what takes long.
    whole: bool,
}

impl<'r> Run<'r> {
    fn tier(&self, tier: Tier, built: &'r Built, report: &mut Report<'r>) {
        let workspace = self.workspace;
        match tier {
            Tier::Static => lints::check(workspace, report),
            Tier::Unit => unit(workspace, report, built),
            Tier::Wire => wire(report, built, self.whole),
            Tier::Ui => browser_tests(workspace, report, built, self.whole),
            Tier::UiSoak => browser_soak(workspace, report, built),
            Tier::Multihost => multihost(workspace, report, built, self.everything),
            tier => crate_tier(workspace, report, tier, built, self.whole),
        }
    }
}

/// Notes what was unsteady. With `--all`, what has been so before fails the run: that is no noise.
fn remember_unsteady(workspace: &Workspace, report: &mut Report, long_ones_too: bool) {
    let Some(history) = History::of_this_user() else {
        report.left_out("unsteady tests", "there is no home to keep a history of them in");
        return;
    };
    let tests = report.unsteady_tests();
    if !tests.is_empty() {
        history.add(&workspace.commit(), &tests);
        println!("-- unsteady tests are noted in {}", history.file().display());
    }
    if long_ones_too {
        let file = history.file().display();
        let advice = format!("mend the test, or the program; then take its lines out of {file}");
        report.check("unsteady tests", &advice, || {
            let told = |(test, times): (String, usize)| format!("{test} ({times} times)");
            let repeated: Vec<String> = history.repeated().into_iter().map(told).collect();
            ensure!(repeated.is_empty(), "in more than one run: {}", repeated.join(", "));
            Ok(())
        });
    }
}

fn static_checks(workspace: &Workspace, report: &mut Report, whole: bool) {
    let mut format = workspace.cargo();
    format.args(["fmt", "--all", "--check"]);
    report.step("formatting", "run `cargo fmt --all`", Step::new(format));
    report.check(
        "tidy",
        "each finding says what to do; `cargo xtask tidy` repeats them",
        || tidy::check(workspace),
    );
    if !whole {
        report.left_out("cargo-deny", "`cargo xtask test static` has it");
        return;
    }
    if long_runs::is_installed("cargo-deny") {
        let mut deny = workspace.cargo();
        deny.args(["deny", "--all-features", "check", "bans", "licenses", "sources"]);
        report.step(
            "cargo-deny",
            "see deny.toml: an exception needs a reason",
            Step::new(deny),
        );
    } else {
        report.left_out("cargo-deny", "it is not installed (cargo install cargo-deny)");
    }
}

/// Program, plugins, tests: everything in one go.
fn build_all(run: &Run<'_>, tiers: &[Tier], report: &mut Report) -> Option<Built> {
    let workspace = run.workspace;
    let packages = tiers.iter().filter_map(|tier| workspace.package(tier.package()?));
    let packages: Vec<&Package> = packages.collect();
    let mut built = None;
    report.check("everything built", "mend the compile error above", || {
        let mut made = Vec::new();
        for arguments in artifacts::builds(workspace, run.whole, &packages) {
            let mut build = workspace.cargo();
            build.arg("build").args(arguments);
            made.extend(artifacts::build(workspace, build)?);
        }
        let plugins = plugins::collect(workspace, Profile::Dev, &made)?;
        built = Some(Built::new(workspace, made, plugins));
        Ok(())
    });
    built
}

fn unit<'r>(workspace: &'r Workspace, report: &mut Report<'r>, built: &'r Built) {
    let advice = Tier::Unit.advice();
    let crates = move |arguments: &[String]| built.own_tests(false, arguments);
    report.same_each_time("unit: crates", &advice, crates(&Tier::Unit.threads()), move |names| {
        crates(&alone(names))
    });
    let documented = "unit: examples in the documentation";
    match tidy::with_examples(workspace) {
        Ok(packages) => {
            let mut examples = workspace.cargo();
            examples.args(["test", "--doc", "--no-fail-fast"]);
            examples.args(packages.iter().flat_map(|name| ["-p", *name]));
            report.step(documented, &advice, Step::tests(examples, Runner::CargoTest));
        }
        Err(error) => drop(report.check(documented, &advice, || Err(error))),
    }
    let types = Step::new(ui::npm(workspace, &["run", "check"]));
    report.step("unit: dashboard types", "run `npm run check` in web-ui", types);
    let tests = Step::tests(ui::npm(workspace, &["run", "test"]), Runner::Vitest);
    report.step("unit: dashboard", "run `npm test` in web-ui", tests);
}

fn wire<'r>(report: &mut Report<'r>, built: &'r Built, whole: bool) {
    let tier = Tier::Wire;
    let told = tier.told(whole);
    let first = built.own_tests(true, &[tier.threads(), told.clone()].concat());
    let again = move |names: &[String]| built.own_tests(true, &[told.clone(), alone(names)].concat());
    report.tests(tier.name(), &tier.advice(), first, again);
}

fn multihost<'r>(workspace: &'r Workspace, report: &mut Report<'r>, built: &'r Built, may_be_left_out: bool) {
    let advice =
        "run it as root, on a Linux kernel with namespaces, veth and TUN devices; it needs ip and tc of iproute2";
    match namespaces::can_be_made() {
        Err(error) if may_be_left_out => report.left_out("multihost", &format!("{error:#}")),
        Err(error) => {
            report.check("multihost: hosts", advice, || Err(error));
        }
        Ok(()) => crate_tier(workspace, report, Tier::Multihost, built, true),
    }
}

fn crate_tier<'r>(workspace: &'r Workspace, report: &mut Report<'r>, tier: Tier, built: &'r Built, whole: bool) {
    let Some(package) = tier.package().and_then(|name| workspace.package(name)) else {
        return;
    };
    let told = tier.told(whole);
    let first = built.tests_of(package, &[tier.threads(), told.clone()].concat());
    let advice = tier.advice();
    let again = move |names: &[String]| built.tests_of(package, &[told.clone(), alone(names)].concat());
    if tier.is_in_real_time() {
        report.tests(tier.name(), &advice, first, again);
    } else {
        report.same_each_time(tier.name(), &advice, first, again);
    }
}

/// Only these tests, one after the other.
fn alone(names: &[String]) -> Vec<String> {
    let options = ["--exact", "--test-threads", "1"].map(str::to_owned);
    [&options[..], names].concat()
}

/// Those whose name has this tag run only where the tier is named, and with `--all`.
const LONG_IN_BROWSER: &str = "@long";

fn browser_tests<'r>(workspace: &'r Workspace, report: &mut Report<'r>, built: &'r Built, whole: bool) {
    let Some(chromium) = chromium(report, Tier::Ui) else {
        return;
    };
    let tests = move |options: &[&str]| {
        let mut tests = in_browser(workspace, built, &chromium, "e2e");
        tests.arg("--").args(options);
        if !whole {
            tests.args(["--grep-invert", LONG_IN_BROWSER]);
        }
        Step::tests(tests, Runner::Playwright)
    };
    let advice = format!("{SEE_TESTS} `cargo xtask test ui`; traces are in test-results/");
    // Playwright has tried them again itself; these are tried anew where the machine stood still.
    report.tries_itself("ui", &advice, tests(&[]), move |_| tests(&["--last-failed"]));
}

fn browser_soak(workspace: &Workspace, report: &mut Report, built: &Built) {
    let Some(chromium) = chromium(report, Tier::UiSoak) else {
        return;
    };
    let mut soak = in_browser(workspace, built, &chromium, "soak");
    let told = std::env::var(SOAK_VARIABLE)
        .ok()
        .and_then(|seconds| seconds.parse().ok());
    let seconds = told.unwrap_or(SOAK_S);
    soak.env(SOAK_VARIABLE, seconds.to_string());
    let advice =
        format!("the table above says what grew; `{SOAK_VARIABLE}=300 cargo xtask test ui-soak` takes less long");
    let step = Step::tests(soak, Runner::Playwright).within(Duration::from_secs(seconds) + AROUND_SOAK);
    report.step("ui-soak", &advice, step);
}

/// Where Chromium is.
fn chromium(report: &mut Report, tier: Tier) -> Option<PathBuf> {
    let mut found = None;
    let advice = format!("install Chromium, or set {} to its path", browser::VARIABLE);
    report.check(&format!("{}: browser", tier.name()), &advice, || {
        found = Some(browser::chromium()?);
        Ok(())
    });
    found
}

/// The script of the dashboard that is a tier and needs Chromium and the program.
fn in_browser(workspace: &Workspace, built: &Built, chromium: &Path, script: &str) -> Command {
    let mut command = ui::npm(workspace, &["run", script]);
    // Playwright must not look for browsers of its own
    built
        .tell(&mut command)
        .env(browser::VARIABLE, chromium)
        .env("PLAYWRIGHT_SKIP_BROWSER_DOWNLOAD", "1");
    command
}
