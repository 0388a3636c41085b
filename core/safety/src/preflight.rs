//! The preflight report: item by item what was found, against which limit, and whether it keeps from arming. Pure: the caller fills
//! in what is known.
//!
//! Must never do: take what is not known for good.

mod swarm;
mod vehicle;

pub use swarm::{SwarmChecks, swarm_report};
pub use vehicle::{NamedRunning, SystemIdUse, VehicleChecks, vehicle_report};

use skein_domain::preflight::never_overridden;
use skein_domain::{ItemStatus, NodeTime, PreflightItem, PreflightOverride, PreflightReport, Refusal};

/// A report older than this, in seconds, says nothing of now.
pub const REPORT_VALID_S: f64 = 5.0;

/// Whether a vehicle may be armed by this report (its own, or the swarm's: ask with both): no red item that is not overridden, and
/// the report is of now.
///
/// # Errors
/// [`Refusal::Preflight`] with the ids of the items; `report` alone if there is none, or an old one.
pub fn may_arm(report: &PreflightReport, overrides: &[PreflightOverride], now: NodeTime) -> Result<(), Refusal> {
    let age_s = now.seconds_since(report.made_at);
    if report.items.is_empty() || !(0.0..=REPORT_VALID_S).contains(&age_s) {
        return Err(Refusal::Preflight {
            items: vec!["report".to_owned()],
        });
    }
    let items: Vec<String> = report
        .blocking()
        .filter(|item| overriding(report, item, overrides, now).is_none())
        .map(|item| item.id.clone())
        .collect();
    if items.is_empty() {
        Ok(())
    } else {
        Err(Refusal::Preflight { items })
    }
}

/// The overrides that arming by this report makes use of, each once: what is to be recorded.
#[must_use]
pub fn used_overrides<'a>(
    report: &PreflightReport,
    overrides: &'a [PreflightOverride],
    now: NodeTime,
) -> Vec<&'a PreflightOverride> {
    overrides
        .iter()
        .filter(|o| {
            report
                .blocking()
                .any(|item| overriding(report, item, std::slice::from_ref(*o), now).is_some())
        })
        .collect()
}

fn overriding<'a>(
    report: &PreflightReport,
    item: &PreflightItem,
    overrides: &'a [PreflightOverride],
    now: NodeTime,
) -> Option<&'a PreflightOverride> {
    if never_overridden(&item.id).is_some() {
        return None;
    }
    overrides.iter().find(|o| o.covers(report.vehicle, &item.id, now))
}

/// What an item is about, to which its finding is added.
#[derive(Clone, Copy)]
struct Subject {
    id: &'static str,
    title: &'static str,
    why: &'static str,
}

impl Subject {
    const fn new(id: &'static str, title: &'static str) -> Self {
        Self { id, title, why: "" }
    }

    const fn because(self, why: &'static str) -> Self {
        Self { why, ..self }
    }

    /// An item with a word for a value.
    fn word(self, status: ItemStatus, value: impl Into<String>) -> PreflightItem {
        PreflightItem {
            id: self.id.to_owned(),
            title: self.title.to_owned(),
            status,
            value: value.into(),
            why: self.why.to_owned(),
            ..PreflightItem::default()
        }
    }

    /// An item with a number that must not be above `red`, and had better not be above `amber`. Not known is red.
    fn at_most(self, value: Option<f64>, amber: f64, red: f64, unit: Unit) -> PreflightItem {
        self.number(value, amber, red, unit, |value, limit| value > limit)
    }

    /// An item with a number that must not be below `red`, and had better not be below `amber`. Not known is red.
    fn at_least(self, value: Option<f64>, amber: f64, red: f64, unit: Unit) -> PreflightItem {
        self.number(value, amber, red, unit, |value, limit| value < limit)
    }

    fn number(
        self,
        value: Option<f64>,
        amber: f64,
        red: f64,
        unit: Unit,
        breaks: fn(f64, f64) -> bool,
    ) -> PreflightItem {
        let Some(value) = value.filter(|v| v.is_finite()) else {
            return self.not_known(red, unit);
        };
        let (status, limit) = if breaks(value, red) {
            (ItemStatus::Red, red)
        } else if breaks(value, amber) {
            (ItemStatus::Amber, amber)
        } else {
            (ItemStatus::Green, red)
        };
        PreflightItem {
            number: Some(value),
            limit: Some(limit),
            unit: unit.word.to_owned(),
            ..self.word(status, unit.show(value))
        }
    }

    fn not_known(self, limit: f64, unit: Unit) -> PreflightItem {
        PreflightItem {
            limit: Some(limit),
            unit: unit.word.to_owned(),
            ..self.word(ItemStatus::Red, "not known")
        }
    }
}

/// A unit and how its numbers are shown.
#[derive(Clone, Copy)]
struct Unit {
    word: &'static str,
    decimals: usize,
}

impl Unit {
    const METRES: Self = Self { word: "m", decimals: 1 };
    const METRES_PER_S: Self = Self {
        word: "m/s",
        decimals: 1,
    };
    const SECONDS: Self = Self { word: "s", decimals: 3 };
    /// Shares are shown as they are limited: a fraction of one.
    const SHARE: Self = Self { word: "", decimals: 2 };
    const COUNT: Self = Self { word: "", decimals: 0 };

    fn show(self, value: f64) -> String {
        let space = if self.word.is_empty() { "" } else { " " };
        format!("{value:.*}{space}{}", self.decimals, self.word)
    }
}

/// Green if it is so, red if it is not or not known.
fn must_be(known: Option<bool>) -> ItemStatus {
    if known == Some(true) {
        ItemStatus::Green
    } else {
        ItemStatus::Red
    }
}

#[cfg(test)]
mod tests;
