//! Learns how much of a full battery hovering and flying take per second.
//!
//! Each time the remaining charge has fallen by a little, the time spent hovering and flying since then and the charge that it took
//! are one equation in the two rates. They are solved together by least squares with exponential forgetting; the configured rates
//! are the prior, worth a fixed time of flight.

use skein_domain::{Battery, EnergySettings, NodeTime};

/// Below this speed through the air it hovers, in metres per second.
pub(super) const HOVERS_BELOW_M_S: f64 = 2.0;
/// Charge that one equation spans at least: two steps of a charge that is reported in whole percents.
const SPAN_SHARE: f64 = 0.02;
/// Or time, in seconds, where the current tells the charge without steps.
const CURRENT_SPAN_S: f64 = 5.0;
/// What the prior is worth, in seconds of flight.
const PRIOR_S: f64 = 20.0;
/// Nothing is learned over a gap between reports longer than this, in seconds.
const LONGEST_GAP_S: f64 = 5.0;
/// A learned rate is believed between these multiples of the configured one.
const BELIEVED: (f64, f64) = (0.3, 6.0);
/// Charge by the battery's own report that it takes to compare the current with it.
const COMPARED_SHARE: f64 = 0.05;

/// Shares of a full battery per second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rates {
    pub hovering: f64,
    pub flying: f64,
}

impl Rates {
    fn configured(settings: &EnergySettings) -> Self {
        Self {
            hovering: 1.0 / settings.hover_endurance_s.max(1.0),
            flying: 1.0 / settings.flying_endurance_s.max(1.0),
        }
    }
}

/// The span since the last equation.
#[derive(Debug, Clone, Copy, Default)]
struct Span {
    hovering_s: f64,
    flying_s: f64,
    /// Remaining charge at its start.
    from: Option<f64>,
    /// Charge by the current, in ampere hours; `None` once a reading was missing.
    drawn_ah: Option<f64>,
}

/// What has been learned of one vehicle.
#[derive(Debug, Clone, Default)]
pub(super) struct Consumption {
    last: Option<NodeTime>,
    span: Span,
    /// Sums of hh, hf, ff, h·charge, f·charge, with forgetting.
    sums: [f64; 5],
    in_air_s: f64,
    /// By the battery's report, and by the current, since both are known.
    compared: (f64, f64),
}

impl Consumption {
    /// Takes what is known at `now`.
    pub(super) fn observe(
        &mut self,
        now: NodeTime,
        airborne: bool,
        airspeed_m_s: f64,
        remaining: Option<f64>,
        battery: &Battery,
        settings: &EnergySettings,
    ) {
        let dt_s = self.last.map(|last| now.seconds_since(last));
        self.last = Some(now);
        let Some(dt_s) = dt_s.filter(|dt_s| airborne && *dt_s > 0.0 && *dt_s <= LONGEST_GAP_S) else {
            self.begin_span(remaining);
            return;
        };
        self.in_air_s += dt_s;
        if airspeed_m_s > HOVERS_BELOW_M_S {
            self.span.flying_s += dt_s;
        } else {
            self.span.hovering_s += dt_s;
        }
        let current_a = battery.current_a.map(f64::from).filter(|a| a.is_finite() && *a >= 0.0);
        self.span.drawn_ah = self.span.drawn_ah.zip(current_a).map(|(ah, a)| ah + a * dt_s / 3600.0);
        self.span.from = self.span.from.or(remaining);
        if let Some(used) = self.used(remaining, settings) {
            self.learn(used, settings);
            self.begin_span(remaining);
        }
    }

    /// The learned rates, or the configured ones until then.
    pub(super) fn rates(&self, settings: &EnergySettings) -> Rates {
        let prior = Rates::configured(settings);
        let [hh, hf, ff, hc, fc] = self.sums;
        let weight = PRIOR_S;
        // (A + w·I) r = b + w·r0, two by two.
        let (a, b, d) = (hh + weight, hf, ff + weight);
        let (p, q) = (hc + weight * prior.hovering, fc + weight * prior.flying);
        let determinant = a * d - b * b;
        let believed = |rate: f64, prior: f64| {
            if rate.is_finite() {
                rate.clamp(prior * BELIEVED.0, prior * BELIEVED.1)
            } else {
                prior
            }
        };
        Rates {
            hovering: believed((p * d - q * b) / determinant, prior.hovering),
            flying: believed((q * a - p * b) / determinant, prior.flying),
        }
    }

    /// Whether it flew long enough for its own rates.
    pub(super) fn is_learned(&self, settings: &EnergySettings) -> bool {
        self.in_air_s >= settings.learned_after_s && self.sums.iter().any(|s| *s > 0.0)
    }

    fn begin_span(&mut self, remaining: Option<f64>) {
        self.span = Span {
            from: remaining,
            drawn_ah: Some(0.0),
            ..Span::default()
        };
    }

    /// Charge used over the span, once it is long enough to tell.
    fn used(&mut self, remaining: Option<f64>, settings: &EnergySettings) -> Option<f64> {
        let by_report = self.span.from.zip(remaining).map(|(from, to)| from - to);
        let by_current = settings
            .capacity_ah
            .filter(|capacity_ah| *capacity_ah > 0.0)
            .zip(self.span.drawn_ah)
            .map(|(capacity_ah, drawn_ah)| drawn_ah / capacity_ah);
        let span_s = self.span.hovering_s + self.span.flying_s;
        match (by_report, by_current) {
            (_, Some(by_current)) if span_s >= CURRENT_SPAN_S => {
                self.compared.0 += by_report.unwrap_or(0.0);
                self.compared.1 += if by_report.is_some() { by_current } else { 0.0 };
                Some(by_current * self.report_per_current())
            }
            (Some(by_report), None) => (by_report >= SPAN_SHARE).then_some(by_report),
            _ => None,
        }
    }

    /// An old battery holds less than it says: the report falls faster than the current explains.
    fn report_per_current(&self) -> f64 {
        let (report, current) = self.compared;
        if report >= COMPARED_SHARE && current > 0.0 {
            (report / current).clamp(0.5, 3.0)
        } else {
            1.0
        }
    }

    fn learn(&mut self, used: f64, settings: &EnergySettings) {
        let (h, f) = (self.span.hovering_s, self.span.flying_s);
        if h + f <= 0.0 {
            return;
        }
        let span_s = h + f;
        let keep = (-span_s / settings.memory_s.max(1.0)).exp();
        for (sum, new) in self.sums.iter_mut().zip([h * h, h * f, f * f, h * used, f * used]) {
            // Every second of flight counts the same, however long the span it is in.
            *sum = *sum * keep + new / span_s;
        }
    }
}
