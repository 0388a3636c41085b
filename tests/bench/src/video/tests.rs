//! What can be told without starting processes: what a viewer counts, and figures put together.

use super::viewer::Seen;
use super::*;

#[test]
fn a_bench_of_nothing_is_refused() {
    let args = VideoBenchArgs::new("ffmpeg".into(), 0, "/nowhere/skein".into());
    assert!(matches!(run_video_bench(&args), Err(BenchError::Argument(_))));
    let args = VideoBenchArgs::new("/nowhere/ffmpeg".into(), 1, "/nowhere/skein".into());
    let error = run_video_bench(&args).unwrap_err();
    assert!(error.to_string().contains("/nowhere/ffmpeg"), "{error}");
}

#[test]
fn a_camera_that_has_stopped_counts_with_the_time_since_its_last_picture() {
    let begun = Instant::now();
    let at = |ms| begun + Duration::from_millis(ms);
    let mut seen = Seen::new(2, begun);
    for ms in (0..2000).step_by(100) {
        seen.picture(0, at(ms));
    }
    seen.picture(1, at(300));
    seen.picture(7, at(400));
    let figures = seen.figures(at(2000));
    assert_eq!(figures.rates_hz, [10.0, 0.5]);
    assert_eq!(figures.longest_gap_ms, 1700.0);
}

#[test]
fn each_relayed_stream_has_its_share_of_what_video_adds() {
    let window = |cpu_percent| WindowFigures {
        cpu_percent,
        ..WindowFigures::default()
    };
    let round = |with| Round {
        without: window(10.0),
        with: window(with),
        viewers: vec![ViewerFigures {
            rates_hz: vec![30.0; 8],
            longest_gap_ms: 50.0,
        }],
        ffmpeg_cpu_percent: 8.0,
    };
    let report = VideoBenchReport::of(8, 10, 5, &[round(20.0), round(30.0), round(25.0)]);
    assert_eq!((report.cpu_ratio, report.cpu_percent_per_relayed.median), (1.5, 1.5));
    assert_eq!(report.pictures_hz.median, 30.0);
    let shown = report.to_string();
    assert!(shown.contains("ours over ffmpeg's: 1.50 [1.00 .. 2.00]"), "{shown}");
}
