//! What is said of a vehicle's charge: how much is left, what the way home costs, and how urgent that is. The estimate itself is
//! `skein-safety`'s.
//!
//! Must never do: estimate anything.

use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};

/// How urgent it is, in order of urgency.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
#[cbor(index_only)]
pub enum EnergyLevel {
    /// Enough.
    #[default]
    #[n(0)]
    Ok,
    /// It must return soon: time to plan who takes its place.
    #[n(1)]
    ReplanSoon,
    /// It must return now to be home with its reserve.
    #[n(2)]
    ReturnNow,
    /// It does not get home any more, or has just enough to land.
    #[n(3)]
    LandNow,
}

impl EnergyLevel {
    /// The word for it, as in JSON.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::ReplanSoon => "replan_soon",
            Self::ReturnNow => "return_now",
            Self::LandNow => "land_now",
        }
    }
}

impl std::fmt::Display for EnergyLevel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.word())
    }
}

/// A vehicle's charge against its way home. Shares are of a full battery.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
pub struct EnergyState {
    /// What is left, 0..=1.
    #[n(0)]
    pub remaining: f64,
    /// What the way home and the landing there cost, with the allowance for the model's error; absent if it cannot get home against
    /// the wind at all.
    #[n(1)]
    pub needed_home: Option<f64>,
    /// What must be left after landing.
    #[n(2)]
    pub reserve: f64,
    /// What is left over: remaining less needed and reserve; negative when the reserve is touched. Less the reserve only, if home
    /// cannot be reached.
    #[n(3)]
    pub margin: f64,
    /// Time until empty at the present consumption, in seconds.
    #[n(4)]
    pub endurance_s: f64,
    /// Time until it must return, if it goes on as now, in seconds; 0 if it must already.
    #[n(5)]
    pub return_in_s: f64,
    /// How urgent it is.
    #[n(6)]
    pub level: EnergyLevel,
    /// The consumption is this vehicle's own; false while it is still the configured one.
    #[n(7)]
    pub learned: bool,
    /// Speed over the ground on the way home in metres per second; 0 if it cannot get home against the wind.
    #[n(8)]
    pub ground_speed_home_m_s: f64,
}

/// `[safety.energy]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct EnergySettings {
    /// Endurance hovering on a full battery until the vehicle's own is learned, in seconds.
    pub hover_endurance_s: f64,
    /// Endurance flying at `airspeed_m_s` on a full battery until the vehicle's own is learned, in seconds.
    pub flying_endurance_s: f64,
    /// Charge of a full battery in ampere hours, if known: lets current readings count.
    pub capacity_ah: Option<f64>,
    /// Cells in series, if known: lets the voltage stand in for a remaining charge that is not reported.
    pub cells: Option<u8>,
    /// Voltage of an empty cell under load.
    pub empty_cell_v: f64,
    /// Voltage of a full cell under load.
    pub full_cell_v: f64,
    /// Airspeed on the way home in metres per second.
    pub airspeed_m_s: f64,
    /// Rate of climb on the way home in metres per second.
    pub climb_m_s: f64,
    /// Rate of descent at home in metres per second.
    pub descent_m_s: f64,
    /// How much more climbing takes than hovering.
    pub climb_factor: f64,
    /// Time to wait over the landing place and to touch down, in seconds.
    pub landing_s: f64,
    /// Headwind assumed when no wind is reported, in metres per second.
    pub assumed_wind_m_s: f64,
    /// Headwind added to a reported wind, for gusts, in metres per second.
    pub gust_m_s: f64,
    /// Share of a full battery that is to be left after landing.
    pub reserve_share: f64,
    /// Share by which the model may be wrong: the way home is taken so much dearer.
    pub model_error_share: f64,
    /// With less than this left it lands wherever it is.
    pub critical_share: f64,
    /// So long before it must return it is said, in seconds.
    pub replan_before_s: f64,
    /// A level gets better only by so much more charge than it takes.
    pub hysteresis_share: f64,
    /// Time in the air until the vehicle's own consumption counts as learned, in seconds.
    pub learned_after_s: f64,
    /// How far back its own consumption counts, in seconds in the air.
    pub memory_s: f64,
}

impl Default for EnergySettings {
    fn default() -> Self {
        Self {
            hover_endurance_s: 1_200.0,
            flying_endurance_s: 1_200.0,
            capacity_ah: None,
            cells: None,
            empty_cell_v: 3.5,
            full_cell_v: 4.15,
            airspeed_m_s: 8.0,
            climb_m_s: 2.0,
            descent_m_s: 1.0,
            climb_factor: 1.5,
            landing_s: 15.0,
            assumed_wind_m_s: 4.0,
            gust_m_s: 1.0,
            reserve_share: 0.15,
            model_error_share: 0.3,
            critical_share: 0.08,
            replan_before_s: 90.0,
            hysteresis_share: 0.02,
            learned_after_s: 60.0,
            memory_s: 300.0,
        }
    }
}
