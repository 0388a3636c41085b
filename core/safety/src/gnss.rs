//! How far two sources of a vehicle's position are apart: its estimate, its satellite receivers, and its own frame.
//!
//! Must never do: decide which of them is right.

use skein_domain::{Geodetic, GnssFix, NodeTime, SwarmFrame, Telemetry};

/// What was heard longer ago than this, in seconds, is not compared.
const COMPARED_WITHIN_S: f64 = 2.0;
/// Delay between a receiver's measurement and its report that a moving vehicle is allowed beside what the times of arrival say.
const REPORT_DELAY_S: f64 = 0.25;

/// Whether a fix gives a place in three dimensions.
#[must_use]
pub fn is_good_fix(fix: GnssFix) -> bool {
    matches!(
        fix,
        GnssFix::ThreeD | GnssFix::Dgps | GnssFix::RtkFloat | GnssFix::RtkFixed
    )
}

/// The greatest horizontal distance in metres between any two of: the position estimate, either satellite receiver, and the local
/// estimate in the vehicle's own frame. What was measured at another time is given the way flown between. `None` when there
/// are no two to compare. Heights are left out: those of receivers and barometers differ by more than any limit of use.
#[must_use]
pub fn disagreement_m(telemetry: &Telemetry, now: NodeTime) -> Option<f64> {
    let t = telemetry;
    let local = t.local_frame.zip(t.local).map(|(frame, local)| frame.geodetic(&local));
    let sources: Vec<(Geodetic, NodeTime)> = [
        (t.global, t.heard.global),
        (t.gnss_place, t.heard.gnss),
        (t.gnss2_place, t.heard.gnss2),
        (local, t.heard.local),
    ]
    .into_iter()
    .filter_map(|(place, heard)| Some((place?, heard)))
    .filter(|(place, heard)| place.is_valid() && now.seconds_since(*heard) <= COMPARED_WITHIN_S)
    .collect();
    let speed_m_s = t.velocity.map_or(0.0, |v| v.north_m_s.hypot(v.east_m_s));
    let mut greatest = None;
    for (i, (a, heard_a)) in sources.iter().enumerate() {
        for (b, heard_b) in sources.iter().skip(i + 1) {
            let apart_m = horizontal_m(a, b);
            let flown_m = speed_m_s * (heard_a.seconds_since(*heard_b).abs() + REPORT_DELAY_S);
            let unexplained_m = if flown_m.is_finite() {
                (apart_m - flown_m).max(0.0)
            } else {
                apart_m
            };
            greatest = Some(f64::max(greatest.unwrap_or(0.0), unexplained_m));
        }
    }
    greatest
}

fn horizontal_m(a: &Geodetic, b: &Geodetic) -> f64 {
    let position = SwarmFrame::new(*a).position(b);
    position.north_m.hypot(position.east_m)
}

#[cfg(test)]
mod tests;
