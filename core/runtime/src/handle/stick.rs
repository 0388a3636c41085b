//! Steering a vehicle by hand, whichever node of the swarm flies it.
//!
//! Must never do: wait, or leave anything in the event log: sticks come twenty times a second.

use super::NodeHandle;
use skein_domain::{NodeId, NodeTime, Refusal, Stick, VehicleCommand, VehicleId};
use skein_state::asks::{Answer, Ask};
use skein_state::by_hand;
use std::time::Duration;

/// Longest wait for another node's answer to a stick: it is old by then.
const ANSWERED_WITHIN: Duration = Duration::from_secs(1);

impl NodeHandle {
    /// How a vehicle that is steered by hand is to move, from a console. The newest replaces what was not taken up; it is good for
    /// [`skein_domain::stick::STICK_GOOD_S`]. To be called inside of a runtime.
    ///
    /// # Errors
    /// For numbers that cannot be meant, a vehicle that is not known, is under another console's control or is not steered by hand. What another
    /// node refuses is told with the sticks that follow.
    pub fn stick(&self, console: Option<&str>, vehicle: VehicleId, stick: Stick) -> Result<(), Refusal> {
        stick.check()?;
        self.may_command(console, &[vehicle])?;
        match self.shared.host(vehicle) {
            None => self.stick_here(vehicle, stick),
            Some(node) => self.stick_elsewhere(node, vehicle, stick),
        }
    }

    fn stick_here(&self, vehicle: VehicleId, stick: Stick) -> Result<(), Refusal> {
        let record = self.shared.vehicles.known(vehicle)?;
        if record.hand.lock().put(stick, self.now()) {
            return Ok(());
        }
        let state = record.state().flight_state;
        Err(Refusal::WrongState {
            state,
            command: VehicleCommand::Steer.name().to_owned(),
        })
    }

    fn stick_elsewhere(&self, node: NodeId, vehicle: VehicleId, stick: Stick) -> Result<(), Refusal> {
        let (begins, last) = self.shared.operators.relays.put(vehicle, stick, self.now());
        if begins {
            tokio::spawn(self.clone().relay(node, vehicle));
        }
        last
    }

    /// Tells another node the newest stick, one after the other, as long as there are some.
    async fn relay(self, node: NodeId, vehicle: VehicleId) {
        while let Some((stick, told)) = self.shared.operators.relays.next(vehicle) {
            let ask = Ask::Stick { vehicle, stick, told };
            let outcome = match self.ask(node, ask, ANSWERED_WITHIN).await {
                Ok(Answer::Done(outcome)) => outcome,
                Ok(_) => Ok(()),
                Err(refusal) => Err(refusal),
            };
            self.shared.operators.relays.answered(vehicle, outcome, self.now());
        }
    }

    /// A stick that came in at another node, at that time of its clock.
    pub(crate) fn stick_from_elsewhere(
        &self,
        vehicle: VehicleId,
        stick: Stick,
        told: NodeTime,
        ahead_us: Option<i64>,
    ) -> Result<(), Refusal> {
        stick.check()?;
        by_hand::in_time(told, ahead_us, self.now())?;
        self.stick_here(vehicle, stick)
    }
}
