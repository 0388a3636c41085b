//! A node that runs, looked at from outside, over its API: actors, links, clocks, preflight report, parameters of an autopilot.
//!
//! Must never do: change anything of it.

use super::Findings;
use super::parameters::{self, Wanted};
use anyhow::{Context, bail};
use reqwest::Url;
use serde_json::Value;
use std::path::Path;
use std::time::Duration;

/// A node that does not answer for so long is not well.
const ANSWER_WITHIN: Duration = Duration::from_secs(4);
/// All parameters of an autopilot over a slow radio.
const READ_WITHIN: Duration = Duration::from_secs(180);
/// A picture of the fleet that is older tells of a node that stands.
const FRESH_S: f64 = 1.0;
/// Beyond these a link works, but not well.
const MUCH_LOST: f64 = 0.1;
const LONG_ROUND_TRIP_S: f64 = 0.3;
const MANY_DAMAGED: f64 = 0.01;
/// Trajectories start together only where clocks are known so well.
const CLOCK_KNOWN_TO_S: f64 = 0.05;

/// A running node.
pub struct Node {
    http: reqwest::Client,
    url: Url,
}

impl Node {
    /// At this address.
    ///
    /// # Errors
    /// The system has no sockets left.
    pub fn at(url: &Url) -> anyhow::Result<Self> {
        let http = reqwest::Client::builder().timeout(ANSWER_WITHIN).build()?;
        let url = url.clone();
        Ok(Self { http, url })
    }

    /// Whether it is well, for a health check: it answers, its picture of the fleet goes on, its actors run.
    pub async fn is_well(&self, findings: &mut Findings) {
        let health = match self.ask("/api/v1/health").await {
            Ok(health) => health,
            Err(error) => {
                let mend = "is it running, and is this web.listen of its configuration? Its log says why it ended";
                return findings.bad(format_args!("node: {} does not answer: {error:#}", self.url), mend);
            }
        };
        let age_s = number(&health, "/snapshot_age_s").unwrap_or(f64::INFINITY);
        if age_s > FRESH_S {
            let mend = "the node stands still: restart it (a vehicle in the air goes to its own failsafe meanwhile)";
            findings.bad(format_args!("node: its picture of the fleet is {age_s:.1} s old"), mend);
        }
        for actor in list(&health, "/not_running") {
            let (name, error) = (text(actor, "/name"), text(actor, "/last_error"));
            let mend = "correct what the error names; `skein plugin node restart VEHICLE` starts a plugin anew";
            findings.bad(format_args!("actor: {name} does not run: {error}"), mend);
        }
        let (flown, heard) = (number(&health, "/vehicles"), number(&health, "/vehicles_connected"));
        if let (Some(flown), Some(heard)) = (flown, heard) {
            findings.good(format_args!("node: answers; {heard} of {flown} vehicles are heard"));
        }
    }

    /// Everything that can be seen from outside.
    ///
    /// # Errors
    /// It does not answer.
    pub async fn examine(&self, findings: &mut Findings) -> anyhow::Result<()> {
        recorder(&self.ask("/api/v1/health").await?, findings);
        links(&self.ask("/api/v1/links").await?, findings);
        // One that is in no swarm says so, and has no others.
        if let Ok(swarm) = self.ask("/api/v1/swarm").await {
            others(&swarm, findings);
        }
        preflight(&self.ask("/api/v1/preflight").await?, findings);
        Ok(())
    }

    /// Compares the parameters of a vehicle's autopilot with a file.
    ///
    /// # Errors
    /// The file cannot be read, or the parameters cannot.
    pub async fn compare(&self, vehicle: u16, file: &Path, findings: &mut Findings) -> anyhow::Result<()> {
        let wanted = parameters::read(file)?;
        let path = format!("/api/v1/vehicles/{vehicle}/parameters?read=true");
        println!("reading the parameters of vehicle {vehicle} (up to some minutes over a radio)");
        let reading = async {
            loop {
                let answer = self.ask(&path).await?;
                match text(&answer, "/reading/state") {
                    "complete" => return Ok(answer),
                    "ended" => bail!("the reading ended: {}", text(&answer, "/reading/why")),
                    _ => tokio::time::sleep(Duration::from_millis(500)).await,
                }
            }
        };
        let read = tokio::time::timeout(READ_WITHIN, reading).await;
        let answer = read.context("the parameters were not read in time: is the link well?")??;
        parameters::compare(vehicle, &wanted, list(&answer, "/parameters"), findings);
        let unknown: Vec<_> = wanted.iter().filter(|wanted| !is_known(wanted, &answer)).collect();
        if !unknown.is_empty() {
            let names: Vec<_> = unknown.iter().map(|wanted| wanted.name.as_str()).collect();
            findings.poor(
                format_args!("parameters: vehicle {vehicle} does not know {}", names.join(", ")),
                "another release of PX4 may have another name, and a simulation has no serial ports",
            );
        }
        Ok(())
    }

    async fn ask(&self, path: &str) -> anyhow::Result<Value> {
        let answer = self.http.get(self.url.join(path)?).send().await?;
        let (status, body) = (answer.status(), answer.json::<Value>().await?);
        if status.is_success() {
            return Ok(body);
        }
        bail!("{}", text(&body, "/error/message"))
    }
}

fn is_known(wanted: &Wanted, answer: &Value) -> bool {
    list(answer, "/parameters")
        .iter()
        .any(|known| text(known, "/name") == wanted.name)
}

/// Whether flights are recorded. Nothing is said of it where nobody wants them to be, or by a node of an earlier version.
fn recorder(health: &Value, findings: &mut Findings) {
    match text(health, "/recorder/state") {
        "recording" => findings.good(format_args!("recorder: writes {}", text(health, "/recorder/file"))),
        "interrupted" => {
            let why = text(health, "/recorder/why");
            let mend =
                "make room on the disk of recorder.folder, or let its user write there; it is tried again by itself";
            findings.poor(format_args!("recorder: flights are not recorded: {why}"), mend);
        }
        _ => {}
    }
}

/// Endpoints over which nothing or rubbish comes, and vehicles that are heard badly.
fn links(report: &Value, findings: &mut Findings) {
    for endpoint in list(report, "/endpoints") {
        let (name, address) = (text(endpoint, "/name"), text(endpoint, "/address"));
        let frames = number(endpoint, "/frames_in").unwrap_or_default();
        let damaged = number(endpoint, "/damaged").unwrap_or_default();
        if frames == 0.0 {
            let mend = "check the cable and its wires, the baud rate on both sides, and MAV_1_CONFIG and MAV_1_MODE of the autopilot";
            findings.poor(format_args!("link: nothing was heard at {name} ({address})"), mend);
        } else if damaged > MANY_DAMAGED * frames {
            let mend = "a wrong baud rate, a long or unshielded cable, a weak radio, or two programs on one port";
            findings.poor(
                format_args!("link: {damaged} of {frames} frames at {name} were damaged"),
                mend,
            );
        } else {
            findings.good(format_args!("link: {name} ({address}): {frames} frames"));
        }
    }
    for vehicle in list(report, "/vehicles") {
        let name = text(vehicle, "/name");
        let is_heard = vehicle.pointer("/link/connected") == Some(&Value::Bool(true));
        let loss = number(vehicle, "/link/loss").unwrap_or_default();
        let round_trip_s = number(vehicle, "/link/round_trip_s").unwrap_or_default();
        if !is_heard {
            let mend = "is it switched on, and in range? Its last age stands in the dashboard";
            findings.poor(format_args!("vehicle: {name} is not heard"), mend);
        } else if loss > MUCH_LOST || round_trip_s > LONG_ROUND_TRIP_S {
            let mend = "a nearer antenna, a free channel, fewer streams (MAV_1_RATE)";
            findings.poor(
                format_args!(
                    "vehicle: {name}: {:.0} % of its frames are lost, {round_trip_s:.2} s for a round trip",
                    loss * 100.0
                ),
                mend,
            );
        } else {
            findings.good(format_args!(
                "vehicle: {name} is heard, {round_trip_s:.3} s for a round trip"
            ));
        }
    }
}

/// The other nodes of its swarm, and how well their clocks are known. How far these are apart means nothing: each counts from its node's start.
fn others(swarm: &Value, findings: &mut Findings) {
    for node in list(swarm, "/nodes") {
        let name = node.pointer("/name").and_then(Value::as_str).unwrap_or_default();
        let error_s = number(node, "/clock_error_s").unwrap_or(f64::INFINITY);
        if node.pointer("/clock_fault") == Some(&Value::Bool(true)) {
            let mend = "its messages come otherwise than its clock says: restart that node on the ground";
            findings.poor(format_args!("clock: that of node {name} cannot be trusted"), mend);
        } else if error_s > CLOCK_KNOWN_TO_S {
            let mend = "wait until it has been heard for some seconds, or make the network between the two faster";
            findings.poor(
                format_args!("clock: that of node {name} is known to {error_s:.3} s only"),
                mend,
            );
        } else {
            findings.good(format_args!(
                "node: {name} is in the swarm, its clock known to {error_s:.3} s"
            ));
        }
    }
}

/// What keeps the swarm or a vehicle on the ground.
fn preflight(report: &Value, findings: &mut Findings) {
    let of_swarm = report.pointer("/swarm").map(|swarm| ("the swarm".to_owned(), swarm));
    let of_vehicles = list(report, "/vehicles").iter().map(|vehicle| {
        (
            format!("vehicle {}", number(vehicle, "/vehicle").unwrap_or_default()),
            vehicle,
        )
    });
    for (whose, checked) in of_swarm.into_iter().chain(of_vehicles) {
        let red: Vec<_> = list(checked, "/items")
            .iter()
            .filter(|item| text(item, "/status") == "red")
            .collect();
        if red.is_empty() {
            findings.good(format_args!("preflight: nothing keeps {whose} on the ground"));
        }
        for item in red {
            let (title, value, why) = (text(item, "/title"), text(item, "/value"), text(item, "/why"));
            findings.poor(format_args!("preflight: {whose}: {title}: {value}"), why);
        }
    }
}

pub(super) fn text<'v>(value: &'v Value, at: &str) -> &'v str {
    value.pointer(at).and_then(Value::as_str).unwrap_or_default()
}

pub(super) fn number(value: &Value, at: &str) -> Option<f64> {
    value.pointer(at).and_then(Value::as_f64)
}

fn list<'v>(value: &'v Value, at: &str) -> &'v [Value] {
    value.pointer(at).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

#[cfg(test)]
mod tests;
