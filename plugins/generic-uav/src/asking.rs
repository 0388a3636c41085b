//! One request to the autopilot, made again while there is hope.

use crate::flight::Asking;
use crate::model::GenericUav;
use skein_domain::{AutopilotCommand, Refusal, RequestId};
use skein_plugin_sdk::Effects;

/// Whether the autopilot may well say yes to the same request a little later.
fn may_change(refusal: &Refusal) -> bool {
    match refusal {
        Refusal::Autopilot { result, .. } => result == "temporarily_rejected",
        Refusal::NotReadyToArm { .. } | Refusal::TimedOut { .. } | Refusal::LinkLost { .. } => true,
        _ => false,
    }
}

impl GenericUav {
    /// Makes a request, at most `attempts` times, and looks for its answer. `None` while it is open. Once accepted it stays so for the
    /// time an answer may take: whoever asks ends the asking by seeing the state that should follow.
    pub(crate) fn ask(
        &mut self,
        asking: &mut Asking,
        command: AutopilotCommand,
        attempts: u32,
        out: &mut Effects,
    ) -> Option<Result<(), Refusal>> {
        let now_s = self.flight.heard_s;
        let refusal = match (asking.accepted_s, asking.outstanding) {
            (Some(accepted_s), _) if !self.is_late(accepted_s) => return Some(Ok(())),
            (Some(_), _) => Some(self.no_answer(command)),
            (None, Some((request, made_s))) => match self.result_of(request) {
                Some(None) => {
                    asking.outstanding = None;
                    asking.accepted_s = Some(now_s);
                    return Some(Ok(()));
                }
                Some(refusal) => refusal,
                None if self.is_late(made_s) => Some(self.no_answer(command)),
                None => return None,
            },
            (None, None) => None,
        };
        if let Some(refusal) = refusal {
            asking.outstanding = None;
            asking.accepted_s = None;
            asking.not_before_s = now_s + self.settings.retry_pause_s;
            asking.refusal = Some(refusal.clone());
            if asking.attempts >= attempts || !may_change(&refusal) {
                return Some(Err(refusal));
            }
        }
        if now_s >= asking.not_before_s {
            let request = RequestId(self.flight.next_request);
            self.flight.next_request = self.flight.next_request.wrapping_add(1);
            asking.attempts = asking.attempts.saturating_add(1);
            asking.outstanding = Some((request, now_s));
            out.autopilot(request, command);
        }
        None
    }

    /// Whether what was to come since then should be there by now.
    fn is_late(&self, since_s: f64) -> bool {
        self.flight.heard_s - since_s > self.settings.request_timeout_s
    }

    fn no_answer(&self, command: AutopilotCommand) -> Refusal {
        Refusal::timed_out(format!("{command:?}"), self.settings.request_timeout_s)
    }
}
