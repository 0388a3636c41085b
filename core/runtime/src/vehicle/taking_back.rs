//! A vehicle that this node flew until it ended: it gets setpoints that hold it where it is, until it is clear that it flies by them again or is
//! left. Its model begins then, and finds it as it is.
//!
//! Must never do: ask for OFFBOARD.

use super::VehicleState;
use skein_domain::exchange::Severity;
use skein_domain::link::LinkEvent;
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{NodeTime, VelocityNed};
use skein_state::resume::judge::{SeenVehicle, Taking};
use skein_view::EventKind;
use skein_view::{PeerEntry, PeerSnapshot};

impl VehicleState {
    /// Whether it is being taken back in this period.
    pub(super) fn takes_back(&mut self, peers: &PeerSnapshot) -> bool {
        let (id, now) = (self.record.id, self.shared.now());
        let Some(entry) = peers.entry(id) else { return false };
        let Some(taking) = self.shared.resume.look(id, &SeenVehicle::of(entry), now) else {
            return false;
        };
        self.hear_without_model();
        match taking {
            Taking::Awaited => true,
            Taking::Holding { .. } => {
                let link = self.record.link();
                link.resume_stream();
                self.hold_here(entry, peers, now);
                true
            }
            Taking::Taken => {
                self.refused_at = None;
                let before = self.shared.resume.before();
                if before.is_some_and(|before| before.withdrawn.contains(&id)) {
                    self.shared.vehicles.withdraw(&self.record);
                }
                let text = format!("{}: taken back, it holds", self.record.name);
                self.record(Severity::Advisory, EventKind::Notice, text);
                false
            }
            Taking::Left(_) => {
                self.refused_at = None;
                self.record.link().stop_stream(now);
                false
            }
        }
    }

    /// Holds it where it was when this began. Until it is known where that is among the others it is stopped in its own frame, as its link does where setpoints
    /// stay away: there is nothing yet that the gate could hold it off.
    fn hold_here(&mut self, entry: &PeerEntry, peers: &PeerSnapshot, now: NodeTime) {
        if !entry.link.connected {
            return;
        }
        if let (Some(own), Some(_)) = (entry.kinematics, entry.telemetry.local_frame) {
            let place = *self.refused_at.get_or_insert(own.position);
            return self.hold_at(place, entry, peers, now);
        }
        if let Some(local) = entry.telemetry.local {
            let hold = LocalSetpoint {
                position: Some(local),
                velocity: Some(VelocityNed::default()),
                yaw_rad: Some(f64::from(entry.telemetry.yaw_rad)),
                ..LocalSetpoint::default()
            };
            let valid_s = self.shared.config.link.setpoint_valid_s;
            self.record.link().stream(now, hold, now.plus_seconds(valid_s));
        }
    }

    /// What its link has to say is told or waits for the model, but for changes of mode: on the way back they are no news.
    fn hear_without_model(&mut self) {
        let link = self.record.link();
        let mut events = std::mem::take(&mut self.waiting);
        for event in link.take_events() {
            if !matches!(event, LinkEvent::ModeChanged { .. }) {
                self.take_link_event(event, &mut events);
            }
        }
        self.waiting = events;
    }
}
