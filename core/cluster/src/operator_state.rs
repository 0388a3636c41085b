//! What operators tell at one node and all others have to know: their signs of life, references, tracks, what they take upon themselves,
//! fences.
//!
//! Must never do: put an older thing in the place of a newer one.

use serde::{Deserialize, Serialize};
use skein_coordination::ReferenceReport;
use skein_domain::NodeTime;
use skein_domain::VehicleId;
use skein_domain::fence::FencePlan;
use skein_domain::payload::Track;
use skein_domain::preflight::PreflightOverride;
use skein_safety::control::Entry;
use skein_state::SharedState;

/// What operators told at a node, for all others.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct OperatorState {
    /// When an operator last gave a sign of life, by the teller's clock.
    pub operator_heard: Option<NodeTime>,
    /// References that were told here, with when.
    pub references: Vec<(String, ReferenceReport, NodeTime)>,
    /// What is tracked, if it was told here.
    pub tracks: Option<Vec<Track>>,
    /// Red items that somebody takes upon himself.
    pub overrides: Vec<PreflightOverride>,
    /// Who has control authority over which vehicles, as this node knows it.
    pub control: Vec<(VehicleId, Entry)>,
    /// When consoles were last heard at this node.
    pub consoles: Vec<(String, NodeTime)>,
}

impl OperatorState {
    /// As it is at this node.
    #[must_use]
    pub fn of(shared: &SharedState) -> Self {
        let (control, consoles) = {
            let table = shared.operators.control();
            let entries = table.entries().iter();
            (
                entries.map(|(id, entry)| (*id, entry.clone())).collect(),
                table.heard_here(shared.now()),
            )
        };
        Self {
            control,
            consoles,
            operator_heard: shared.operators.heard_here(),
            references: shared.observed.references.told_here(),
            tracks: shared.observed.tracks_here(),
            overrides: shared.operators.overrides_here(),
        }
    }

    /// Takes it up on another node.
    pub fn take_up(self, shared: &SharedState, ahead_us: Option<i64>) {
        let Some(ahead_us) = ahead_us else { return };
        let now = shared.now();
        let here = |at: NodeTime| at.on_clock_ahead_by(ahead_us).min(now);
        let (operators, observed) = (&shared.operators, &shared.observed);
        if let Some(heard) = self.operator_heard {
            operators.hear_elsewhere(here(heard));
        }
        for (name, report, at) in self.references {
            // One that is out of order says nothing new.
            let _ = observed.references.hear(&name, report, here(at));
        }
        if let Some(mut tracks) = self.tracks {
            for track in &mut tracks {
                track.time = here(track.time);
            }
            observed.hear_tracks(tracks);
        }
        {
            let mut table = operators.change_control();
            for (console, at) in &self.consoles {
                table.hear_elsewhere(console, here(*at));
            }
            table.merge(
                self.control
                    .into_iter()
                    .map(|(vehicle, entry)| (vehicle, entry.timed(here))),
            );
        }
        let told = self.overrides.into_iter().map(|given| PreflightOverride {
            given_at: here(given.given_at),
            ..given
        });
        operators.hear_overrides(told);
    }
}

/// Fences that were set while the swarm runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FencesTold {
    /// Grows with every change.
    pub revision: u64,
    /// They.
    pub plan: FencePlan,
}

impl FencesTold {
    /// Puts them in force if they are newer than those in force.
    pub fn take_up(self, shared: &SharedState) {
        let Some(swarm) = &shared.swarm else { return };
        let mut revision = swarm.fence_revision();
        if *revision < self.revision && shared.set_fences(self.plan).is_ok() {
            *revision = self.revision;
        }
    }
}
