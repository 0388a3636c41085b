//! What a flight came to: its story, its figures, and what it failed.

use skein_domain::VehicleId;
use std::fmt;

/// The nearest that two came to each other, in the truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closest {
    /// Distance in metres; infinite if there were never two.
    pub distance_m: f64,
    /// One of them.
    pub a: VehicleId,
    /// The other; the same as the first for one that is not ours.
    pub b: VehicleId,
    /// When, in seconds.
    pub at_s: f64,
}

impl Default for Closest {
    fn default() -> Self {
        Self {
            distance_m: f64::INFINITY,
            a: VehicleId(0),
            b: VehicleId(0),
            at_s: 0.0,
        }
    }
}

/// The furthest that somebody was outside of the fence, against what its speed explains.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Crossing {
    /// How far outside in metres.
    pub outside_m: f64,
    /// How far it may have been there.
    pub allowed_m: f64,
    /// Who.
    pub id: VehicleId,
    /// When, in seconds.
    pub at_s: f64,
}

/// The lowest that somebody flew.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lowest {
    /// Height above the ground in metres; infinite if nobody flew.
    pub height_m: f64,
    /// Who.
    pub id: VehicleId,
    /// When, in seconds.
    pub at_s: f64,
}

impl Default for Lowest {
    fn default() -> Self {
        Self {
            height_m: f64::INFINITY,
            id: VehicleId(0),
            at_s: 0.0,
        }
    }
}

/// How a vehicle ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Arrival {
    /// In its place, so far from it in metres.
    There(f64),
    /// Not in its place, for a reason that is told.
    Held {
        /// How far from it in metres.
        off_m: f64,
        /// Why.
        why: String,
    },
    /// It has no place, for this reason.
    Without(String),
}

/// How much the separation filter had to do.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FilterFigures {
    /// Setpoints that passed it.
    pub calls: u64,
    /// Of these changed.
    pub changed: u64,
    /// Of these such that not all demands could be kept.
    pub infeasible: u64,
}

/// How far followers were from their slots while their leader flew a route, in metres, in the truth.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OnRoute {
    /// Half of the time no more than this.
    pub median_m: f64,
    /// But for a twentieth of the time no more than this.
    pub p95_m: f64,
    /// The most.
    pub worst_m: f64,
}

impl OnRoute {
    /// Of all that was seen, in metres.
    #[must_use]
    pub fn of(mut seen_m: Vec<f64>) -> Self {
        seen_m.sort_by(f64::total_cmp);
        let share = |share: f64| {
            let at = (share * seen_m.len() as f64) as usize;
            seen_m.get(at).or(seen_m.last()).copied().unwrap_or(0.0)
        };
        Self {
            median_m: share(0.5),
            p95_m: share(0.95),
            worst_m: share(1.0),
        }
    }
}

impl fmt::Display for OnRoute {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            median_m,
            p95_m,
            worst_m,
        } = self;
        if *worst_m > 0.0 {
            writeln!(
                f,
                "off the slots on a route: median {median_m:.2} m, p95 {p95_m:.2} m, worst {worst_m:.2} m"
            )?;
        }
        Ok(())
    }
}

/// A criterion that was not met.
#[derive(Debug, Clone, PartialEq)]
pub enum Failure {
    /// Two came too near to each other.
    TooClose(Closest),
    /// One came too near to something that is not ours.
    TooCloseToForeign(Closest),
    /// Somebody was further outside of the fence than its speed explains.
    FenceCrossed(Crossing),
    /// Somebody was lower than a setpoint in flight may lead.
    TooLow(Lowest),
    /// A vehicle is not where it should be, and nothing says why.
    NotArrived {
        /// Which.
        id: VehicleId,
        /// How far from its place in metres.
        off_m: f64,
        /// What is known.
        why: String,
    },
    /// A vehicle answers and has neither a place nor a reason for that.
    Forgotten(VehicleId),
    /// A number of the truth is none.
    NotFinite(VehicleId),
}

/// What a flight came to.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Outcome {
    /// Its seed.
    pub seed: u64,
    /// How many vehicles.
    pub vehicles: usize,
    /// What happened, in seconds from the beginning.
    pub story: Vec<(f64, String)>,
    /// How long it took, in seconds.
    pub end_s: f64,
    /// The nearest of two of ours, one of which answered.
    pub closest: Closest,
    /// The nearest of one of ours to something that is not ours.
    pub closest_foreign: Closest,
    /// The worst crossing of the fence.
    pub crossing: Crossing,
    /// The lowest that one flew.
    pub lowest: Lowest,
    /// When everyone was in place for good, if everyone was.
    pub arrived_s: Option<f64>,
    /// How each vehicle ended that still answered.
    pub arrivals: Vec<(VehicleId, Arrival)>,
    /// What was refused.
    pub refusals: Vec<String>,
    /// What the filter did.
    pub filter: FilterFigures,
    /// How the slots were kept on a route, if one was flown.
    pub on_route: OnRoute,
    /// It took longer than is simulated; its distances count, arrivals that were still to come do not.
    pub cut_short: bool,
    /// What was not met.
    pub failures: Vec<Failure>,
}

impl Outcome {
    /// Whether every criterion was met.
    #[must_use]
    pub fn is_passed(&self) -> bool {
        self.failures.is_empty()
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooClose(c) => write!(
                f,
                "{} and {} were {:.2} m apart at {:.2} s",
                c.a, c.b, c.distance_m, c.at_s
            ),
            Self::TooCloseToForeign(c) => {
                write!(
                    f,
                    "{} was {:.2} m from a foreign aircraft at {:.2} s",
                    c.a, c.distance_m, c.at_s
                )
            }
            Self::FenceCrossed(c) => write!(
                f,
                "{} was {:.2} m outside of the fence at {:.2} s, its speed explains {:.2} m",
                c.id, c.outside_m, c.at_s, c.allowed_m
            ),
            Self::TooLow(l) => write!(f, "{} was {:.2} m over the ground at {:.2} s", l.id, l.height_m, l.at_s),
            Self::NotArrived { id, off_m, why } => write!(f, "{id} is {off_m:.2} m from its place: {why}"),
            Self::Forgotten(id) => write!(f, "{id} has neither a place nor a reason"),
            Self::NotFinite(id) => write!(f, "{id} is nowhere"),
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "seed {}: {} vehicles, {:.1} s", self.seed, self.vehicles, self.end_s)?;
        for (at_s, what) in &self.story {
            writeln!(f, "{at_s:8.2} s  {what}")?;
        }
        let c = &self.closest;
        writeln!(
            f,
            "nearest: {:.2} m, {} and {} at {:.2} s",
            c.distance_m, c.a, c.b, c.at_s
        )?;
        if self.closest_foreign.distance_m.is_finite() {
            let c = &self.closest_foreign;
            writeln!(
                f,
                "nearest to the foreign aircraft: {:.2} m, {} at {:.2} s",
                c.distance_m, c.a, c.at_s
            )?;
        }
        if self.crossing.outside_m > 0.0 {
            let c = &self.crossing;
            let (out_m, allowed_m) = (c.outside_m, c.allowed_m);
            writeln!(
                f,
                "outside of the fence: {out_m:.2} m of {allowed_m:.2} m, {} at {:.2} s",
                c.id, c.at_s
            )?;
        }
        let FilterFigures {
            calls,
            changed,
            infeasible,
        } = self.filter;
        writeln!(
            f,
            "filter: {calls} setpoints, {changed} changed, {infeasible} of them not to all demands"
        )?;
        write!(f, "{}", self.on_route)?;
        let there = |a: &&(VehicleId, Arrival)| matches!(a.1, Arrival::There(_));
        let count = self.arrivals.iter().filter(there).count();
        writeln!(
            f,
            "in place: {count} of {} that answer, {:?} s",
            self.arrivals.len(),
            self.arrived_s
        )?;
        for (id, arrival) in &self.arrivals {
            match arrival {
                Arrival::There(_) => {}
                Arrival::Held { off_m, why } => writeln!(f, "  {id}: {off_m:.1} m from its place: {why}")?,
                Arrival::Without(why) => writeln!(f, "  {id}: no place: {why}")?,
            }
        }
        for failure in &self.failures {
            writeln!(f, "FAILED: {failure}")?;
        }
        Ok(())
    }
}
