//! What came of what was asked: commands end, and a gimbal that does not follow is told of.

use super::{Gimbal, moment};
use crate::aim::{Aim, PendingOf};
use crate::following::{Bounds, Change, Look};
use skein_domain::exchange::Severity;
use skein_domain::{NodeTime, Refusal};
use skein_plugin_sdk::Effects;

impl Gimbal {
    /// Ends the command under way when what it asked for is the case, or took too long.
    pub(super) fn judge(&mut self, now: NodeTime, effects: &mut Effects) {
        let at = moment(now, &self.settings, &self.own);
        let reached = match self.core.aim {
            Aim::Idle => return,
            Aim::Rates(_) => self.core.sent.is_some(),
            Aim::Angles(_) | Aim::Place(_) => {
                let attitude = self.core.device.status(&at).attitude;
                let heard_since = |heard: NodeTime| {
                    self.core
                        .sent
                        .is_some_and(|_| self.core.pending.is_none_or(|pending| heard >= pending.begun))
                };
                let off_rad = self
                    .wanted(now)
                    .zip(attitude.filter(|a| heard_since(a.heard)))
                    .and_then(|(wanted, attitude)| wanted.off_rad(&attitude, at.vehicle_yaw_rad));
                off_rad.is_some_and(|off_rad| off_rad <= self.settings.tolerance_rad)
            }
        };
        // Rates must be kept up: a device may stop by itself when nobody repeats them.
        self.core.reached = reached && !matches!(self.core.aim, Aim::Rates(_));
        let Some(pending) = self.core.pending.filter(|pending| pending.of == PendingOf::Aim) else {
            return;
        };
        let after_s = now.seconds_since(pending.begun);
        if reached {
            self.end(Ok(()), effects);
        } else if after_s > self.settings.turn_timeout_s {
            let what = "the gimbal to look where it is to look".to_owned();
            self.end(Err(Refusal::timed_out(what, after_s)), effects);
        }
    }

    /// Looks whether the gimbal follows, and tells when that changes.
    pub(super) fn look_after(&mut self, now: NodeTime, effects: &mut Effects) {
        let look = self.look(now);
        let bounds = Bounds {
            tolerance_rad: self.settings.follow_tolerance_rad,
            after_s: self.settings.follow_timeout_s,
        };
        let by_servos = self
            .core
            .device
            .status(&moment(now, &self.settings, &self.own))
            .by_servos;
        match self.core.following.look(now, look, bounds) {
            Some(Change::Stays) => {
                let off_deg = look.map_or(0.0, |look| look.off_rad.to_degrees());
                let hint = if by_servos {
                    " PX4 holds servos to the horizon and to north with MNT_DO_STAB = 1 only."
                } else {
                    ""
                };
                effects.notice(
                    Severity::Warning,
                    format!("The gimbal does not follow: it looks {off_deg:.0}° off where it is wanted.{hint}"),
                );
            }
            Some(Change::Follows) => effects.notice(Severity::Info, "The gimbal follows again.".to_owned()),
            None => {}
        }
    }

    /// Where the gimbal is wanted and how far off it looks. `None` if nothing is wanted of it, or it cannot be told: it is not heard,
    /// not ours to steer, was not told yet, or is at an end stop.
    fn look(&self, now: NodeTime) -> Option<Look> {
        let at = moment(now, &self.settings, &self.own);
        let status = self.core.device.status(&at);
        let seen = status.connected && self.core.device.obeys() && !status.at_end_stop && self.core.sent.is_some();
        let attitude = status
            .attitude
            .filter(|attitude| seen && at.within(Some(attitude.heard), at.settings.lost_after_s))?;
        let wanted = self.wanted(now)?;
        Some(Look {
            wanted: wanted.seen_from_nose(at.vehicle_yaw_rad)?,
            off_rad: wanted.off_rad(&attitude, at.vehicle_yaw_rad)?,
        })
    }
}
