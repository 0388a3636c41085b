//! Radios: what they can be asked, and what they say of their link.

use serde::{Deserialize, Serialize};

/// What a radio can be asked, where the device allows it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "command", rename_all = "snake_case", deny_unknown_fields)]
pub enum RadioCommand {
    /// Change the channel.
    SetChannel {
        /// Its number as the device counts.
        channel: u32,
    },
    /// Change the transmission power.
    SetPower {
        /// In decibels over a milliwatt.
        power_dbm: f64,
    },
}

/// The state of a radio link.
#[derive(Debug, Clone, PartialEq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(default)]
pub struct RadioState {
    /// It is heard.
    pub connected: bool,
    /// What the figures come from: `radio_status`, `nl80211`.
    pub source: String,
    /// Signal strength here, in decibels over a milliwatt.
    pub rssi_dbm: Option<f64>,
    /// Signal strength at the far end, in decibels over a milliwatt.
    pub remote_rssi_dbm: Option<f64>,
    /// Noise here, in decibels over a milliwatt.
    pub noise_dbm: Option<f64>,
    /// Signal over noise in decibels, of the weaker end.
    pub snr_db: Option<f64>,
    /// Share of packets lost, 0..=1.
    pub loss: Option<f64>,
    /// Time a packet takes, in seconds.
    pub latency_s: Option<f64>,
    /// Data rate in bits per second.
    pub throughput_bit_s: Option<f64>,
    /// Channel.
    pub channel: Option<u32>,
    /// Transmission power in decibels over a milliwatt.
    pub power_dbm: Option<f64>,
    /// Distance to the ground station in metres.
    pub distance_m: Option<f64>,
    /// Distance at which the link is expected to fail, in metres, from how it fell off so far.
    pub range_m: Option<f64>,
    /// Time until the vehicle is out of range if it goes on as now, in seconds.
    pub out_of_range_in_s: Option<f64>,
    /// It is about to leave the range.
    pub warning: bool,
    /// What is wrong with it; empty if nothing.
    pub fault: String,
}
