//! The words of the preflight report: what was looked at before arming, with value and limit, and who overrode what. What is
//! looked at is `skein-safety`'s and the plugins' to say.
//!
//! Must never do: check anything.

use crate::{NodeTime, Refusal, VehicleId};
use minicbor::{Decode, Encode};
use serde::{Deserialize, Serialize};

/// How an item stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
#[cbor(index_only)]
pub enum ItemStatus {
    /// Says nothing now: it is about a vehicle on the ground, and this one flies.
    #[n(3)]
    NotApplicable,
    /// Good.
    #[default]
    #[n(0)]
    Green,
    /// An operator should know; it does not keep from arming.
    #[n(1)]
    Amber,
    /// Keeps from arming.
    #[n(2)]
    Red,
}

/// One thing looked at.
#[derive(Debug, Clone, PartialEq, Default)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
pub struct PreflightItem {
    /// Its id: what an override names. Those of plugins begin with the plugin's name and a slash.
    #[n(0)]
    pub id: String,
    /// A few words for people.
    #[n(1)]
    pub title: String,
    /// How it stands.
    #[n(2)]
    pub status: ItemStatus,
    /// The value as text, with its unit.
    #[n(3)]
    pub value: String,
    /// The value as a number, in `unit`, if it is one.
    #[n(4)]
    pub number: Option<f64>,
    /// Unit of number and limit; empty if they have none.
    #[n(5)]
    pub unit: String,
    /// What the number is held against, in `unit`.
    #[n(6)]
    pub limit: Option<f64>,
    /// Why it stands so, or why it matters.
    #[n(7)]
    pub why: String,
    /// It keeps from arming, and a permitted operator may take that upon himself. Filled in when the report is finished, whoever made
    /// the item.
    #[n(8)]
    #[cbor(default)]
    #[serde(default)]
    pub may_be_overridden: bool,
}

/// What was found before arming one vehicle, or for the swarm.
#[derive(Debug, Clone, PartialEq, Default)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
pub struct PreflightReport {
    /// The vehicle; absent for the swarm.
    #[n(0)]
    pub vehicle: Option<VehicleId>,
    /// Item by item.
    #[n(1)]
    pub items: Vec<PreflightItem>,
    /// When it was looked at.
    #[n(2)]
    pub made_at: NodeTime,
}

impl PreflightReport {
    /// With its items marked that may be overridden: those that are red and not among [`NEVER_OVERRIDDEN`].
    #[must_use]
    pub fn finished(mut self) -> Self {
        for item in &mut self.items {
            item.may_be_overridden = item.status == ItemStatus::Red && never_overridden(&item.id).is_none();
        }
        self
    }

    /// How the worst item stands. A report without items is red: nothing was looked at.
    #[must_use]
    pub fn worst(&self) -> ItemStatus {
        self.items.iter().map(|i| i.status).max().unwrap_or(ItemStatus::Red)
    }

    /// The items that keep from arming unless they are overridden.
    pub fn blocking(&self) -> impl Iterator<Item = &PreflightItem> {
        self.items.iter().filter(|i| i.status == ItemStatus::Red)
    }
}

/// Red items that a person takes upon themselves. Recorded when it is given and when it is used.
#[derive(Debug, Clone, PartialEq)]
#[derive(Serialize, Deserialize, Encode, Decode, ts_rs::TS, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PreflightOverride {
    /// Who.
    #[n(0)]
    pub operator: String,
    /// Why; must not be empty.
    #[n(1)]
    pub reason: String,
    /// Ids of the items.
    #[n(2)]
    pub items: Vec<String>,
    /// For which vehicle; absent: for items of the swarm.
    #[n(3)]
    pub vehicle: Option<VehicleId>,
    /// When it was given.
    #[n(4)]
    pub given_at: NodeTime,
    /// For how long it holds, in seconds.
    #[n(5)]
    pub valid_s: f64,
}

/// Items that nobody can override, with the reason why.
pub const NEVER_OVERRIDDEN: &[(&str, &str)] = &[
    (
        "position",
        "without a position nothing is known of the way to other vehicles and to the fence",
    ),
    (
        "duplicate_system_id",
        "a command would reach two vehicles, and which of them answers is not known",
    ),
    ("model", "nothing would fly the vehicle"),
];

/// No override holds for longer, in seconds: what was red must be looked at again.
pub const LONGEST_OVERRIDE_S: f64 = 900.0;

/// Why an item can never be overridden; nothing if it can.
#[must_use]
pub fn never_overridden(item: &str) -> Option<&'static str> {
    NEVER_OVERRIDDEN.iter().find(|(id, _)| *id == item).map(|(_, why)| *why)
}

impl PreflightOverride {
    /// Whether it may be taken at all.
    ///
    /// # Errors
    /// [`Refusal::NotPermitted`] for an item that nobody can override, [`Refusal::InvalidValue`] for one without a name, a reason,
    /// an item, or a sensible duration.
    pub fn check(&self) -> Result<(), Refusal> {
        let invalid = |detail: &str| Err(Refusal::invalid(detail.to_owned()));
        for item in &self.items {
            if let Some(why) = never_overridden(item) {
                let detail = format!("override of {item}: {why}");
                return Err(Refusal::NotPermitted { detail });
            }
        }
        if self.operator.trim().is_empty() {
            return invalid("an override needs the name of who gives it");
        }
        if self.reason.trim().is_empty() {
            return invalid("an override needs a reason");
        }
        if self.items.is_empty() {
            return invalid("an override names the items it is for");
        }
        if !(self.valid_s > 0.0 && self.valid_s <= LONGEST_OVERRIDE_S) {
            return invalid(&format!("an override holds for up to {LONGEST_OVERRIDE_S} s"));
        }
        Ok(())
    }

    /// Whether it covers an item of a vehicle (of the swarm, without one) now.
    #[must_use]
    pub fn covers(&self, vehicle: Option<VehicleId>, item: &str, now: NodeTime) -> bool {
        let age_s = now.seconds_since(self.given_at);
        self.check().is_ok()
            && self.vehicle == vehicle
            && (0.0..=self.valid_s).contains(&age_s)
            && self.items.iter().any(|i| i == item)
    }
}

/// `[safety.preflight]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PreflightSettings {
    /// Share of frames lost beyond which the link is amber.
    pub loss_amber_share: f64,
    /// Share of frames lost beyond which the link is red.
    pub loss_red_share: f64,
    /// A position older than this is none, in seconds.
    pub position_within_s: f64,
    /// Fewer satellites are red.
    pub min_satellites: u8,
    /// A vehicle without a satellite receiver is red; switch it off for flights under another positioning system.
    pub require_gnss: bool,
    /// Two sources of the position may differ by so much, in metres.
    pub max_disagreement_m: f64,
    /// Less charge is red, as a share of a full battery.
    pub min_battery_share: f64,
    /// Less charge is amber, as a share of a full battery.
    pub full_battery_share: f64,
    /// A vehicle that moves faster than this on the ground is red, in metres per second.
    pub max_ground_speed_m_s: f64,
    /// The offset between a vehicle's clock and the node's may be unsure by so much, in seconds.
    pub max_clock_error_s: f64,
    /// Clock offsets of the swarm may lie so far apart, in seconds.
    pub max_clock_spread_s: f64,
    /// Vehicles that stand closer together than this are red, in metres.
    pub min_ground_distance_m: f64,
    /// A swarm without a fence is red; amber otherwise.
    pub require_fence: bool,
    /// A swarm without a vehicle that can host the coordinator is red.
    pub require_coordinator_vehicle: bool,
}

impl Default for PreflightSettings {
    fn default() -> Self {
        Self {
            loss_amber_share: 0.05,
            loss_red_share: 0.3,
            position_within_s: 1.0,
            min_satellites: 6,
            require_gnss: true,
            max_disagreement_m: 3.0,
            min_battery_share: 0.3,
            full_battery_share: 0.5,
            max_ground_speed_m_s: 0.5,
            max_clock_error_s: 0.05,
            max_clock_spread_s: 0.05,
            min_ground_distance_m: 1.0,
            require_fence: false,
            require_coordinator_vehicle: false,
        }
    }
}

#[cfg(test)]
mod tests;
