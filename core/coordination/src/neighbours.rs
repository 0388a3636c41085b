//! Our vehicles and what is tracked as the separation filter wants them, with whether they do their part.
//!
//! Must never do: leave out one whose position is known. Who is in doubt is taken for one that does not give way.

use skein_domain::payload::{Track, TrackEstimate, TrackSource};
use skein_domain::{FlightState, NodeTime, PositionNed, VelocityNed};
use skein_safety::avoidance::{Cooperation, Neighbour, NeighbourId};
use skein_view::PeerEntry;

/// How far a vehicle's position may be wrong, in metres: three standard deviations of an ordinary satellite estimate relative to another
/// one of the same swarm.
const VEHICLE_UNCERTAINTY_M: f64 = 0.3;
/// The same for what is seen in a picture.
const TRACK_UNCERTAINTY_M: f64 = 2.0;
/// A track of the swarm's own making whose place is known worse than this, as a standard deviation in metres, is nowhere in particular.
const TRACK_KNOWN_WITHIN_M: f64 = 10.0;
/// It is kept away from if its place is known as well as this, and has been there for so long, in seconds: to keep away from wherever it may be, and from all
/// that a detector takes for something for a moment, would drive everybody about.
const TRACK_KEPT_AWAY_WITHIN_M: f64 = 3.0;
const TRACK_KEPT_AWAY_FROM_S: f64 = 2.0;
/// And if it is as sure as this that there is something.
const TRACK_KEPT_AWAY_CONFIDENCE: f64 = 0.7;
/// So hard an autopilot brakes that has lost its setpoints, at most, in metres per second squared.
const HARDEST_BRAKING_M_S2: f64 = 7.0;
/// When one that has just fallen silent may have begun to brake: not yet, on the way, or at once, as a share of the time since.
const STARTS_TO_BRAKE: [f64; 3] = [1.0, 0.5, 0.0];
/// How hard it may have turned aside meanwhile, in metres per second squared, and how far at most, in metres.
const TURNS_ASIDE_M_S2: f64 = 3.0;
const TURNS_ASIDE_MAX_M: f64 = 1.5;
/// A vehicle not heard for so long, in seconds, hears us no more than we hear it: without setpoints its autopilot stops it.
const STOPS_AFTER_S: f64 = 2.0;
/// By then it has come as far as it came before in so many seconds: half a second's way, if it braked at once, and two, if it went on for a
/// second first. It is kept away from at each of these places, so close to each other that nobody fits between two.
const STOPS_WITHIN_S: [f64; 5] = [0.5, 0.9, 1.3, 1.7, 2.1];
/// How far beside that way it may have come to stand, as the time it would have taken, in seconds.
const STOPS_BESIDE_S: f64 = 0.25;
/// Slower than this it stood, in metres per second.
const STOOD_M_S: f64 = 0.2;
/// Heights over its last known place at which a silent vehicle may be met, in metres: so close that nobody fits between two.
const COLUMN_M: [f64; 7] = [0.0, 5.0, 10.0, 15.0, 20.0, -5.0, -10.0];
/// A vehicle whose state is older than this does not do its part, in seconds.
const FRESH_S: f64 = 0.5;

/// Something tracked as the filters see it.
#[must_use]
pub fn track(track: &Track) -> Neighbour {
    Neighbour {
        id: NeighbourId::Foreign(track.track),
        position: track.position,
        velocity: track.velocity,
        measured: track.time,
        uncertainty_m: TRACK_UNCERTAINTY_M,
        cooperation: Cooperation::DoesNot,
        airborne: true,
    }
}

/// Whether a track is known well enough to be flown by: whatever was told is.
#[must_use]
pub fn is_known(estimate: &TrackEstimate) -> bool {
    match estimate.source {
        TrackSource::Told => true,
        TrackSource::Fused => is_known_within(estimate, TRACK_KNOWN_WITHIN_M),
    }
}

fn is_known_within(estimate: &TrackEstimate, within_m: f64) -> bool {
    let error_m = estimate.largest_error_m();
    !estimate.guessed_range && error_m.is_some_and(|error_m| error_m <= within_m)
}

/// The same with what is known of how well it is known; nothing for what the swarm made itself and does not know well enough to keep away from.
#[must_use]
pub fn estimated(estimate: &TrackEstimate) -> Option<Neighbour> {
    let told = track(&estimate.track);
    match estimate.source {
        TrackSource::Told => Some(told),
        TrackSource::Fused => {
            let known = is_known_within(estimate, TRACK_KEPT_AWAY_WITHIN_M)
                && estimate.age_s >= TRACK_KEPT_AWAY_FROM_S
                && estimate.confidence >= TRACK_KEPT_AWAY_CONFIDENCE;
            known.then(|| Neighbour {
                uncertainty_m: TRACK_UNCERTAINTY_M.max(2.0 * estimate.largest_error_m().unwrap_or_default()),
                ..told
            })
        }
    }
}

/// One of our vehicles as the others' filters see it: once, or, not heard for long, at every place where it may be. Nothing without a
/// position.
///
/// The autopilot's own failsafe has a silent one: it goes on for a while or brakes at once, and then returns, for which it climbs first, or
/// lands. Whoever gave way to it over or under it would meet it.
#[must_use]
pub fn vehicle(entry: &PeerEntry, now: NodeTime) -> Vec<Neighbour> {
    let Some(known) = as_heard(entry, now) else {
        return Vec::new();
    };
    let silent_s = now.seconds_since(known.measured);
    if silent_s <= FRESH_S {
        return vec![known];
    }
    if silent_s <= STOPS_AFTER_S {
        return STARTS_TO_BRAKE
            .map(|share| braking(&known, silent_s, share, now))
            .to_vec();
    }
    let heights_m: &[f64] = if entry.airborne { &COLUMN_M } else { &[0.0] };
    let speed_m_s = known.velocity.norm();
    let at = |time_s: f64, height_m: f64| {
        let stood = known.position.after(&known.velocity, time_s);
        Neighbour {
            position: PositionNed {
                down_m: stood.down_m - height_m,
                ..stood
            },
            velocity: VelocityNed::default(),
            measured: now,
            uncertainty_m: VEHICLE_UNCERTAINTY_M + STOPS_BESIDE_S * speed_m_s,
            cooperation: if height_m == 0.0 {
                Cooperation::DoesNot
            } else {
                Cooperation::MayCome
            },
            ..known
        }
    };
    // Who stood has stopped where it was.
    let stops_s: &[f64] = if speed_m_s > STOOD_M_S { &STOPS_WITHIN_S } else { &[0.0] };
    stops_s
        .iter()
        .flat_map(|time_s| heights_m.iter().map(|height_m| at(*time_s, *height_m)))
        .collect()
}

/// Where it is if, since it was heard, it flew on for this share of the time, and then braked as hard as it can: who flies behind it would see
/// it far ahead, where it would be if it had flown on all the time.
///
/// It may have turned aside as well, but not by much: if it were looked for wherever it could have got to, those beside it would be driven out of their ways,
/// into those of others who do not see that.
fn braking(known: &Neighbour, silent_s: f64, flown_on: f64, now: NodeTime) -> Neighbour {
    let speed_m_s = known.velocity.norm();
    let (flown_s, since_s) = (flown_on * silent_s, (1.0 - flown_on) * silent_s);
    let braking_s = since_s.min(speed_m_s / HARDEST_BRAKING_M_S2);
    let left = 1.0 - HARDEST_BRAKING_M_S2 * braking_s / speed_m_s.max(1e-6);
    let aside_m = (0.5 * TURNS_ASIDE_M_S2 * silent_s * silent_s).min(TURNS_ASIDE_MAX_M);
    Neighbour {
        // The mean speed while it brakes.
        position: known
            .position
            .after(&known.velocity, flown_s + braking_s * 0.5 * (1.0 + left)),
        velocity: (known.velocity.vector() * left).into(),
        measured: now,
        uncertainty_m: known.uncertainty_m + aside_m,
        cooperation: Cooperation::DoesNot,
        ..*known
    }
}

fn as_heard(entry: &PeerEntry, now: NodeTime) -> Option<Neighbour> {
    let kinematics = entry.kinematics?;
    let fresh = now.seconds_since(kinematics.measured) <= FRESH_S;
    let lost = matches!(entry.flight_state, FlightState::PilotControl | FlightState::Faulted);
    let under_our_control = entry.link.connected && !lost && entry.link.setpoint_rate_hz > 0.0;
    Some(Neighbour {
        id: NeighbourId::Vehicle(entry.id),
        position: kinematics.position,
        velocity: kinematics.velocity,
        measured: kinematics.measured,
        uncertainty_m: VEHICLE_UNCERTAINTY_M,
        cooperation: if fresh && under_our_control {
            Cooperation::Shares
        } else {
            Cooperation::DoesNot
        },
        airborne: entry.airborne,
    })
}

#[cfg(test)]
mod tests;
