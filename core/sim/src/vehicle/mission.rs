//! A mission: taken in by the mission protocol as PX4 takes it in, kept, and flown in AUTO.MISSION.
//!
//! Known are waypoints and changes of speed; every other item is refused as unsupported. A mission cannot be what a vehicle takes
//! off with: it flies one that is in the air. After the last waypoint it holds there, still in its mode.

use super::SimVehicle;
use super::channel::{Channel, LinkKind, Outbox};
use super::commander::Notice;
use crate::wire::Sender;
use mavlink::dialects::common::{
    MISSION_ACK_DATA, MISSION_COUNT_DATA, MISSION_CURRENT_DATA, MISSION_ITEM_INT_DATA, MISSION_ITEM_REACHED_DATA,
    MISSION_REQUEST_INT_DATA, MavCmd, MavFrame, MavMessage, MavMissionResult, MavMissionType, MavSeverity,
    MissionState,
};
use nalgebra::Vector3;
use skein_domain::{FlightMode, Geodetic};
use std::sync::Arc;

use MavMissionResult::{
    MAV_MISSION_ACCEPTED as ACCEPTED, MAV_MISSION_ERROR as ERROR, MAV_MISSION_NO_SPACE as NO_SPACE,
    MAV_MISSION_UNSUPPORTED as UNSUPPORTED, MAV_MISSION_UNSUPPORTED_FRAME as UNSUPPORTED_FRAME,
};

/// Items it has room for.
const ITEMS_MAX: u16 = 500;
/// An item that does not come is asked for again after, and the transfer is given up after, in seconds.
const ASK_AGAIN_S: f64 = 0.25;
const GIVE_UP_S: f64 = 5.0;
/// How often it is said again that an item was reached.
const TOLD_AGAIN: u8 = 10;
/// A waypoint is reached within this height, in metres.
const HEIGHT_REACHED_M: f64 = 0.8;

/// A transfer under way.
#[derive(Debug, Clone)]
struct Transfer {
    link: LinkKind,
    partner: Sender,
    count: u16,
    items: Vec<MISSION_ITEM_INT_DATA>,
    heard_s: f64,
    ask_s: f64,
}

/// What is kept, and how far it has been flown.
#[derive(Debug, Clone, Default)]
pub(super) struct Mission {
    items: Vec<MISSION_ITEM_INT_DATA>,
    /// The places among them, for the truth.
    places: Arc<Vec<Geodetic>>,
    transfer: Option<Transfer>,
    current: usize,
    /// The item that is being flown to.
    flying: Option<usize>,
    speed_m_s: Option<f64>,
    /// Who spoke of missions last.
    partner: Option<Sender>,
    /// The item that was reached last, when that is said again, and how often.
    told: Option<(u16, f64, u8)>,
}

impl Mission {
    /// Whether there is anything to fly.
    pub(super) fn is_there(&self) -> bool {
        !self.items.is_empty()
    }

    /// The autopilot starts anew: what was kept is kept, from its beginning.
    pub(super) fn restart(&mut self) {
        *self = Self {
            items: std::mem::take(&mut self.items),
            places: self.places.clone(),
            ..Self::default()
        };
    }

    /// The places that are kept, with the heights as they came: over the sea or over the launch place.
    pub(super) fn places(&self) -> &Arc<Vec<Geodetic>> {
        &self.places
    }

    fn replace(&mut self, items: Vec<MISSION_ITEM_INT_DATA>) {
        let is_place = |item: &&MISSION_ITEM_INT_DATA| item.command == MavCmd::MAV_CMD_NAV_WAYPOINT;
        *self = Self {
            places: Arc::new(items.iter().filter(is_place).map(place_in).collect()),
            items,
            partner: self.partner,
            ..Self::default()
        };
    }
}

impl SimVehicle {
    /// Takes a message of the mission protocol.
    pub(super) fn take_mission_message(&mut self, link: LinkKind, from: Sender, m: &MavMessage, out: &mut Outbox) {
        match m {
            MavMessage::MISSION_REQUEST_LIST(m) if self.is_for_me(m.target_system, m.target_component) => {
                let of_route = m.mission_type == MavMissionType::MAV_MISSION_TYPE_MISSION;
                let answer = MISSION_COUNT_DATA {
                    count: if of_route { self.mission.items.len() as u16 } else { 0 },
                    target_system: from.system_id,
                    target_component: from.component_id,
                    mission_type: m.mission_type,
                    ..MISSION_COUNT_DATA::default()
                };
                self.on_channel(link, |_, channel| channel.send(out, &answer));
            }
            MavMessage::MISSION_REQUEST_INT(m) if self.is_for_me(m.target_system, m.target_component) => {
                let item = self
                    .mission
                    .items
                    .get(usize::from(m.seq))
                    .map(|item| MISSION_ITEM_INT_DATA {
                        target_system: from.system_id,
                        target_component: from.component_id,
                        ..item.clone()
                    });
                if let Some(item) = item {
                    self.on_channel(link, |_, channel| channel.send(out, &item));
                }
            }
            MavMessage::MISSION_COUNT(m) if self.is_for_me(m.target_system, m.target_component) => {
                self.take_count(link, from, m, out);
            }
            MavMessage::MISSION_ACK(m) if self.is_for_me(m.target_system, m.target_component) => {
                if self.mission.partner != Some(from) {
                    self.say_mission("REJ. WP CMD: partner id mismatch");
                } else if m.mavtype == MavMissionResult::MAV_MISSION_OPERATION_CANCELLED {
                    self.mission.transfer = None;
                }
            }
            MavMessage::MISSION_ITEM_INT(m) if self.is_for_me(m.target_system, m.target_component) => {
                self.take_item(link, from, m, out);
            }
            MavMessage::MISSION_CLEAR_ALL(m) if self.is_for_me(m.target_system, m.target_component) => {
                let all = m.mission_type == MavMissionType::MAV_MISSION_TYPE_ALL;
                if all || m.mission_type == MavMissionType::MAV_MISSION_TYPE_MISSION {
                    self.mission.replace(Vec::new());
                }
                self.answer_mission(link, from, m.mission_type, ACCEPTED, out);
            }
            _ => {}
        }
    }

    fn take_count(&mut self, link: LinkKind, from: Sender, m: &MISSION_COUNT_DATA, out: &mut Outbox) {
        let (now_s, route) = (self.time_s, MavMissionType::MAV_MISSION_TYPE_MISSION);
        if m.mission_type != route {
            // An empty plan is no plan; this vehicle keeps no fences and no rally points.
            let answer = if m.count == 0 { ACCEPTED } else { UNSUPPORTED };
            self.answer_mission(link, from, m.mission_type, answer, out);
            return;
        }
        if let Some(transfer) = &mut self.mission.transfer {
            let again = transfer.partner == from && transfer.items.is_empty();
            transfer.heard_s = now_s;
            if !again {
                if transfer.partner == from {
                    self.say_mission("WPM: REJ. CMD: Busy");
                }
                self.answer_mission(link, from, route, ERROR, out);
                return;
            }
            // It keeps to the count that it was told first.
            transfer.ask_s = now_s;
            return;
        }
        self.mission.partner = Some(from);
        if m.count > ITEMS_MAX {
            self.answer_mission(link, from, route, NO_SPACE, out);
        } else if m.count == 0 {
            self.mission.replace(Vec::new());
            self.answer_mission(link, from, route, ACCEPTED, out);
        } else {
            self.mission.transfer = Some(Transfer {
                link,
                partner: from,
                count: m.count,
                items: Vec::new(),
                heard_s: now_s,
                ask_s: now_s,
            });
        }
    }

    fn take_item(&mut self, link: LinkKind, from: Sender, m: &MISSION_ITEM_INT_DATA, out: &mut Outbox) {
        let Some(transfer) = &mut self.mission.transfer else {
            // The last one once more: its acknowledgement got lost.
            let last = usize::from(m.seq) + 1 == self.mission.items.len();
            if !last {
                self.say_mission("IGN MISSION_ITEM: No transfer");
            }
            let answer = if last { ACCEPTED } else { ERROR };
            self.answer_mission(link, from, m.mission_type, answer, out);
            return;
        };
        if transfer.partner != from {
            return;
        }
        transfer.heard_s = self.time_s;
        if usize::from(m.seq) != transfer.items.len() {
            return;
        }
        if let Some(problem) = problem(m) {
            self.mission.transfer = None;
            self.say_mission("IGN MISSION_ITEM: Invalid item");
            self.answer_mission(link, from, m.mission_type, problem, out);
            return;
        }
        transfer.items.push(m.clone());
        transfer.ask_s = self.time_s;
        if transfer.items.len() < usize::from(transfer.count) {
            return;
        }
        let items = std::mem::take(&mut transfer.items);
        self.mission.replace(items);
        self.answer_mission(link, from, m.mission_type, ACCEPTED, out);
    }

    fn say_mission(&mut self, text: &str) {
        self.notices.push(Notice {
            severity: MavSeverity::MAV_SEVERITY_CRITICAL,
            text: text.to_owned(),
        });
    }

    fn answer_mission(
        &mut self,
        link: LinkKind,
        to: Sender,
        mission_type: MavMissionType,
        result: MavMissionResult,
        out: &mut Outbox,
    ) {
        let answer = MISSION_ACK_DATA {
            target_system: to.system_id,
            target_component: to.component_id,
            mavtype: result,
            mission_type,
            ..MISSION_ACK_DATA::default()
        };
        self.on_channel(link, |_, channel| channel.send(out, &answer));
    }

    /// Asks for the next item of a transfer, and flies what is there.
    pub(super) fn step_mission(&mut self, out: &mut Outbox) {
        self.ask_for_item(out);
        if let Some((seq, _, times)) = self.mission.told.filter(|(_, at_s, _)| self.time_s >= *at_s) {
            self.tell_reached(seq, times, out);
        }
        self.commander.has_mission = self.mission.is_there();
        if self.commander.mode() != FlightMode::Mission || self.lift.is_landed() {
            self.mission.flying = None;
            return;
        }
        self.fly_mission(out);
    }

    fn ask_for_item(&mut self, out: &mut Outbox) {
        let now_s = self.time_s;
        let Some(transfer) = self.mission.transfer.as_mut().filter(|t| now_s >= t.ask_s) else {
            return;
        };
        if now_s - transfer.heard_s > GIVE_UP_S {
            self.mission.transfer = None;
            self.say_mission("Operation timeout");
            return;
        }
        transfer.ask_s = now_s + ASK_AGAIN_S;
        let (link, partner) = (transfer.link, transfer.partner);
        let request = MISSION_REQUEST_INT_DATA {
            seq: transfer.items.len() as u16,
            target_system: partner.system_id,
            target_component: partner.component_id,
            mission_type: MavMissionType::MAV_MISSION_TYPE_MISSION,
        };
        self.on_channel(link, |_, channel| channel.send(out, &request));
    }

    fn fly_mission(&mut self, out: &mut Outbox) {
        let (number, here) = (self.mission.current, self.estimator.now.position);
        let Some(item) = self.mission.items.get(number).cloned() else {
            return;
        };
        if item.command == MavCmd::MAV_CMD_DO_CHANGE_SPEED {
            self.mission.speed_m_s = Some(f64::from(item.param2)).filter(|speed| *speed > 0.0);
            self.reached(number, out);
            return;
        }
        let goal = self.place_of(&item);
        if self.mission.flying != Some(number) {
            self.mission.flying = Some(number);
            let way = goal.xy() - here.xy();
            let yaw_rad = if item.param4.is_finite() {
                f64::from(item.param4).to_radians()
            } else if way.norm() > 1.0 {
                way.y.atan2(way.x)
            } else {
                f64::NAN
            };
            let speed_m_s = self.mission.speed_m_s.unwrap_or(self.limits.guidance.cruise_m_s);
            self.guidance.set_hold(goal, yaw_rad, speed_m_s);
        }
        let asked_m = f64::from(item.param2);
        let radius_m = if asked_m > 0.0 {
            asked_m
        } else {
            self.parameters.number("NAV_ACC_RAD")
        };
        let there = (goal.xy() - here.xy()).norm() < radius_m && (goal.z - here.z).abs() < HEIGHT_REACHED_M;
        if there {
            self.reached(number, out);
        }
    }

    /// Where a waypoint lies in the vehicle's own frame.
    fn place_of(&self, item: &MISSION_ITEM_INT_DATA) -> Vector3<f64> {
        let place = place_in(item);
        let mut own = self.own_frame().position(&place).vector();
        if is_relative(item.frame) {
            own.z = self.home_or_here().z - f64::from(item.z);
        }
        own
    }

    fn reached(&mut self, number: usize, out: &mut Outbox) {
        self.mission.current = number + 1;
        self.tell_reached(number as u16, 0, out);
    }

    /// Says that an item was reached: at once, and ten times more, a second apart.
    fn tell_reached(&mut self, seq: u16, times: u8, out: &mut Outbox) {
        self.mission.told = (times < TOLD_AGAIN).then_some((seq, self.time_s + 1.0, times + 1));
        let message = MISSION_ITEM_REACHED_DATA { seq };
        let mut channels = std::mem::take(&mut self.channels);
        channels
            .iter_mut()
            .for_each(|channel: &mut Channel| channel.send(out, &message));
        self.channels = channels;
    }

    pub(super) fn mission_current(&self) -> MISSION_CURRENT_DATA {
        let (current, total) = (self.mission.current, self.mission.items.len());
        let mission_state = if total == 0 {
            MissionState::MISSION_STATE_NO_MISSION
        } else if current >= total {
            MissionState::MISSION_STATE_COMPLETE
        } else if self.commander.mode() == FlightMode::Mission {
            MissionState::MISSION_STATE_ACTIVE
        } else if current == 0 {
            MissionState::MISSION_STATE_NOT_STARTED
        } else {
            MissionState::MISSION_STATE_PAUSED
        };
        MISSION_CURRENT_DATA {
            seq: current.min(total.saturating_sub(1)) as u16,
            total: total as u16,
            mission_state,
            ..MISSION_CURRENT_DATA::default()
        }
    }
}

// MAV_FRAME numbers; the protocol has two of each for historical reasons.
fn is_above_sea(frame: MavFrame) -> bool {
    matches!(frame as u8, 0 | 5)
}

fn is_relative(frame: MavFrame) -> bool {
    matches!(frame as u8, 3 | 6)
}

/// Why an item is refused.
fn problem(item: &MISSION_ITEM_INT_DATA) -> Option<MavMissionResult> {
    match item.command {
        MavCmd::MAV_CMD_DO_CHANGE_SPEED => None,
        MavCmd::MAV_CMD_NAV_WAYPOINT => {
            (!is_above_sea(item.frame) && !is_relative(item.frame)).then_some(UNSUPPORTED_FRAME)
        }
        _ => Some(UNSUPPORTED),
    }
}

/// The place of an item as it stands there.
fn place_in(item: &MISSION_ITEM_INT_DATA) -> Geodetic {
    Geodetic {
        latitude_deg: f64::from(item.x) * 1e-7,
        longitude_deg: f64::from(item.y) * 1e-7,
        altitude_amsl_m: f64::from(item.z),
    }
}
