//! Whether the control loop comes in time, for the operator: what one late computer does to all vehicles has one cause.
//!
//! Must never do: decide anything. What flies has its own watch.

use crate::snapshot::EventKind;
use skein_domain::NodeTime;
use skein_domain::exchange::Severity;

/// A beat that comes later than this is told, in seconds. Setpoints are held on to for longer.
const LATE_S: f64 = 0.25;
/// So long without a late beat it is over, in seconds.
const OVER_AFTER_S: f64 = 5.0;

/// The beats so far.
#[derive(Debug, Default)]
pub(crate) struct Overrun {
    last: Option<NodeTime>,
    /// Of the last late beat, until it is over.
    late: Option<NodeTime>,
}

/// What there is to tell of a beat.
pub(crate) type Told = (Severity, EventKind, String);

impl Overrun {
    /// Takes note of a beat.
    pub(crate) fn beat(&mut self, now: NodeTime, period_s: f64) -> Option<Told> {
        let since_s = self.last.replace(now).map_or(0.0, |last| now.seconds_since(last));
        let by_s = since_s - period_s;
        if by_s > LATE_S {
            self.late = Some(now);
            let text = format!("this computer was late by {by_s:.1} s");
            return Some((Severity::Warning, EventKind::Overrun { by_s }, text));
        }
        self.late.take_if(|late| now.seconds_since(*late) > OVER_AFTER_S)?;
        Some((
            Severity::Info,
            EventKind::OverrunEnded,
            "this computer is in time again".to_owned(),
        ))
    }
}

#[cfg(test)]
mod tests {
    //! Each late beat is told, and once that it is over.

    use super::*;

    fn told(gaps_s: &[f64]) -> Vec<String> {
        let (mut overrun, mut now_s) = (Overrun::default(), 0.0);
        let mut texts = Vec::new();
        for gap_s in gaps_s {
            now_s += gap_s;
            texts.extend(
                overrun
                    .beat(NodeTime::from_seconds(now_s), 0.02)
                    .map(|(_, _, text)| text),
            );
        }
        texts
    }

    #[test]
    fn late_beats_are_told_and_their_end_once() {
        let in_time = [0.02; 600];
        assert_eq!(told(&in_time), Vec::<String>::new());
        let late = [&in_time[..10], &[0.42, 0.02, 1.02], &in_time[..]].concat();
        assert_eq!(
            told(&late),
            [
                "this computer was late by 0.4 s",
                "this computer was late by 1.0 s",
                "this computer is in time again"
            ]
        );
    }

    #[test]
    fn the_first_beat_is_not_late() {
        assert_eq!(told(&[100.0, 0.02]), Vec::<String>::new());
    }
}
