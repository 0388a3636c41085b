//! A gimbal behind a MAVLink gimbal manager (gimbal protocol v2): found and owned. How it is turned is in [`turning`], what is known of
//! the device in [`looks`].

mod looks;
mod turning;

use crate::attitude::{Attitude, Limits};
use crate::orders::{Control, ControlOutcome, Moment, Status};
use crate::settings::Settings;
use mavlink::MessageData;
use mavlink::dialects::common::{
    COMMAND_ACK_DATA, COMMAND_LONG_DATA, GIMBAL_DEVICE_ATTITUDE_STATUS_DATA, GIMBAL_DEVICE_INFORMATION_DATA,
    GIMBAL_MANAGER_INFORMATION_DATA, GIMBAL_MANAGER_STATUS_DATA, MavCmd,
};
use minicbor::{Decode, Encode};
use payload_mavlink::{Requests, decode, send};
use skein_domain::payload::{GimbalOwner, MavlinkMessage};
use skein_domain::{NodeTime, Refusal, SystemId};
use skein_plugin_sdk::Effects;

/// Messages that a gimbal is known by.
pub(crate) const MESSAGES: &[u32] = &[
    COMMAND_ACK_DATA::ID,
    GIMBAL_MANAGER_INFORMATION_DATA::ID,
    GIMBAL_MANAGER_STATUS_DATA::ID,
    GIMBAL_DEVICE_INFORMATION_DATA::ID,
    GIMBAL_DEVICE_ATTITUDE_STATUS_DATA::ID,
    looks::MOUNT_ORIENTATION,
];

/// Pause between two questions, in seconds.
const QUESTION_PAUSE_S: f64 = 1.0;
/// How often the device is asked what it is. One that never says can be used all the same.
const DEVICE_QUESTIONS: u8 = 5;
/// A manager that has not said for this long who steers it, in seconds, is taken never to do.
const SILENT_MANAGER_S: f64 = 3.0;
/// A status that names nobody is taken for old for this long after control was given to us, in seconds.
const GRANT_SETTLES_S: f64 = 1.0;
/// "Not me any more", in the numbers of DO_GIMBAL_MANAGER_CONFIGURE. There is one for "me" too, but autopilots take it for themselves.
const NOT_MYSELF: f32 = -3.0;
/// "Leave it as it is", in the same numbers.
const UNCHANGED: f32 = -1.0;
/// Lowest component id that a device of its own can have; below are servos and the like, which their manager turns and speaks for.
const FIRST_COMPONENT: u8 = 7;

/// What a command to the manager is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Encode, Decode)]
#[cbor(index_only)]
enum Errand {
    #[n(0)]
    Take,
    #[n(1)]
    Release,
    #[n(2)]
    Turn,
}

/// The client of a gimbal manager.
#[derive(Debug, Clone, PartialEq, Default, Encode, Decode)]
pub(crate) struct Manager {
    #[n(0)]
    system_id: u8,
    /// The manager's component, once it answered.
    #[n(1)]
    component: Option<u8>,
    /// The device; 0 until one is heard.
    #[n(2)]
    device: u8,
    #[n(3)]
    requests: Requests<Errand>,
    #[n(4)]
    heard: Option<NodeTime>,
    #[n(5)]
    attitude: Option<Attitude>,
    #[n(6)]
    manager_limits: Option<Limits>,
    #[n(7)]
    device_limits: Option<Limits>,
    #[n(8)]
    model: String,
    #[n(9)]
    failures: u32,
    #[n(10)]
    flags: u16,
    /// System and component that steer it, as it last said.
    #[n(11)]
    owner: Option<(u8, u8)>,
    /// Control was given to us and not taken since.
    #[n(12)]
    granted: Option<NodeTime>,
    /// What the manager calls us.
    #[n(13)]
    own: (u8, u8),
    #[n(14)]
    last_question: Option<NodeTime>,
    #[n(15)]
    device_questions: u8,
    /// When it was found.
    #[n(16)]
    found: Option<NodeTime>,
    /// What the manager says it can; absent until it says anything.
    #[n(17)]
    capabilities: Option<u32>,
    /// Where the servos stand, if the device is servos.
    #[n(18)]
    servos: Option<Attitude>,
    /// When a turn was last asked for by a command.
    #[n(19)]
    turn_asked: Option<NodeTime>,
    /// It said that it does not know the command to turn.
    #[n(20)]
    #[cbor(default)]
    by_messages_only: bool,
}

impl Manager {
    pub(crate) fn new(system_id: Option<SystemId>, settings: &Settings) -> Self {
        Self {
            system_id: system_id.map_or(0, |id| id.0),
            device: settings.gimbal_device_id,
            own: (settings.own_system_id, settings.own_component_id),
            ..Self::default()
        }
    }

    pub(crate) fn is_ours(&self) -> bool {
        self.granted.is_some()
    }

    pub(crate) fn status(&self, at: &Moment) -> Status {
        let connected = self.component.is_some() && at.within(self.heard, at.settings.lost_after_s);
        Status {
            connected,
            owner: if connected { self.owner() } else { GimbalOwner::Unknown },
            attitude: self.looks(at),
            at_end_stop: self.is_at_end_stop(),
            by_servos: self.has_servos(),
            limits: self.limits(),
            model: self.model.clone(),
            fault: if connected { self.fault() } else { String::new() },
        }
    }

    /// Whether control may be taken without being told to: nobody has it, or the manager never says who does.
    pub(crate) fn is_free(&self, at: &Moment) -> bool {
        match self.owner {
            Some((system_id, _)) => system_id == 0,
            None => !at.within(self.found, SILENT_MANAGER_S),
        }
    }

    fn owner(&self) -> GimbalOwner {
        match (self.granted, self.owner) {
            (Some(_), _) => GimbalOwner::Us,
            (None, None) => GimbalOwner::Unknown,
            (None, Some((0, _))) => GimbalOwner::Nobody,
            (None, Some((system_id, component_id))) => GimbalOwner::Other {
                system_id,
                component_id,
            },
        }
    }

    pub(crate) fn hear(&mut self, at: &Moment, message: &MavlinkMessage) -> Option<ControlOutcome> {
        match message.message_id {
            COMMAND_ACK_DATA::ID => return self.hear_acknowledgement(at, message),
            GIMBAL_MANAGER_INFORMATION_DATA::ID => self.hear_manager(at, message, decode(message)?),
            GIMBAL_MANAGER_STATUS_DATA::ID => self.hear_status(at, message, &decode(message)?),
            GIMBAL_DEVICE_INFORMATION_DATA::ID => self.hear_device(at, message, &decode(message)?),
            GIMBAL_DEVICE_ATTITUDE_STATUS_DATA::ID => self.hear_attitude(at, message, &decode(message)?),
            looks::MOUNT_ORIENTATION => self.hear_mount(at, message),
            _ => {}
        }
        None
    }

    fn hear_acknowledgement(&mut self, at: &Moment, message: &MavlinkMessage) -> Option<ControlOutcome> {
        let (errand, outcome) = self.requests.heard(at.now, message)?;
        let named = self.requests.own().filter(|named| *named != self.own);
        match (errand, outcome) {
            (Errand::Take, Ok(())) if let Some(named) = named => {
                // It calls us otherwise than we thought, and gave control to nobody there is.
                self.own = named;
                self.request_control(Control::Take);
                None
            }
            (Errand::Take, outcome) => {
                if outcome.is_ok() {
                    self.granted = Some(at.now);
                }
                Some((Control::Take, outcome))
            }
            (Errand::Release, outcome) => {
                if outcome.is_ok() {
                    self.lose();
                }
                Some((Control::Release, outcome))
            }
            (Errand::Turn, outcome) => {
                self.turn_answered(at, outcome);
                None
            }
        }
    }

    /// A turn was done or refused. Whether it is reached is seen by where the device looks.
    fn turn_answered(&mut self, at: &Moment, outcome: Result<(), Refusal>) {
        match outcome {
            Ok(()) => {}
            Err(Refusal::NotSupported { .. }) => self.by_messages_only = true,
            // PX4 denies it to whoever is not in control, and says only every two seconds who is: it is asked at once, and what is wanted
            // goes on or ends by the answer.
            Err(_) => {
                self.lose();
                self.found = Some(at.now);
                self.last_question = None;
            }
        }
    }

    /// Control is no longer ours; who has it is for the manager to say.
    fn lose(&mut self) {
        self.granted = None;
        self.owner = None;
    }

    fn hear_manager(&mut self, at: &Moment, message: &MavlinkMessage, said: GIMBAL_MANAGER_INFORMATION_DATA) {
        if self.device != 0 && said.gimbal_device_id != 0 && said.gimbal_device_id != self.device {
            return;
        }
        if said.gimbal_device_id != 0 {
            self.device = said.gimbal_device_id;
        }
        self.system_id = message.system_id;
        if self.component.replace(message.component_id).is_none() {
            self.found = Some(at.now);
        }
        self.capabilities = Some(said.cap_flags.bits()).filter(|bits| *bits != 0);
        self.manager_limits = Limits::said((said.pitch_min, said.pitch_max), (said.yaw_min, said.yaw_max));
        self.heard = Some(at.now);
    }

    fn hear_status(&mut self, at: &Moment, message: &MavlinkMessage, said: &GIMBAL_MANAGER_STATUS_DATA) {
        let from_ours = self.component == Some(message.component_id)
            && (said.gimbal_device_id == 0 || said.gimbal_device_id == self.device);
        if !from_ours {
            return;
        }
        self.heard = Some(at.now);
        let primary = (said.primary_control_sysid, said.primary_control_compid);
        let settles = at.within(self.granted, GRANT_SETTLES_S);
        if self.own == primary {
            self.granted = self.granted.or(Some(at.now));
        } else if !(settles && primary.0 == 0) {
            self.granted = None;
        }
        self.owner = Some(primary);
    }

    pub(crate) fn work(&mut self, at: &Moment, effects: &mut Effects) -> Option<ControlOutcome> {
        if self.component.is_some() && !at.within(self.heard, at.settings.lost_after_s) {
            // Whoever comes back may be another, or have forgotten us.
            self.component = None;
            self.device_questions = 0;
            self.lose();
        }
        self.question(at, effects);
        self.work_requests(at, effects)
    }

    /// Sends what is due; gives what was given up. A turn that nobody acknowledged is none of it: it goes on by messages.
    fn work_requests(&mut self, at: &Moment, effects: &mut Effects) -> Option<ControlOutcome> {
        let given_up = self.requests.work(at.now, at.settings.patience(), effects);
        let mut of_control = given_up.into_iter().filter_map(|(errand, outcome)| match errand {
            Errand::Take => Some((Control::Take, outcome)),
            Errand::Release => Some((Control::Release, outcome)),
            Errand::Turn => None,
        });
        of_control.next_back()
    }

    fn question(&mut self, at: &Moment, effects: &mut Effects) {
        if at.within(self.last_question, QUESTION_PAUSE_S) {
            return;
        }
        let Some(manager) = self.component else {
            self.last_question = Some(at.now);
            self.request_message(GIMBAL_MANAGER_INFORMATION_DATA::ID, 0, effects);
            return;
        };
        if self.owner.is_none() {
            self.last_question = Some(at.now);
            self.request_message(GIMBAL_MANAGER_STATUS_DATA::ID, manager, effects);
        }
        if self.model.is_empty() && self.device_questions < DEVICE_QUESTIONS {
            self.last_question = Some(at.now);
            self.device_questions += 1;
            let device = if self.device >= FIRST_COMPONENT {
                self.device
            } else {
                manager
            };
            self.request_message(GIMBAL_DEVICE_INFORMATION_DATA::ID, device, effects);
        }
    }

    /// Asks once. The answer is the message itself; it is asked again until that comes.
    fn request_message(&self, id: u32, target_component: u8, effects: &mut Effects) {
        let command = COMMAND_LONG_DATA {
            // Ids below 2^24 are exact.
            param1: id as f32,
            command: MavCmd::MAV_CMD_REQUEST_MESSAGE,
            target_system: self.system_id,
            target_component,
            ..COMMAND_LONG_DATA::default()
        };
        send(&command, effects);
    }

    pub(crate) fn ask(&mut self, at: &Moment, control: Control, effects: &mut Effects) -> Option<ControlOutcome> {
        let (errand, opposite) = match control {
            Control::Take => (Errand::Take, Errand::Release),
            Control::Release => (Errand::Release, Errand::Take),
        };
        if self.requests.contains(&errand) {
            return None;
        }
        // A request the other way that nobody answered yet is out of date, and a turn need not be waited for.
        self.requests.forget(&opposite);
        self.requests.forget(&Errand::Turn);
        self.request_control(control);
        self.work_requests(at, effects)
    }

    fn request_control(&mut self, control: Control) {
        let (errand, system_id, component_id) = match control {
            Control::Take => (Errand::Take, f32::from(self.own.0), f32::from(self.own.1)),
            Control::Release => (Errand::Release, NOT_MYSELF, NOT_MYSELF),
        };
        let command = COMMAND_LONG_DATA {
            param1: system_id,
            param2: component_id,
            param3: UNCHANGED,
            param4: UNCHANGED,
            param7: f32::from(self.device),
            command: MavCmd::MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE,
            target_system: self.system_id,
            target_component: self.component.unwrap_or_default(),
            ..COMMAND_LONG_DATA::default()
        };
        self.requests.ask(errand, &command);
    }
}
