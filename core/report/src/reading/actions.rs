//! Who commanded what: the audit, commands with their progress, and every event.
//!
//! Must never do: keep without bound.

use super::Since;
use crate::facts::{ActionFacts, CommandFacts, EventFacts, Step};
use skein_domain::exchange::CommandProgress;
use skein_domain::{CommandId, VehicleId};
use skein_recording::{AuditChain, AuditRecord};
use skein_view::{EventKind, EventRecord};
use std::collections::HashMap;

/// So many of each are kept.
const ACTIONS: usize = 5_000;
const COMMANDS: usize = 5_000;
const EVENTS: usize = 10_000;
/// Steps of one command.
const STEPS: usize = 20;

/// What was done.
#[derive(Debug)]
pub struct Actions {
    since: Since,
    chain: AuditChain,
    by_id: HashMap<(Option<VehicleId>, CommandId), usize>,
    kept: Kept,
}

/// The same, for the report.
#[derive(Debug, Default)]
pub struct Kept {
    pub actions: Vec<ActionFacts>,
    pub broken: Option<String>,
    pub commands: Vec<CommandFacts>,
    pub events: Vec<EventFacts>,
    pub left_out: u64,
}

impl Actions {
    pub fn new(since: Since) -> Self {
        Self {
            since,
            chain: AuditChain::default(),
            by_id: HashMap::new(),
            kept: Kept::default(),
        }
    }

    pub fn audit(&mut self, record: AuditRecord) {
        if let Err(broken) = self.chain.follow(&record) {
            self.kept.broken.get_or_insert_with(|| broken.to_string());
        }
        if self.kept.actions.len() == ACTIONS {
            self.kept.left_out += 1;
            return;
        }
        let audit = record.audit;
        self.kept.actions.push(ActionFacts {
            t_ms: (self.since.s(audit.time) * 1e3).round() as i64,
            who: audit.who,
            over: audit.over,
            what: audit.what,
            with: audit.with,
            outcome: audit.outcome,
        });
    }

    pub fn event(&mut self, event: &EventRecord) {
        if let EventKind::Command { id, command, progress } = &event.kind {
            self.command(event, *id, command, progress);
        }
        if self.kept.events.len() == EVENTS {
            self.kept.left_out += 1;
            return;
        }
        self.kept.events.push(EventFacts {
            t_s: self.since.s(event.time),
            vehicle: event.vehicle,
            node: event.node,
            severity: event.severity,
            text: event.text.clone(),
        });
    }

    fn command(&mut self, event: &EventRecord, id: CommandId, command: &str, progress: &CommandProgress) {
        let t_s = self.since.s(event.time);
        let known = self.by_id.get(&(event.vehicle, id)).copied();
        let index = match known {
            Some(index) => index,
            None if self.kept.commands.len() == COMMANDS => {
                self.kept.left_out += 1;
                return;
            }
            None => {
                self.kept.commands.push(CommandFacts {
                    t_s,
                    id: id.0,
                    vehicle: event.vehicle,
                    command: command.to_owned(),
                    progress: Vec::new(),
                    refused: false,
                });
                let index = self.kept.commands.len() - 1;
                self.by_id.insert((event.vehicle, id), index);
                index
            }
        };
        let Some(kept) = self.kept.commands.get_mut(index) else {
            return;
        };
        let text = match progress {
            CommandProgress::Executing => "taken up".to_owned(),
            CommandProgress::Done => "done".to_owned(),
            CommandProgress::Refused { refusal } => {
                kept.refused = true;
                refusal.to_string()
            }
        };
        if kept.progress.len() < STEPS {
            kept.progress.push(Step { t_s, text });
        }
    }

    pub fn finish(self) -> Kept {
        self.kept
    }
}
