//! The plugin's configuration.

use schemars::JsonSchema;
use serde::Deserialize;

/// Where the figures come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// RADIO_STATUS, as telemetry radios put it into the vehicle's MAVLink.
    #[default]
    RadioStatus,
    /// The Wi-Fi interface of the computer this runs on, through Linux' nl80211.
    Nl80211,
}

/// How RADIO_STATUS counts signal strength.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RssiScale {
    /// As SiK radios do: raw / 1.9 - 127 dBm.
    #[default]
    Sik,
    /// dBm as a signed byte.
    SignedDbm,
}

/// Configuration of the radio plugin. Every key may be left out.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Where the figures come from.
    pub source: Source,
    /// How RADIO_STATUS counts signal strength.
    pub rssi_scale: RssiScale,
    /// Wi-Fi interface, for example `wlan0`; empty: the first there is.
    pub interface: String,
    /// How often the Wi-Fi interface is asked, per second.
    #[schemars(range(min = 0.1, max = 20.0))]
    pub poll_hz: f64,
    /// Noise to reckon with where the source gives none, in decibels over a milliwatt.
    #[schemars(range(min = -150.0, max = 0.0))]
    pub noise_dbm: f64,
    /// The link counts as at its end when its signal is less than this over the noise, in decibels.
    #[schemars(range(min = 0.0, max = 60.0))]
    pub snr_margin_db: f64,
    /// Warn so long before the vehicle reaches the end of the link as it flies now, in seconds.
    #[schemars(range(min = 0.0))]
    pub warn_before_s: f64,
    /// Warn from this share of the expected range on, however the vehicle flies.
    #[schemars(range(min = 0.1, max = 1.0))]
    pub warn_share: f64,
    /// How long a measurement weighs in what is known of how the link falls off, in seconds of measuring.
    #[schemars(range(min = 1.0))]
    pub memory_s: f64,
    /// The radio counts as lost when it gave no figures for this long, in seconds.
    #[schemars(range(min = 0.1))]
    pub lost_after_s: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            source: Source::RadioStatus,
            rssi_scale: RssiScale::Sik,
            interface: String::new(),
            poll_hz: 2.0,
            noise_dbm: -100.0,
            snr_margin_db: 10.0,
            warn_before_s: 20.0,
            warn_share: 0.85,
            memory_s: 120.0,
            lost_after_s: 5.0,
        }
    }
}

impl Settings {
    /// Whether every value can be worked with; else which cannot.
    pub fn check(&self) -> Result<(), String> {
        for (key, value, low, high) in [
            ("poll_hz", self.poll_hz, 0.1, 20.0),
            ("noise_dbm", self.noise_dbm, -150.0, 0.0),
            ("snr_margin_db", self.snr_margin_db, 0.0, 60.0),
            ("warn_before_s", self.warn_before_s, 0.0, 1e6),
            ("warn_share", self.warn_share, 0.1, 1.0),
            ("memory_s", self.memory_s, 1.0, 1e6),
            ("lost_after_s", self.lost_after_s, 0.1, 1e6),
        ] {
            if !(low..=high).contains(&value) {
                return Err(format!("{key} = {value}: it must be within {low} and {high}"));
            }
        }
        Ok(())
    }
}
