//! What is kept of one vehicle while the recording is read.
//!
//! Must never do: count time or way on the ground as flown.

use super::Since;
use super::wire::WholeVehicle;
use crate::curve::{Sample, Thinner, WayThinner};
use crate::facts::{Battery, EndState, Extreme, Gap, Gaps, Near, VehicleCurves, VehicleFacts, Worst};
use skein_domain::exchange::Severity;
use skein_domain::{FlightMode, LandedState, NodeTime, PositionNed, SwarmFrame, VehicleId};
use skein_recording::VehicleTelemetry;

/// Between two samples further apart nothing is known of the flight, in seconds.
const APART_S: f64 = 3.0;
/// Noise of a position is no way: it counts where the vehicle is so far from the last place that counted, in metres.
const WAY_M: f64 = 0.5;
/// A position that is older is not where the vehicle is, in seconds.
const OLD_S: f64 = 1.0;
/// Setpoints of a vehicle in OFFBOARD are missing where none was recorded for so long, in seconds.
const GAP_S: f64 = 1.5;
/// So many gaps are shown.
const GAPS_SHOWN: usize = 50;

/// One vehicle.
#[derive(Debug)]
pub struct Vehicle {
    facts: VehicleFacts,
    height: Thinner,
    speed: Thinner,
    error: Thinner,
    battery: Thinner,
    loss: Thinner,
    round_trip: Thinner,
    setpoint_rate: Thinner,
    way: WayThinner,
    counted: Option<PositionNed>,
    last: Option<VehicleTelemetry>,
    last_setpoint: Option<NodeTime>,
    heard: bool,
}

/// Armed, and not known to stand on the ground.
pub fn airborne(of: &VehicleTelemetry) -> bool {
    of.armed && of.landed != LandedState::OnGround
}

/// Where it is at the moment of its message, from where it was measured and its velocity; nothing if that is too long ago.
pub fn place_now(of: &VehicleTelemetry) -> Option<PositionNed> {
    let kinematics = of.kinematics?;
    let since_s = of.time.seconds_since(kinematics.measured);
    (0.0..OLD_S)
        .contains(&since_s.max(0.0))
        .then(|| kinematics.position.after(&kinematics.velocity, since_s.max(0.0)))
}

fn higher(of: &mut Option<Extreme>, t_s: f64, value: f64) {
    if value.is_finite() && of.is_none_or(|known| value > known.value) {
        *of = Some(Extreme { t_s, value });
    }
}

impl Vehicle {
    pub fn new(id: VehicleId, points: usize) -> Self {
        let thinner = || Thinner::new(points);
        Self {
            facts: VehicleFacts {
                id,
                name: String::new(),
                plugin: String::new(),
                simulated: false,
                flight_s: 0.0,
                flown_m: 0.0,
                highest_m: None,
                fastest_m_s: None,
                nearest: None,
                largest_error_m: None,
                battery: None,
                link: Worst::default(),
                gaps: Gaps::default(),
                setpoints_refused: 0,
                setpoints_changed: 0,
                setpoints: 0,
                events: [0; 3],
                end: EndState::NeverFlew,
                home_m: None,
                way_m: Vec::new(),
                curves: VehicleCurves::default(),
            },
            height: thinner(),
            speed: thinner(),
            error: thinner(),
            battery: thinner(),
            loss: thinner(),
            round_trip: thinner(),
            setpoint_rate: thinner(),
            way: WayThinner::new(points),
            counted: None,
            last: None,
            last_setpoint: None,
            heard: true,
        }
    }

    /// The newest of it.
    pub fn last(&self) -> Option<&VehicleTelemetry> {
        self.last.as_ref()
    }

    pub fn whole(&mut self, of: WholeVehicle, frame: Option<&SwarmFrame>) {
        self.facts.name = of.name;
        self.facts.plugin = of.plugin;
        self.facts.simulated = of.simulated;
        if let (Some(home), Some(frame)) = (of.home, frame) {
            let home = frame.position(&home);
            self.facts.home_m = Some([home.north_m, home.east_m]);
        }
    }

    pub fn event(&mut self, severity: Severity) {
        let [all, warnings, critical] = &mut self.facts.events;
        *all += 1;
        *warnings += u64::from(severity == Severity::Warning);
        *critical += u64::from(severity == Severity::Critical);
    }

    pub fn near(&mut self, near: Near) {
        if self
            .facts
            .nearest
            .is_none_or(|known| near.distance_m < known.distance_m)
        {
            self.facts.nearest = Some(near);
        }
    }

    pub fn telemetry(&mut self, since: Since, of: VehicleTelemetry, in_place: bool) {
        let t_s = since.s(of.time);
        let flies = airborne(&of);
        let before = self.last.as_ref();
        let flew = before.is_some_and(airborne);
        let step_s = before.map_or(0.0, |before| of.time.seconds_since(before.time));
        if flies && flew && (0.0..APART_S).contains(&step_s) {
            self.facts.flight_s += step_s;
        }
        self.heard = of.link.connected;
        if let Some(place) = place_now(&of) {
            self.moved(t_s, &of, place, flies);
            if flies && let Some(error_m) = of.tracking_error_m {
                self.error.push(Sample::new(t_s, error_m));
                if in_place {
                    higher(&mut self.facts.largest_error_m, t_s, error_m);
                }
            }
        }
        if let Some(remaining) = of.battery.remaining.map(f64::from) {
            self.battery.push(Sample::new(t_s, remaining));
            if flies && self.facts.battery.is_none() {
                self.facts.battery = Some(Battery {
                    first: remaining,
                    last: remaining,
                });
            }
            if let Some(battery) = &mut self.facts.battery {
                battery.last = remaining;
            }
        }
        self.link(t_s, &of);
        self.facts.end = match (flies, self.facts.end) {
            (true, _) => EndState::InAir,
            (false, EndState::NeverFlew) => EndState::NeverFlew,
            (false, _) => EndState::OnGround,
        };
        if of.mode != FlightMode::Offboard || !flies {
            self.last_setpoint = None;
        }
        self.last = Some(of);
    }

    fn moved(&mut self, t_s: f64, of: &VehicleTelemetry, place: PositionNed, flies: bool) {
        let speed_m_s = of
            .kinematics
            .map_or(0.0, |now| now.velocity.north_m_s.hypot(now.velocity.east_m_s));
        self.height.push(Sample::new(t_s, -place.down_m));
        self.speed.push(Sample::new(t_s, speed_m_s));
        if !flies {
            return;
        }
        higher(&mut self.facts.highest_m, t_s, -place.down_m);
        higher(&mut self.facts.fastest_m_s, t_s, speed_m_s);
        self.way.push([place.north_m, place.east_m]);
        match self.counted {
            None => self.counted = Some(place),
            Some(from) => {
                let way_m = from.horizontal_distance_m(&place);
                if way_m >= WAY_M {
                    self.facts.flown_m += way_m;
                    self.counted = Some(place);
                }
            }
        }
    }

    fn link(&mut self, t_s: f64, of: &VehicleTelemetry) {
        let link = &of.link;
        self.setpoint_rate
            .push(Sample::new(t_s, f64::from(link.setpoint_rate_hz)));
        if !link.connected {
            return;
        }
        let loss = f64::from(link.loss);
        self.loss.push(Sample::new(t_s, loss));
        higher(&mut self.facts.link.loss, t_s, loss);
        if let Some(round_trip_s) = link.round_trip_s.map(f64::from) {
            self.round_trip.push(Sample::new(t_s, round_trip_s));
            higher(&mut self.facts.link.round_trip_s, t_s, round_trip_s);
        }
    }

    pub fn setpoint(&mut self, since: Since, at: NodeTime, refused: bool, changed: bool) {
        self.facts.setpoints += 1;
        self.facts.setpoints_refused += u64::from(refused);
        self.facts.setpoints_changed += u64::from(changed);
        if let Some(before) = self.last_setpoint {
            let length_s = at.seconds_since(before);
            if length_s > GAP_S {
                let gap = Gap {
                    t_s: since.s(before),
                    length_s,
                };
                let gaps = &mut self.facts.gaps;
                gaps.count += 1;
                if gaps.longest.is_none_or(|known| length_s > known.length_s) {
                    gaps.longest = Some(gap);
                }
                if gaps.some.len() < GAPS_SHOWN {
                    gaps.some.push(gap);
                }
            }
        }
        self.last_setpoint = Some(at);
    }

    pub fn finish(self) -> VehicleFacts {
        let lost = self.facts.end == EndState::InAir && !self.heard;
        VehicleFacts {
            end: if lost { EndState::Lost } else { self.facts.end },
            way_m: self.way.finish(),
            curves: VehicleCurves {
                height_m: self.height.finish(),
                speed_m_s: self.speed.finish(),
                tracking_error_m: self.error.finish(),
                battery: self.battery.finish(),
                loss: self.loss.finish(),
                round_trip_s: self.round_trip.finish(),
                setpoint_rate_hz: self.setpoint_rate.finish(),
            },
            ..self.facts
        }
    }
}
