//! Moments in time of day (UTC), as text.
//!
//! Must never do: read a clock, or end the program because a file tells of a year that there is none of.

use jiff::Timestamp;

/// A moment in nanoseconds since 1970, to the microsecond.
pub(crate) fn timestamp(unix_ns: u64) -> Timestamp {
    let us = i64::try_from(unix_ns / 1_000).unwrap_or(i64::MAX);
    Timestamp::from_microsecond(us).unwrap_or(Timestamp::MAX)
}

/// `2026-11-28T10:31:52.120000Z`.
pub(crate) fn precise(unix_ns: u64) -> String {
    timestamp(unix_ns).strftime("%Y-%m-%dT%H:%M:%S.%6fZ").to_string()
}

/// `2026-11-28 10:31:52 UTC`, of nanoseconds since 1970.
#[must_use]
pub fn time_of_day(unix_ns: u64) -> String {
    timestamp(unix_ns).strftime("%Y-%m-%d %H:%M:%S UTC").to_string()
}
