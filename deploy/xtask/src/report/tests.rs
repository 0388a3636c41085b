//! What a run comes to.

use super::*;
use anyhow::bail;

fn code(report: Report) -> String {
    format!("{:?}", report.close())
}

#[test]
fn a_failed_step_fails_the_run_and_counts() {
    let mut report = Report::new();
    assert!(report.check("good", "nothing", || Ok(())));
    assert!(!report.check("bad", "mend it", || bail!("broken")));
    assert_eq!(
        report.total(),
        Tally {
            passed: 0,
            failed: 1,
            skipped: 0
        }
    );
    assert_eq!(code(report), format!("{:?}", ExitCode::FAILURE));
}

#[test]
fn a_run_without_failures_succeeds() {
    let mut report = Report::new();
    report.check("good", "nothing", || Ok(()));
    assert_eq!(report.total(), Tally::default());
    assert_eq!(code(report), format!("{:?}", ExitCode::SUCCESS));
}
