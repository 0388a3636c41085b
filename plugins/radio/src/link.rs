//! What a source says of a link, in one form whatever the source.

use crate::settings::{RssiScale, Settings};
use mavlink::dialects::common::RADIO_STATUS_DATA;
use minicbor::{Decode, Encode};
use skein_domain::NodeTime;

/// SiK radios: steps per decibel, and where they begin.
const SIK_STEPS_PER_DB: f64 = 1.9;
const SIK_OFFSET_DBM: f64 = -127.0;

/// One measurement of a link. What the source does not give is absent.
#[derive(Debug, Clone, Copy, PartialEq, Default, Encode, Decode)]
pub(crate) struct Figures {
    #[n(0)]
    pub(crate) rssi_dbm: Option<f64>,
    #[n(1)]
    pub(crate) remote_rssi_dbm: Option<f64>,
    #[n(2)]
    pub(crate) noise_dbm: Option<f64>,
    #[n(3)]
    pub(crate) remote_noise_dbm: Option<f64>,
    /// Share of packets lost since the measurement before.
    #[n(4)]
    pub(crate) loss: Option<f64>,
    #[n(5)]
    pub(crate) latency_s: Option<f64>,
    #[n(6)]
    pub(crate) throughput_bit_s: Option<f64>,
    #[n(7)]
    pub(crate) channel: Option<u32>,
    #[n(8)]
    pub(crate) power_dbm: Option<f64>,
}

/// Figures and when they were measured.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub(crate) struct Heard {
    #[n(0)]
    pub(crate) when: NodeTime,
    #[n(1)]
    pub(crate) figures: Figures,
}

impl Figures {
    pub(crate) fn from_radio_status(said: &RADIO_STATUS_DATA, scale: RssiScale) -> Self {
        // 0 is "nothing received", 255 "not known".
        let dbm = |raw: u8| (1..u8::MAX).contains(&raw).then(|| in_dbm(raw, scale));
        Self {
            rssi_dbm: dbm(said.rssi),
            remote_rssi_dbm: dbm(said.remrssi),
            noise_dbm: dbm(said.noise),
            remote_noise_dbm: dbm(said.remnoise),
            ..Self::default()
        }
    }

    /// Signal over noise of the weaker end, with the noise to reckon with where it is not given.
    pub(crate) fn snr_db(&self, settings: &Settings) -> Option<f64> {
        let over = |rssi: Option<f64>, noise: Option<f64>| rssi.map(|rssi| rssi - noise.unwrap_or(settings.noise_dbm));
        let here = over(self.rssi_dbm, self.noise_dbm);
        let there = over(self.remote_rssi_dbm, self.remote_noise_dbm.or(self.noise_dbm));
        match (here, there) {
            (Some(here), Some(there)) => Some(here.min(there)),
            (one, other) => one.or(other),
        }
    }
}

fn in_dbm(raw: u8, scale: RssiScale) -> f64 {
    match scale {
        RssiScale::Sik => f64::from(raw) / SIK_STEPS_PER_DB + SIK_OFFSET_DBM,
        RssiScale::SignedDbm => f64::from(raw.cast_signed()),
    }
}
