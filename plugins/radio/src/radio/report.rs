//! The state as others see it, told when it changes.

use super::Radio;
use crate::link::Figures;
use crate::settings::Source;
use skein_domain::NodeTime;
use skein_domain::payload::RadioState;
use skein_plugin_sdk::Effects;

/// Figures that only drift are told no more often than this, in seconds.
const DRIFT_PAUSE_S: f64 = 1.0;

/// Tells the state when it changed.
#[derive(Debug)]
pub(super) struct Reporter {
    pub(super) incarnation: u32,
    last: Option<(NodeTime, RadioState)>,
}

impl Reporter {
    pub(super) fn new(incarnation: u32) -> Self {
        Self {
            incarnation,
            last: None,
        }
    }

    fn tell(&mut self, now: NodeTime, state: RadioState, effects: &mut Effects) {
        if let Some((when, last)) = &self.last {
            let only_drifts = RadioState {
                distance_m: state.distance_m,
                range_m: state.range_m,
                out_of_range_in_s: state.out_of_range_in_s,
                loss: state.loss,
                latency_s: state.latency_s,
                ..last.clone()
            } == state;
            if *last == state || only_drifts && now.seconds_since(*when) < DRIFT_PAUSE_S {
                return;
            }
        }
        effects.report(&state);
        self.last = Some((now, state));
    }
}

impl Radio {
    pub(super) fn report(&mut self, now: NodeTime, effects: &mut Effects) {
        let state = self.state(now);
        self.reporter.tell(now, state, effects);
    }

    fn state(&self, now: NodeTime) -> RadioState {
        let recent = |heard: &crate::link::Heard| now.seconds_since(heard.when) <= self.settings.lost_after_s;
        let heard = self.core.heard.filter(recent);
        // Figures of a link that is not heard would be taken for present ones.
        let figures = heard.map_or_else(Figures::default, |heard| heard.figures);
        let away = self.away();
        let range_m = self.core.fall_off.range_m(self.settings.snr_margin_db);
        let source = match self.settings.source {
            Source::RadioStatus => "radio_status",
            Source::Nl80211 => "nl80211",
        };
        RadioState {
            connected: heard.is_some(),
            source: source.to_owned(),
            rssi_dbm: figures.rssi_dbm,
            remote_rssi_dbm: figures.remote_rssi_dbm,
            noise_dbm: figures.noise_dbm,
            snr_db: figures.snr_db(&self.settings),
            // Where the source says nothing of them: those of the vehicle's MAVLink, which goes over this radio.
            loss: figures
                .loss
                .or(self.own.link_loss)
                .map(|loss| (loss * 100.0).round() / 100.0),
            latency_s: figures
                .latency_s
                .or(self.own.link_round_trip_s.map(|s| s / 2.0))
                .map(|s| (s * 1e3).round() / 1e3),
            throughput_bit_s: figures.throughput_bit_s,
            channel: figures.channel,
            power_dbm: figures.power_dbm,
            distance_m: away.map(|away| away.distance_m.round()),
            range_m: range_m.map(f64::round),
            out_of_range_in_s: away
                .zip(range_m)
                .and_then(|(away, range)| away.out_of_range_in_s(range))
                .map(f64::round),
            warning: self.core.warned,
            fault: self.fault.clone(),
        }
    }
}
