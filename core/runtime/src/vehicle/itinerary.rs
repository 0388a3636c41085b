//! Commands in several legs: what the actor does as they go on. Where they stand is in the vehicle's record.
//!
//! Must never do: keep a leg of its own beside the record's.

use super::VehicleState;
use skein_domain::exchange::{CommandProgress, Event};
use skein_domain::{CommandId, FlightState, Refusal};
use skein_state::{Itinerary, LegProgress};

impl VehicleState {
    /// The first leg has been taken up.
    pub(super) fn begin_itinerary(&mut self, itinerary: Itinerary) {
        let returns = itinerary.returns;
        self.record.commanded.begin_itinerary(itinerary);
        if returns {
            let mut published = self.record.change_state();
            if published.flight_state == FlightState::GoingTo {
                published.flight_state = FlightState::Returning;
            }
        }
    }

    /// The next leg, if the last is done, as an event for the next batch.
    pub(super) fn next_leg(&mut self) {
        if let Some((id, command)) = self.record.commanded.next_leg(|| self.shared.next_command_id()) {
            self.waiting.push(Event::Command {
                id,
                command,
                not_before: self.shared.now(),
            });
        }
    }

    /// How a leg goes on; tells whether the id was one.
    pub(super) fn leg_progress(&mut self, id: CommandId, progress: &CommandProgress) -> bool {
        match self.record.commanded.leg_progress(id, progress) {
            LegProgress::NoLeg => return false,
            LegProgress::GoesOn => {}
            LegProgress::Over(itinerary) => {
                self.record_progress(itinerary.id, itinerary.name, progress);
                if let CommandProgress::Refused { refusal } = progress {
                    self.model.note_refusal(itinerary.id, refusal.clone());
                }
            }
        }
        true
    }

    /// Another command takes the place of an itinerary.
    pub(super) fn abandon_itinerary(&mut self) {
        if let Some(itinerary) = self.record.commanded.abandon_itinerary() {
            let progress = CommandProgress::Refused {
                refusal: Refusal::Superseded,
            };
            self.record_progress(itinerary.id, itinerary.name, &progress);
        }
    }

    /// The flight state as it is shown: the legs of a return are a return.
    pub(super) fn shown_state(&self, state: FlightState) -> FlightState {
        match state {
            FlightState::GoingTo | FlightState::Holding if self.record.commanded.returns() => FlightState::Returning,
            other => other,
        }
    }
}
