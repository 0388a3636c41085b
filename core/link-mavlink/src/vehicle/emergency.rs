//! The emergency stop over MAVLink: what [`EmergencyStop`] wants is sent at once, around everything that waits.
//!
//! Must never do: wait for anything before the first frame of it.

use super::VehicleCore;
use super::messages::FramesTo;
use skein_domain::link::LinkEvent;
use skein_domain::{NodeTime, Refusal, RequestId};
use skein_px4::acknowledgement::Acknowledgement;
use skein_px4::commands::CommandOutlet;
use skein_px4::emergency::{ARM_DISARM, EmergencyStop, Urgent};

impl VehicleCore {
    /// Stops the motors at once, whoever else hears it. Ends the setpoint stream and every command under way that flies or arms.
    pub fn stop_motors(&mut self, now: NodeTime, request: RequestId) {
        self.end_emergency(now, Err(Refusal::Superseded));
        self.emergency = Some(EmergencyStop::new(request, now));
        // First of all the command itself: nothing that follows may keep it waiting.
        self.poll_emergency(now);
        self.commands.end_flying(&mut self.ended, &Refusal::Superseded);
        self.finish_commands();
        let action = self.stream.bar_for_good();
        self.act(now, action);
    }

    /// Whether an emergency stop is under way.
    #[must_use]
    pub fn is_stopping_motors(&self) -> bool {
        self.emergency.is_some()
    }

    /// Sends it again if it is time, or gives up.
    pub(super) fn poll_emergency(&mut self, now: NodeTime) {
        let target = self.target();
        let Some(emergency) = &mut self.emergency else { return };
        match emergency.poll(now, &self.texts) {
            Urgent::Wait => {}
            Urgent::Send(command, before) => FramesTo(&mut self.outbox, target).command(&command, before),
            Urgent::Unconfirmed(after_s) => self.events.push(LinkEvent::StopUnconfirmed { after_s }),
            Urgent::Over(refusal) => self.end_emergency(now, Err(refusal)),
        }
    }

    /// Whether an acknowledgement is the emergency stop's.
    pub(super) fn acknowledge_emergency(&mut self, ack: &Acknowledgement) -> bool {
        self.emergency.as_mut().is_some_and(|stop| stop.acknowledge(ack))
    }

    /// A heartbeat shows whether the motors are armed.
    pub(super) fn see_emergency(&mut self, now: NodeTime, armed: bool) {
        let round_trip_s = self.clock.round_trip_s().unwrap_or(0.0);
        let settled = |stop: &EmergencyStop| stop.is_settled(now, round_trip_s);
        if !armed && self.emergency.as_ref().is_some_and(settled) {
            self.end_emergency(now, Ok(()));
        }
    }

    fn end_emergency(&mut self, now: NodeTime, outcome: Result<(), Refusal>) {
        if let Some(stop) = self.emergency.take() {
            self.commands.rest(ARM_DISARM, EmergencyStop::rests_until(now));
            self.events.push(LinkEvent::Result {
                request: stop.request(),
                outcome,
            });
        }
    }
}
