//! What can be told without starting processes: arguments, and figures put together.

use super::*;
use crate::report::{Gaps, Spread};

#[test]
fn a_bench_of_nothing_is_refused() {
    let args = FleetBenchArgs::new(3, 0, PathBuf::from("/nowhere/skein"));
    assert!(matches!(run_fleet_bench(&args), Err(BenchError::Argument(_))));
    let args = FleetBenchArgs {
        seconds: 1,
        rounds: 0,
        ..args
    };
    assert!(matches!(run_fleet_bench(&args), Err(BenchError::Argument(_))));
}

#[test]
fn a_program_that_is_not_there_is_named() {
    let args = FleetBenchArgs::new(3, 1, PathBuf::from("/nowhere/skein"));
    assert_eq!(args.plugins, PathBuf::from("/nowhere/plugins"));
    let error = run_fleet_bench(&args).unwrap_err();
    assert!(error.to_string().contains("/nowhere/skein"), "{error}");
}

fn figures(cpu_percent: f64, p99_ms: f64) -> WindowFigures {
    let gaps = Gaps {
        p99_ms,
        over_60_ms: 1,
        ..Gaps::default()
    };
    WindowFigures {
        cpu_percent,
        rss_mib: 30.0,
        load: LoadFigures {
            gaps,
            ..LoadFigures::default()
        },
        ..WindowFigures::default()
    }
}

#[test]
fn medians_and_ratios_come_from_the_windows() {
    let program = vec![figures(30.0, 22.0), figures(60.0, 24.0), figures(36.0, 23.0)];
    let bare = vec![figures(10.0, 21.0), figures(12.0, 21.0), figures(18.0, 21.0)];
    let recording = vec![WindowFigures {
        recorded_bytes_per_s_per_vehicle: 800.0,
        ..figures(39.6, 25.0)
    }];
    let report = FleetBenchReport::of(20, 10.0, program, recording, bare);
    assert_eq!(report.recording_cpu_ratio, 1.1);
    assert_eq!(report.recorded_bytes_per_s_per_vehicle.median, 800.0);
    assert_eq!(
        report.program.cpu_percent,
        Spread {
            min: 30.0,
            median: 36.0,
            max: 60.0
        }
    );
    assert_eq!(report.program.cpu_percent_per_vehicle.median, 1.8);
    assert_eq!(
        (report.program.rss_mib_per_vehicle, report.program.gaps_over_60_ms),
        (1.5, 3)
    );
    assert_eq!(report.cpu_ratio, 3.0);
    assert_eq!(
        report.cpu_ratio_of_rounds,
        Spread {
            min: 2.0,
            median: 3.0,
            max: 5.0
        }
    );
    let json = serde_json::to_string(&report).unwrap();
    assert_eq!(serde_json::from_str::<FleetBenchReport>(&json).unwrap(), report);
    assert!(report.to_string().contains("3.00 [2.00 .. 5.00]"), "{report}");
    assert_eq!(Spread::of([4.0, 1.0]).median, 2.5);
    assert_eq!(FleetBenchReport::of(20, 10.0, vec![], vec![], vec![]).cpu_ratio, 0.0);
}
