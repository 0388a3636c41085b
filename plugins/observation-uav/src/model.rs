//! The model: hands every event through to the flight, and says before each tick where to be and where to look.

use crate::payloads::Payloads;
use crate::report::{Activity, ObservationState, tenth};
use crate::settings::{OnRadioWarning, Settings};
use crate::target::{Sightings, missing, words};
use crate::watch::{self, Asked, Watch};
use crate::{geometry, target};
use generic_uav::{GenericUav, Goal};
use skein_plugin_sdk::domain::exchange::{Create, Event, Severity};
use skein_plugin_sdk::domain::manifest::EffectKind;
use skein_plugin_sdk::domain::{
    CommandId, FlightState, NodeTime, PositionNed, Refusal, RequestId, VehicleCommand, VelocityNed,
};
use skein_plugin_sdk::{CreateError, Effects, UavManifest, UavModel, log};

/// The state is reported at most this often, in seconds; a change of what it does at once.
const REPORT_INTERVAL_S: f64 = 0.5;
/// On station when no farther from it than this, in metres.
const ON_STATION_M: f64 = 1.5;
/// With a camera that is fixed it closes in on its target by this speed at least, in metres per second.
const SLOWEST_M_S: f64 = 1.0;
/// A period longer than this is none: the vehicle was held meanwhile, in seconds.
const LONGEST_PERIOD_S: f64 = 0.25;

/// Flies one vehicle and keeps something in view.
pub struct ObservationUav {
    pub(crate) uav: GenericUav,
    pub(crate) settings: Settings,
    pub(crate) watch: Watch,
    pub(crate) sightings: Sightings,
    pub(crate) payloads: Payloads,
    pub(crate) now: NodeTime,
    ticked: Option<NodeTime>,
    reported: Option<(NodeTime, ObservationState)>,
}

impl UavModel for ObservationUav {
    type Config = Settings;

    const MANIFEST: UavManifest = UavManifest {
        name: "observation-uav",
        version: env!("CARGO_PKG_VERSION"),
        description: "Flies as generic-uav does, and keeps a place, a vehicle or a track in view from a stand-off distance, with the gimbal, camera and radio of its vehicle.",
        // Those of `GenericUav` first: one constant list cannot take in another.
        effects: &[
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
            EffectKind::Report,
            EffectKind::PayloadCommand,
        ],
    };

    fn create(mut create: Create, settings: Settings) -> Result<Self, CreateError> {
        settings.check().map_err(CreateError::new)?;
        let restored = create.snapshot.take().map(|bytes| watch::decode(&bytes));
        let watch = match restored {
            Some(Ok((flight, watch))) => {
                create.snapshot = Some(flight);
                watch
            }
            other => {
                if let Some(Err(why)) = other {
                    log::warn!("the snapshot is of no use ({why}): starting from what the vehicle does");
                }
                // Answers to an earlier incarnation's requests must not be taken for answers to this one's.
                Watch {
                    next_request: create.incarnation.0.wrapping_shl(16),
                    ..Watch::default()
                }
            }
        };
        let now = create.now;
        Ok(Self {
            uav: GenericUav::create(create, settings.flight())?.with_guidance(),
            settings,
            watch,
            sightings: Sightings::default(),
            payloads: Payloads::default(),
            now,
            ticked: None,
            reported: None,
        })
    }

    fn handle(&mut self, now: NodeTime, events: &[Event], effects: &mut Effects) {
        self.now = now;
        for event in events {
            self.take(event, effects);
            self.notice_flight(effects);
        }
    }

    fn snapshot(&self) -> Vec<u8> {
        watch::encode(self.uav.snapshot(), &self.watch)
    }

    fn state_schema() -> Option<schemars::Schema> {
        Some(schemars::schema_for!(ObservationState))
    }
}

impl ObservationUav {
    fn take(&mut self, event: &Event, out: &mut Effects) {
        match event {
            Event::Peers(peers) => {
                self.sightings.peers.clone_from(peers);
                self.fly(event, out);
            }
            Event::Tracks(tracks) => self.sightings.tracks.clone_from(tracks),
            Event::Payload(report) => {
                self.payloads.take(report);
                self.watch_radio(out);
            }
            Event::PayloadResult { request, refusal } => self.take_answer(*request, refusal.as_ref(), out),
            Event::Command {
                id,
                command,
                not_before,
            } => self.take_command(*id, *command, *not_before, out),
            Event::Tick => self.tick(out),
            other => self.fly(other, out),
        }
    }

    /// Hands an event through to the flight.
    pub(crate) fn fly(&mut self, event: &Event, out: &mut Effects) {
        self.uav.handle(self.now, std::slice::from_ref(event), out);
    }

    fn tick(&mut self, out: &mut Effects) {
        let dt_s = self.ticked.map_or(0.0, |ticked| self.now.seconds_since(ticked));
        self.ticked = Some(self.now);
        self.steer(out);
        self.fly(&Event::Tick, out);
        // A command that had to wait may have begun.
        self.notice_flight(out);
        self.look(dt_s.clamp(0.0, LONGEST_PERIOD_S), out);
        self.run_camera(out);
        self.report(out);
    }

    /// An observation begins and ends with the flight for it.
    pub(crate) fn notice_flight(&mut self, out: &mut Effects) {
        let flown = self.uav.guided();
        let observed = self.watch.observation.as_ref().map(|observation| observation.id);
        if flown.map(|(id, _)| id) != observed {
            if observed.is_some() {
                self.end_observation(out);
            }
            if let Some((
                id,
                VehicleCommand::Observe {
                    target,
                    stand_off_m,
                    height_m,
                    bearing_rad,
                },
            )) = flown
            {
                let asked = Asked {
                    stand_off_m,
                    height_m,
                    bearing_rad,
                };
                self.begin_observation(id, target, asked, out);
            }
        }
        if self.watch.region.is_some() && self.uav.state() == FlightState::Idle {
            self.end_region(out);
        }
    }

    /// Says where to be.
    fn steer(&mut self, out: &mut Effects) {
        let (now, settings) = (self.now, &self.settings);
        let own = self.uav.own_state().and_then(|own| own.kinematics);
        let place = self.uav.guided_reference().or(self.uav.position());
        let here = self.uav.position();
        let camera_rad = self.fixed_camera_pitch_rad();
        let Some(observation) = &mut self.watch.observation else {
            return;
        };
        if !observation.aimed.look(&self.sightings, now, settings) {
            self.lose_target(out);
            return;
        }
        let waits = observation.waits(out);
        let (Some((at, velocity)), Some(place)) = (observation.aimed.motion(now, settings), place) else {
            return; // Stands until it is seen.
        };
        let (height_m, level) = observation.height_over(&at, &place, camera_rad, settings.lowest_m);
        let velocity = if level {
            VelocityNed {
                down_m_s: 0.0,
                ..velocity
            }
        } else {
            velocity
        };
        if let Some(bearing_rad) = geometry::bearing_rad(&at, &place) {
            observation.bearing_rad = Some(bearing_rad);
        }
        // Over the target itself: back off, the way the nose does not point.
        let behind_rad = || own.map_or(0.0, |own| own.yaw_rad) + std::f64::consts::PI;
        let present_rad = *observation.bearing_rad.get_or_insert_with(behind_rad);
        // Around the target, not over it.
        let bearing_rad = match observation.asked_bearing_rad {
            Some(asked_rad) => geometry::on_the_way(present_rad, asked_rad),
            None => present_rad,
        };
        let position = geometry::on_circle(&at, bearing_rad, observation.stand_off_m, height_m);
        let station = match observation.asked_bearing_rad {
            Some(asked_rad) => geometry::on_circle(&at, asked_rad, observation.stand_off_m, height_m),
            None => position,
        };
        let near = !waits && here.is_some_and(|here| here.distance_m(&station) <= ON_STATION_M);
        let arrived = near && !observation.on_station;
        observation.on_station |= near;
        let late = !observation.on_station && now.seconds_since(observation.since) > settings.approach_timeout_s;
        let after_s = now.seconds_since(observation.since);
        let speed_m_s = self.speed_m_s(&at, &velocity);
        self.uav.guide((!waits).then_some(Goal {
            position,
            velocity,
            time: now,
            speed_m_s,
        }));
        if arrived {
            self.uav.guided_command_done(out);
        }
        if late {
            let what = "arrival at the stand-off distance".to_owned();
            let refusal = Refusal::timed_out(what, after_s);
            self.break_off(refusal, false, "the stand-off distance was not reached", out);
        }
    }

    /// How fast to fly to a target that moves: as fast as that at least, or it would never be reached.
    fn speed_m_s(&self, at: &PositionNed, velocity: &VelocityNed) -> f64 {
        let most_m_s = self.settings.speed_m_s;
        let least_m_s = velocity.vector().xy().norm() + SLOWEST_M_S;
        (most_m_s * self.speed_share(at)).max(least_m_s).min(most_m_s)
    }

    fn lose_target(&mut self, out: &mut Effects) {
        let Some(observation) = &self.watch.observation else {
            return;
        };
        let target = observation.aimed.target;
        let detail = format!("{} is gone", words(&target));
        self.break_off(missing(&target), false, &detail, out);
    }

    /// Ends the observation from within.
    fn break_off(&mut self, refusal: Refusal, home: bool, why: &str, out: &mut Effects) {
        let then = if home { "returning" } else { "holding" };
        out.notice(Severity::Warning, format!("observation broken off: {why}"));
        self.uav.break_off_guided(refusal, home, &format!("{why}: {then}"), out);
        self.notice_flight(out);
    }

    /// Tells of the radio's warning, and heeds it.
    fn watch_radio(&mut self, out: &mut Effects) {
        let warning = self.payloads.radio().filter(|(_, state)| state.warning);
        let told = std::mem::replace(&mut self.watch.radio_warning, warning.is_some());
        let Some((name, state)) = warning.filter(|_| !told) else {
            return;
        };
        let when = state
            .out_of_range_in_s
            .map(|left_s| format!(" in {left_s:.0} s"))
            .unwrap_or_default();
        out.notice(
            Severity::Warning,
            format!("radio {name}: about to leave its range{when}"),
        );
        let home = match self.settings.on_radio_warning {
            OnRadioWarning::Tell => return,
            OnRadioWarning::Hold => false,
            OnRadioWarning::Return => true,
        };
        if self.watch.observation.is_some() {
            let why = "the radio is about to leave its range";
            let refusal = Refusal::not_permitted(why.to_owned());
            self.break_off(refusal, home, why, out);
        }
    }

    /// The number of a new request to a payload.
    pub(crate) fn new_request(&mut self) -> RequestId {
        let request = RequestId(self.watch.next_request);
        self.watch.next_request = self.watch.next_request.wrapping_add(1);
        request
    }

    /// Whether a command is being carried out already.
    pub(crate) fn is_known(&self, id: CommandId) -> bool {
        let observed = self.watch.observation.as_ref().map(|observation| observation.id);
        let looked = self.watch.region.as_ref().and_then(|region| region.command);
        observed == Some(id) || looked == Some(id)
    }

    fn report(&mut self, out: &mut Effects) {
        let state = self.state();
        let due = match &self.reported {
            None => true,
            Some((at, told)) => {
                let waited = self.now.seconds_since(*at) >= REPORT_INTERVAL_S;
                let at_once = told.activity != state.activity || told.target != state.target;
                *told != state && (waited || at_once)
            }
        };
        if due {
            out.report(&state);
            self.reported = Some((self.now, state));
        }
    }

    fn state(&self) -> ObservationState {
        let aimed = self.aimed();
        let at = aimed.and_then(|aimed| aimed.position(self.now, &self.settings));
        let both = at.zip(self.uav.position());
        let observation = self.watch.observation.as_ref();
        let camera = self.payloads.camera();
        let finite = |value: &f64| value.is_finite();
        let distance = |(at, here): (PositionNed, PositionNed)| tenth(here.horizontal_distance_m(&at));
        ObservationState {
            activity: match observation {
                Some(observation) if observation.on_station => Activity::Observing,
                Some(_) => Activity::Approaching,
                None if self.watch.region.is_some() => Activity::Looking,
                None => Activity::None,
            },
            target: aimed.map(|aimed| aimed.target),
            distance_m: both.map(distance).filter(finite),
            stand_off_m: observation.map(|observation| observation.stand_off_m),
            height_m: both.map(|(at, here)| tenth(at.down_m - here.down_m)).filter(finite),
            waits: observation.is_some_and(|observation| observation.waits),
            in_view: at.is_some_and(|at| self.sees(&at)),
            gimbal: self.payloads.gimbal().map(|(name, _)| name.to_owned()),
            camera: camera.map(|(name, _)| name.to_owned()),
            recording: camera.is_some_and(|(_, state)| state.recording || state.capturing),
            radio_warning: self.watch.radio_warning,
        }
    }

    /// What is looked at: the region of interest, or else what is observed.
    pub(crate) fn aimed(&self) -> Option<&target::Aimed> {
        let region = self.watch.region.as_ref().map(|region| &region.aimed);
        region.or(self.watch.observation.as_ref().map(|observation| &observation.aimed))
    }
}
