//! The rules, pure: which version a node starts, when one on trial stays or goes back, which node of a swarm is next.
//!
//! Must never do: I/O, read a clock. The installed package applies [`Versions::start`] to what a newer version wrote: fields are only ever added.

use serde::{Deserialize, Serialize};
use skein_domain::{NodeId, VehicleId};
use skein_view::{GoneBack, NodeUpgradeState, NodeVersions, VersionLabel};

/// A version on trial must be well for so long without a break, in seconds: one that ends after a moment does not stay.
const WELL_FOR_S: f64 = 5.0;

/// A version of the program on one node.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Version {
    /// The one that is installed: what the service manager starts.
    Package,
    /// One that was unpacked into a folder of its own.
    Slot {
        /// As it was packed.
        version: String,
        /// SHA-256 of its archive.
        digest: String,
    },
}

/// How the installed package is known again, without reading it: a node that was killed in flight must be back within a second.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Package {
    /// As it was built.
    pub version: String,
    /// Size of its program.
    pub bytes: u64,
    /// When its program was last changed, in nanoseconds since 1970.
    pub changed_ns: i128,
}

/// What a version has to see again to be well, since the one before saw it.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Expectations {
    /// Vehicles that were heard.
    #[serde(default)]
    pub vehicles: Vec<VehicleId>,
    /// Another node of the swarm was heard.
    #[serde(default)]
    pub others: bool,
    /// The swarm had a coordinator, which this node was or followed.
    #[serde(default)]
    pub led: bool,
}

/// A version that is tried.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Trial {
    /// Which.
    pub version: Version,
    /// It was started: once, and not again unless it confirms itself.
    pub begun: bool,
    /// What it has to see.
    #[serde(default)]
    pub expects: Expectations,
}

/// What a node keeps of its versions.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Versions {
    /// The one that has confirmed itself.
    pub confirmed: Version,
    /// The one before.
    #[serde(default)]
    pub before: Option<Version>,
    /// The one that is tried.
    #[serde(default)]
    pub trial: Option<Trial>,
    /// The last one that did not stay.
    #[serde(default)]
    pub gone_back: Option<GoneBack>,
    /// The installed package, when a version was last chosen.
    #[serde(default)]
    pub package: Option<Package>,
}

impl Default for Versions {
    fn default() -> Self {
        Self {
            confirmed: Version::Package,
            before: None,
            trial: None,
            gone_back: None,
            package: None,
        }
    }
}

/// What is started.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Start {
    /// Which version.
    pub version: Version,
    /// It has to confirm itself.
    pub on_trial: bool,
}

/// What a version on trial sees.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Seen {
    /// Vehicles that are heard.
    pub vehicles: Vec<VehicleId>,
    /// Another node of the swarm is heard.
    pub others: bool,
    /// The swarm has a coordinator, which this node is or follows.
    pub led: bool,
}

/// What becomes of a version on trial.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// It is not known yet.
    Wait,
    /// It stays.
    Confirm,
    /// It goes back, for this reason.
    GoBack(String),
}

impl Versions {
    /// Chooses what is started now; to be stored before it is. A package that was exchanged since wins over every other version.
    pub fn start(&mut self, package: Package) -> Start {
        let exchanged = self.package.as_ref().is_some_and(|known| *known != package);
        self.package = Some(package);
        if exchanged {
            self.trial = None;
            let before = std::mem::replace(&mut self.confirmed, Version::Package);
            self.before = Some(before).filter(|before| *before != Version::Package);
        }
        match &mut self.trial {
            Some(trial) if !trial.begun => {
                trial.begun = true;
                Start {
                    version: trial.version.clone(),
                    on_trial: true,
                }
            }
            Some(_) => {
                self.give_up("it ended, or was ended, before it had confirmed itself");
                self.stays()
            }
            None => self.stays(),
        }
    }

    fn stays(&self) -> Start {
        Start {
            version: self.confirmed.clone(),
            on_trial: false,
        }
    }

    /// This version is tried at the next start. Gives false if that is what runs and stays already.
    pub fn try_next(&mut self, version: Version, expects: Expectations) -> bool {
        if self.confirmed == version {
            return false;
        }
        self.gone_back = None;
        self.trial = Some(Trial {
            version,
            begun: false,
            expects,
        });
        true
    }

    /// The version on trial stays.
    pub fn confirm(&mut self) {
        if let Some(trial) = self.trial.take() {
            self.before = Some(std::mem::replace(&mut self.confirmed, trial.version));
        }
    }

    /// The version on trial does not stay, or is not even begun.
    pub fn give_up(&mut self, why: &str) {
        if let Some(trial) = self.trial.take() {
            let (from, why) = (self.label(&trial.version), why.to_owned());
            self.gone_back = Some(GoneBack { from, why });
        }
    }

    /// The version that had confirmed itself cannot be started any more: the package takes its place.
    pub fn fall_back(&mut self, why: &str) {
        let lost = std::mem::replace(&mut self.confirmed, Version::Package);
        if lost != Version::Package {
            let (from, why) = (self.label(&lost), why.to_owned());
            self.gone_back = Some(GoneBack { from, why });
        }
        self.before = None;
    }

    /// What must stay on the disk.
    pub fn kept(&self) -> impl Iterator<Item = &Version> {
        let trial = self.trial.as_ref().map(|trial| &trial.version);
        [Some(&self.confirmed), self.before.as_ref(), trial]
            .into_iter()
            .flatten()
    }

    /// A version as it is told of.
    #[must_use]
    pub fn label(&self, version: &Version) -> VersionLabel {
        match version {
            Version::Slot { version, digest } => VersionLabel {
                version: version.clone(),
                digest: Some(digest.clone()),
            },
            Version::Package => VersionLabel {
                version: self
                    .package
                    .as_ref()
                    .map_or_else(String::new, |package| package.version.clone()),
                digest: None,
            },
        }
    }
}

impl Expectations {
    /// What is missing of it, in words.
    #[must_use]
    pub fn missing(&self, seen: &Seen) -> Option<String> {
        let vehicle = self.vehicles.iter().find(|vehicle| !seen.vehicles.contains(vehicle));
        if let Some(vehicle) = vehicle {
            return Some(format!("vehicle {vehicle} is not heard again"));
        }
        if self.others && !seen.others {
            return Some("no other node of the swarm is heard".into());
        }
        (self.led && !seen.led).then(|| "it follows no coordinator".into())
    }
}

/// Judges a version on trial: so long after its start, well for so long (or what is missing). Where a vehicle is armed, as a pilot can do at any
/// time, nothing is exchanged.
#[must_use]
pub fn judge(since_start_s: f64, limit_s: f64, well_for_s: Result<f64, &str>, armed: bool) -> Verdict {
    match well_for_s {
        Ok(well_for_s) if well_for_s >= WELL_FOR_S => Verdict::Confirm,
        Err(missing) if since_start_s >= limit_s && !armed => {
            Verdict::GoBack(format!("after {limit_s:.0} s {missing}"))
        }
        _ => Verdict::Wait,
    }
}

/// Which node is next: others first, the one that coordinates last of them, this one at the very end.
#[must_use]
pub fn next_node(waiting: &[NodeId], coordinator: Option<NodeId>, me: NodeId) -> Option<NodeId> {
    let order = |node: &&NodeId| (**node == me, Some(**node) == coordinator, **node);
    waiting.iter().min_by_key(order).copied()
}

/// Whether a roll-out goes on after what became of a node: a version that did not come up on one does not on the next either.
#[must_use]
pub fn goes_on(after: &NodeUpgradeState) -> bool {
    !matches!(after, NodeUpgradeState::GoneBack { .. } | NodeUpgradeState::Lost { .. })
}

/// Whether a node was never told to start `wanted`: it neither runs it nor is about to, and has not gone back from it.
#[must_use]
pub fn knows_nothing_of(wanted: &VersionLabel, told: &NodeVersions) -> bool {
    let gone_back = told.gone_back.as_ref().map(|back| &back.from);
    let known = [Some(&told.runs), told.pending.as_ref(), gone_back];
    told.broken_off.is_none() && known.into_iter().flatten().all(|label| label.digest != wanted.digest)
}

/// What a node's own word means for a roll-out that had told it to start `wanted`.
#[must_use]
pub fn progress(wanted: &VersionLabel, told: &NodeVersions) -> NodeUpgradeState {
    let is_wanted = |label: &VersionLabel| label.digest == wanted.digest;
    if is_wanted(&told.runs) {
        return match told.on_trial {
            true => NodeUpgradeState::OnTrial,
            false => NodeUpgradeState::Confirmed,
        };
    }
    if let Some(back) = told.gone_back.as_ref().filter(|back| is_wanted(&back.from)) {
        return NodeUpgradeState::GoneBack { why: back.why.clone() };
    }
    if told.pending.as_ref().is_some_and(is_wanted) {
        return NodeUpgradeState::Starting;
    }
    match &told.broken_off {
        Some(refusal) => NodeUpgradeState::Refused {
            refusal: refusal.clone(),
        },
        None => NodeUpgradeState::GoneBack {
            why: format!("the node runs {} and knows of no trial", told.runs.version),
        },
    }
}

#[cfg(test)]
mod tests;
