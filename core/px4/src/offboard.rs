//! Offboard control of one vehicle, the same over any wire: commands, the setpoint stream, changes of mode and the emergency stop, and what
//! each of them means for the others.
//!
//! Must never do: frame a message, or know which wire carries it.

use crate::acknowledgement::Acknowledgement;
use crate::commands::{Around, CommandOutlet, Commands, Ended, Origin};
use crate::emergency::{ARM_DISARM, EmergencyStop, Urgent};
use crate::events::EventQueue;
use crate::mode_watch::ModeWatch;
use crate::plan::{self, Condition, Plan, Situation};
use crate::setpoints::{HoldPlace, SetpointStream, StreamAction};
use crate::settings::LinkSettings;
use crate::status_text::StatusTexts;
use skein_domain::link::{LinkEvent, StreamState};
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{AutopilotCommand, FlightMode, LandedState, NodeTime, Refusal, RequestId};

/// The way out to one vehicle.
pub trait Wire: CommandOutlet {
    /// Sends a setpoint.
    fn setpoint(&mut self, setpoint: &LocalSetpoint);
}

/// One moment: what the link knows of its vehicle, and the way out.
pub struct Moment<'a> {
    /// Now.
    pub now: NodeTime,
    /// Times and counts.
    pub settings: &'a LinkSettings,
    /// What the vehicle tells. Whether setpoints are sent is filled in here.
    pub situation: Situation,
    /// Where it would hold.
    pub hold: HoldPlace,
    /// The way out.
    pub wire: &'a mut dyn Wire,
}

/// Offboard control of one vehicle.
#[derive(Debug, Default)]
pub struct OffboardControl {
    /// Events until the vehicle's actor takes them.
    pub events: EventQueue,
    /// Texts of the autopilot; they stand beside its refusals.
    pub texts: StatusTexts,
    modes: ModeWatch,
    commands: Commands,
    ended: Vec<Ended>,
    /// Requests for a message rate that have ended, and whether they were granted.
    rates: Vec<(u32, bool)>,
    stream: SetpointStream,
    emergency: Option<EmergencyStop>,
}

impl OffboardControl {
    /// Asks the autopilot for something, unless there is a `refusal`; the outcome comes as an event.
    pub fn request(
        &mut self,
        moment: &mut Moment<'_>,
        request: RequestId,
        command: AutopilotCommand,
        refusal: Option<Refusal>,
    ) {
        let planned = match refusal {
            Some(refusal) => Err(refusal),
            None if self.emergency.is_some() => Err(Refusal::not_permitted("an emergency stop is under way")),
            None => plan::plan(command, &self.situation(moment)),
        };
        match planned {
            Ok(plan) => {
                if plan.condition == Condition::Streaming {
                    self.stream.unbar();
                }
                self.start(moment, Origin::Request(request), plan);
            }
            Err(refusal) => self.answer(request, Err(refusal)),
        }
    }

    /// Starts a command that was planned elsewhere.
    pub fn start(&mut self, moment: &mut Moment<'_>, origin: Origin, plan: Plan) {
        self.with_commands(moment, |commands, around| commands.start(around, origin, plan));
    }

    /// How a request ended.
    pub fn answer(&mut self, request: RequestId, outcome: Result<(), Refusal>) {
        self.events.push(LinkEvent::Result { request, outcome });
    }

    /// Takes in an acknowledgement that is ours.
    pub fn on_ack(&mut self, moment: &mut Moment<'_>, ack: &Acknowledgement) {
        if !self.emergency.as_mut().is_some_and(|stop| stop.acknowledge(ack)) {
            self.with_commands(moment, |commands, around| commands.on_ack(around, ack));
        }
    }

    /// The vehicle has told its mode and whether it is armed; before that it was `armed_before`, if it had told.
    pub fn on_state(&mut self, moment: &mut Moment<'_>, armed_before: Option<bool>, round_trip_s: f64) {
        let (now, state) = (moment.now, moment.situation);
        let armed = state.armed;
        if armed_before.is_some_and(|before| before != armed) {
            self.events.push(LinkEvent::ArmedChanged { armed });
        }
        let settled = |stop: &EmergencyStop| stop.is_settled(now, round_trip_s);
        if !armed && self.emergency.as_ref().is_some_and(settled) {
            self.end_emergency(now, Ok(()));
        }
        if let Some(change) = self.modes.on_mode(now, state.mode) {
            let (from, to, commanded) = (change.from, change.to, change.commanded);
            self.events.push(LinkEvent::ModeChanged { from, to, commanded });
            // On the ground nobody is taken out of anyone's control: after a landing PX4 changes its mode by itself.
            if from == FlightMode::Offboard && !commanded && armed {
                let action = self.stream.taken_over();
                self.act(moment, action);
            }
        }
        if !armed && state.landed == LandedState::OnGround {
            self.stream.unbar();
        } else if state.mode == FlightMode::Offboard {
            self.stream.handed_back();
        }
        self.poll_commands(moment);
    }

    /// Takes a setpoint that is valid until `expires`, and sends it.
    pub fn stream(&mut self, moment: &mut Moment<'_>, setpoint: LocalSetpoint, expires: NodeTime) {
        let action = self.stream.offer(moment.now, setpoint, expires, moment.settings);
        self.act(moment, action);
        if self.commands.is_entering_offboard() {
            self.poll_commands(moment);
        }
    }

    /// Setpoints may be sent again although the autopilot's failsafe took the vehicle out of OFFBOARD.
    pub fn resume_stream(&mut self) {
        self.stream.handed_back();
    }

    /// Ends the stream on purpose.
    pub fn stop_stream(&mut self, moment: &mut Moment<'_>) {
        let action = self.stream.stop();
        self.act(moment, action);
    }

    /// Ends all commands for one reason.
    pub fn end_commands(&mut self, refusal: &Refusal) {
        self.commands.end_all(&mut self.ended, refusal);
        self.finish();
    }

    /// Ends all commands and the stream for one reason: nothing may be sent any more.
    pub fn give_up(&mut self, moment: &mut Moment<'_>, refusal: &Refusal) {
        self.end_commands(refusal);
        let action = self.stream.give_up();
        self.act(moment, action);
    }

    /// Stops the motors at once, whoever else hears it. Ends the setpoint stream and every command under way that flies or arms.
    pub fn stop_motors(&mut self, moment: &mut Moment<'_>, request: RequestId) {
        self.end_emergency(moment.now, Err(Refusal::Superseded));
        self.emergency = Some(EmergencyStop::new(request, moment.now));
        // First of all the command itself: nothing that follows may keep it waiting.
        self.poll_emergency(moment);
        self.commands.end_flying(&mut self.ended, &Refusal::Superseded);
        self.finish();
        let action = self.stream.bar_for_good();
        self.act(moment, action);
    }

    /// Sends the emergency stop again if it is time, or gives up.
    pub fn poll_emergency(&mut self, moment: &mut Moment<'_>) {
        let Some(stop) = &mut self.emergency else { return };
        match stop.poll(moment.now, &self.texts) {
            Urgent::Wait => {}
            Urgent::Send(command, before) => moment.wire.command(&command, before),
            Urgent::Unconfirmed(after_s) => self.events.push(LinkEvent::StopUnconfirmed { after_s }),
            Urgent::Over(refusal) => self.end_emergency(moment.now, Err(refusal)),
        }
    }

    fn end_emergency(&mut self, now: NodeTime, outcome: Result<(), Refusal>) {
        if let Some(stop) = self.emergency.take() {
            self.commands.rest(ARM_DISARM, EmergencyStop::rests_until(now));
            self.answer(stop.request(), outcome);
        }
    }

    /// Repeats or ends the stream, and does what has become due of the commands.
    pub fn poll(&mut self, moment: &mut Moment<'_>) {
        let hold = moment.hold;
        let action = self.stream.poll(moment.now, || hold, moment.settings);
        self.act(moment, action);
        self.poll_commands(moment);
    }

    /// Does what has become due or possible of the commands.
    pub fn poll_commands(&mut self, moment: &mut Moment<'_>) {
        self.with_commands(moment, Commands::poll);
    }

    /// When something has to be done next, if nothing is heard until then.
    #[must_use]
    pub fn due(&self, settings: &LinkSettings) -> Option<NodeTime> {
        let emergency = self.emergency.as_ref().map(EmergencyStop::due);
        let due = [self.stream.due(settings), self.commands.due(), emergency];
        due.into_iter().flatten().min()
    }

    /// Whether one of the rate keeper's commands is under way.
    #[must_use]
    pub fn is_tuning(&self) -> bool {
        self.commands.is_tuning()
    }

    /// Requests for a message rate that have ended since the last call, and whether they were granted.
    pub fn take_rates(&mut self) -> Vec<(u32, bool)> {
        std::mem::take(&mut self.rates)
    }

    /// What the stream is doing.
    #[must_use]
    pub fn stream_state(&self) -> StreamState {
        self.stream.state()
    }

    /// Whether setpoints are being sent.
    #[must_use]
    pub fn is_streaming(&self) -> bool {
        self.stream.is_active()
    }

    /// Setpoints per second.
    pub fn setpoint_rate_hz(&mut self, now: NodeTime) -> f32 {
        self.stream.rate_hz(now)
    }

    fn situation(&self, moment: &Moment<'_>) -> Situation {
        Situation {
            streaming: self.stream.is_active(),
            ..moment.situation
        }
    }

    fn act(&mut self, moment: &mut Moment<'_>, action: StreamAction) {
        if let Some(setpoint) = action.send {
            moment.wire.setpoint(&setpoint);
        }
        if let Some(state) = action.changed {
            self.events.push(LinkEvent::Stream(state));
        }
    }

    fn with_commands(&mut self, moment: &mut Moment<'_>, act: impl FnOnce(&mut Commands, &mut Around<'_>)) {
        let settings = moment.settings;
        let mut around = Around {
            now: moment.now,
            settings,
            situation: self.situation(moment),
            stream_has_run: self.stream.has_run(moment.now, settings.offboard_lead_s),
            texts: &self.texts,
            modes: &mut self.modes,
            outlet: &mut *moment.wire,
            ended: &mut self.ended,
        };
        act(&mut self.commands, &mut around);
        self.finish();
    }

    fn finish(&mut self) {
        for Ended { origin, outcome } in self.ended.drain(..) {
            match origin {
                Origin::Request(request) => self.events.push(LinkEvent::Result { request, outcome }),
                Origin::Rate(id) => self.rates.push((id, outcome.is_ok())),
                Origin::Copy(_) | Origin::Nobody => {}
            }
        }
    }
}
