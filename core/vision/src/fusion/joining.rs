//! Which tracklets belong together, and to which tracks. Nothing is decided while another answer is nearly as good: the next sightings will tell.

use super::birth::{self, Explained};
use super::estimate::Estimate;
use super::tracklet::{Belongs, Tracklet};
use super::{BELIEVED_AFTER, FARTHEST, Observation, Sensor, SwarmTracker, Track};
use std::cmp::Ordering;
use std::collections::BTreeSet;

/// Sightings that are needed before anything is decided.
pub(super) const ENOUGH: usize = 5;
/// And how long they have to last, in seconds.
const ENOUGH_S: f64 = 0.4;
/// What belongs together deviates by less than this, by the deviation that is expected.
const FITS: f64 = 2.2;
/// The second best has to be worse by this, as twice a logarithm of likelihoods.
const CLEARLY: f64 = 9.0;
/// After this many seconds less is enough: a target that flies along with another is to be seen at last.
const PATIENCE_S: f64 = 3.0;
const LESS_CLEARLY: f64 = 2.0;
/// What is one thing is no larger than by this factor from one side than from another.
const SIZES_DIFFER: f64 = 4.0;
/// Two tracks that are no farther from each other are one: 95 % of six squared deviations.
const SAME: f64 = 12.6;

impl SwarmTracker {
    /// Tracklets that a track predicted go to it.
    pub(super) fn join_tracks(&mut self) {
        let mut fits: Vec<(f64, usize, u64)> = Vec::new();
        for index in 0..self.tracklets.len() {
            let best = self.best_track(&self.tracklets[index]);
            let tracklet = &mut self.tracklets[index];
            // Things cross: what has a track with a guessed range goes to a known one only if it stays where that is.
            let since = tracklet
                .fits
                .filter(|(id, _)| best.is_some_and(|(_, best)| best == *id));
            tracklet.fits = since.or(best.map(|(_, id)| (id, tracklet.seen())));
            let lasts_s = tracklet
                .fits
                .map_or(0.0, |(_, since)| tracklet.seen().seconds_since(since));
            if let Some((cost, id)) = best.filter(|_| tracklet.belongs == Belongs::Nothing || lasts_s > PATIENCE_S) {
                fits.push((cost, index, id));
            }
        }
        fits.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, index, id) in fits {
            let sensor = self.tracklets[index].sensor.clone();
            let now = self.tracklets[index].seen();
            if self.tracks.iter().any(|track| track.id == id) && !self.sensors_of(id, now).contains(&sensor) {
                let id = match self.tracklets[index].belongs {
                    Belongs::Track(guessed) => self.unite(id, guessed),
                    _ => id,
                };
                self.tracklets[index].belongs = Belongs::Track(id);
                self.learn(index, id);
            }
        }
    }

    /// The track that predicts what a tracklet saw, if it may go to one and no other track does nearly as well; and how badly.
    fn best_track(&self, tracklet: &Tracklet) -> Option<(f64, u64)> {
        if !self.is_free(tracklet) || !is_enough(tracklet) {
            return None;
        }
        let known = self
            .tracks
            .iter()
            .filter(|track| track.sightings >= BELIEVED_AFTER && tracklet.belongs != Belongs::Track(track.id))
            .filter(|track| !track.guessed_range || self.goes_on_with(track, tracklet));
        let free = known.filter(|track| !self.sees(tracklet, track));
        let mut costs: Vec<(f64, u64)> = free
            .filter_map(|track| Some((self.cost(tracklet, &track.estimate)?, track.id)))
            .collect();
        costs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let wanted = if tracklet.age_s() > PATIENCE_S {
            LESS_CLEARLY
        } else {
            CLEARLY
        };
        let clear = costs.get(1).is_none_or(|second| second.0 - costs[0].0 > wanted);
        costs.first().copied().filter(|_| clear)
    }

    /// Whether a track is looked for that a tracklet belongs to: it belongs to none, or alone to one whose range is only guessed.
    fn is_free(&self, tracklet: &Tracklet) -> bool {
        match tracklet.belongs {
            Belongs::Nothing => true,
            Belongs::Track(id) => {
                let alone = self.sensors_of(id, tracklet.seen()).len() == 1;
                alone && self.tracks.iter().any(|track| track.id == id && track.guessed_range)
            }
            Belongs::Own(_) | Belongs::Dropped => false,
        }
    }

    /// Whether a track whose range is guessed was taken over from another tracker, this tracklet's sensor saw it there, and nobody has seen it here yet.
    fn goes_on_with(&self, track: &Track, tracklet: &Tracklet) -> bool {
        track.taken_over_from.contains(&tracklet.sensor) && self.sensors_of(track.id, tracklet.seen()).is_empty()
    }

    /// Whether this tracklet's sensor sees the track under another name.
    fn sees(&self, tracklet: &Tracklet, track: &Track) -> bool {
        self.sensors_of(track.id, tracklet.seen()).contains(&tracklet.sensor)
    }

    /// Whether a track that is known predicts what a tracklet saw.
    pub(super) fn is_predicted(&self, tracklet: &Tracklet) -> bool {
        let mut known = self
            .tracks
            .iter()
            .filter(|track| track.sightings >= BELIEVED_AFTER && !track.guessed_range);
        known.any(|track| self.cost(tracklet, &track.estimate).is_some())
    }

    /// How badly an estimate predicts what a tracklet saw; `None` if it does not.
    fn cost(&self, tracklet: &Tracklet, estimate: &Estimate) -> Option<f64> {
        let (mut squared, mut dimensions, mut cost) = (0.0, 0, 0.0);
        for (time, seen) in &tracklet.sightings {
            let fit = estimate.fit(*time, seen, self.settings.acceleration_m2_s3)?;
            squared += fit.squared;
            dimensions += fit.dimensions;
            cost += fit.cost();
        }
        (squared < FITS * dimensions as f64).then_some(cost)
    }

    /// What a tracklet knew before it belonged to the track: its newest sighting, and what it takes it for.
    fn learn(&mut self, index: usize, id: u64) {
        let tracklet = &self.tracklets[index];
        let Some(track) = self.tracks.iter_mut().find(|track| track.id == id) else {
            return;
        };
        if let Some((time, seen)) = tracklet.sightings.back()
            && track.estimate.correct(*time, seen, self.settings.acceleration_m2_s3)
        {
            track.seen = track.seen.max(tracklet.seen());
        }
        track.scores.blend(&tracklet.scores, 0.2);
    }

    /// Tracklets of two cameras that see one thing begin a track, or make a guessed one a known one.
    pub(super) fn pair_cameras(&mut self) {
        loop {
            let pairs = self.pairs();
            let clear = pairs.iter().filter(|pair| is_clear(pair, &pairs, &self.tracklets));
            let worse = |pair: &Pair| (std::cmp::Reverse(pair.witnesses), pair.explained.ratio());
            let best = clear.min_by(|a, b| {
                let (a, b) = (worse(a), worse(b));
                a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
            });
            let Some(best) = best else { return };
            let (first, second, estimate) = (best.first, best.second, best.explained.estimate.clone());
            if !self.begin_pair(first, second, estimate) {
                return;
            }
            self.join_tracks();
        }
    }

    /// All that could belong together.
    fn pairs(&self) -> Vec<Pair> {
        let open: Vec<usize> = (0..self.tracklets.len()).filter(|index| self.is_open(*index)).collect();
        let mut pairs = Vec::new();
        for (place, first) in open.iter().copied().enumerate() {
            for second in open[place + 1..].iter().copied() {
                let (a, b) = (&self.tracklets[first], &self.tracklets[second]);
                let apart_s = a.seen().seconds_since(b.seen()).abs();
                if a.sensor == b.sensor || apart_s > self.settings.sight_lost_s {
                    continue;
                }
                let (a_seen, b_seen): (Vec<_>, Vec<_>) = (
                    a.sightings.iter().cloned().collect(),
                    b.sightings.iter().cloned().collect(),
                );
                let explained = birth::explain(a.seen().max(b.seen()), &a_seen, &b_seen);
                let fits = |explained: &Explained| {
                    explained.ratio() < FITS
                        && are_as_large(a, b, &explained.estimate)
                        && [a, b].into_iter().all(|one| self.agrees(one, &explained.estimate))
                };
                if let Some(explained) = explained.filter(fits) {
                    let witnesses = self.witnesses(&open, first, second, &explained.estimate);
                    pairs.push(Pair {
                        first,
                        second,
                        explained,
                        witnesses,
                    });
                }
            }
        }
        pairs
    }

    /// Whether the track that a tracklet belongs to, if it is known where that is, may be there too: a pair moves no track to somewhere else.
    fn agrees(&self, tracklet: &Tracklet, estimate: &Estimate) -> bool {
        let of_it = |track: &&Track| tracklet.belongs == Belongs::Track(track.id) && !track.guessed_range;
        self.tracks.iter().find(of_it).is_none_or(|track| {
            let known = track.estimate.at(estimate.time, self.settings.acceleration_m2_s3);
            let off = known.position() - estimate.position();
            let whole = (known.position_covariance() + estimate.position_covariance()).cholesky();
            whole.is_some_and(|whole| off.dot(&whole.solve(&off)) < FARTHEST[3])
        })
    }

    /// How many other sensors see something there.
    fn witnesses(&self, open: &[usize], first: usize, second: usize, estimate: &Estimate) -> usize {
        let of_pair = [&self.tracklets[first].sensor, &self.tracklets[second].sensor];
        let others = open.iter().map(|index| &self.tracklets[*index]);
        let others = others.filter(|tracklet| !of_pair.contains(&&tracklet.sensor));
        let seeing = others.filter(|tracklet| self.cost(tracklet, estimate).is_some());
        let sensors: BTreeSet<&Sensor> = seeing.map(|tracklet| &tracklet.sensor).collect();
        sensors.len()
    }

    /// Whether a partner is looked for: a camera's tracklet that belongs to nothing, or alone to its track.
    fn is_open(&self, index: usize) -> bool {
        let tracklet = &self.tracklets[index];
        let open = match tracklet.belongs {
            Belongs::Nothing => true,
            Belongs::Track(id) => self.sensors_of(id, tracklet.seen()).len() == 1,
            Belongs::Own(_) | Belongs::Dropped => false,
        };
        open && tracklet.is_bearing() && is_enough(tracklet)
    }

    fn begin_pair(&mut self, first: usize, second: usize, estimate: Estimate) -> bool {
        let guessed = [first, second].map(|index| match self.tracklets[index].belongs {
            Belongs::Track(id) => Some(id),
            _ => None,
        });
        let id = match guessed {
            [Some(id), Some(other)] => {
                let (kept, gone) = self.older(id, other);
                self.swallow(kept, gone);
                Some(kept)
            }
            [Some(id), None] | [None, Some(id)] => Some(id),
            [None, None] => {
                let scores = self.tracklets[first].scores.clone();
                let worth = [first, second].map(|index| self.tracklets[index].worth());
                self.begin(estimate.clone(), scores, BELIEVED_AFTER, worth.iter().sum())
            }
        };
        let Some(id) = id else { return false };
        if let Some(track) = self.tracks.iter_mut().find(|track| track.id == id) {
            track.seen = estimate.time;
            track.estimate = estimate;
            track.guessed_range = false;
            track.scores.blend(&self.tracklets[second].scores, 0.5);
        }
        for index in [first, second] {
            self.tracklets[index].belongs = Belongs::Track(id);
        }
        true
    }

    /// One of two tracks that are one ends; what spoke for it speaks for the other.
    fn swallow(&mut self, kept: u64, gone: u64) {
        let of_gone = self
            .tracks
            .iter()
            .find(|track| track.id == gone)
            .map(|track| track.evidence);
        self.tracks.retain(|track| track.id != gone);
        if let (Some(kept), Some(of_gone)) = (self.tracks.iter_mut().find(|track| track.id == kept), of_gone) {
            kept.evidence.join(&of_gone);
        }
    }

    /// Two tracks are one, and it is where the first is: the number that is kept.
    fn unite(&mut self, placed: u64, other: u64) -> u64 {
        let (kept, gone) = self.older(placed, other);
        let place = self.tracks.iter().find(|track| track.id == placed);
        let place = place.map(|track| (track.estimate.clone(), track.guessed_range));
        if let (Some(kept), Some((estimate, guessed_range))) =
            (self.tracks.iter_mut().find(|track| track.id == kept), place)
        {
            kept.estimate = estimate;
            kept.guessed_range = guessed_range;
        }
        self.swallow(kept, gone);
        for tracklet in &mut self.tracklets {
            if tracklet.belongs == Belongs::Track(gone) {
                tracklet.belongs = Belongs::Track(kept);
            }
        }
        kept
    }

    /// Which of two tracks is kept when they are one: the pinned, the named, the older.
    fn older(&self, first: u64, second: u64) -> (u64, u64) {
        let rank = |id: u64| {
            let track = self.tracks.iter().find(|track| track.id == id);
            track.map_or((false, false), |track| (track.pinned, !track.name.is_empty()))
        };
        let first_stays = (rank(first), std::cmp::Reverse(first)) > (rank(second), std::cmp::Reverse(second));
        if first_stays { (first, second) } else { (second, first) }
    }

    /// A tracklet of positions that no track predicted.
    pub(super) fn begin_from_positions(&mut self) {
        for index in 0..self.tracklets.len() {
            let tracklet = &self.tracklets[index];
            let Some((time, Observation::Position { position, covariance })) = tracklet.sightings.back() else {
                continue;
            };
            if tracklet.belongs == Belongs::Nothing && is_enough(tracklet) {
                let mut estimate = Estimate::of_position(*time, position, covariance);
                for (time, seen) in tracklet.sightings.iter().rev().skip(1) {
                    estimate.correct(*time, seen, self.settings.acceleration_m2_s3);
                }
                let (scores, worth) = (tracklet.scores.clone(), tracklet.worth());
                if let Some(id) = self.begin(estimate, scores, BELIEVED_AFTER, worth) {
                    self.tracklets[index].belongs = Belongs::Track(id);
                }
            }
        }
    }

    /// Two tracks that are one become one.
    pub(super) fn merge(&mut self) {
        while let Some((first, second)) = self.same() {
            let placed = self.older(first, second).0;
            self.unite(placed, if placed == first { second } else { first });
        }
    }

    /// Two tracks that no sensor tells apart, and that are where the other one is.
    fn same(&self) -> Option<(u64, u64)> {
        let known: Vec<&Track> = self.tracks.iter().filter(|track| !track.guessed_range).collect();
        for (place, first) in known.iter().enumerate() {
            for second in &known[place + 1..] {
                let now = first.estimate.time.max(second.estimate.time);
                let told_apart = {
                    let sensors = self.sensors_of(first.id, now);
                    self.sensors_of(second.id, now)
                        .iter()
                        .any(|sensor| sensors.contains(sensor))
                };
                let density = self.settings.acceleration_m2_s3;
                let (a, b) = (first.estimate.at(now, density), second.estimate.at(now, density));
                let off = a.state - b.state;
                let whole = (a.covariance + b.covariance).cholesky();
                let near = whole.is_some_and(|whole| off.dot(&whole.solve(&off)) < SAME);
                // Two that are hardly known anywhere are not known to be one.
                let sharp = (a.position_covariance() + b.position_covariance()).trace() < 100.0;
                if near && sharp && !told_apart {
                    return Some((first.id, second.id));
                }
            }
        }
        None
    }
}

/// Two tracklets that one thing explains.
struct Pair {
    first: usize,
    second: usize,
    explained: Explained,
    /// Other sensors that see something there.
    witnesses: usize,
}

impl Pair {
    fn has(&self, index: usize) -> bool {
        self.first == index || self.second == index
    }

    fn other(&self, index: usize) -> usize {
        if self.first == index { self.second } else { self.first }
    }
}

/// Whether one thing at a place would look as large to both as it does. What is none crosses somewhere, and would be a grain to one and a barn to the other.
fn are_as_large(first: &Tracklet, second: &Tracklet, estimate: &Estimate) -> bool {
    let place = estimate.position();
    let sizes_m = first.size_at_m(&place).zip(second.size_at_m(&place));
    sizes_m.is_none_or(|(a_m, b_m)| (a_m / b_m).ln().abs() < SIZES_DIFFER.ln())
}

/// Whether no other pair that has one of its tracklets, and the same two sensors, has as many witnesses and explains nearly as well.
fn is_clear(pair: &Pair, pairs: &[Pair], tracklets: &[Tracklet]) -> bool {
    let age_s = tracklets[pair.first].age_s().min(tracklets[pair.second].age_s());
    let wanted = if age_s > PATIENCE_S { LESS_CLEARLY } else { CLEARLY };
    let rival = |index: usize| {
        let sensor = &tracklets[pair.other(index)].sensor;
        let rivals = pairs
            .iter()
            .filter(|rival| rival.has(index) && rival.other(index) != pair.other(index));
        let mut of_sensor = rivals.filter(|rival| tracklets[rival.other(index)].sensor == *sensor);
        of_sensor.any(|rival| match rival.witnesses.cmp(&pair.witnesses) {
            Ordering::Less => false,
            Ordering::Equal => rival.explained.squared - pair.explained.squared < wanted,
            Ordering::Greater => true,
        })
    };
    !rival(pair.first) && !rival(pair.second)
}

pub(super) fn is_enough(tracklet: &Tracklet) -> bool {
    let lasts_s = match (tracklet.sightings.front(), tracklet.sightings.back()) {
        (Some(first), Some(last)) => last.0.seconds_since(first.0),
        _ => 0.0,
    };
    tracklet.sightings.len() >= ENOUGH && lasts_s >= ENOUGH_S
}
