//! A route put on the vehicle by the mission protocol: counted, asked for item by item by the autopilot, acknowledged at the end.
//!
//! Must never do: start a flight. The route lies there until the mode is set to MISSION. Nobody here looks at whether it leads
//! anywhere safe; whoever uploads it has had it judged.
//!
//! The autopilot leads: after MISSION_COUNT it asks for what it wants, again and again by itself. From here only what it cannot
//! miss without noticing is repeated: the count, and the last item, on which its acknowledgement follows.
//!
//! PX4 goes on asking for the items of an upload that was broken off, and takes what it gets for those: so such an upload is
//! cancelled before the next one is announced, and nothing is answered that is asked for out of turn.

use super::VehicleCore;
use crate::route_message::RouteMessage;
use mavlink::dialects::common::{
    MISSION_ACK_DATA, MISSION_CLEAR_ALL_DATA, MISSION_COUNT_DATA, MISSION_ITEM_INT_DATA, MavCmd, MavFrame,
    MavMissionResult, MavMissionType,
};
use skein_domain::link::{LinkEvent, RoutePoint};
use skein_domain::{NodeTime, Refusal, RequestId};

/// Most points of a route.
pub const POINTS_MAX: usize = 400;
/// Fastest way between two points that is taken for meant, in metres per second.
const SPEED_MAX_M_S: f64 = 100.0;
/// An autopilot that is still busy with an upload that was broken off lets go of it after five seconds.
const BUSY_FOR_S: f64 = 6.0;
/// How often an upload is begun anew at most.
const RESTARTS_MAX: u8 = 3;
/// How long nothing may be heard in the middle of an upload, in seconds: PX4 gives up by then.
const SILENCE_MAX_S: f64 = 5.0;

/// `MAV_MISSION_RESULT` in words, as refusals carry it.
fn result_word(result: u8) -> String {
    match result {
        0 => "accepted",
        1 => "error",
        2 => "unsupported_frame",
        3 => "unsupported",
        4 => "no_space",
        5 => "invalid",
        6..=12 => return format!("invalid_parameter_{}", result - 5),
        13 => "invalid_sequence",
        14 => "denied",
        15 => "operation_cancelled",
        other => return format!("result_{other}"),
    }
    .to_owned()
}

/// One item: a point, or the speed on the way to the next one.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Item {
    Speed { speed_m_s: f64 },
    Point { index: u16, point: RoutePoint },
}

/// Where an upload stands.
#[derive(Debug)]
struct Upload {
    request: RequestId,
    items: Vec<Item>,
    first: NodeTime,
    /// When the autopilot last asked for something.
    heard: NodeTime,
    next: NodeTime,
    attempts: u8,
    /// The item that was last asked for.
    asked: Option<u16>,
    /// What the autopilot said against it, and until when words beside that are awaited.
    refused: Option<(String, NodeTime)>,
    /// How often it was begun anew, because the autopilot was in the middle of another one.
    restarts: u8,
}

/// The upload under way, and what lies on the vehicle.
#[derive(Debug, Default)]
pub struct RouteUpload {
    upload: Option<Upload>,
    /// Of each item of the last accepted route, which point it is.
    points: Vec<Option<u16>>,
    /// The item that was last reached: PX4 says so several times.
    reached: Option<u16>,
    /// The autopilot may be in the middle of an upload that was broken off.
    must_cancel: bool,
}

impl RouteUpload {
    /// When there is something to do next.
    pub fn due(&self) -> Option<NodeTime> {
        self.upload.as_ref().map(|upload| upload.next)
    }
}

impl VehicleCore {
    /// Puts a route on the vehicle in place of the one it has; an empty one takes that away.
    pub fn upload_route(&mut self, now: NodeTime, request: RequestId, route: &[RoutePoint]) {
        let refusal = self.refusal(now, false).or_else(|| wrong(route));
        if let Some(refusal) = refusal {
            let outcome = Err(refusal);
            self.offboard.events.push(LinkEvent::Result { request, outcome });
            return;
        }
        self.break_off_route(&Refusal::Superseded);
        self.route.upload = Some(Upload {
            request,
            items: items(route),
            first: now,
            heard: now,
            next: now,
            attempts: 0,
            asked: None,
            refused: None,
            restarts: 0,
        });
        self.poll_route(now);
    }

    /// Ends the upload under way for a reason.
    pub(super) fn break_off_route(&mut self, refusal: &Refusal) {
        self.end_route(Err(refusal.clone()));
    }

    /// Repeats what may have got lost, or gives up.
    pub(super) fn poll_route(&mut self, now: NodeTime) {
        let Some(upload) = self.route.upload.as_mut().filter(|upload| now >= upload.next) else {
            return;
        };
        if let Some((result, until)) = upload.refused.clone() {
            let busy = upload.asked.is_none() && now.seconds_since(upload.first) < BUSY_FOR_S && result == "error";
            if !busy {
                if now >= until {
                    let text = self.offboard.texts.between(upload.first, now);
                    self.end_route(Err(Refusal::Autopilot { result, text }));
                }
                return;
            }
        }
        let (silent_s, after_s) = (now.seconds_since(upload.heard), now.seconds_since(upload.first));
        let unheard = upload.asked.is_none() && upload.attempts >= self.settings.command_attempts.max(1);
        if silent_s >= SILENCE_MAX_S.max(self.settings.ack_timeout_s) || (unheard && upload.refused.is_none()) {
            let what = match upload.asked {
                None => "an answer to a route".to_owned(),
                Some(item) => format!("the end of an upload, {} of {} items", item + 1, upload.items.len()),
            };
            self.end_route(Err(Refusal::timed_out(what, after_s)));
            return;
        }
        upload.next = now.plus_seconds(self.settings.ack_timeout_s);
        let last = upload.items.len().checked_sub(1);
        match upload.asked {
            Some(item) if Some(usize::from(item)) == last => self.send_item(item),
            Some(_) => {}
            None => {
                upload.attempts = upload.attempts.saturating_add(1);
                self.announce_route();
            }
        }
    }

    fn announce_route(&mut self) {
        let (target_system, target_component) = self.target();
        if self.route.must_cancel {
            self.outbox.push(&MISSION_ACK_DATA {
                target_system,
                target_component,
                mavtype: MavMissionResult::MAV_MISSION_OPERATION_CANCELLED,
                mission_type: MavMissionType::MAV_MISSION_TYPE_MISSION,
                ..MISSION_ACK_DATA::default()
            });
        }
        let count = self.route.upload.as_ref().map_or(0, |upload| upload.items.len());
        if count == 0 {
            self.outbox.push(&MISSION_CLEAR_ALL_DATA {
                target_system,
                target_component,
                mission_type: MavMissionType::MAV_MISSION_TYPE_MISSION,
            });
            return;
        }
        self.outbox.push(&MISSION_COUNT_DATA {
            count: u16::try_from(count).unwrap_or(u16::MAX),
            target_system,
            target_component,
            mission_type: MavMissionType::MAV_MISSION_TYPE_MISSION,
            ..MISSION_COUNT_DATA::default()
        });
    }

    fn send_item(&mut self, number: u16) {
        let target = self.target();
        let item = self
            .route
            .upload
            .as_ref()
            .and_then(|upload| upload.items.get(usize::from(number)));
        if let Some(item) = item {
            let message = item_message(item, number, target);
            self.outbox.push(&message);
        }
    }

    /// A message of the mission protocol came.
    pub(super) fn on_route_message(&mut self, now: NodeTime, message: &RouteMessage) {
        let own = (self.settings.own_system_id, self.settings.own_component_id);
        let ours = |target: (u8, u8)| (target.0 == 0 || target.0 == own.0) && (target.1 == 0 || target.1 == own.1);
        match *message {
            RouteMessage::Request { item, target } if ours(target) => self.on_item_asked(now, item),
            RouteMessage::Acknowledgement { result, target } if ours(target) => self.on_route_answer(now, result),
            RouteMessage::Reached { item } => {
                let again = self.route.reached.replace(item) == Some(item);
                if let Some(Some(index)) = self.route.points.get(usize::from(item)).copied().filter(|_| !again) {
                    self.offboard.events.push(LinkEvent::RoutePointReached { index });
                }
            }
            _ => {}
        }
    }

    fn on_item_asked(&mut self, now: NodeTime, item: u16) {
        let Some(upload) = &mut self.route.upload else { return };
        let next = upload.asked.map_or(0, |asked| asked.saturating_add(1));
        if item > next || usize::from(item) >= upload.items.len() {
            self.restart_route(now);
            return;
        }
        if item == 0 {
            self.route.must_cancel = false;
        }
        upload.heard = now;
        upload.asked = Some(item);
        upload.refused = None;
        upload.next = now.plus_seconds(self.settings.ack_timeout_s);
        self.send_item(item);
    }

    /// The autopilot is in the middle of another upload than this: from the beginning.
    fn restart_route(&mut self, now: NodeTime) {
        let Some(upload) = &mut self.route.upload else { return };
        self.route.must_cancel = true;
        if upload.restarts >= RESTARTS_MAX {
            let after_s = now.seconds_since(upload.first);
            let what = "the autopilot to ask for this route and no other".to_owned();
            self.end_route(Err(Refusal::timed_out(what, after_s)));
            return;
        }
        upload.restarts += 1;
        (upload.asked, upload.refused, upload.heard) = (None, None, now);
        upload.next = now.plus_seconds(self.settings.ack_timeout_s);
        self.announce_route();
    }

    fn on_route_answer(&mut self, now: NodeTime, result: u8) {
        const ACCEPTED: u8 = 0;
        let Some(upload) = &mut self.route.upload else { return };
        if result == ACCEPTED {
            let last = upload.items.len().checked_sub(1);
            let asked = upload.asked.map(usize::from);
            if asked.is_some() && asked != last {
                // It counted fewer: those of an upload that was broken off.
                self.restart_route(now);
            } else if asked == last {
                let point = |item: &Item| match item {
                    Item::Point { index, .. } => Some(*index),
                    Item::Speed { .. } => None,
                };
                self.route.points = upload.items.iter().map(point).collect();
                self.route.reached = None;
                self.end_route(Ok(()));
            }
        } else if upload.refused.is_none() {
            self.route.must_cancel |= upload.asked.is_none();
            let until = now.plus_seconds(self.settings.refusal_text_s);
            upload.refused = Some((result_word(result), until));
            upload.next = until;
        }
    }

    fn end_route(&mut self, outcome: Result<(), Refusal>) {
        if let Some(Upload { request, .. }) = self.route.upload.take() {
            self.route.must_cancel |= outcome.is_err();
            self.offboard.events.push(LinkEvent::Result { request, outcome });
        }
    }
}

/// Why a route cannot be meant.
fn wrong(route: &[RoutePoint]) -> Option<Refusal> {
    let detail = if route.len() > POINTS_MAX {
        format!("a route of {} points; up to {POINTS_MAX} can be uploaded", route.len())
    } else {
        let bad = |point: &RoutePoint| {
            let speed_fits = |speed: f64| speed > 0.0 && speed <= SPEED_MAX_M_S;
            !point.place.is_valid() || !point.speed_m_s.is_none_or(speed_fits)
        };
        let index = route.iter().position(bad)?;
        format!(
            "point {index} of the route has no valid place, or a speed that is not over 0 and up to {SPEED_MAX_M_S} m/s"
        )
    };
    Some(Refusal::InvalidValue { detail })
}

/// The items of a route: before a point its speed, where that is another one than before.
fn items(route: &[RoutePoint]) -> Vec<Item> {
    let mut items = Vec::with_capacity(route.len() * 2);
    let mut speed = None;
    for (index, point) in route.iter().enumerate() {
        if let Some(speed_m_s) = point.speed_m_s.filter(|asked| speed != Some(*asked)) {
            speed = Some(speed_m_s);
            items.push(Item::Speed { speed_m_s });
        }
        items.push(Item::Point {
            index: u16::try_from(index).unwrap_or(u16::MAX),
            point: *point,
        });
    }
    items
}

fn item_message(item: &Item, number: u16, target: (u8, u8)) -> MISSION_ITEM_INT_DATA {
    let message = MISSION_ITEM_INT_DATA {
        seq: number,
        target_system: target.0,
        target_component: target.1,
        current: u8::from(number == 0),
        autocontinue: 1,
        mission_type: MavMissionType::MAV_MISSION_TYPE_MISSION,
        ..MISSION_ITEM_INT_DATA::default()
    };
    match *item {
        Item::Speed { speed_m_s } => {
            const GROUND_SPEED: f32 = 1.0;
            const THRUST_AS_IT_IS: f32 = -1.0;
            MISSION_ITEM_INT_DATA {
                command: MavCmd::MAV_CMD_DO_CHANGE_SPEED,
                frame: MavFrame::MAV_FRAME_MISSION,
                param1: GROUND_SPEED,
                param2: speed_m_s as f32,
                param3: THRUST_AS_IT_IS,
                ..message
            }
        }
        Item::Point { point, .. } => MISSION_ITEM_INT_DATA {
            command: MavCmd::MAV_CMD_NAV_WAYPOINT,
            frame: MavFrame::MAV_FRAME_GLOBAL,
            // The nose where the autopilot's own setting wants it.
            param4: f32::NAN,
            x: (point.place.latitude_deg * 1e7).round() as i32,
            y: (point.place.longitude_deg * 1e7).round() as i32,
            z: point.place.altitude_amsl_m as f32,
            ..message
        },
    }
}

#[cfg(test)]
mod tests;
