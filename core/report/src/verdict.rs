//! A flight in a few plain sentences, made from what was found.
//!
//! Must never do: judge; it counts and compares.

use crate::facts::{EndState, Finding, FindingKind, Report, VehicleFacts};
use crate::page::Clock;
use skein_domain::VehicleId;

/// The sentences, the gravest first.
pub fn of(report: &Report) -> Vec<String> {
    let flew = report
        .vehicles
        .iter()
        .filter(|vehicle| vehicle.end != EndState::NeverFlew);
    if flew.count() == 0 {
        return vec!["No vehicle was in the air.".into()];
    }
    let mut sentences = ends(report);
    sentences.extend(counts(&report.findings));
    sentences.extend(distance(report));
    sentences.extend(error(report));
    sentences
}

/// A number as a word, where that is short.
fn number(of: usize) -> String {
    let words = [
        "no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten",
    ];
    words.get(of).map_or_else(|| of.to_string(), |word| (*word).to_owned())
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters
        .next()
        .map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

fn named(vehicles: &[&VehicleFacts]) -> String {
    let ids: Vec<String> = vehicles.iter().map(|vehicle| vehicle.id.to_string()).collect();
    match ids.as_slice() {
        [one] => format!("vehicle {one}"),
        [rest @ .., last] => format!("vehicles {} and {last}", rest.join(", ")),
        [] => String::new(),
    }
}

/// Which vehicles they are about, where those are few.
fn whose(found: &[&Finding]) -> String {
    let mut ids: Vec<VehicleId> = found.iter().filter_map(|found| found.vehicle).collect();
    ids.sort_unstable();
    ids.dedup();
    let ids: Vec<String> = ids.iter().map(ToString::to_string).collect();
    match ids.as_slice() {
        [] => String::new(),
        [one] => format!(" (vehicle {one})"),
        few if few.len() <= 4 => format!(" (vehicles {})", few.join(", ")),
        many => format!(" ({} vehicles)", many.len()),
    }
}

fn ends(report: &Report) -> Vec<String> {
    let with =
        |end: EndState| -> Vec<&VehicleFacts> { report.vehicles.iter().filter(|vehicle| vehicle.end == end).collect() };
    let (lost, in_air) = (with(EndState::Lost), with(EndState::InAir));
    let mut sentences = Vec::new();
    if lost.is_empty() {
        sentences.push("No vehicle was lost.".to_owned());
    } else {
        let were = if lost.len() == 1 { "was" } else { "were" };
        let last = "in the air when last heard, and not heard again";
        sentences.push(capital(&format!("{} {were} lost: {last}.", named(&lost))));
    }
    if !in_air.is_empty() {
        let were = if in_air.len() == 1 { "was" } else { "were" };
        sentences.push(capital(&format!(
            "{} {were} still in the air at the end of the recording.",
            named(&in_air)
        )));
    }
    sentences
}

fn counts(findings: &[Finding]) -> Option<String> {
    let mut parts = Vec::new();
    let mut tell = |kinds: &[FindingKind], one: &str, many: &str| {
        let of = findings.iter().filter(|found| kinds.contains(&found.kind));
        let found: Vec<&Finding> = of.collect();
        if !found.is_empty() {
            let what = if found.len() == 1 { one } else { many };
            parts.push(format!("{} {what}{}", number(found.len()), whose(&found)));
        }
    };
    tell(&[FindingKind::EmergencyStop], "emergency stop", "emergency stops");
    tell(&[FindingKind::Failsafe], "failsafe", "failsafes");
    tell(&[FindingKind::Takeover], "takeover", "takeovers");
    tell(&[FindingKind::LinkLoss], "loss of link", "losses of link");
    tell(
        &[FindingKind::Restart],
        "restart of a plugin or actor",
        "restarts of plugins or actors",
    );
    tell(&[FindingKind::Refusal], "refusal", "refusals");
    let others = [FindingKind::Avoidance, FindingKind::Setpoints, FindingKind::Warning];
    tell(&others, "other warning", "other warnings");
    if findings.iter().all(|found| found.kind == FindingKind::TooClose) && !findings.is_empty() {
        return None;
    }
    match parts.as_slice() {
        [] => Some("Nothing was reported as wrong.".into()),
        [one] => Some(capital(&format!("{one}."))),
        [rest @ .., last] => Some(capital(&format!("{} and {last}.", rest.join(", ")))),
    }
}

fn distance(report: &Report) -> Option<String> {
    let least = report.charts.distance_m.lowest()?;
    let [a, b] = least.pair?;
    let at = Clock::of(&report.about).time(least.t_s);
    let mut limits = report.charts.distance_limit_m.iter();
    let limit = limits.rfind(|limit| limit.t_s <= least.t_s);
    let under = match limit {
        Some(limit) if least.value < limit.value => format!(", under the limit of {:.2} m", limit.value),
        Some(limit) => format!(" (limit {:.2} m)", limit.value),
        None => String::new(),
    };
    Some(format!(
        "Smallest distance {:.2} m between {a} and {b} at {at}{under}.",
        least.value
    ))
}

/// The vehicle that was furthest from its place, where that is beyond the limit.
fn error(report: &Report) -> Option<String> {
    let limit_m = report.charts.tracking_limit_m?;
    let worst = report
        .vehicles
        .iter()
        .filter_map(|vehicle| Some((vehicle, vehicle.largest_error_m?)));
    let (vehicle, error) = worst.max_by(|a, b| a.1.value.total_cmp(&b.1.value))?;
    let at = Clock::of(&report.about).time(error.t_s);
    (error.value > limit_m).then(|| {
        let (id, metres) = (vehicle.id, error.value);
        format!("Vehicle {id} was {metres:.1} m from its place at {at} (limit {limit_m:.1} m).")
    })
}
