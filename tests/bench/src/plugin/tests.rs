//! The figures and their table; a whole run needs built libraries and is made by hand or by the program's command.

use super::*;

#[test]
fn quantiles_of_a_round() {
    assert_eq!(quantiles((1..=1000).rev().map(f64::from).collect()), (501.0, 991.0));
    assert_eq!(quantiles(vec![7.0]), (7.0, 7.0));
    assert_eq!(quantiles(Vec::new()), (0.0, 0.0));
}

#[test]
fn the_table_names_every_way_once_with_its_ratio() {
    let rounds = vec![(250.0, 400.0), (300.0, 500.0), (260.0, 450.0)];
    let report = PluginBenchReport {
        plugin: "bench-echo 0.1.0".to_owned(),
        payload_bytes: 100,
        rounds: 3,
        processors: 2,
        in_process: figures(&rounds, 26.0),
        ..PluginBenchReport::default()
    };
    assert_eq!(report.in_process.ratio_to_direct, 10.0);
    let text = report.to_string();
    assert_eq!(text.lines().count(), 9);
    let line = text
        .lines()
        .find(|line| line.starts_with("in this process"))
        .expect("is there");
    assert!(
        line.contains("260 [250 .. 300]") && line.contains("450") && line.ends_with("10.0"),
        "{line}"
    );
}

#[test]
fn the_echo_called_directly_is_one() {
    let args = PluginBenchArgs::new(PathBuf::new(), PathBuf::new());
    let mut effects = Effects::default();
    let bytes: Vec<u8> = (0..args.payload_bytes).map(|i| i as u8).collect();
    let events = [Event::Received { bytes: bytes.clone() }];
    Echo::default().handle(NodeTime(1), &events, &mut effects);
    assert_eq!(effects.as_slice(), [Effect::Transmit { bytes }]);
}
