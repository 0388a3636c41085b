//! Clippy's lints of everything in the workspace; a warning is an error.
//!
//! Must never do: leave out a program because it is not run by default.

use crate::report::Report;
use crate::step::Step;
use crate::workspace::Workspace;

/// What cargo calls all targets leaves out the test programs that run only where they are named: the tiers. They are named here.
const EVERYTHING: [(&str, &[&str]); 2] = [("clippy", &["--all-targets"]), ("clippy: the tiers", &["--test", "*"])];

/// Looks at everything. Only what changed since the last time, and what uses it, is looked at again.
pub fn check(workspace: &Workspace, report: &mut Report) {
    for (name, targets) in EVERYTHING {
        let mut lints = workspace.cargo();
        lints
            .args(["clippy", "--workspace"])
            .args(targets)
            .args(["--", "-D", "warnings"]);
        report.step(name, "mend what clippy names above", Step::new(lints));
    }
}
