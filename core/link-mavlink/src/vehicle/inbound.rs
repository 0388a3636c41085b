//! What each message of the autopilot means for its link.

use super::boot::Stamp;
use super::clock_sync::ClockSync;
use super::{VehicleCore, rates, telemetry};
use crate::decode::{Heartbeat, Inbound};
use mavlink::dialects::common::{
    AUTOPILOT_VERSION_DATA, GLOBAL_POSITION_INT_DATA, GPS_GLOBAL_ORIGIN_DATA, TIMESYNC_DATA,
};
use skein_domain::link::LinkEvent;
use skein_domain::{FlightMode, NodeTime, Refusal};
use skein_px4::acknowledgement::Acknowledgement;
use skein_px4::local_origin::OriginChange;
use skein_px4::modes::Px4Mode;
use skein_px4::offboard::OffboardControl;
use skein_px4::status_text::StatusText;

impl VehicleCore {
    pub(super) fn on_message(&mut self, now: NodeTime, message: Inbound) {
        match message {
            Inbound::LocalPosition(local) => {
                if self.is_of_this_boot(now, local.time_boot_ms) {
                    self.estimate.on_local(now, &local, &mut self.origin);
                }
            }
            Inbound::Attitude(attitude) => {
                if self.is_of_this_boot(now, attitude.time_boot_ms) {
                    self.estimate.on_attitude(now, &attitude);
                }
            }
            Inbound::GlobalPosition(global) => self.on_global_position(now, &global),
            Inbound::Heartbeat(heartbeat) => self.on_heartbeat(now, heartbeat),
            Inbound::ExtendedState(state) => {
                if self.estimate.on_extended_state(&state) {
                    self.control(now, OffboardControl::poll_commands);
                }
            }
            Inbound::SystemStatus(status) => self.estimate.on_system_status(now, &status),
            Inbound::Battery(battery) => self.estimate.on_battery(now, &battery),
            Inbound::Gnss(gnss) => self.estimate.on_gnss(now, &gnss),
            Inbound::SecondGnss(gnss) => self.estimate.on_second_gnss(now, &gnss),
            Inbound::Estimator(status) => self.estimate.on_estimator(now, &status),
            Inbound::Wind(wind) => self.estimate.on_wind(now, &wind),
            Inbound::Home(home) => {
                self.rates.on_copy(rates::HOME);
                self.estimate.on_home(&home);
            }
            Inbound::GlobalOrigin(origin) => self.on_global_origin(now, &origin),
            Inbound::Acknowledgement(ack) => self.on_acknowledgement(now, &ack),
            Inbound::TimeSync(message) => self.on_time_sync(now, &message),
            Inbound::StatusText(message) => {
                let text = self.offboard.texts.on_message(now, &message);
                self.on_text(text);
            }
            Inbound::ParameterValue(value) => {
                self.parameters.on_value(now, &value);
                self.send_parameters(now);
            }
            Inbound::ParameterError(error) => {
                self.parameters.on_error(&error);
                self.send_parameters(now);
            }
            Inbound::AutopilotVersion(version) => self.on_version(&version),
            Inbound::Route(message) => self.on_route_message(now, &message),
        }
    }

    fn on_global_position(&mut self, now: NodeTime, message: &GLOBAL_POSITION_INT_DATA) {
        if self.is_of_this_boot(now, message.time_boot_ms) {
            let change = self.estimate.on_global(now, message, &mut self.origin);
            self.on_origin_change(now, change);
        }
    }

    fn on_global_origin(&mut self, now: NodeTime, message: &GPS_GLOBAL_ORIGIN_DATA) {
        self.rates.on_copy(rates::GLOBAL_ORIGIN);
        let place = telemetry::place(message.latitude, message.longitude, message.altitude);
        let change = self.origin.on_said(place);
        self.on_origin_change(now, change);
    }

    /// Answers to other ground stations are not ours, though they may be about the same command.
    fn on_acknowledgement(&mut self, now: NodeTime, ack: &Acknowledgement) {
        let ours = |id: u8, own: u8| id == 0 || id == own;
        let (system, component) = (self.settings.own_system_id, self.settings.own_component_id);
        if ours(ack.target_system, system) && ours(ack.target_component, component) {
            self.control(now, |offboard, moment| offboard.on_ack(moment, ack));
        }
    }

    /// An answer to us, or the autopilot's own question, which nobody needs an answer to.
    fn on_time_sync(&mut self, now: NodeTime, message: &TIMESYNC_DATA) {
        if message.tc1 == 0 {
            self.rates.on_unused(rates::TIMESYNC);
        } else {
            // One back by more than two seconds has been taken for a restart by the stamps of the messages long before.
            if let Some(by_s) = self.clock.on_answer(now, message) {
                self.offboard.events.push(LinkEvent::ClockJumped { by_s });
            }
        }
    }

    fn on_version(&mut self, message: &AUTOPILOT_VERSION_DATA) {
        self.rates.on_copy(rates::AUTOPILOT_VERSION);
        let [kind, patch, minor, major] = message.flight_sw_version.to_le_bytes();
        self.identity.firmware = Some([major, minor, patch, kind]);
        self.identity.uid = Some(message.uid);
        self.estimate.set_simulated(self.identity.is_simulated());
    }

    fn on_heartbeat(&mut self, now: NodeTime, heartbeat: Heartbeat) {
        if !heartbeat.is_vehicle() {
            return;
        }
        let armed_before = self.heartbeat.replace(heartbeat).map(|before| before.armed());
        let armed = heartbeat.armed();
        self.parameters.set_armed(armed);
        let mode = heartbeat.px4_mode().map_or(FlightMode::Unknown, Px4Mode::flight_mode);
        self.estimate.set_mode(mode, armed, heartbeat.failsafe());
        let round_trip_s = self.clock.round_trip_s().unwrap_or(0.0);
        self.control(now, |offboard, moment| {
            offboard.on_state(moment, armed_before, round_trip_s)
        });
    }

    /// Judges a message's time stamp; a restart is noticed here.
    fn is_of_this_boot(&mut self, now: NodeTime, stamp_ms: u32) -> bool {
        match self.boot.judge(now, stamp_ms) {
            Stamp::Fresh => true,
            Stamp::Doubtful => false,
            Stamp::Rebooted => {
                self.on_reboot(now);
                true
            }
            Stamp::Interleaved => {
                self.interleaved = Some(now);
                false
            }
        }
    }

    /// The autopilot restarted: it has forgotten its rates, its frame, and every command; so must we.
    fn on_reboot(&mut self, now: NodeTime) {
        self.offboard.events.push(LinkEvent::Rebooted);
        self.rates.restart(self.system_id, now);
        self.origin.restart();
        self.clock = ClockSync::default();
        self.estimate.restart();
        self.traffic.restart();
        self.parameters.break_off("the autopilot restarted", true);
        let refusal = Refusal::Autopilot {
            result: "rebooted".to_owned(),
            text: String::new(),
        };
        self.offboard.end_commands(&refusal);
        self.heed_rates();
        self.break_off_route(&refusal);
        // Its frame may be another now: no old position must reach it.
        self.stop_stream(now);
        self.next_heartbeat = now;
    }

    fn on_origin_change(&mut self, now: NodeTime, change: OriginChange) {
        if change == OriginChange::Moved {
            self.rates.renew_copy(rates::GLOBAL_ORIGIN, now);
        }
    }

    pub(super) fn on_text(&mut self, text: Option<StatusText>) {
        if let Some(StatusText { severity, text, .. }) = text {
            self.offboard.events.push(LinkEvent::StatusText { severity, text });
        }
    }
}
