//! What a run has built and tests: the program, the plugins, the test programs. These are run as they are, without cargo, which would let only
//! one tier at a time begin.
//!
//! Must never do: run a test program that this run has not built.

use crate::artifacts::{Artifact, is_tier_or_fixture};
use crate::plugins::Profile;
use crate::step::Step;
use crate::tally::Runner;
use crate::workspace::{Package, Workspace};
use std::path::PathBuf;
use std::process::Command;

/// What property tests draw their inputs from. Every run draws the same, so that it comes out the same; `--all` draws others, and more.
const DRAWN_FROM: &str = "PROPTEST_RNG_SEED";
const SEED_OF_EVERY_RUN: &str = "1";

/// Where the artefacts under test are; the tests find them through variables (see skein-testkit).
pub struct Built {
    root: PathBuf,
    binary: PathBuf,
    plugins: PathBuf,
    examples: PathBuf,
    programs: Vec<Program>,
}

/// A test program.
struct Program {
    /// Folder of its package, relative to the root.
    folder: String,
    path: PathBuf,
    /// As its manifest says: see [`Package::in_real_time`].
    in_real_time: bool,
}

impl Built {
    /// What `made` holds.
    pub fn new(workspace: &Workspace, made: Vec<Artifact>, plugins: PathBuf) -> Self {
        let output = workspace.target.join(Profile::Dev.folder());
        let program = |artifact: Artifact| {
            let path = artifact.executable.filter(|_| artifact.is_test)?;
            let folder = artifact.folder;
            let mut packages = workspace.packages.iter();
            let package = packages.find(|package| package.folder == folder);
            let in_real_time = package.is_some_and(|package| package.in_real_time.contains(&artifact.name));
            Some(Program {
                folder,
                path,
                in_real_time,
            })
        };
        Self {
            root: workspace.root.clone(),
            binary: output.join("skein"),
            plugins,
            examples: output.join("examples"),
            programs: made.into_iter().filter_map(program).collect(),
        }
    }

    /// Tells a command where they are.
    pub fn tell<'c>(&self, command: &'c mut Command) -> &'c mut Command {
        command
            .env("SKEIN_BINARY", &self.binary)
            .env("SKEIN_PLUGINS", &self.plugins)
            .env("SKEIN_EXAMPLES", &self.examples)
    }

    /// The tests beside the code, and the own test files of crates that are no tier: those in real time, or the others. The arguments are those
    /// of the test programs.
    pub fn own_tests(&self, in_real_time: bool, arguments: &[String]) -> Step {
        let is_selected =
            |program: &Program| program.in_real_time == in_real_time && !is_tier_or_fixture(&program.folder);
        self.tests(is_selected, arguments)
    }

    /// The tests of one tier's crate.
    pub fn tests_of(&self, package: &Package, arguments: &[String]) -> Step {
        self.tests(|program| program.folder == package.folder, arguments)
    }

    fn tests(&self, is_selected: impl Fn(&Program) -> bool, arguments: &[String]) -> Step {
        let selected = self.programs.iter().filter(|program| is_selected(program));
        let command = |program: &Program| {
            let folder = self.root.join(&program.folder);
            let mut command = Command::new(&program.path);
            // as cargo runs them
            command.current_dir(&folder).env("CARGO_MANIFEST_DIR", &folder);
            command.env(DRAWN_FROM, SEED_OF_EVERY_RUN).args(arguments);
            self.tell(&mut command);
            command
        };
        Step::programs(selected.map(command).collect(), Runner::CargoTest)
    }
}
