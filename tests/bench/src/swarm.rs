//! What a whole swarm's decisions cost in one process and on one core: a change of formation planned, the separation filter for all
//! vehicles in one control period, a leader replaced. Each beside something plain that is measured in the same run.
//!
//! Must never do: judge. Times hang on the machine; the ratios say more.

use crate::error::BenchError;
use serde::Serialize;
use skein_config::NodeConfig;
use skein_coordination::{Formation, PlanInput, PlanLimits, plan, succeed};
use skein_coordination::{neighbours, steering};
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{
    FlightState, FormationRequest, LinkHealth, NodeTime, PositionNed, Refusal, Setpoint, Shape, Telemetry, VehicleId,
    VelocityNed,
};
use skein_safety::avoidance::Surroundings;
use skein_safety::{Gate, Limits};
use skein_view::{PeerEntry, PeerSnapshot};
use std::fmt;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

/// How often each is measured; the median counts.
const ROUNDS: usize = 21;
/// Control periods per second by default.
const PERIOD_MS: f64 = 20.0;
/// Distance between the vehicles before the change, in metres.
const SPACING_M: f64 = 5.0;

/// What to run.
#[derive(Debug, Clone, Copy)]
pub struct SwarmBenchArgs {
    /// How many vehicles.
    pub vehicles: usize,
}

impl SwarmBenchArgs {
    /// With so many vehicles.
    #[must_use]
    pub fn new(vehicles: usize) -> Self {
        Self { vehicles }
    }
}

/// A time beside that of something plain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Beside {
    /// Median of ours in milliseconds.
    pub ms: f64,
    /// Median of the plain one in milliseconds.
    pub plain_ms: f64,
    /// How many times as long ours takes.
    pub ratio: f64,
}

impl Beside {
    fn of(ms: f64, plain_ms: f64) -> Self {
        Self {
            ms,
            plain_ms,
            ratio: ms / plain_ms,
        }
    }
}

/// The whole bench.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SwarmBenchReport {
    /// How many vehicles.
    pub vehicles: usize,
    /// A change of formation planned, beside giving each vehicle the nearest slot that is left.
    pub plan: Beside,
    /// All setpoints of one control period steered in cruise, beside the distances of all pairs.
    pub filter_cruise: Beside,
    /// The same while all fly towards the middle, where everybody has to give way.
    pub filter_crowded: Beside,
    /// Share of a control period that the crowded one takes, in percent.
    pub filter_share_percent: f64,
    /// The filter per pair of vehicles, in nanoseconds: in cruise, where most pairs are out of each other's reach.
    pub filter_per_pair_ns: f64,
    /// The same where everybody has to give way.
    pub filter_crowded_per_pair_ns: f64,
    /// The distance of a pair in a bare loop, in nanoseconds.
    pub distance_per_pair_ns: f64,
    /// A leader replaced, beside the same distances.
    pub succession: Beside,
}

impl fmt::Display for SwarmBenchReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} vehicles, one core, medians of {ROUNDS}:", self.vehicles)?;
        let rows = [
            ("change of formation planned", self.plan, "nearest first"),
            (
                "filter of one period, cruise",
                self.filter_cruise,
                "distances of all pairs",
            ),
            (
                "filter of one period, crowded",
                self.filter_crowded,
                "distances of all pairs",
            ),
            ("leader replaced", self.succession, "distances of all pairs"),
        ];
        for (what, figures, plain) in rows {
            let Beside { ms, plain_ms, ratio } = figures;
            writeln!(f, "{what:<32} {ms:>9.3} ms   {ratio:>8.1} x {plain} ({plain_ms:.4} ms)")?;
        }
        writeln!(
            f,
            "filter, crowded: {:.1} % of a period of {PERIOD_MS} ms",
            self.filter_share_percent
        )?;
        writeln!(
            f,
            "per pair of vehicles: filter in cruise {:.1} ns, crowded {:.1} ns; distance in a bare loop {:.1} ns",
            self.filter_per_pair_ns, self.filter_crowded_per_pair_ns, self.distance_per_pair_ns
        )
    }
}

/// Runs it.
///
/// # Errors
/// When the formation cannot be planned.
pub fn run_swarm_bench(args: &SwarmBenchArgs) -> Result<SwarmBenchReport, BenchError> {
    let config = NodeConfig::default();
    let gate = Arc::new(gate(&config));
    let swarm = Swarm::grid(args.vehicles, &gate);
    let refused = |refusal: Refusal| BenchError::Program(refusal.to_string());
    let formed = swarm.change(Shape::Grid, None, &config, &gate).map_err(refused)?;
    let changed = || swarm.change(Shape::Circle, Some(formed.clone()), &config, &gate);
    changed().map_err(refused)?;
    let leader = formed.leader.unwrap_or_default();
    let planned_ms = median_ms(changed);
    let slots: Vec<PositionNed> = swarm.circle(args.vehicles);
    let nearest_ms = median_ms(|| nearest_first(&swarm.places(), &slots));
    let distances_ms = median_ms(|| swarm.distances());
    let cruise_ms = median_ms(|| swarm.steer(&gate, Swarm::cruise));
    let crowded_ms = median_ms(|| swarm.steer(&gate, Swarm::inwards));
    let succeeded_ms = median_ms(|| succeed(&formed, leader, NodeTime::from_seconds(60.0), &[], &swarm.peers));
    let pairs = (args.vehicles * (args.vehicles - 1)).max(1) as f64;
    Ok(SwarmBenchReport {
        vehicles: args.vehicles,
        plan: Beside::of(planned_ms, nearest_ms),
        filter_cruise: Beside::of(cruise_ms, distances_ms),
        filter_crowded: Beside::of(crowded_ms, distances_ms),
        filter_share_percent: 100.0 * crowded_ms / PERIOD_MS,
        filter_per_pair_ns: 1e6 * cruise_ms / pairs,
        filter_crowded_per_pair_ns: 1e6 * crowded_ms / pairs,
        distance_per_pair_ns: 1e6 * distances_ms / pairs,
        succession: Beside::of(succeeded_ms, distances_ms),
    })
}

fn median_ms<T>(run: impl Fn() -> T) -> f64 {
    let mut times: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let begun = Instant::now();
            black_box(run());
            begun.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times.get(ROUNDS / 2).copied().unwrap_or_default()
}

fn gate(config: &NodeConfig) -> Gate {
    let safety = &config.safety;
    let limits = Limits {
        max_speed_m_s: safety.max_speed_m_s,
        max_climb_m_s: safety.max_climb_m_s,
        max_descent_m_s: safety.max_descent_m_s,
        min_separation_m: safety.min_separation_m,
        separation_horizon_s: safety.separation_horizon_s,
    };
    Gate::new(limits, None)
}

/// Each vehicle takes the nearest slot that is left: no bound on anybody's way, nobody kept apart.
fn nearest_first(places: &[PositionNed], slots: &[PositionNed]) -> Vec<usize> {
    let mut taken = vec![false; slots.len()];
    places
        .iter()
        .map(|place| {
            let left = slots
                .iter()
                .enumerate()
                .filter(|(i, _)| !taken.get(*i).copied().unwrap_or(true));
            let nearest = left.min_by(|a, b| place.distance_m(a.1).total_cmp(&place.distance_m(b.1)));
            let index = nearest.map_or(0, |(i, _)| i);
            if let Some(slot) = taken.get_mut(index) {
                *slot = true;
            }
            index
        })
        .collect()
}

/// A swarm in the air.
struct Swarm {
    peers: PeerSnapshot,
    now: NodeTime,
}

impl Swarm {
    fn grid(count: usize, gate: &Gate) -> Self {
        let now = NodeTime::from_seconds(50.0);
        let side = (count as f64).sqrt().ceil().max(1.0) as usize;
        let entries: Vec<PeerEntry> = (0..count)
            .map(|i| {
                let place = PositionNed::new((i / side) as f64 * SPACING_M, (i % side) as f64 * SPACING_M, -20.0);
                entry(VehicleId(u16::try_from(i + 1).unwrap_or(u16::MAX)), place, now)
            })
            .collect();
        let all: Vec<_> = entries.iter().flat_map(|e| neighbours::vehicle(e, now)).collect();
        let surroundings = Surroundings::new(&all, &gate.avoidance(), now);
        let peers = PeerSnapshot {
            made: now,
            entries,
            surroundings,
            anchor: None,
        };
        Self { peers, now }
    }

    fn places(&self) -> Vec<PositionNed> {
        let entries = self.peers.entries.iter();
        entries.filter_map(|e| e.kinematics).map(|k| k.position).collect()
    }

    fn circle(&self, count: usize) -> Vec<PositionNed> {
        let radius_m = count as f64 * SPACING_M / std::f64::consts::TAU;
        (0..count)
            .map(|i| {
                let angle = i as f64 / count as f64 * std::f64::consts::TAU;
                PositionNed::new(angle.cos() * radius_m, angle.sin() * radius_m, -20.0)
            })
            .collect()
    }

    fn change(
        &self,
        shape: Shape,
        before: Option<Formation>,
        config: &NodeConfig,
        gate: &Arc<Gate>,
    ) -> Result<Formation, Refusal> {
        let input = PlanInput {
            request: FormationRequest::new(shape, SPACING_M),
            before,
            route_speed_m_s: None,
            under_way: false,
            ahead: None,
            reference: None,
            limits: PlanLimits::new(&config.coordinator, config.safety.max_speed_m_s),
            gate: Arc::clone(gate),
            start: self.now,
        };
        plan(&input, &self.peers)
    }

    /// The smallest distance of each from all others, as plainly as it can be found.
    fn distances(&self) -> f64 {
        let places = self.places();
        let mut sum = 0.0;
        for (i, a) in places.iter().enumerate() {
            let others = places.iter().enumerate().filter(|(j, _)| *j != i);
            sum += others.map(|(_, b)| a.distance_m(b)).fold(f64::INFINITY, f64::min);
        }
        sum
    }

    fn cruise(at: &PositionNed) -> Setpoint {
        let velocity = VelocityNed::new(5.0, 0.0, 0.0);
        Setpoint {
            position: Some(at.after(&velocity, 0.05)),
            velocity: Some(velocity),
            ..Setpoint::default()
        }
    }

    fn inwards(at: &PositionNed) -> Setpoint {
        let middle = PositionNed::new(35.0, 35.0, at.down_m);
        Setpoint::hold(middle, None)
    }

    /// One control period: the picture of all, and each one's setpoint.
    fn steer(&self, gate: &Gate, wanted: impl Fn(&PositionNed) -> Setpoint) -> usize {
        let entries = &self.peers.entries;
        let all: Vec<_> = entries.iter().flat_map(|e| neighbours::vehicle(e, self.now)).collect();
        let surroundings = Surroundings::new(&all, &gate.avoidance(), self.now);
        let passed = entries.iter().filter(|entry| {
            let at = entry.kinematics.map_or(PositionNed::default(), |k| k.position);
            steering::steer(gate, entry, &wanted(&at), &surroundings, self.now)
                .outcome
                .is_ok()
        });
        passed.count()
    }
}

fn entry(id: VehicleId, position: PositionNed, now: NodeTime) -> PeerEntry {
    PeerEntry {
        id,
        kinematics: Some(VehicleKinematics {
            position,
            velocity: VelocityNed::new(5.0, 0.0, 0.0),
            yaw_rad: 0.0,
            measured: now,
        }),
        airborne: true,
        telemetry: Telemetry::default(),
        link: LinkHealth {
            connected: true,
            last_heard: now,
            setpoint_rate_hz: 50.0,
            ..LinkHealth::default()
        },
        flight_state: FlightState::Holding,
        anchor: None,
        home: None,
        limits: None,
        under_order: false,
        may_rejoin: false,
        energy: None,
    }
}
