//! What the vehicle carries, on its links: which component answers what, and when each speaks. How the payloads behave is in
//! [`skein_sim_payloads`].
//!
//! Must never do: answer for a component that is not there.

mod camera;
mod gimbal;

pub(super) use gimbal::{GIMBAL_CONFIGURE, GIMBAL_PITCHYAW};

use super::SimVehicle;
use super::channel::{AUTOPILOT_COMPONENT, Channel, LinkKind, Outbox, Stream};
use super::commands::{REQUEST_MESSAGE, SET_MESSAGE_INTERVAL};
use crate::truth::{CameraTruth, GimbalTruth, RadioTruth};
use crate::wire::{CommandRequest, Sender};
use mavlink::dialects::common::{
    HEARTBEAT_DATA, MavAutopilot, MavModeFlag, MavResult, MavState, MavType, RADIO_STATUS_DATA,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use skein_domain::{Geodetic, PositionNed};
use skein_sim_payloads::camera::Camera;
use skein_sim_payloads::manager::{Carrier, Gimbal};
use skein_sim_payloads::radio::{Radio, sik_raw};
use skein_sim_payloads::{
    CAMERA_COMPONENT, GIMBAL_COMPONENT, GimbalOutput, GimbalSettings, PayloadPlan, RADIO_COMPONENT,
};

const HEARTBEAT: u32 = 0;
/// A signal does not change faster than is worth computing this often, in seconds.
const RADIO_PERIOD_S: f64 = 0.1;
/// Distinguishes the payloads' random numbers from the vehicle's.
const RANDOM_STREAM: u64 = 1 << 32;

/// What one vehicle carries.
#[derive(Debug, Clone)]
pub(super) struct Payloads {
    pub(super) gimbal: Option<Gimbal>,
    pub(super) camera: Option<Camera>,
    radio: Option<Radio>,
    /// Time since the radio was last looked at, in seconds.
    radio_waits_s: f64,
    rng: ChaCha8Rng,
}

impl Payloads {
    /// As the plan has it, for a vehicle that stands at `at`.
    pub(super) fn new(plan: &PayloadPlan, seed: u64, number: u64, at: &PositionNed) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(RANDOM_STREAM + number);
        Self {
            gimbal: plan.gimbal.map(Gimbal::new),
            camera: plan.camera.map(Camera::new),
            radio: plan.radio.map(|settings| Radio::new(settings, at, &mut rng)),
            radio_waits_s: 0.0,
            rng,
        }
    }

    /// Which component a report comes from, if not the autopilot itself.
    fn component_of(&self, message_id: u32) -> Option<u8> {
        match message_id {
            283 | 285 if self.has(GIMBAL_COMPONENT) => Some(GIMBAL_COMPONENT),
            259..=263 | 269..=271 if self.camera.is_some() => Some(CAMERA_COMPONENT),
            _ => None,
        }
    }

    /// Whether there is such a component.
    pub(super) fn has(&self, component: u8) -> bool {
        let settings = self.gimbal.as_ref().map(|gimbal| &gimbal.head.settings);
        component == GIMBAL_COMPONENT && has_device(settings) || component == CAMERA_COMPONENT && self.camera.is_some()
    }
}

/// Whether there is a gimbal that speaks for itself.
fn has_device(gimbal: Option<&GimbalSettings>) -> bool {
    gimbal.is_some_and(|settings| settings.output == GimbalOutput::Device)
}

/// What payloads send by themselves, and what can be asked to be sent at a rate: component, message, rate in hertz.
pub(super) fn streams(plan: &PayloadPlan) -> Vec<(u8, u32, f64)> {
    let mut streams = Vec::new();
    if let Some(gimbal) = &plan.gimbal {
        streams.extend([(AUTOPILOT_COMPONENT, 280, 0.0), (AUTOPILOT_COMPONENT, 281, 0.5)]);
        if gimbal.output != GimbalOutput::Device {
            streams.extend([(AUTOPILOT_COMPONENT, 265, 10.0), (AUTOPILOT_COMPONENT, 285, 5.0)]);
        }
    }
    if has_device(plan.gimbal.as_ref()) {
        streams.extend([(HEARTBEAT, 1.0), (285, 10.0), (283, 0.0)].map(|(id, rate)| (GIMBAL_COMPONENT, id, rate)));
    }
    if plan.camera.is_some() {
        streams.push((CAMERA_COMPONENT, HEARTBEAT, 1.0));
        streams.extend([259, 260, 261, 262, 269, 270, 271].map(|id| (CAMERA_COMPONENT, id, 0.0)));
    }
    if plan.radio.is_some() {
        streams.push((RADIO_COMPONENT, 109, 1.0));
    }
    streams
}

impl SimVehicle {
    /// Lets `dt_s` pass for what it carries.
    pub(super) fn step_payloads(&mut self, dt_s: f64) {
        // Taken out while it asks the vehicle where a place is.
        if let Some(mut gimbal) = self.payloads.gimbal.take() {
            let here = self.estimator.now.position;
            let towards = |place: &Geodetic| self.own_frame().position(place).vector() - here;
            gimbal.step(&self.carrier(), towards, dt_s);
            self.payloads.gimbal = Some(gimbal);
        }
        if let Some(camera) = &mut self.payloads.camera {
            camera.step(self.time_s, dt_s);
        }
        self.payloads.radio_waits_s += dt_s;
        if self.payloads.radio.is_some() && self.payloads.radio_waits_s >= RADIO_PERIOD_S {
            let at = self.true_position();
            let Payloads {
                radio,
                radio_waits_s,
                rng,
                ..
            } = &mut self.payloads;
            let waited_s = std::mem::take(radio_waits_s);
            if let Some(radio) = radio {
                radio.step(&at, waited_s, rng);
            }
        }
    }

    pub(super) fn carrier(&self) -> Carrier {
        Carrier {
            yaw_rad: self.body.yaw_rad,
            yaw_rate_rad_s: self.body.yaw_rate_rad_s,
        }
    }

    /// Share of datagrams that its radio really loses now, 0..=1.
    #[must_use]
    pub fn radio_loss(&self) -> f64 {
        let lossy = self
            .payloads
            .radio
            .as_ref()
            .filter(|radio| radio.settings.loses_datagrams);
        lossy.map_or(0.0, |radio| radio.loss)
    }

    /// Tells every link of pictures that were taken.
    pub(super) fn report_pictures(&mut self, channels: &mut [Channel], out: &mut Outbox) {
        let pictures = self.payloads.camera.as_mut().map(Camera::take_pictures);
        for picture in pictures.unwrap_or_default() {
            let message = self.image_captured(&picture);
            for channel in channels.iter_mut() {
                channel.send_as(CAMERA_COMPONENT, out, &message);
            }
        }
    }

    /// Sends one message of one component; false if it has none such. `index` says which, where there may be several.
    pub(super) fn send_of(
        &self,
        channel: &mut Channel,
        Stream { component, message_id }: Stream,
        index: u8,
        out: &mut Outbox,
    ) -> bool {
        match (component, message_id) {
            (GIMBAL_COMPONENT | CAMERA_COMPONENT, HEARTBEAT) if self.payloads.has(component) => {
                channel.send_as(component, out, &part_heartbeat(component));
                true
            }
            (AUTOPILOT_COMPONENT, 265 | 280 | 281 | 285) | (GIMBAL_COMPONENT, _) => {
                self.send_gimbal_message(channel, component, message_id, out)
            }
            (CAMERA_COMPONENT, _) => self.send_camera_message(channel, message_id, index, out),
            (RADIO_COMPONENT, 109) => self.send_radio_status(channel, out),
            (AUTOPILOT_COMPONENT, _) => self.send_message(channel, message_id, out),
            _ => false,
        }
    }

    fn send_radio_status(&self, channel: &mut Channel, out: &mut Outbox) -> bool {
        let Some(radio) = &self.payloads.radio else {
            return false;
        };
        // The radio at this end of the link reports itself first; the vehicle's is the remote one.
        let status = RADIO_STATUS_DATA {
            rxerrors: radio.errors(),
            fixed: 0,
            rssi: sik_raw(radio.ground_signal_dbm),
            remrssi: sik_raw(radio.signal_dbm),
            txbuf: 100,
            noise: sik_raw(radio.settings.ground_noise_dbm),
            remnoise: sik_raw(radio.settings.noise_dbm),
        };
        channel.send_as_radio(out, &status);
        true
    }

    /// Carries out a command that is a payload's; gives the component that answers, and its answer. `None`: it is the autopilot's,
    /// if it is meant for that at all.
    pub(super) fn run_for_payload(
        &mut self,
        link: LinkKind,
        sender: Sender,
        request: &CommandRequest,
        out: &mut Outbox,
    ) -> Option<(u8, MavResult)> {
        let asked = request.param[0] as u32;
        let about_message = matches!(request.command, SET_MESSAGE_INTERVAL | REQUEST_MESSAGE);
        let component = match request.target_component {
            0 if about_message => self.payloads.component_of(asked),
            0 if self.payloads.camera.is_some() && camera::is_camera_command(request.command) => Some(CAMERA_COMPONENT),
            component => Some(component).filter(|component| self.payloads.has(*component)),
        };
        match component {
            Some(component) if about_message => Some((component, self.about_message(link, component, request, out))),
            Some(CAMERA_COMPONENT) => Some((CAMERA_COMPONENT, self.run_camera_command(link, request, out))),
            // A device obeys its manager only.
            Some(component) => Some((component, MavResult::MAV_RESULT_UNSUPPORTED)),
            None => {
                let by = (sender.system_id, sender.component_id);
                let answer = self.run_manager_command(by, request)?;
                Some((AUTOPILOT_COMPONENT, answer))
            }
        }
    }

    /// SET_MESSAGE_INTERVAL and REQUEST_MESSAGE for a payload's component.
    fn about_message(&mut self, link: LinkKind, component: u8, c: &CommandRequest, out: &mut Outbox) -> MavResult {
        let stream = Stream {
            component,
            message_id: c.param[0] as u32,
        };
        let mut done = false;
        if c.command == SET_MESSAGE_INTERVAL {
            let (interval_us, now_us) = (f64::from(c.param[1]), self.time_us());
            self.on_channel(link, |_, channel| {
                done = channel.set_interval(stream, interval_us, now_us)
            });
        } else {
            let index = c.param[1] as u8;
            self.on_channel(link, |vehicle, channel| {
                done = vehicle.send_of(channel, stream, index, out)
            });
        }
        if done {
            MavResult::MAV_RESULT_ACCEPTED
        } else {
            MavResult::MAV_RESULT_DENIED
        }
    }

    /// Where its gimbal really points.
    pub(super) fn gimbal_truth(&self) -> Option<GimbalTruth> {
        let gimbal = self.payloads.gimbal.as_ref()?;
        Some(GimbalTruth {
            roll_rad: 0.0,
            pitch_rad: gimbal.head.pitch.angle_rad,
            yaw_vehicle_rad: gimbal.head.yaw.angle_rad,
            yaw_north_rad: gimbal.yaw_north_rad(&self.carrier()),
            owner: gimbal.owner,
        })
    }

    /// What its camera really does.
    pub(super) fn camera_truth(&self) -> Option<CameraTruth> {
        let camera = self.payloads.camera.as_ref()?;
        Some(CameraTruth {
            pictures: camera.pictures as u32,
            recording: camera.recording_s(self.time_s).is_some(),
            zoom_factor: camera.zoom_factor(),
            field_of_view_rad: camera.field_of_view_rad(),
        })
    }

    /// How its radio is really heard.
    pub(super) fn radio_truth(&self) -> Option<RadioTruth> {
        let radio = self.payloads.radio.as_ref()?;
        Some(RadioTruth {
            signal_dbm: radio.signal_dbm,
            loss: radio.loss,
            distance_m: self.true_position().distance_m(&radio.settings.ground_station),
        })
    }
}

fn part_heartbeat(component: u8) -> HEARTBEAT_DATA {
    HEARTBEAT_DATA {
        custom_mode: 0,
        mavtype: if component == CAMERA_COMPONENT {
            MavType::MAV_TYPE_CAMERA
        } else {
            MavType::MAV_TYPE_GIMBAL
        },
        autopilot: MavAutopilot::MAV_AUTOPILOT_INVALID,
        base_mode: MavModeFlag::empty(),
        system_status: MavState::MAV_STATE_ACTIVE,
        mavlink_version: 3,
    }
}
