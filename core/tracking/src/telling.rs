//! What is told of tracks in the event log: that one begins, ends, or is taken for a vehicle of ours; and how much of it at most.
//!
//! Must never do: fill the log. Of very many only how many is said.

use skein_domain::exchange::Severity;
use skein_domain::payload::TrackEstimate;
use skein_domain::{NodeTime, VehicleId};
use skein_state::SharedState;
use skein_view::EventKind;
use std::collections::BTreeSet;

/// So many events are told in so many seconds at most.
const MOST: u32 = 20;
const WITHIN_S: f64 = 10.0;

/// What was told.
#[derive(Debug, Default)]
pub(crate) struct Telling {
    known: BTreeSet<u64>,
    ours: BTreeSet<u64>,
    limit: Limit,
}

impl Telling {
    /// These are no news.
    pub(crate) fn know(&mut self, tracks: impl IntoIterator<Item = u64>) {
        self.known.extend(tracks);
    }

    /// An operator ended this one, which is told by itself.
    pub(crate) fn forget(&mut self, track: u64) {
        self.known.remove(&track);
        self.ours.remove(&track);
    }

    /// Tells what is new.
    pub(crate) fn tell(&mut self, shared: &SharedState, tracks: &[TrackEstimate], now: NodeTime) {
        let ours = shared.observed.tracks_of_ours();
        for (track, text) in self.news(tracks, &ours) {
            if self.limit.admits(now) {
                let kind = EventKind::Track { track };
                shared.events.record(now, None, Severity::Info, kind, text);
            }
        }
        if let Some(left_out) = self.limit.left_out(now) {
            let text = format!("{left_out} more tracks have begun or ended");
            shared.events.record(now, None, Severity::Info, EventKind::Notice, text);
        }
    }

    fn news(&mut self, tracks: &[TrackEstimate], ours: &[(u64, VehicleId)]) -> Vec<(u64, String)> {
        let mut news = Vec::new();
        let there: BTreeSet<u64> = tracks.iter().map(|track| track.track.track).collect();
        for track in tracks.iter().filter(|track| !self.known.contains(&track.track.track)) {
            news.push((track.track.track, begins(track)));
        }
        for gone in self.known.difference(&there) {
            news.push((*gone, format!("track {gone} has ended")));
        }
        self.ours.retain(|track| ours.iter().any(|(known, _)| known == track));
        for (track, vehicle) in ours {
            if there.contains(track) && self.ours.insert(*track) {
                news.push((*track, format!("track {track} is taken for vehicle {vehicle} of ours")));
            }
        }
        self.known = there;
        news
    }
}

fn begins(track: &TrackEstimate) -> String {
    let place = track.track.position;
    let class = if track.class.is_empty() {
        "unknown"
    } else {
        &track.class
    };
    let range = if track.guessed_range {
        ", its range is only guessed"
    } else {
        ""
    };
    format!(
        "track {} ({class}) has begun: {:.0} m north, {:.0} m east, seen by {}{range}",
        track.track.track,
        place.north_m,
        place.east_m,
        track.sensors.join(", ")
    )
}

/// A number of events in a time.
#[derive(Debug, Default)]
struct Limit {
    since: NodeTime,
    told: u32,
    left_out: u32,
}

impl Limit {
    fn admits(&mut self, now: NodeTime) -> bool {
        if now.seconds_since(self.since) >= WITHIN_S && self.left_out == 0 {
            (self.since, self.told) = (now, 0);
        }
        self.told += 1;
        let admitted = self.told <= MOST;
        self.left_out += u32::from(!admitted);
        admitted
    }

    /// How many were left out, once the time is over.
    fn left_out(&mut self, now: NodeTime) -> Option<u32> {
        if self.left_out == 0 || now.seconds_since(self.since) < WITHIN_S {
            return None;
        }
        (self.since, self.told) = (now, 0);
        Some(std::mem::take(&mut self.left_out))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use skein_domain::payload::{FIRST_FUSED_TRACK, Track};
    use skein_domain::{PositionNed, VelocityNed};

    fn track(number: u64) -> TrackEstimate {
        TrackEstimate::told(Track {
            track: FIRST_FUSED_TRACK + number,
            position: PositionNed::default(),
            velocity: VelocityNed::default(),
            time: NodeTime(0),
            error_m: None,
        })
    }

    #[test]
    fn what_begins_ends_or_turns_out_ours_is_told_once() {
        let mut telling = Telling::default();
        telling.know([FIRST_FUSED_TRACK]);
        let both = [track(0), track(1)];
        let ours = [(FIRST_FUSED_TRACK + 1, VehicleId(3))];
        let told: Vec<u64> = telling.news(&both, &[]).into_iter().map(|(track, _)| track).collect();
        assert_eq!(told, [FIRST_FUSED_TRACK + 1]);
        assert_eq!(telling.news(&both, &ours).len(), 1);
        assert!(telling.news(&both, &ours).is_empty());
        telling.forget(FIRST_FUSED_TRACK + 1);
        let [(gone, _)] = telling.news(&[], &[]).try_into().expect("one ends by itself");
        assert_eq!(gone, FIRST_FUSED_TRACK);
    }

    #[test]
    fn of_very_many_only_how_many_is_told() {
        let mut limit = Limit::default();
        let at = |s: f64| NodeTime::from_seconds(100.0 + s);
        let admitted = (0..50).filter(|_| limit.admits(at(0.0))).count();
        assert_eq!(admitted, 20);
        assert_eq!(limit.left_out(at(9.0)), None);
        assert_eq!(limit.left_out(at(10.0)), Some(30));
        assert_eq!(limit.left_out(at(20.0)), None);
        assert!(limit.admits(at(20.0)));
    }
}
