//! Vehicles that are heard for the first time while others fly: they are shown, and taken in when they have told their position for a while, so
//! many a minute at most. Whoever forges heartbeats makes no vehicles of ours.
//!
//! Must never do: keep one of ours waiting that is heard again, or anybody while nobody flies.

use super::{Discovery, FleetMessage, FleetState};
use ractor::ActorRef;
use skein_config::{AdoptionRule, NewcomerSettings};
use skein_domain::NodeTime;
use std::collections::VecDeque;
use std::time::Duration;

/// How often those on probation are looked at.
const LOOK: Duration = Duration::from_millis(250);
/// A vehicle that is really there tells this many things a second, over a poor radio too.
const LEAST_RATE_HZ: f32 = 4.0;
/// An older position is a pause, in seconds.
const POSITION_WITHIN_S: f64 = 1.0;

/// Who waits, and who was let in of late.
#[derive(Default)]
pub(super) struct Probation {
    waiting: Vec<Candidate>,
    admitted: VecDeque<NodeTime>,
}

struct Candidate {
    discovery: Discovery,
    rule: AdoptionRule,
    /// Since when it has told its position without a pause.
    steady_since: Option<NodeTime>,
}

impl Candidate {
    fn look(&mut self, now: NodeTime) {
        let (telemetry, health) = self.discovery.link.read(now);
        let placed = telemetry.local_frame.is_some()
            && telemetry.local.is_some_and(|position| position.is_finite())
            && now.seconds_since(telemetry.position_time) <= POSITION_WITHIN_S;
        let steady = placed && health.connected && health.receive_rate_hz >= LEAST_RATE_HZ;
        self.steady_since = steady.then(|| self.steady_since.unwrap_or(now));
    }

    fn passes(&self, now: NodeTime, settings: &NewcomerSettings) -> bool {
        let since = self.steady_since;
        since.is_some_and(|since| now.seconds_since(since) >= settings.probation_s)
    }
}

impl FleetState {
    fn somebody_flies(&self) -> bool {
        self.shared.peers().entries.iter().any(|entry| entry.airborne)
    }

    /// Whether it has to show first that it is there. If so it waits.
    pub(super) fn keep_on_probation(
        &mut self,
        myself: &ActorRef<FleetMessage>,
        discovery: Discovery,
        rule: &AdoptionRule,
    ) -> Option<Discovery> {
        if !self.somebody_flies() {
            return Some(discovery);
        }
        let probation_s = self.shared.config.newcomers.probation_s;
        let why = format!("others fly: it is taken in when it has told its position for {probation_s} s");
        self.not_adopted(discovery.unadopted(why));
        if self.probation.waiting.is_empty() {
            myself.send_after(LOOK, || FleetMessage::LookAtNewcomers);
        }
        // Who is heard again begins again: there is one of each system id at most.
        let again = discovery.system_id;
        let waiting = &mut self.probation.waiting;
        waiting.retain(|other| other.discovery.system_id != again);
        waiting.push(Candidate {
            discovery,
            rule: rule.clone(),
            steady_since: None,
        });
        None
    }

    /// Looks at those that wait, and takes in whom it may.
    pub(super) async fn look_at_newcomers(&mut self, myself: &ActorRef<FleetMessage>) {
        let now = self.shared.now();
        let free = !self.somebody_flies();
        let settings = self.shared.config.newcomers.clone();
        let mut waiting = std::mem::take(&mut self.probation.waiting);
        waiting.iter_mut().for_each(|candidate| candidate.look(now));
        for candidate in waiting {
            if free || (candidate.passes(now, &settings) && self.probation.has_room(now, settings.most_per_min)) {
                self.probation.admitted.push_back(now);
                self.take_in(myself, candidate.discovery, &candidate.rule).await;
            } else {
                self.probation.waiting.push(candidate);
            }
        }
        if !self.probation.waiting.is_empty() {
            myself.send_after(LOOK, || FleetMessage::LookAtNewcomers);
        }
    }
}

impl Probation {
    fn has_room(&mut self, now: NodeTime, most_per_min: u32) -> bool {
        while self.admitted.front().is_some_and(|at| now.seconds_since(*at) > 60.0) {
            self.admitted.pop_front();
        }
        self.admitted.len() < most_per_min as usize
    }
}

#[cfg(test)]
mod tests {
    //! How many are let in.

    use super::*;

    #[test]
    fn so_many_a_minute_and_no_more() {
        let mut probation = Probation::default();
        let at = NodeTime::from_seconds;
        for second in 0..3 {
            assert!(probation.has_room(at(f64::from(second)), 3));
            probation.admitted.push_back(at(f64::from(second)));
        }
        assert!(!probation.has_room(at(3.0), 3) && !probation.has_room(at(60.0), 3));
        assert!(probation.has_room(at(60.5), 3));
        assert!(!probation.has_room(at(60.5), 0));
    }
}
