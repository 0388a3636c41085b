//! Energy: what is left against what the way home costs, from the vehicle's own reports. Says when the swarm should plan without
//! the vehicle, when it must return, and when it does not get home any more.
//!
//! Shares are of a full battery, rates are shares per second. Two rates are learned, hovering and flying, by least squares over the
//! flight so far with the configured ones as the prior; older flight counts less.
//!
//! Must never do: promise a way home that the charge does not pay for under the model.

mod consumption;
mod home;

pub use home::{HomeCost, WayHome};

use crate::wind::Wind;
use consumption::Consumption;
use skein_domain::{Battery, EnergyLevel, EnergySettings, EnergyState, NodeTime, VelocityNed};

/// What a vehicle reports, once per period or less often.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EnergySample {
    /// Its battery; what is absent is done without.
    pub battery: Battery,
    /// The battery is a simulated one: how full it says it is counts, how fast it empties tells nothing of how long it lasts. PX4's
    /// empties at a set pace while armed, and stays for ever at the level where it is told to stop.
    pub simulated: bool,
    /// Motors run and it is off the ground.
    pub airborne: bool,
    /// Its velocity over the ground.
    pub velocity: Option<VelocityNed>,
    /// The wind it reports.
    pub wind: Option<VelocityNed>,
}

/// Time constant of the smoothing of a remaining charge that is made of the voltage, which sags with every gust, in seconds.
const VOLTAGE_SMOOTHING_S: f64 = 10.0;
/// A charge reported longer ago than this, in seconds, has been used on since: it is carried on with the learned rate.
const CARRIED_AFTER_S: f64 = 2.0;

/// The energy of one vehicle.
#[derive(Debug, Clone, Default)]
pub struct EnergyEstimator {
    consumption: Consumption,
    /// The newest remaining charge, and when it was reported.
    remaining: Option<(f64, NodeTime)>,
    sample: EnergySample,
    level: EnergyLevel,
}

impl EnergyEstimator {
    /// One that knows nothing yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes a report. Values that are not finite count as absent.
    pub fn observe(&mut self, now: NodeTime, sample: &EnergySample, settings: &EnergySettings) {
        self.sample = *sample;
        if let Some(remaining) = self.remaining_of(now, &sample.battery, settings) {
            self.remaining = Some((remaining, now));
        }
        let airspeed_m_s = airspeed_m_s(sample);
        let remaining = self.remaining.filter(|(_, at)| *at == now).map(|(share, _)| share);
        // On the ground nothing is learned either.
        let consumes = sample.airborne && !sample.simulated;
        self.consumption
            .observe(now, consumes, airspeed_m_s, remaining, &sample.battery, settings);
    }

    /// How it stands against the way home. `None` as long as the remaining charge is not known.
    ///
    /// The level is kept between calls: it gets worse at once, and better only by a margin.
    pub fn assess(&mut self, now: NodeTime, way: &WayHome, settings: &EnergySettings) -> Option<EnergyState> {
        let rates = self.consumption.rates(settings);
        let present = if airspeed_m_s(&self.sample) > consumption::HOVERS_BELOW_M_S {
            rates.flying
        } else {
            rates.hovering
        };
        let (reported, at) = self.remaining?;
        let silent_s = now.seconds_since(at).max(0.0);
        let carried = if self.sample.airborne && silent_s > CARRIED_AFTER_S {
            silent_s * present
        } else {
            0.0
        };
        let remaining = (reported - carried).clamp(0.0, 1.0);
        let wind = Wind::known_or_assumed(self.sample.wind.as_ref(), settings);
        let cost = home::cost(way, wind, &rates, settings);
        let needed_home = cost.total().map(|bare| bare * (1.0 + settings.model_error_share));
        let reserve = settings.reserve_share;
        let margin = remaining - needed_home.unwrap_or(0.0) - reserve;
        let receding_m_s = if way.receding_m_s.is_finite() {
            way.receding_m_s.max(0.0)
        } else {
            0.0
        };
        let drain = present + cost.per_metre.unwrap_or(0.0) * receding_m_s * (1.0 + settings.model_error_share);
        let return_in_s = match needed_home {
            Some(_) if margin > 0.0 && drain > 0.0 => margin / drain,
            _ => 0.0,
        };
        let state = EnergyState {
            remaining,
            needed_home,
            reserve,
            margin,
            endurance_s: if present > 0.0 { remaining / present } else { 0.0 },
            return_in_s,
            level: EnergyLevel::Ok,
            learned: self.consumption.is_learned(settings),
            ground_speed_home_m_s: cost.ground_speed_m_s,
        };
        let hysteresis = settings.hysteresis_share.max(0.0);
        let now_level = level_of(&state, &cost, settings, 0.0, drain);
        // Better only when it would still be better with so much less.
        let kept_level = level_of(&state, &cost, settings, hysteresis, drain);
        self.level = now_level.max(self.level.min(kept_level));
        Some(EnergyState {
            level: self.level,
            ..state
        })
    }

    fn remaining_of(&self, now: NodeTime, battery: &Battery, settings: &EnergySettings) -> Option<f64> {
        if let Some(remaining) = battery.remaining.map(f64::from).filter(|r| r.is_finite()) {
            return Some(remaining.clamp(0.0, 1.0));
        }
        let cells = f64::from(settings.cells.filter(|c| *c > 0)?);
        let volts = battery.voltage_v.map(f64::from).filter(|v| v.is_finite())?;
        let span_v = settings.full_cell_v - settings.empty_cell_v;
        if span_v <= 0.0 {
            return None;
        }
        let share = ((volts / cells - settings.empty_cell_v) / span_v).clamp(0.0, 1.0);
        let Some((before, at)) = self.remaining else {
            return Some(share);
        };
        let weight = (now.seconds_since(at).max(0.0) / VOLTAGE_SMOOTHING_S).min(1.0);
        Some(before + (share - before) * weight)
    }
}

/// How urgent it is with `less` charge than there is.
fn level_of(state: &EnergyState, cost: &HomeCost, settings: &EnergySettings, less: f64, drain: f64) -> EnergyLevel {
    let remaining = state.remaining - less;
    let landing = cost.landing * (1.0 + settings.model_error_share);
    let Some(bare) = cost.total() else {
        return EnergyLevel::LandNow;
    };
    let lands_here = !cost.is_home && remaining <= settings.critical_share.max(landing);
    if lands_here || remaining < bare {
        return EnergyLevel::LandNow;
    }
    let margin = state.margin - less;
    if margin <= 0.0 {
        EnergyLevel::ReturnNow
    } else if margin <= drain * settings.replan_before_s {
        EnergyLevel::ReplanSoon
    } else {
        EnergyLevel::Ok
    }
}

/// Speed through the air in metres per second: over the ground, less the wind if it is reported.
fn airspeed_m_s(sample: &EnergySample) -> f64 {
    let Some(velocity) = sample.velocity.filter(VelocityNed::is_finite) else {
        return 0.0;
    };
    let wind = sample.wind.filter(VelocityNed::is_finite).unwrap_or_default();
    (velocity.north_m_s - wind.north_m_s).hypot(velocity.east_m_s - wind.east_m_s)
}

#[cfg(test)]
mod tests;
