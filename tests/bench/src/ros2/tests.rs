//! What can be told without ROS 2: arguments, ratios, and what stands in the table.

use super::*;

fn args(seconds: u32) -> Ros2BenchArgs {
    Ros2BenchArgs::new(
        PathBuf::from("/nowhere/bin/python"),
        seconds,
        PathBuf::from("/nowhere/skein"),
    )
}

#[test]
fn a_python_without_ros_2_and_a_window_of_nothing_are_refused() {
    let error = run_ros2_bench(&args(10)).unwrap_err().to_string();
    assert!(error.contains("/nowhere/bin/python"), "{error}");
    assert!(matches!(run_ros2_bench(&args(2)), Err(BenchError::Argument(_))));
}

#[test]
fn domains_are_not_used_twice() {
    let (one, other) = (fresh_domain(), fresh_domain());
    assert!(one != other && (1..=100).contains(&one) && (1..=100).contains(&other));
}

fn asked() -> Asked {
    Asked {
        one_way_us: vec![500; 100],
        there_and_back_us: vec![1000; 100],
        by_timer_us: vec![10_000; 100],
        rclpy_call_us: vec![2000; 10],
        skein_call_us: vec![6000, 2000, 3000],
        pose_age_us: vec![25_000, -3, 50_000],
        ..Asked::default()
    }
}

fn marked() -> Marked {
    Marked {
        reactions_us: vec![30_000, 12_000, 15_000],
        ..Marked::default()
    }
}

fn named<'a>(all: &'a [Latency], what: &str) -> &'a Latency {
    all.iter().find(|of| of.what == what).expect(what)
}

#[test]
fn each_latency_is_a_multiple_of_its_like() {
    let all = report::latencies(&asked(), &marked());
    let hold = named(&all, "call rclpy > Skein > rclpy: hold");
    assert_eq!((hold.samples, hold.p50_ms, hold.p99_ms), (3, 3.0, 6.0));
    assert_eq!((hold.p50_ratio, hold.p99_ratio), (Some(1.5), Some(3.0)));
    let reaction = named(&all, "PX4's position > Skein > PX4's setpoint");
    assert_eq!((reaction.p50_ratio, reaction.p99_ratio), (Some(15.0), Some(30.0)));
    assert_eq!(named(&all, "  beside the 50 Hz timer").p50_ratio, Some(1.5));
    let pose = named(&all, "PX4's position > Skein > rclpy");
    assert_eq!((pose.p50_ms, pose.p50_ratio), (25.0, Some(50.0)));
    // Nothing is a multiple of nothing.
    let none = report::latencies(&Asked::default(), &Marked::default());
    assert!(none.iter().all(|of| of.samples == 0 && of.p50_ratio.is_none()));
}

#[test]
fn the_table_sets_costs_beside_those_without_ros_2() {
    let cost = |link, vehicles, ros2, cpu_percent| CostFigures {
        link,
        vehicles,
        ros2,
        cpu_percent,
        rss_mib: 10.0 * cpu_percent,
        threads: 9,
        poses_hz: (ros2 == Shown::Heard).then_some(19.9),
        other_cpu_percent: 50.0,
    };
    let report = Ros2BenchReport {
        seconds: 30,
        processors: 2,
        latencies: report::latencies(&asked(), &marked()),
        refused: 0,
        unanswered: 1,
        lost_questions: 3,
        lost_marks: 2,
        busy_percent: 80.0,
        costs: vec![
            cost(VehicleLink::Mavlink, 10, Shown::Off, 8.0),
            cost(VehicleLink::Mavlink, 10, Shown::Heard, 12.0),
            cost(VehicleLink::Dds, 10, Shown::Off, 20.0),
            cost(VehicleLink::Dds, 10, Shown::Unheard, 22.0),
        ],
    };
    let text = report.to_string();
    let line = |begin: &str| {
        text.lines()
            .find(|line| line.starts_with(begin))
            .expect(begin)
            .to_owned()
    };
    let words = |line: String| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(
        words(line("MAVLink        10 heard")),
        ["MAVLink", "10", "heard", "12.0", "120.0", "9", "19.9", "1.50x", "1.50x"]
    );
    assert!(
        words(line("DDS            10 unheard")).contains(&"1.10x".to_owned()),
        "{text}"
    );
    assert!(words(line("MAVLink        10 off")).ends_with(&["-".to_owned(), "-".to_owned(), "-".to_owned()]));
    assert!(
        text.contains("1 not answered; 3 questions of rclpy to rclpy lost; 2 marks"),
        "{text}"
    );
}
