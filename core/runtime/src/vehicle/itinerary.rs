//! Commands that take more than one flight: around a no-fly zone, or home at a height of its own. The model flies one leg after the
//! other; whoever asked sees one command.
//!
//! It lies in the vehicle's record, so that the next incarnation of the actor goes on with it. Must never do: outlive the command; whatever
//! replaces a leg ends the whole.

use super::VehicleState;
use skein_domain::exchange::{CommandProgress, Event};
use skein_domain::{CommandId, FlightState, Refusal, VehicleCommand};
use skein_state::Itinerary;
use std::collections::VecDeque;

impl VehicleState {
    /// The first leg has been taken up.
    pub(super) fn begin_itinerary(
        &mut self,
        id: CommandId,
        name: &'static str,
        legs: VecDeque<VehicleCommand>,
        first: CommandId,
        returns: bool,
    ) {
        *self.record.itinerary.lock() = Some(Itinerary {
            id,
            name,
            legs,
            current: Some(first),
            returns,
        });
        if returns {
            let mut published = self.record.change_state();
            if published.flight_state == FlightState::GoingTo {
                published.flight_state = FlightState::Returning;
            }
        }
    }

    /// The next leg, if the last is done, as an event for the next batch.
    pub(super) fn next_leg(&mut self) {
        let mut slot = self.record.itinerary.lock();
        let Some(itinerary) = slot.as_mut().filter(|i| i.current.is_none()) else {
            return;
        };
        let Some(command) = itinerary.legs.pop_front() else {
            return;
        };
        let id = self.shared.next_command_id();
        itinerary.current = Some(id);
        drop(slot);
        self.waiting.push(Event::Command {
            id,
            command,
            not_before: self.shared.now(),
        });
    }

    /// How a leg goes on; tells whether the id was one. The end of the last leg, or of any by force, is the end of the whole.
    pub(super) fn leg_progress(&mut self, id: CommandId, progress: &CommandProgress) -> bool {
        let ended = {
            let mut slot = self.record.itinerary.lock();
            let Some(itinerary) = slot.as_mut().filter(|i| i.current == Some(id)) else {
                return false;
            };
            match progress {
                CommandProgress::Executing => return true,
                CommandProgress::Done if !itinerary.legs.is_empty() => {
                    itinerary.current = None;
                    return true;
                }
                CommandProgress::Done | CommandProgress::Refused { .. } => slot.take(),
            }
        };
        if let Some(itinerary) = ended {
            self.record_progress(itinerary.id, itinerary.name, progress);
            if let CommandProgress::Refused { refusal } = progress {
                self.model.note_refusal(itinerary.id, refusal.clone());
            }
        }
        true
    }

    /// Another command takes the place of an itinerary.
    pub(super) fn abandon_itinerary(&mut self) {
        let abandoned = self.record.itinerary.lock().take();
        if let Some(itinerary) = abandoned {
            let progress = CommandProgress::Refused {
                refusal: Refusal::Superseded,
            };
            self.record_progress(itinerary.id, itinerary.name, &progress);
        }
    }

    /// The flight state as it is shown: the legs of a return are a return.
    pub(super) fn shown_state(&self, state: FlightState) -> FlightState {
        let returning = self.record.itinerary.lock().as_ref().is_some_and(|i| i.returns);
        match state {
            FlightState::GoingTo | FlightState::Holding if returning => FlightState::Returning,
            other => other,
        }
    }
}
