//! What one neighbour demands of the own velocity: one half-space, or nothing. The geometry of two, in stretched coordinates.

use super::nearest::Row;
use super::surroundings::{Carried, unknown_m};
use super::{AvoidanceSettings, NeighbourId};
use nalgebra::Vector3;
use skein_domain::VehicleId;

/// How fast two that are nearer than they should be move apart, per metre that is missing, per second.
const PARTING_PER_S: f64 = 1.0;
/// Nobody is asked to part faster than this, in metres per second.
const PARTING_MAX_M_S: f64 = 3.0;
/// What the wanted velocity may be changed by other neighbours before this one has to be looked at, in metres per second.
const ELBOW_ROOM_M_S: f64 = 2.0;
/// Each of two that share takes half of what is left between them. Of what is already missing each makes up more than all: velocities
/// follow late, and half of a lack, asked for again and again, closes too slowly.
const SHARE_OF_ROOM: f64 = 0.5;
const SHARE_OF_LACK: f64 = 1.5;
/// The same for who does it all.
const LACK_ALONE: f64 = 3.0;
/// Who is led past passes by this much more than the keep-out distance, in metres.
const PASSING_MARGIN_M: f64 = 0.15;
/// Until the closest approach, but no longer than this in seconds, the other may turn towards one with this acceleration.
const PASSING_MAX_S: f64 = 1.2;
const SURPRISE_SHARING: f64 = 0.0;
const SURPRISE_OTHER: f64 = 1.5;
/// Rows yield by the time until contact: what is near yields last, and what does not share yields half as readily.
const CONTACT_YIELDS_PER_S: f64 = 0.5;
const YIELDS_LEAST: f64 = 0.1;
/// What does not share yields less than any fence: nobody flies into it to stay inside.
const STRANGER_YIELDS_LEAST: f64 = 0.01;
/// Who would pass another on the left by less than this part of the keep-out distance passes it on the right instead.
const RIGHT_HAND: f64 = 0.35;
/// Dodging is preferred to braking when what lies between is flown in less than this, in seconds.
const DODGE_S: f64 = 4.0;

/// Who plans to come nearer than this beyond the keep-out distance, in metres, is judged as if it were this: it may have to.
const LEAST_ROOM_M: f64 = 0.5;
/// So slow, in metres per second, is always slow enough.
const LEAST_CLOSING_M_S: f64 = 0.1;

/// The own vehicle as it is believed to be now.
#[derive(Debug, Clone, Copy)]
pub(super) struct Own {
    pub id: VehicleId,
    pub position: Vector3<f64>,
    pub velocity: Vector3<f64>,
    /// What the autopilot would make of the wanted setpoint.
    pub wanted: Vector3<f64>,
    pub uncertain_m: f64,
    pub age_s: f64,
    /// Where the wanted setpoint leads, if it says.
    pub goal: Option<Vector3<f64>>,
}

/// The demand of one neighbour.
#[derive(Debug, Clone, Copy)]
pub(super) struct Demand {
    pub id: NeighbourId,
    pub row: Row,
    /// Present distance in real metres.
    pub distance_m: f64,
    /// The half-space stops the approach instead of leading past: along the line of sight.
    pub stops: bool,
    /// It does not give way, and is where the wanted setpoint leads: no way round it would lead there.
    pub in_place: bool,
    /// Where it is from here, and how fast.
    apart: Vector3<f64>,
    velocity: Vector3<f64>,
}

impl Demand {
    /// Smallest distance in metres within the horizon if the own velocity were this one.
    pub fn predicted_m(&self, own_velocity: &Vector3<f64>, horizon_s: f64) -> f64 {
        let relative = self.velocity - own_velocity;
        let speed = relative.norm_squared();
        let at_s = if speed > 0.0 {
            (-self.apart.dot(&relative) / speed).min(horizon_s).max(0.0)
        } else {
            0.0
        };
        (self.apart + relative * at_s).norm()
    }
}

/// Beyond this distance nobody that shares demands anything, if none is faster against the own velocity, less certain or older.
pub(super) fn reach_m(own: &Own, fastest_m_s: f64, uncertain_m: f64, age_s: f64, settings: &AvoidanceSettings) -> f64 {
    let keep_m = keep_out_m(settings, own.uncertain_m + uncertain_m);
    let closing = fastest_m_s + (own.wanted - own.velocity).norm() + ELBOW_ROOM_M_S;
    let delay_s = settings.reaction_s + own.age_s + age_s.min(settings.horizon_s);
    let room_m = room_needed_m(closing, 2.0 * settings.braking_m_s2, delay_s, settings.horizon_s);
    stretch(settings, keep_m) * (keep_m + room_m)
}

/// Closing speed from which two that brake at `braking` after a delay stop within `room_m`; negative if there is none.
pub(super) fn closing_limit_m_s(room_m: f64, braking_m_s2: f64, delay_s: f64, horizon_s: f64) -> f64 {
    if room_m <= 0.0 {
        return (PARTING_PER_S * room_m).max(-PARTING_MAX_M_S);
    }
    let lost = braking_m_s2 * delay_s;
    let brakes = (lost * lost + 2.0 * braking_m_s2 * room_m).sqrt() - lost;
    brakes.max(room_m / horizon_s)
}

/// How much room two need that close at a speed; the inverse of [`closing_limit_m_s`].
pub(super) fn room_needed_m(closing_m_s: f64, braking_m_s2: f64, delay_s: f64, horizon_s: f64) -> f64 {
    let stops = closing_m_s * delay_s + 0.5 * closing_m_s * closing_m_s / braking_m_s2;
    stops.min(closing_m_s * horizon_s)
}

/// The distance two have to keep, in real metres, for what is not known of either.
pub(super) fn keep_out_m(settings: &AvoidanceSettings, uncertain_m: f64) -> f64 {
    settings.min_separation_m + uncertain_m
}

/// How much taller than wide the volume is, after the margin: that is not stretched, since it is no downwash.
fn stretch(settings: &AvoidanceSettings, keep_m: f64) -> f64 {
    if keep_m > 0.0 {
        (settings.vertical_stretch * settings.min_separation_m / keep_m).max(1.0)
    } else {
        1.0
    }
}

/// How much of the speed at which two that share may close they close at, as a share: above 1 the filter would slow them down. Zero if
/// they go past each other; none if they are nearer to each other than they may be, however slow. `apart` is where the other is from here, `closing` how fast it is come closer to; their states are `age_s` old.
pub(super) fn used_share(
    apart: &Vector3<f64>,
    closing: &Vector3<f64>,
    age_s: f64,
    settings: &AvoidanceSettings,
) -> Option<f64> {
    let uncertain_m = settings.noise_m + unknown_m(age_s, settings.peer_acceleration_m_s2);
    let keep_m = keep_out_m(settings, 2.0 * uncertain_m);
    let squeeze = 1.0 / stretch(settings, keep_m);
    let squeezed = |v: &Vector3<f64>| Vector3::new(v.x, v.y, v.z * squeeze);
    let (there, relative) = (squeezed(apart), squeezed(closing));
    let (distance_m, speed_m_s) = (there.norm(), relative.norm());
    let closing_m_s = there.dot(&relative) / distance_m.max(1e-6);
    let sine = keep_m / distance_m;
    if distance_m < keep_m {
        return None;
    }
    let goes_past = closing_m_s < speed_m_s * (1.0 - sine * sine).sqrt();
    if closing_m_s <= 0.0 || goes_past {
        return Some(0.0);
    }
    let room_m = (distance_m - keep_m).max(LEAST_ROOM_M);
    let delay_s = settings.reaction_s + 2.0 * age_s;
    let limit_m_s = closing_limit_m_s(room_m, 2.0 * settings.braking_m_s2, delay_s, settings.horizon_s);
    Some(closing_m_s / (limit_m_s - settings.peer_acceleration_m_s2 * age_s).max(LEAST_CLOSING_M_S))
}

/// What `peer` demands of `own`; none if it is too far away to matter this period.
pub(super) fn demand(own: &Own, peer: &Carried, settings: &AvoidanceSettings) -> Option<Demand> {
    let keep_m = keep_out_m(settings, own.uncertain_m + peer.uncertain_m);
    let squeeze = 1.0 / stretch(settings, keep_m);
    let squeezed = |v: Vector3<f64>| Vector3::new(v.x, v.y, v.z * squeeze);
    let apart = peer.position - own.position;
    let there = squeezed(apart);
    let distance_m = there.norm();
    let relative = squeezed(own.velocity - peer.velocity);
    let braking = if peer.shares { 2.0 } else { 1.0 } * settings.braking_m_s2;
    let delay_s = settings.reaction_s + own.age_s + peer.age_s.min(settings.horizon_s);
    let room_m = distance_m - keep_m;
    let fastest = relative.norm() + peer.braked_m_s + (own.wanted - own.velocity).norm() + ELBOW_ROOM_M_S;
    if room_m > room_needed_m(fastest, braking, delay_s, settings.horizon_s) {
        return None;
    }
    let sight = there
        .try_normalize(1e-6)
        .unwrap_or_else(|| sideways_of(own.id, peer.id) * -1.0);
    let closing = closing_limit_m_s(room_m, braking, delay_s, settings.horizon_s);
    // Who goes away ahead may have braked since it was heard.
    let braked_m_s = sight.dot(&squeezed(peer.velocity)).max(0.0).min(peer.braked_m_s);
    let stop = Side {
        normal: sight,
        room: closing - sight.dot(&relative) - braked_m_s,
    };
    let margin_m = passing_margin_m(peer.shares, &there, &relative);
    let pass = passing(own, peer, &sight, &relative, (keep_m + margin_m) / distance_m);
    let contact_s = room_m.max(0.0) / sight.dot(&relative).max(0.1);
    let (least, ease) = match (peer.shares, peer.is_there) {
        (true, _) => (YIELDS_LEAST, 2.0),
        (false, true) => (STRANGER_YIELDS_LEAST, 1.0),
        (false, false) => (YIELDS_LEAST, 1.0),
    };
    let yields = (CONTACT_YIELDS_PER_S * contact_s).clamp(least, 1.0) * ease;
    let row = |side: &Side| side.row(own, peer.shares, squeeze, yields);
    let stop_row = row(&stop);
    let chosen = pass
        .filter(|pass| stop_row.excess(&own.wanted) > 0.0 && prefers(&stop, pass, &relative, room_m, closing))
        .map(|pass| row(&pass));
    Some(Demand {
        id: peer.id,
        row: chosen.unwrap_or(stop_row),
        distance_m: apart.norm(),
        stops: chosen.is_none(),
        in_place: !peer.shares
            && own
                .goal
                .is_some_and(|goal| squeezed(peer.position - goal).norm() < keep_m),
        apart,
        velocity: peer.velocity,
    })
}

/// How much further than it must one passes: what the other could still do until then, in part.
fn passing_margin_m(shares: bool, there: &Vector3<f64>, relative: &Vector3<f64>) -> f64 {
    let square = relative.norm_squared();
    let left_s = if square > 0.0 {
        (there.dot(relative) / square).clamp(0.0, PASSING_MAX_S)
    } else {
        0.0
    };
    let surprise = if shares { SURPRISE_SHARING } else { SURPRISE_OTHER };
    PASSING_MARGIN_M + 0.5 * surprise * left_s * left_s
}

/// Whether leading past costs less than stopping. Both vehicles judge by what both know, so that they come to the same answer.
fn prefers(stop: &Side, pass: &Side, relative: &Vector3<f64>, room_m: f64, closing: f64) -> bool {
    let early = closing.min(room_m / DODGE_S) - relative.dot(&stop.normal);
    pass.room > early
}

/// One half-space on the relative velocity, in stretched coordinates: `normal · relative` may grow by `room`.
#[derive(Debug, Clone, Copy)]
struct Side {
    normal: Vector3<f64>,
    room: f64,
}

impl Side {
    /// The own part of it as a condition on the own velocity, in real coordinates.
    fn row(&self, own: &Own, shares: bool, squeeze: f64, yields: f64) -> Row {
        let part = match (shares, self.room > 0.0) {
            (false, true) => self.room,
            (false, false) => LACK_ALONE * self.room,
            (true, true) => SHARE_OF_ROOM * self.room,
            (true, false) => SHARE_OF_LACK * self.room,
        };
        let normal = Vector3::new(self.normal.x, self.normal.y, self.normal.z * squeeze);
        let length = normal.norm().max(1e-6);
        Row {
            normal: normal / length,
            bound: (normal.dot(&own.velocity) + part) / length,
            yields,
        }
    }
}

/// The side of the collision cone along which the two lead past each other; none inside the keep-out volume.
fn passing(own: &Own, peer: &Carried, sight: &Vector3<f64>, relative: &Vector3<f64>, sine: f64) -> Option<Side> {
    let outside = sine < 1.0;
    if !outside {
        return None;
    }
    let cosine = (1.0 - sine * sine).sqrt();
    let closing = sight.dot(relative);
    let across = relative - sight * closing;
    let right = right_of(sight).unwrap_or_else(|| sideways_of(own.id, peer.id));
    let bias = RIGHT_HAND * closing.max(0.0) * sine / cosine.max(0.1);
    let around = (across + right * bias).try_normalize(1e-6).unwrap_or(right);
    // Out of the cone through this side.
    let out = around * cosine - sight * sine;
    Some(Side {
        normal: -out,
        room: out.dot(relative),
    })
}

/// Level and to the right when looking along `sight`; none if that is straight up or down.
fn right_of(sight: &Vector3<f64>) -> Option<Vector3<f64>> {
    Vector3::new(-sight.y, sight.x, 0.0).try_normalize(0.1)
}

/// A level direction that two vehicles choose opposite to each other where geometry does not give one.
fn sideways_of(own: VehicleId, peer: NeighbourId) -> Vector3<f64> {
    let first = match peer {
        NeighbourId::Vehicle(peer) => own < peer,
        NeighbourId::Foreign(_) => true,
    };
    Vector3::new(if first { 1.0 } else { -1.0 }, 0.0, 0.0)
}
