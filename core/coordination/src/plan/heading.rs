//! Which way a formation heads, how fast it may turn, and what that takes of its members' speed.
//!
//! Must never do: let it turn faster than its outermost member flies, where it is now or where it is to be.

use super::{Basis, PlanInput};
use skein_domain::frames::wrap_angle_rad;
use skein_domain::{FlightLimits, FormationControl, FormationHeading, HeadingRequest, OffsetFrd};
use skein_flight::limits;

/// Below this turning rate a formation does not follow its leader's course: a quarter turn would take longer than ten seconds.
const SLOWEST_USEFUL_TURN_RAD_S: f64 = 0.15;
/// Leader's speed assumed when a formation's turning rate is chosen, in metres per second, until a route says otherwise.
const NOMINAL_SPEED_M_S: f64 = 5.0;
/// Acceleration of the outermost vehicle in a turn of the formation, in metres per second squared: beyond it tracking suffers.
const TURN_ACCELERATION_M_S2: f64 = 3.0;
/// A formation that stands turns towards its heading no faster than this, in radians per second.
pub(super) const STANDING_TURN_RAD_S: f64 = 0.2;
/// The outermost vehicle goes no faster by a turn to a fixed heading, in metres per second: it may be changing places at the same time.
pub(super) const HEADING_TURN_M_S: f64 = 4.0;
/// However little speed is left to the outermost vehicle, a turn to a fixed heading takes this much of it, in metres per second: it must
/// come to an end.
const HEADING_TURN_LEAST_M_S: f64 = 0.5;
/// Less than this is no turn, in radians.
const NO_TURN_RAD: f64 = 0.01;
/// With a member farther out than so many times its outermost place a formation turns only as fast as that member can be carried round,
/// until it is formed.
const FAR_OUT: f64 = 1.25;

/// How the heading is chosen, while they form and once they are formed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Headings {
    pub forming: FormationHeading,
    pub formed: FormationHeading,
}

pub(super) fn choose(
    input: &PlanInput,
    from: &[OffsetFrd],
    slots: &[OffsetFrd],
    basis: &Basis,
    together: &FlightLimits,
) -> Headings {
    let speed_m_s = input
        .route_speed_m_s
        .unwrap_or(NOMINAL_SPEED_M_S)
        .min(together.max_speed_m_s * limits::TURN_SPEED_SHARE);
    let rate_rad_s = |slots: &[OffsetFrd]| course_rate_rad_s(slots, speed_m_s, together);
    let max_rate_rad_s = rate_rad_s(slots);
    // Whoever is further out now than it will be is carried round as well.
    let to_fixed_rad_s = {
        let farthest_m = farthest_m(from, slots).max(1.0);
        let within = max_rate_rad_s.min(rate_rad_s(from)).min(HEADING_TURN_M_S / farthest_m);
        within.max(HEADING_TURN_LEAST_M_S / farthest_m).min(STANDING_TURN_RAD_S)
    };
    let fixed = |heading_rad: f64| FormationHeading::Fixed {
        heading_rad,
        max_rate_rad_s: Some(to_fixed_rad_s),
    };
    let formed = match input.request.heading {
        HeadingRequest::Fixed { heading_deg } => fixed(heading_deg.to_radians()),
        // Directions are kept in north and east: such a formation does not turn.
        _ if input.request.control == FormationControl::Bearings => fixed(basis.heading_rad),
        HeadingRequest::Auto if max_rate_rad_s < SLOWEST_USEFUL_TURN_RAD_S => fixed(basis.heading_rad),
        HeadingRequest::Auto | HeadingRequest::Course => FormationHeading::Course { max_rate_rad_s },
    };
    let far_out = farthest_m(from, &[]) > FAR_OUT * farthest_m(&[], slots);
    let forming = match formed {
        FormationHeading::Course { max_rate_rad_s } if far_out => FormationHeading::Course {
            max_rate_rad_s: max_rate_rad_s.min(to_fixed_rad_s),
        },
        as_formed => as_formed,
    };
    Headings { forming, formed }
}

/// How fast a formation may turn, in radians per second, while its anchor flies at `speed_m_s`, for everyone to keep up with its place.
pub(crate) fn course_rate_rad_s(slots: &[OffsetFrd], speed_m_s: f64, together: &FlightLimits) -> f64 {
    let acceleration_m_s2 = TURN_ACCELERATION_M_S2.min(together.max_acceleration_m_s2);
    limits::max_turn_rate_within_rad_s(slots, speed_m_s, together.max_speed_m_s, acceleration_m_s2)
}

/// How much of each member's speed the formation as a whole takes: its anchor's speed and its turning.
pub(super) fn taken_m_s(
    input: &PlanInput,
    from: &[OffsetFrd],
    slots: &[OffsetFrd],
    headings: &Headings,
    basis: &Basis,
) -> f64 {
    let turning_rad_s = basis.turning_rad_s.abs();
    let turns = turning_rad_s > 1e-3;
    let farthest_now_m = farthest_m(from, slots);
    // Who comes from a little outside is carried round by what the formation turns now; the rate it may turn at is for its places.
    let turned_m_s = match &headings.forming {
        FormationHeading::Course { max_rate_rad_s } if input.under_way || turns => {
            let may_turn_m = if headings.forming == headings.formed {
                farthest_m(&[], slots)
            } else {
                farthest_now_m
            };
            (turning_rad_s * farthest_now_m).max(max_rate_rad_s * may_turn_m)
        }
        FormationHeading::Fixed {
            heading_rad,
            max_rate_rad_s: Some(max_rate_rad_s),
        } if wrap_angle_rad(heading_rad - basis.heading_rad).abs() > NO_TURN_RAD => {
            turning_rad_s.max(*max_rate_rad_s) * farthest_now_m
        }
        _ => turning_rad_s * farthest_now_m,
    };
    let flown_m_s = input.route_speed_m_s.filter(|_| input.under_way).unwrap_or(0.0);
    flown_m_s + turned_m_s
}

/// How far the outermost place is from the anchor on the ground, before or after a change.
pub(super) fn farthest_m(from: &[OffsetFrd], slots: &[OffsetFrd]) -> f64 {
    let all = from.iter().chain(slots);
    all.map(|o| o.forward_m.hypot(o.right_m)).fold(0.0, f64::max)
}
