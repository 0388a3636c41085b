//! Cameras that this node speaks for in MAVLink's camera protocol 2: where their video is sent to, for ground stations that the autopilot passes
//! messages on to. Each is a component of the vehicle's system with a heartbeat of its own.
//!
//! Bound: one frame in 50 ms, heartbeats and answers together; at most sixteen answers wait, and a command that finds no room is not answered, so that
//! it is asked again. Must never do: carry out a command, or use the component id of a camera that speaks for itself.

mod answers;

use crate::fields::Fields;
use crate::frame::Frame;
use crate::outbox::Outbox;
use answers::Answer;
use mavlink::MavHeader;
use mavlink::dialects::common::{HEARTBEAT_DATA, MavAutopilot, MavModeFlag, MavState, MavType};
use skein_domain::NodeTime;
use std::collections::VecDeque;

/// `MAV_COMP_ID_CAMERA6` to `MAV_COMP_ID_CAMERA`. Cameras that speak for themselves begin at the other end.
const COMPONENTS: [u8; 6] = [105, 104, 103, 102, 101, 100];
/// It is listened for so long before an id counts as free, in seconds: cameras are heard once a second.
const LISTEN_S: f64 = 2.5;
/// An id at which nobody was heard for so long is free again, in seconds.
const HEARD_FOR_S: f64 = 30.0;
const HEARTBEAT_S: f64 = 1.0;
/// Frames are so far apart, in seconds: the longest takes as long on a line of 57600 baud.
const APART_S: f64 = 0.05;
const MOST_WAITING: usize = 16;
/// `custom_mode` of these heartbeats means nothing to anyone. By this and our system id we know them when a second link brings them back.
const OUR_SIGN: u32 = 0x534b_0000;

const HEARTBEAT: u32 = 0;
const COMMAND_INT: u32 = 75;
const COMMAND_LONG: u32 = 76;

/// A camera whose video is sent to ground stations.
#[derive(Debug, Clone, PartialEq)]
pub struct ToldCamera {
    /// Its name on the vehicle.
    pub name: String,
    /// Its streams.
    pub streams: Vec<ToldStream>,
}

/// One stream, H.264 as RTP over UDP.
#[derive(Debug, Clone, PartialEq)]
pub struct ToldStream {
    /// What people call it.
    pub name: String,
    /// The port at which a ground station receives it.
    pub port: u16,
    /// Pictures come.
    pub running: bool,
    /// Pictures per second.
    pub rate_hz: f64,
    /// Width and height in pixels.
    pub size_px: (u32, u32),
    /// Bits per second; 0 if it is not known.
    pub bits_per_s: f64,
}

/// The cameras of one vehicle that this node speaks for.
#[derive(Debug)]
pub struct Cameras {
    system_id: u8,
    sign: u32,
    voices: Vec<Voice>,
    /// When another camera was last heard at each of [`COMPONENTS`].
    others: [Option<NodeTime>; COMPONENTS.len()],
    listens_until: Option<NodeTime>,
    /// From which camera, and what.
    waiting: VecDeque<(String, Answer)>,
    next_frame: NodeTime,
}

/// One camera and as whom it speaks.
#[derive(Debug)]
struct Voice {
    camera: ToldCamera,
    /// None before an id has been found, and while all are taken.
    sender: Option<MavHeader>,
    next_heartbeat: NodeTime,
}

/// The system that a command is for, if the frame is one.
pub(crate) fn asked_system(frame: &Frame<'_>) -> Option<u8> {
    let is_command = matches!(frame.header.message_id, COMMAND_INT | COMMAND_LONG);
    (is_command && frame.known).then(|| Fields(frame.payload).u8(30))
}

impl Cameras {
    /// None yet.
    #[must_use]
    pub fn new(system_id: u8, own_system_id: u8) -> Self {
        Self {
            system_id,
            sign: OUR_SIGN | u32::from(own_system_id),
            voices: Vec::new(),
            others: [None; COMPONENTS.len()],
            listens_until: None,
            waiting: VecDeque::new(),
            next_frame: NodeTime::default(),
        }
    }

    /// Speaks for these from now on. One that was there before keeps its component.
    pub fn tell(&mut self, now: NodeTime, cameras: Vec<ToldCamera>) {
        self.listens_until.get_or_insert(now.plus_seconds(LISTEN_S));
        let mut before = std::mem::take(&mut self.voices);
        let voice = |camera: ToldCamera| match before.iter().position(|voice| voice.camera.name == camera.name) {
            Some(at) => Voice {
                camera,
                ..before.swap_remove(at)
            },
            None => Voice {
                camera,
                sender: None,
                next_heartbeat: now,
            },
        };
        self.voices = cameras.into_iter().map(voice).collect();
    }

    /// Hears any frame of the vehicle's system: a camera that speaks for itself keeps its id, and ours gives way.
    pub fn hear(&mut self, now: NodeTime, frame: &Frame<'_>) {
        let header = &frame.header;
        let place = COMPONENTS
            .iter()
            .position(|component| *component == header.component_id);
        let Some(place) = place.filter(|_| header.message_id == HEARTBEAT && frame.known) else {
            return;
        };
        if Fields(frame.payload).u32(0) == self.sign {
            return;
        }
        if let Some(other) = self.others.get_mut(place) {
            *other = Some(now);
        }
        for voice in &mut self.voices {
            voice
                .sender
                .take_if(|sender| sender.component_id == header.component_id);
        }
    }

    /// A command that is for the vehicle's system. True if it is for one of these cameras.
    pub fn ask(&mut self, now: NodeTime, frame: &Frame<'_>) -> bool {
        let (fields, asker) = (
            Fields(frame.payload),
            (frame.header.system_id, frame.header.component_id),
        );
        let (command, target) = (fields.u16(28), fields.u8(31));
        let parameters = (fields.f32(0), fields.f32(4));
        let mut is_ours = false;
        for voice in self.voices.iter().filter(|voice| voice.sender.is_some()) {
            let component = voice.sender.map(|sender| sender.component_id);
            // What is for all components is the autopilot's to answer, but for what only a camera can tell.
            let for_all = target == 0 && answers::is_about_cameras(command, parameters);
            if component != Some(target) && !for_all {
                continue;
            }
            is_ours |= component == Some(target);
            let answers = answers::to(command, parameters, asker, voice.camera.streams.len());
            if self.waiting.len() + answers.len() <= MOST_WAITING {
                let name = &voice.camera.name;
                self.waiting
                    .extend(answers.into_iter().map(|answer| (name.clone(), answer)));
            }
        }
        self.next_frame = self.next_frame.max(now);
        is_ours
    }

    /// When the next frame is due.
    #[must_use]
    pub fn due(&self) -> Option<NodeTime> {
        let first = self.listens_until.filter(|_| !self.voices.is_empty())?;
        let heartbeat = self.voices.iter().map(|voice| voice.next_heartbeat).min()?;
        let next = if self.waiting.is_empty() {
            heartbeat.max(self.next_frame)
        } else {
            self.next_frame
        };
        Some(next.max(first))
    }

    /// Sends what is due, one frame at a time.
    pub fn poll(&mut self, now: NodeTime, outbox: &mut Outbox) {
        if self.due().is_none_or(|due| now < due) {
            return;
        }
        self.next_frame = now.plus_seconds(APART_S);
        self.choose(now);
        let sign = self.sign;
        if let Some(voice) = self.voices.iter_mut().find(|voice| voice.next_heartbeat <= now) {
            voice.next_heartbeat = now.plus_seconds(HEARTBEAT_S);
            if let Some(sender) = &mut voice.sender {
                outbox.push_from(sender, &heartbeat(sign));
            }
            return;
        }
        while let Some((name, answer)) = self.waiting.pop_front() {
            // One that is not spoken for any more has nothing to say.
            let voice = self.voices.iter_mut().find(|voice| voice.camera.name == name);
            if let Some(Voice {
                camera,
                sender: Some(sender),
                ..
            }) = voice
            {
                answer.push(now, camera, sender, outbox);
                return;
            }
        }
    }

    /// Finds an id for each that has none.
    fn choose(&mut self, now: NodeTime) {
        let is_free = |at: usize| {
            let heard = self.others.get(at).copied().flatten();
            heard.is_none_or(|heard| now.seconds_since(heard) > HEARD_FOR_S)
        };
        let free: Vec<u8> = (0..)
            .zip(COMPONENTS)
            .filter(|(at, _)| is_free(*at))
            .map(|(_, id)| id)
            .collect();
        let mut taken: Vec<u8> = self
            .voices
            .iter()
            .filter_map(|voice| Some(voice.sender?.component_id))
            .collect();
        for voice in self.voices.iter_mut().filter(|voice| voice.sender.is_none()) {
            let Some(component_id) = free.iter().copied().find(|id| !taken.contains(id)) else {
                return;
            };
            taken.push(component_id);
            voice.sender = Some(MavHeader {
                system_id: u32::from(self.system_id),
                component_id,
                sequence: 0,
            });
        }
    }
}

fn heartbeat(sign: u32) -> HEARTBEAT_DATA {
    HEARTBEAT_DATA {
        custom_mode: sign,
        mavtype: MavType::MAV_TYPE_CAMERA,
        autopilot: MavAutopilot::MAV_AUTOPILOT_INVALID,
        base_mode: MavModeFlag::empty(),
        system_status: MavState::MAV_STATE_ACTIVE,
        mavlink_version: 3,
    }
}

#[cfg(test)]
mod tests;
