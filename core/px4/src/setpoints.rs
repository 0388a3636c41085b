//! The setpoint stream: sent at once when it is given, repeated while it is valid, replaced by a hold when it has expired,
//! and given up on purpose after a bounded time.
//!
//! Must never do: send a velocity that has expired, or anything at all while the stream is stopped, given up or taken over.
//! PX4 goes back to OFFBOARD by itself when setpoints come again after its failsafe: so after a take-over (a change out of
//! OFFBOARD that nobody here asked for) and after giving up, nothing is sent until OFFBOARD is asked for anew.

use crate::send_rate::SendRate;
use crate::settings::LinkSettings;
use skein_domain::link::StreamState;
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{LocalPositionNed, NodeTime, VelocityNed};

/// A setpoint that is still valid is repeated when none has been sent for this many periods.
const REPEAT_PERIODS: f64 = 3.0;

/// Where the vehicle is, for a hold.
#[derive(Debug, Clone, Copy, Default)]
pub struct HoldPlace {
    /// Its position, if it was measured just now.
    pub position: Option<LocalPositionNed>,
    /// Its yaw in radians, if known.
    pub yaw_rad: Option<f64>,
}

/// Why nothing may be sent until OFFBOARD is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Barred {
    /// The stream was given up.
    GivenUp,
    /// The autopilot left OFFBOARD unasked.
    TakenOver,
    /// The motors were stopped in an emergency.
    Emergency,
}

/// What is to be done now.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StreamAction {
    /// To be sent.
    pub send: Option<LocalSetpoint>,
    /// The new state, if it changed.
    pub changed: Option<StreamState>,
}

/// The stream to one vehicle.
#[derive(Debug, Default)]
pub struct SetpointStream {
    state: StreamState,
    current: LocalSetpoint,
    expires: NodeTime,
    hold_until: NodeTime,
    /// Since when setpoints have been sent without a pause.
    since: Option<NodeTime>,
    last_sent: NodeTime,
    /// Spreads a faster caller to the configured rate.
    next_allowed: NodeTime,
    barred: Option<Barred>,
    rate: SendRate,
}

impl SetpointStream {
    /// What it is doing.
    #[must_use]
    pub fn state(&self) -> StreamState {
        self.state
    }

    /// Whether anything is being sent.
    #[must_use]
    pub fn is_active(&self) -> bool {
        matches!(self.state, StreamState::Fresh | StreamState::HoldingExpired)
    }

    /// Takes a setpoint that is valid until `expires`.
    pub fn offer(
        &mut self,
        now: NodeTime,
        setpoint: LocalSetpoint,
        expires: NodeTime,
        settings: &LinkSettings,
    ) -> StreamAction {
        if self.barred.is_some() || expires <= now || !is_well_formed(&setpoint) {
            return StreamAction::default();
        }
        (self.current, self.expires) = (setpoint, expires);
        let changed = self.enter(StreamState::Fresh);
        let period_s = 1.0 / settings.setpoint_rate_hz.max(1.0);
        if now < self.next_allowed {
            return StreamAction { send: None, changed };
        }
        self.next_allowed = self
            .next_allowed
            .max(now.plus_seconds(-0.5 * period_s))
            .plus_seconds(period_s);
        StreamAction {
            send: Some(self.sending(now, setpoint)),
            changed,
        }
    }

    /// Does what has become due.
    pub fn poll(&mut self, now: NodeTime, place: impl FnOnce() -> HoldPlace, settings: &LinkSettings) -> StreamAction {
        let period_s = 1.0 / settings.setpoint_rate_hz.max(1.0);
        let pause_s = now.seconds_since(self.last_sent);
        match self.state {
            StreamState::Fresh if now >= self.expires => {
                let place = place();
                self.current = LocalSetpoint {
                    // Without a position the vehicle is at least told to stop.
                    position: place.position,
                    velocity: Some(VelocityNed::default()),
                    yaw_rad: self.current.yaw_rad.or(place.yaw_rad),
                    ..LocalSetpoint::default()
                };
                self.hold_until = now.plus_seconds(settings.hold_for_s);
                let changed = self.enter(StreamState::HoldingExpired);
                StreamAction {
                    send: Some(self.sending(now, self.current)),
                    changed,
                }
            }
            StreamState::Fresh if pause_s >= REPEAT_PERIODS * period_s => self.repeat(now),
            StreamState::HoldingExpired if now >= self.hold_until => self.give_up(),
            StreamState::HoldingExpired if pause_s >= 0.9 * period_s => self.repeat(now),
            _ => StreamAction::default(),
        }
    }

    /// When [`Self::poll`] has something to do next, if nothing else happens.
    #[must_use]
    pub fn due(&self, settings: &LinkSettings) -> Option<NodeTime> {
        let period_s = 1.0 / settings.setpoint_rate_hz.max(1.0);
        match self.state {
            StreamState::Fresh => Some(self.expires.min(self.last_sent.plus_seconds(REPEAT_PERIODS * period_s))),
            StreamState::HoldingExpired => Some(self.hold_until.min(self.last_sent.plus_seconds(period_s))),
            StreamState::Stopped | StreamState::GivenUp => None,
        }
    }

    /// Ends it on purpose.
    pub fn stop(&mut self) -> StreamAction {
        if self.barred == Some(Barred::GivenUp) {
            self.barred = None;
        }
        StreamAction {
            send: None,
            changed: self.enter(StreamState::Stopped),
        }
    }

    /// Ends it because nothing may be sent any more.
    pub fn give_up(&mut self) -> StreamAction {
        if self.state == StreamState::Stopped {
            return StreamAction::default();
        }
        self.barred = Some(Barred::GivenUp);
        StreamAction {
            send: None,
            changed: self.enter(StreamState::GivenUp),
        }
    }

    /// The autopilot has left OFFBOARD unasked: nothing that could bring it back is sent until it is asked for.
    pub fn taken_over(&mut self) -> StreamAction {
        if self.barred != Some(Barred::Emergency) {
            self.barred = Some(Barred::TakenOver);
        }
        let changed = if self.is_active() {
            self.enter(StreamState::Stopped)
        } else {
            None
        };
        StreamAction { send: None, changed }
    }

    /// The motors are being stopped: nothing is sent until OFFBOARD is asked for, or the vehicle stands disarmed.
    pub fn bar_for_good(&mut self) -> StreamAction {
        self.barred = Some(Barred::Emergency);
        StreamAction {
            send: None,
            changed: self.enter(StreamState::Stopped),
        }
    }

    /// The autopilot is in OFFBOARD again, by whoever's will, or would be if setpoints came: what a take-over barred may be sent again.
    pub fn handed_back(&mut self) {
        if self.barred == Some(Barred::TakenOver) {
            self.barred = None;
        }
    }

    /// OFFBOARD was asked for, or a flight has ended: setpoints may be sent again.
    pub fn unbar(&mut self) {
        self.barred = None;
    }

    /// Whether setpoints have been sent without a pause for `lead_s`, and are fresh.
    #[must_use]
    pub fn has_run(&self, now: NodeTime, lead_s: f64) -> bool {
        self.state == StreamState::Fresh && self.since.is_some_and(|since| now.seconds_since(since) >= lead_s)
    }

    /// Setpoints per second.
    pub fn rate_hz(&mut self, now: NodeTime) -> f32 {
        self.rate.rate_hz(now)
    }

    fn repeat(&mut self, now: NodeTime) -> StreamAction {
        StreamAction {
            send: Some(self.sending(now, self.current)),
            changed: None,
        }
    }

    fn sending(&mut self, now: NodeTime, setpoint: LocalSetpoint) -> LocalSetpoint {
        self.since.get_or_insert(now);
        self.last_sent = now;
        self.rate.on_sent(now);
        setpoint
    }

    fn enter(&mut self, state: StreamState) -> Option<StreamState> {
        if self.state == state {
            return None;
        }
        if !matches!((self.state, state), (StreamState::Fresh, StreamState::HoldingExpired)) {
            self.since = None;
        }
        self.state = state;
        Some(state)
    }
}

/// Autopilots read single precision: a number beyond it would reach them as infinite.
fn is_well_formed(setpoint: &LocalSetpoint) -> bool {
    let fits = |value: f64| (value as f32).is_finite();
    (setpoint.position.is_some() || setpoint.velocity.is_some())
        && setpoint
            .position
            .is_none_or(|p| p.vector().iter().all(|part| fits(*part)))
        && setpoint
            .velocity
            .is_none_or(|v| v.vector().iter().all(|part| fits(*part)))
        && setpoint
            .acceleration
            .is_none_or(|a| a.vector().iter().all(|part| fits(*part)))
        && setpoint.yaw_rad.is_none_or(fits)
        && setpoint.yaw_rate_rad_s.is_none_or(fits)
}

#[cfg(test)]
mod tests;
