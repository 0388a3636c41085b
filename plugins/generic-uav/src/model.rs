//! The model: takes events in order, steps once per tick, tells every change of state.

use crate::blend::{Motion, Stop};
use crate::flight::{Flight, Flying, Phase, Plan, Purpose, Reference, ToldState};
use crate::settings::Settings;
use crate::way::Track;
use skein_domain::exchange::{Create, Event, OwnState, PeerState};
use skein_domain::manifest::EffectKind;
use skein_domain::{
    FlightLimits, FlightMode, LandedState, NodeTime, Refusal, RequestId, Setpoint, Stick, Task, VehicleId, VehicleTask,
};
use skein_flight::drag::Look;
use skein_plugin_sdk::{CreateError, Effects, UavManifest, UavModel, saved};

/// Of the saved flight state. Changes when an older one would be misunderstood; fields that are only added keep it.
const SNAPSHOT_VERSION: u32 = 1;
/// A gap between two ticks longer than this is not flown through: the vehicle was held by its link meanwhile, in seconds.
pub(crate) const LONGEST_STEP_S: f64 = 0.25;
/// A reference farther than this from the measured place is not where the vehicle is, in metres.
const FARTHEST_REFERENCE_M: f64 = 4.0;
/// After a silence everything a vehicle tells has come in by then, in seconds.
const HEARD_WHOLE_S: f64 = 2.0;
/// A measured state is carried on for at most this long, in seconds.
const LONGEST_EXTRAPOLATION_S: f64 = 0.5;

/// The flight state machine of one vehicle.
pub struct GenericUav {
    pub(crate) settings: Settings,
    pub(crate) vehicle: VehicleId,
    pub(crate) flight: Flight,
    /// The vehicle's own state as last seen.
    pub(crate) own: Option<OwnState>,
    pub(crate) now: NodeTime,
    /// The present plan's way, built when it is first needed.
    pub(crate) track: Option<Track>,
    /// What the neighbours are known to do, while a place among them is to be kept.
    pub(crate) peers: Vec<PeerState>,
    /// The stick last heard in a flight by hand, and when. Not saved: one from before a restart is not followed.
    pub(crate) stick: Option<(Stick, NodeTime)>,
    /// The limits last told; a new instance tells them again.
    limits_told: Option<FlightLimits>,
    /// A model that is built on this one says where to be while it observes something.
    pub(crate) takes_guidance: bool,
}

impl UavModel for GenericUav {
    type Config = Settings;

    const MANIFEST: UavManifest = UavManifest {
        name: "generic-uav",
        version: env!("CARGO_PKG_VERSION"),
        description: "Flies any multirotor whose autopilot takes OFFBOARD setpoints: take-off, hold, go to, lead, follow, keep a place among neighbours, fly trajectories, return, land.",
        effects: Self::EFFECTS,
    };

    fn create(create: Create, settings: Settings) -> Result<Self, CreateError> {
        settings.check().map_err(CreateError::new)?;
        let restored = saved::restored(SNAPSHOT_VERSION, create.snapshot.as_deref());
        // Answers to an earlier incarnation's requests must not be taken for answers to this one's.
        let flight = restored.unwrap_or_else(|| Flight {
            next_request: create.incarnation.0.wrapping_shl(16),
            ..Flight::default()
        });
        Ok(Self {
            settings,
            vehicle: create.vehicle,
            flight,
            own: None,
            now: create.now,
            track: None,
            peers: Vec::new(),
            stick: None,
            limits_told: None,
            takes_guidance: false,
        })
    }

    fn handle(&mut self, now: NodeTime, events: &[Event], effects: &mut Effects) {
        self.now = now;
        let limits = self.settings.flight_limits();
        if self.limits_told.replace(limits) != Some(limits) {
            effects.limits(limits);
        }
        for event in events {
            self.take(event, effects);
            self.tell_state(effects);
        }
    }

    fn snapshot(&self) -> Vec<u8> {
        saved::encode(SNAPSHOT_VERSION, &self.flight)
    }
}

impl GenericUav {
    /// The effects it may return; a model that is built on it names them too.
    pub const EFFECTS: &[EffectKind] = &[
        EffectKind::Setpoint,
        EffectKind::StopStream,
        EffectKind::Autopilot,
        EffectKind::CommandProgress,
        EffectKind::State,
        EffectKind::Anchor,
        EffectKind::Notice,
        EffectKind::TrackingError,
        EffectKind::RouteFinished,
        EffectKind::Limits,
    ];

    fn take(&mut self, event: &Event, out: &mut Effects) {
        match event {
            Event::Tick => self.tick(out),
            Event::Own(own) => {
                self.own = Some(*own);
                self.hear(own.link_connected);
                self.derive_state(own);
            }
            Event::Task(task) => {
                self.take_task(task);
                // At once, and not with the tick: an anchor that follows in the same batch must find the new slot.
                self.take_up_task(out);
            }
            Event::Anchor(anchor) => self.take_anchor(anchor),
            Event::Command {
                id,
                command,
                not_before,
            } => self.take_command(*id, *command, *not_before, out),
            Event::AutopilotResult { request, refusal } => self.flight.answers.push((*request, refusal.clone())),
            Event::ModeChanged { from, to, commanded } => {
                if !commanded {
                    self.flight.unasked_modes.push((*from, *to));
                }
            }
            Event::LinkLost(lost) => self.hear(!*lost),
            Event::Rebooted => self.rebooted(out),
            Event::Peers(peers) => self.take_peers(peers),
            Event::Stick(stick) => self.take_stick(stick),
            Event::Refused(refusal) => self.flight.gate_refusal = Some(refusal.clone()),
            Event::FaultDrill(_) => {} // The SDK's.
            // Payloads and what they see are no matter of this model's.
            Event::PayloadCommand { .. }
            | Event::Mavlink(_)
            | Event::Received { .. }
            | Event::Payload(_)
            | Event::Frame(_)
            | Event::Tracks(_)
            | Event::PayloadResult { .. } => {}
        }
    }

    /// The vehicle is heard, or is not.
    fn hear(&mut self, heard: bool) {
        if self.flight.link_lost && heard {
            self.flight.heard_again_s = Some(self.flight.heard_s);
        }
        self.flight.link_lost = !heard;
    }

    /// Whether what the vehicle tells less often may still be from before a silence: that it is disarmed is heard before that it stands
    /// on the ground.
    pub(crate) fn is_just_heard_again(&self) -> bool {
        let since_s = self.flight.heard_again_s;
        since_s.is_some_and(|since_s| self.flight.heard_s - since_s < HEARD_WHOLE_S)
    }

    /// Where others are matters only among neighbours.
    fn take_peers(&mut self, peers: &[PeerState]) {
        let keeps = |task: &VehicleTask| matches!(task.task, Task::Keep(_));
        let flies_so = matches!(
            &self.flight.phase,
            Phase::Flying(Flying {
                purpose: Purpose::Keep(_),
                ..
            })
        );
        self.peers.clear();
        if flies_so || self.flight.task.as_ref().is_some_and(keeps) {
            self.peers.extend_from_slice(peers);
        }
    }

    /// One control period.
    fn tick(&mut self, out: &mut Effects) {
        let Some(own) = self.own else { return };
        let dt_s = self.step_clock();
        self.learn_drag(&own);
        self.begin_waiting(out);
        self.watch_modes(&own, out);
        self.take_up_task(out);
        match std::mem::take(&mut self.flight.phase) {
            Phase::Flying(flying) => self.step_flying(flying, &own, dt_s, out),
            // Nothing is to be decided on what is not heard; what streams goes on above.
            phase if self.flight.link_lost => self.flight.phase = phase,
            Phase::Idle => self.step_idle(&own, out),
            Phase::Arming(arming) => self.step_arming(arming, &own, out),
            Phase::Disarming(asking) => self.step_disarming(asking, &own, out),
            Phase::TakingOff(taking_off) => self.step_taking_off(taking_off, &own, out),
            Phase::Landing(landing) => self.step_landing(landing, &own, dt_s, out),
            Phase::PilotControl => self.step_pilot_control(&own),
            Phase::Faulted => self.flight.phase = Phase::Faulted,
        }
        if !self.flight.link_lost {
            self.flight.answers.clear();
        }
        self.flight.unasked_modes.clear();
        self.flight.gate_refusal = None;
    }

    /// Time since the last tick in seconds: zero at the first one and after a gap.
    fn step_clock(&mut self) -> f64 {
        let gap_s = self.flight.ticked.map_or(0.0, |ticked| self.now.seconds_since(ticked));
        self.flight.ticked = Some(self.now);
        let dt_s = if (0.0..=LONGEST_STEP_S).contains(&gap_s) {
            gap_s
        } else {
            0.0
        };
        if !self.flight.link_lost {
            self.flight.heard_s += dt_s;
        }
        dt_s
    }

    /// Looks at how the vehicle flies, while it surely does.
    fn learn_drag(&mut self, own: &OwnState) {
        let flies = own.armed && own.landed == LandedState::InAir && !self.flight.link_lost;
        let told = own.kinematics.zip(own.roll_rad).zip(own.pitch_rad);
        match told.filter(|_| flies) {
            Some(((kinematics, roll_rad), pitch_rad)) => self.flight.drag.see(Look {
                time: kinematics.measured,
                velocity: kinematics.velocity,
                roll_rad,
                pitch_rad,
                yaw_rad: kinematics.yaw_rad,
            }),
            None => self.flight.drag.interrupt(),
        }
    }

    /// Without a snapshot the state follows from what the vehicle does. Once, with the first state that is heard.
    fn derive_state(&mut self, own: &OwnState) {
        if self.flight.derived || !own.link_connected {
            return;
        }
        self.flight.derived = true;
        if !is_airborne(own) {
            return;
        }
        if own.mode == FlightMode::Offboard
            && let Some(have) = self.measured()
        {
            let flying = Flying {
                purpose: Purpose::Hold { at: None },
                engaging: None,
                plan: Plan::Stop(Stop {
                    from: have.position,
                    velocity: have.velocity,
                }),
                elapsed_s: 0.0,
                blend: None,
                yaw_rad: own.kinematics.map(|k| k.yaw_rad),
                after: None,
            };
            self.enter(Phase::Flying(flying), "taken over in the air");
        } else {
            self.enter(Phase::PilotControl, "was in the air already");
        }
    }

    /// A new phase and why.
    pub(crate) fn enter(&mut self, phase: Phase, detail: impl Into<String>) {
        self.flight.phase = phase;
        self.flight.detail = detail.into();
    }

    /// Tells the state if it is another than last told.
    fn tell_state(&mut self, out: &mut Effects) {
        let state = self.flight.phase.state();
        let same = |told: &ToldState| told.state == state && told.detail == self.flight.detail;
        if !self.flight.told.as_ref().is_some_and(same) {
            let detail = self.flight.detail.clone();
            out.state(state, detail.clone());
            self.flight.told = Some(ToldState { state, detail });
        }
    }

    /// The command being carried out has come to its end.
    pub(crate) fn command_done(&mut self, out: &mut Effects) {
        if let Some(command) = self.flight.command.take() {
            out.done(command.id);
        }
    }

    /// The command being carried out is broken off.
    pub(crate) fn command_refused(&mut self, refusal: Refusal, out: &mut Effects) {
        if let Some(command) = self.flight.command.take() {
            out.refused(command.id, refusal);
        }
    }

    /// The answer to a request, if it came since the last tick: `None` inside means accepted.
    pub(crate) fn result_of(&self, request: RequestId) -> Option<Option<Refusal>> {
        self.flight
            .answers
            .iter()
            .find(|(id, _)| *id == request)
            .map(|(_, refusal)| refusal.clone())
    }

    /// Ends the stream and forgets where it was.
    pub(crate) fn stop_stream(&mut self, out: &mut Effects) {
        self.flight.reference = None;
        self.flight.refused_for_s = 0.0;
        out.stop_stream();
    }

    /// Where the vehicle is now, as measured and carried on to this moment.
    pub(crate) fn measured(&self) -> Option<Motion> {
        let kinematics = self.own?.kinematics?;
        let age_s = self
            .now
            .seconds_since(kinematics.measured)
            .clamp(0.0, LONGEST_EXTRAPOLATION_S);
        let position = kinematics.position.after(&kinematics.velocity, age_s);
        let motion = Motion {
            position,
            velocity: kinematics.velocity,
            ..Motion::default()
        };
        (motion.position.is_finite() && motion.velocity.is_finite()).then_some(motion)
    }

    /// How far the present is from what [`Self::measured`] says, in seconds: nothing as long as the vehicle is heard.
    pub(crate) fn not_heard_s(&self) -> f64 {
        let measured = self.own.and_then(|own| own.kinematics).map(|k| k.measured);
        let age_s = measured.map_or(0.0, |measured| self.now.seconds_since(measured));
        (age_s - LONGEST_EXTRAPOLATION_S).max(0.0)
    }

    /// The setpoint last given, if the vehicle may be taken to be there.
    pub(crate) fn fresh_reference(&self) -> Option<Reference> {
        let reference = self.flight.reference?;
        let age_s = self.now.seconds_since(reference.time);
        let near = self
            .measured()
            .is_none_or(|m| m.position.distance_m(&reference.position) <= FARTHEST_REFERENCE_M);
        ((0.0..=LONGEST_STEP_S).contains(&age_s) && near).then_some(reference)
    }

    /// The motion from which a new plan goes on, and its time: the reference if the vehicle follows one, else what is measured.
    pub(crate) fn present_motion(&self) -> Option<(Motion, NodeTime)> {
        match self.fresh_reference() {
            Some(Reference {
                position,
                velocity,
                time,
                ..
            }) => Some((
                Motion {
                    position,
                    velocity,
                    ..Motion::default()
                },
                time,
            )),
            None => self.measured().map(|motion| (motion, self.now)),
        }
    }

    /// Streams one setpoint and remembers it. One that is not finite is not given away.
    pub(crate) fn stream(
        &mut self,
        motion: &Motion,
        yaw_rad: Option<f64>,
        yaw_rate_rad_s: Option<f64>,
        out: &mut Effects,
    ) {
        let setpoint = Setpoint {
            position: Some(motion.position),
            velocity: Some(motion.velocity),
            acceleration: Some(motion.acceleration),
            yaw_rad: yaw_rad.filter(|yaw| yaw.is_finite()),
            yaw_rate_rad_s: yaw_rate_rad_s.filter(|rate| rate.is_finite()),
            // Not into the acceleration itself: whoever judges how the setpoint moves must see how it moves.
            drag_per_s: Some(self.flight.drag.drag_per_s()),
        };
        if !setpoint.is_well_formed() {
            return;
        }
        let Motion { position, velocity, .. } = *motion;
        let yaw_rad = setpoint.yaw_rad;
        self.flight.reference = Some(Reference {
            position,
            velocity,
            yaw_rad,
            time: self.now,
        });
        out.setpoint(setpoint);
    }
}

/// Armed and not known to stand on the ground.
pub(crate) fn is_airborne(own: &OwnState) -> bool {
    own.armed && own.landed != LandedState::OnGround
}
