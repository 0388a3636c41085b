//! Moments of the recording as time of day.
//!
//! Must never do: show a time without saying somewhere on the page which time it is.

use crate::facts::About;
use jiff::Timestamp;
use jiff::tz::{Offset, TimeZone};

/// Tells moments in time of day.
#[derive(Debug, Clone)]
pub struct Clock {
    begins_unix_ms: i64,
    offset: Offset,
}

impl Clock {
    /// The clock of a report.
    pub fn of(about: &About) -> Self {
        Self {
            begins_unix_ms: about.begins_unix_ms,
            offset: Offset::from_seconds(about.utc_offset_s).unwrap_or(Offset::UTC),
        }
    }

    fn told(&self, t_s: f64, how: &str) -> String {
        let at_ms = self.begins_unix_ms.saturating_add((t_s * 1e3).round() as i64);
        let zone = TimeZone::fixed(self.offset);
        Timestamp::from_millisecond(at_ms).map_or_else(
            |_| format!("{t_s:.0} s"),
            |at| at.to_zoned(zone).strftime(how).to_string(),
        )
    }

    /// `12:03:44`
    pub fn time(&self, t_s: f64) -> String {
        self.told(t_s, "%H:%M:%S")
    }

    /// `12:03`
    pub fn minute(&self, t_s: f64) -> String {
        self.told(t_s, "%H:%M")
    }

    /// `28 November 2026, 12:03:44 UTC`
    pub fn date_time(&self, t_s: f64) -> String {
        format!("{} {}", self.told(t_s, "%-d %B %Y, %H:%M:%S"), self.zone())
    }

    /// `UTC` or `UTC+02:00`
    pub fn zone(&self) -> String {
        match self.offset.seconds() {
            0 => "UTC".into(),
            seconds => {
                let sign = if seconds < 0 { '-' } else { '+' };
                let minutes = seconds.abs() / 60;
                format!("UTC{sign}{:02}:{:02}", minutes / 60, minutes % 60)
            }
        }
    }

    /// Moments about `step_s` apart that are round in time of day, within the recording.
    pub fn round_moments(&self, step_s: f64, duration_s: f64) -> Vec<f64> {
        let begins_s = self.begins_unix_ms as f64 * 1e-3 + f64::from(self.offset.seconds());
        let first_s = (begins_s / step_s).ceil() * step_s - begins_s;
        let count = ((duration_s - first_s) / step_s).floor().clamp(-1.0, 100.0) as i64;
        (0..=count).map(|n| first_s + n as f64 * step_s).collect()
    }
}
