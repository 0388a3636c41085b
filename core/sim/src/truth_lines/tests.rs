//! How the truth is written: the gaps between lines, and the times of what is caught up on.

use super::*;

fn frame(time_s: f64, gap_s: f64) -> TruthFrame {
    TruthFrame {
        time_s,
        vehicles: vec![VehicleTruth {
            system_id: 7,
            offboard_gap_recent_s: gap_s,
            ..VehicleTruth::default()
        }],
        ..TruthFrame::default()
    }
}

fn lines(frames: &[(f64, f64, f64)]) -> Vec<TruthLine> {
    let mut out = Vec::new();
    let mut lines = TruthLines::new(&mut out);
    for (time_s, gap_s, now_s) in frames {
        lines.look_at(&frame(*time_s, *gap_s), *now_s);
    }
    let text = String::from_utf8(out).expect("text");
    text.lines()
        .map(|line| serde_json::from_str(line).expect("a line"))
        .collect()
}

#[test]
fn the_longest_gap_of_the_frames_between_is_told_once() {
    let told = lines(&[
        (0.02, 0.01, 100.02),
        (0.04, 0.3, 100.04),
        (0.06, 0.02, 100.06),
        (0.08, 0.0, 100.08),
        (0.10, 0.0, 100.10),
        (0.12, 0.01, 100.12),
    ]);
    let gaps: Vec<f64> = told.iter().map(|line| line.vehicles[0].setpoint_gap_s).collect();
    assert_eq!(gaps, [0.3, 0.01]);
    assert_eq!(told[0].vehicles[0].system_id, 7);
}

#[test]
fn what_is_caught_up_on_belongs_to_its_own_time() {
    let told = lines(&[(0.0, 0.0, 100.0), (0.02, 0.0, 100.5), (0.04, 0.0, 100.5)]);
    assert!((told[0].time_s - 100.04).abs() < 1e-6, "{told:?}");
}

#[test]
fn time_that_was_let_go_is_not_caught_up_on() {
    let told = lines(&[(0.0, 0.0, 100.0), (0.02, 0.0, 103.02), (0.04, 0.0, 103.04)]);
    assert!((told[0].time_s - 103.04).abs() < 1e-6, "{told:?}");
}
