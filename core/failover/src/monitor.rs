//! When a coordinator is missed, and whose turn it is to take over.
//!
//! Must never do: count the same pulse twice as a sign of life. Ages are not passed on, because those who pass them on to each other
//! would keep a dead holder alive; the numbers of pulses are.

use crate::{Beacon, Leadership, Standing, Term};
use serde::{Deserialize, Serialize};
use skein_domain::{NodeId, NodeTime};
use std::collections::BTreeMap;

/// Who may take over when the swarm has come apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Apart {
    /// Every part has a coordinator of its own.
    #[default]
    EveryPart,
    /// Only a part with more than half of the swarm takes over; the vehicles of the others do what [`crate::Unled`] says. A holder goes
    /// on for those it reaches, whatever their number. Of two equal halves only the holder's is led, and two nodes have no successor.
    Majority,
}

/// Limits of the monitor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LeaderMonitorSettings {
    /// A holder without a new pulse for so long is lost, in seconds. Several periods of beacons.
    pub lost_after_s: f64,
    /// Each less suited candidate waits so much longer than the one before it, in seconds: longer than a claim needs to get around.
    pub stagger_s: f64,
    /// A node that has just started listens for so long before it misses anybody, in seconds.
    pub listen_s: f64,
    /// How many others must be heard to take over. With none, a node that is cut off would coordinate itself alone.
    pub least_others: usize,
    /// Who may take over in a swarm that has come apart.
    pub apart: Apart,
    /// How many nodes the swarm has, for the majority; without it as many as have been heard since the monitor began.
    pub swarm_size: Option<usize>,
}

impl Default for LeaderMonitorSettings {
    fn default() -> Self {
        Self {
            lost_after_s: 0.5,
            stagger_s: 0.2,
            listen_s: 2.0,
            least_others: 1,
            apart: Apart::EveryPart,
            swarm_size: None,
        }
    }
}

/// What a candidate should do now.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Turn {
    /// A holder is there.
    Held,
    /// None is; others are to take over first, or it can't be said yet.
    Wait,
    /// It is this node's turn to claim the leadership.
    Claim,
    /// This node coordinates but is no candidate any more, and another one is: the leadership is to be offered to it.
    HandOver(NodeId),
    /// This node coordinates, but some obey another holder of the same number, and go on doing so: it is to take the next number.
    Renew,
    /// None is, and too few others are heard to take over: the node is cut off.
    Alone,
    /// None is, and this part of the swarm is too small to take over.
    Minority,
}

/// More nodes than any swarm has; those beyond are not counted on.
const MOST_NODES: usize = 1024;

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Heard {
    at: NodeTime,
    standing: Option<Standing>,
}

/// The monitor of one node over the leadership. As data it is what a turn was decided from.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct LeaderMonitor {
    settings: LeaderMonitorSettings,
    started: NodeTime,
    others: BTreeMap<NodeId, Heard>,
    /// The obeyed term, its newest pulse, and when that one was first heard of.
    pulse: Option<(Term, u64, NodeTime)>,
    /// Since when, and when last, others have been heard to obey another holder of the obeyed number.
    divided: Option<(NodeTime, NodeTime)>,
    /// When a better suited holder of the obeyed number was last heard itself.
    better_rival: Option<NodeTime>,
    /// When somebody last looked here.
    looked: Option<NodeTime>,
}

/// A node that looks every few hundredths of a second and then not for longer stood still: its computer slept, or its container was paused. What
/// is beyond is not counted as the others' silence; so much of each gap is, so that a node that is always late misses the dead all the same.
const LONGEST_LOOK_S: f64 = 0.25;

/// How much longer a holder that hears a better suited one of its number itself leaves the next number to that one. Were both as quick, each would take the
/// next number before it has heard that the other did, again and again, where messages take long.
const RIVAL_FIRST: f64 = 4.0;

impl LeaderMonitor {
    /// A monitor that begins at `now`.
    #[must_use]
    pub fn new(settings: LeaderMonitorSettings, now: NodeTime) -> Self {
        Self {
            settings,
            started: now,
            others: BTreeMap::new(),
            pulse: None,
            divided: None,
            better_rival: None,
            looked: None,
        }
    }

    /// To be called every few hundredths of a second, before anything that has arrived since is taken in. Time in which this node stood
    /// still is nobody's silence: what the others said meanwhile still lies in its sockets, or they stood still with it.
    pub fn look(&mut self, now: NodeTime) {
        let gap_s = self.looked.map_or(0.0, |looked| now.seconds_since(looked));
        self.looked = Some(self.looked.map_or(now, |looked| looked.max(now)));
        let still_s = gap_s - LONGEST_LOOK_S;
        if still_s > 0.0 {
            self.leave_out(still_s);
        }
    }

    /// Moves all that has been heard later by so much, as if the time had not passed.
    fn leave_out(&mut self, still_s: f64) {
        let later = |at: &mut NodeTime| *at = at.plus_seconds(still_s);
        later(&mut self.started);
        self.others.values_mut().for_each(|heard| later(&mut heard.at));
        self.pulse.iter_mut().for_each(|(.., since)| later(since));
        self.divided.iter_mut().for_each(|(first, last)| {
            later(first);
            later(last);
        });
        self.better_rival.iter_mut().for_each(later);
    }

    /// Takes a beacon of another node in. Call it after [`Leadership::hear`].
    pub fn hear(&mut self, now: NodeTime, leadership: &Leadership, beacon: &Beacon) {
        let room = self.others.len() < MOST_NODES || self.others.contains_key(&beacon.from);
        // Its own beacon, sent back by somebody, says nothing about others.
        if beacon.from == leadership.node() || !room {
            return;
        }
        let heard = Heard {
            at: now,
            standing: beacon.standing,
        };
        self.others.insert(beacon.from, heard);
        self.follow(now, leadership);
        let same_number = |(a, b): (Term, Term)| a.number == b.number && a.holder.node != b.holder.node;
        if leadership.obeyed().zip(beacon.obeys).is_some_and(same_number) {
            // A late beacon of somebody who has come round since must not count as lasting.
            let lasting = self
                .divided
                .filter(|(_, last)| now.seconds_since(*last) <= self.settings.lost_after_s);
            self.divided = Some((lasting.map_or(now, |(first, _)| first), now));
            let better = beacon.obeys.map(|term| term.holder) > leadership.obeyed().map(|term| term.holder);
            if better && beacon.obeys.is_some_and(|term| term.holder.node == beacon.from) {
                self.better_rival = Some(now);
            }
        }
        if let Some((term, pulse, since)) = self.pulse.as_mut()
            && beacon.obeys == Some(*term)
            && beacon.pulse > *pulse
        {
            (*pulse, *since) = (beacon.pulse, now);
        }
    }

    /// The beacon to send now. A holder's counts its pulse up.
    pub fn beacon(&mut self, now: NodeTime, me: NodeId, leadership: &Leadership) -> Beacon {
        self.follow(now, leadership);
        if let Some((_, pulse, since)) = self.pulse.as_mut().filter(|_| leadership.acting().is_some()) {
            (*pulse, *since) = (pulse.saturating_add(1), now);
        }
        Beacon {
            from: me,
            obeys: leadership.obeyed(),
            pulse: self.pulse.map_or(0, |(_, pulse, _)| pulse),
            standing: leadership.standing(),
        }
    }

    /// How long there has been no new pulse of the obeyed term's holder, in seconds; none before the first term.
    #[must_use]
    pub fn silent_s(&self, now: NodeTime) -> Option<f64> {
        self.pulse.map(|(_, _, since)| now.seconds_since(since))
    }

    /// The others heard lately.
    pub fn present(&self, now: NodeTime) -> impl Iterator<Item = NodeId> {
        self.heard_lately(now).map(|(node, _)| node)
    }

    /// The most suited of the others heard lately: whom the leadership is to be handed to.
    #[must_use]
    pub fn heir(&self, now: NodeTime) -> Option<NodeId> {
        let standings = self.heard_lately(now).filter_map(|(_, heard)| heard.standing);
        standings.max().map(|standing| standing.node)
    }

    /// What a candidate should do now.
    #[must_use]
    pub fn turn(&self, now: NodeTime, leadership: &Leadership) -> Turn {
        if leadership.acting().is_some() {
            return self.holders_turn(now, leadership);
        }
        if self
            .silent_s(now)
            .is_some_and(|silent_s| silent_s <= self.settings.lost_after_s)
        {
            return Turn::Held;
        }
        let missed_s = self.missed_s(now);
        let Some(mine) = leadership.standing().filter(|_| missed_s > 0.0) else {
            return Turn::Wait;
        };
        let others = self.present(now).count();
        if others < self.settings.least_others {
            return Turn::Alone;
        }
        let swarm = self.settings.swarm_size.unwrap_or(self.others.len() + 1);
        if self.settings.apart == Apart::Majority && (others + 1) * 2 <= swarm {
            return Turn::Minority;
        }
        if missed_s > self.settings.stagger_s * self.better_than(now, leadership, mine) as f64 {
            Turn::Claim
        } else {
            Turn::Wait
        }
    }

    fn holders_turn(&self, now: NodeTime, leadership: &Leadership) -> Turn {
        // The better suited one renews at once when it hears of it; if none has, the other one is not acting, or does not hear of it.
        let recent_s = self.settings.lost_after_s;
        let rival = self.better_rival.is_some_and(|at| now.seconds_since(at) <= recent_s);
        let limit_s = if rival { recent_s * RIVAL_FIRST } else { recent_s };
        let lasts = self
            .divided
            .is_some_and(|(first, last)| last.seconds_since(first) > limit_s && now.seconds_since(last) <= recent_s);
        if leadership.standing().is_none() {
            return self.heir(now).map_or(Turn::Held, Turn::HandOver);
        }
        if lasts { Turn::Renew } else { Turn::Held }
    }

    /// How long the holder has been missed, in seconds. Who has just started misses nobody before it has listened.
    fn missed_s(&self, now: NodeTime) -> f64 {
        let listened_s = now.seconds_since(self.started) - self.settings.listen_s;
        let lost_s = self
            .silent_s(now)
            .map_or(listened_s, |silent_s| silent_s - self.settings.lost_after_s);
        lost_s.min(listened_s)
    }

    /// How many of those heard lately are more suited. The missed holder is none of them: it may still be heard of, not acting.
    fn better_than(&self, now: NodeTime, leadership: &Leadership, mine: Standing) -> usize {
        let missed = leadership.obeyed().map(|term| term.holder.node);
        self.heard_lately(now)
            .filter(|(id, heard)| Some(*id) != missed && heard.standing.is_some_and(|standing| standing > mine))
            .count()
    }

    /// Somebody not heard for longer is not counted on. As long as a holder's: whoever went with it is then known to have gone.
    fn heard_lately(&self, now: NodeTime) -> impl Iterator<Item = (NodeId, Heard)> {
        let within_s = self.settings.lost_after_s;
        self.others
            .iter()
            .filter(move |(_, heard)| now.seconds_since(heard.at) <= within_s)
            .map(|(node, heard)| (*node, *heard))
    }

    /// A holder without a new pulse for so long is lost, in seconds.
    pub(crate) fn lost_after_s(&self) -> f64 {
        self.settings.lost_after_s
    }

    /// For how long this monitor has gone on, in seconds.
    pub(crate) fn watched_s(&self, now: NodeTime) -> f64 {
        now.seconds_since(self.started)
    }

    /// Begins to count anew when another term is obeyed: taking the leadership is a sign of life.
    fn follow(&mut self, now: NodeTime, leadership: &Leadership) {
        let Some(obeyed) = leadership.obeyed() else { return };
        if self.pulse.is_none_or(|(term, ..)| term != obeyed) {
            self.pulse = Some((obeyed, 0, now));
            self.divided = None;
            self.better_rival = None;
        }
    }
}

#[cfg(test)]
mod tests;
