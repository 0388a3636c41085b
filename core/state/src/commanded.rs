//! The command that a vehicle carries out. One that takes more than one flight, around a no-fly zone or home at a height of its own, has an
//! itinerary: one leg after the other, and whoever asked sees one command.
//!
//! It outlives the vehicle's actor: the next incarnation goes on with it. Must never do: outlive the command; whatever replaces a leg ends the whole.

#[cfg(test)]
mod tests;

use parking_lot::Mutex;
use skein_domain::exchange::CommandProgress;
use skein_domain::{CommandId, Refusal, VehicleCommand};
use std::collections::{BTreeMap, VecDeque};
use tracing::Span;

/// So many commands are followed at once; a vehicle carries out one.
const MOST_TRACED: usize = 16;

/// A command in several legs.
#[derive(Debug, Clone)]
pub struct Itinerary {
    /// The command that was asked for.
    pub id: CommandId,
    /// Its name.
    pub name: &'static str,
    /// It leads home: the vehicle is shown as returning and takes no slot.
    pub returns: bool,
    /// What is still to be flown, first leg first.
    pub legs: VecDeque<VehicleCommand>,
    /// The leg being flown; none between two.
    pub current: Option<CommandId>,
}

/// What became of an itinerary with the progress of a command.
#[derive(Debug)]
pub enum LegProgress {
    /// The command is no leg.
    NoLeg,
    /// It goes on.
    GoesOn,
    /// It is over: its last leg is done, or any was refused.
    Over(Itinerary),
}

/// What one vehicle was commanded.
#[derive(Debug, Default)]
pub struct Commanded {
    command: Mutex<Option<(CommandId, VehicleCommand)>>,
    itinerary: Mutex<Option<Itinerary>>,
    /// Spans of those whose end was not told yet.
    traced: Mutex<BTreeMap<CommandId, Span>>,
}

impl Commanded {
    /// The command that it carries out, if one.
    #[must_use]
    pub fn command(&self) -> Option<VehicleCommand> {
        self.command.lock().map(|(_, command)| command)
    }

    /// It has taken one up.
    pub fn begin(&self, id: CommandId, command: VehicleCommand) {
        *self.command.lock() = Some((id, command));
    }

    /// How this one goes on.
    pub fn progress(&self, of: CommandId, progress: &CommandProgress) {
        if matches!(progress, CommandProgress::Executing) {
            return;
        }
        self.command.lock().take_if(|(id, _)| *id == of);
        let Some(span) = self.traced.lock().remove(&of) else {
            return;
        };
        match progress {
            CommandProgress::Refused { refusal } => {
                span.record("outcome", tracing::field::display(refusal));
                // That a newer command takes its place is no fault.
                if *refusal != Refusal::Superseded {
                    span.record("otel.status_code", "ERROR");
                }
            }
            _ => drop(span.record("outcome", "done")),
        }
    }

    /// Its span lasts until [`Self::progress`] tells its end.
    pub fn trace(&self, id: CommandId, span: Span) {
        if span.is_disabled() {
            return;
        }
        let mut traced = self.traced.lock();
        if traced.len() >= MOST_TRACED {
            traced.pop_first();
        }
        traced.insert(id, span);
    }

    /// The first leg of an itinerary has been taken up.
    pub fn begin_itinerary(&self, itinerary: Itinerary) {
        *self.itinerary.lock() = Some(itinerary);
    }

    /// The next leg, if the last one is done; `id` gives it a number.
    pub fn next_leg(&self, id: impl FnOnce() -> CommandId) -> Option<(CommandId, VehicleCommand)> {
        let mut itinerary = self.itinerary.lock();
        let itinerary = itinerary.as_mut().filter(|itinerary| itinerary.current.is_none())?;
        let leg = itinerary.legs.pop_front()?;
        let id = id();
        itinerary.current = Some(id);
        Some((id, leg))
    }

    /// How the command of this number goes on.
    pub fn leg_progress(&self, id: CommandId, progress: &CommandProgress) -> LegProgress {
        let mut slot = self.itinerary.lock();
        let Some(itinerary) = slot.as_mut().filter(|itinerary| itinerary.current == Some(id)) else {
            return LegProgress::NoLeg;
        };
        match progress {
            CommandProgress::Executing => LegProgress::GoesOn,
            CommandProgress::Done if !itinerary.legs.is_empty() => {
                itinerary.current = None;
                LegProgress::GoesOn
            }
            CommandProgress::Done | CommandProgress::Refused { .. } => {
                slot.take().map_or(LegProgress::NoLeg, LegProgress::Over)
            }
        }
    }

    /// Another command takes the place of an itinerary.
    pub fn abandon_itinerary(&self) -> Option<Itinerary> {
        self.itinerary.lock().take()
    }

    /// Whether an itinerary leads it home.
    #[must_use]
    pub fn returns(&self) -> bool {
        self.itinerary
            .lock()
            .as_ref()
            .is_some_and(|itinerary| itinerary.returns)
    }
}
