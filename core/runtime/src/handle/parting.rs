//! What becomes of this node's vehicles in the air when it stops: their autopilots are asked to go on by themselves, and it is told who has
//! not confirmed that.
//!
//! Must never do: touch a vehicle over which a pilot has control authority; wait without a bound; end a stream before its vehicle's autopilot has taken over.

use super::NodeHandle;
use skein_config::OnStop;
use skein_domain::exchange::Severity;
use skein_domain::{AutopilotCommand, FlightMode, FlightState, RequestId};
use skein_state::VehicleRecord;
use skein_view::EventKind;
use skein_view::airborne;
use std::sync::Arc;
use std::time::Duration;

/// Longest wait for the autopilots: a command is tried three times, and the heartbeat that shows the mode comes once a second.
const CONFIRMED_WITHIN: Duration = Duration::from_secs(4);
/// How often it is looked who has confirmed.
const LOOK: Duration = Duration::from_millis(50);
/// Request id of what is asked for here, beyond what models, actors and the watch use.
const PARTING_REQUEST: RequestId = RequestId(u32::MAX - 3);

impl NodeHandle {
    /// Has the autopilots of this node's vehicles in the air do what the configuration says, and waits for a bounded time until they do.
    /// What there is to say goes to `tell` and into the event log.
    pub async fn part(&self, tell: impl Fn(&str)) {
        let say = |severity, text: String| {
            tell(&text);
            let events = &self.shared.events;
            events.record(self.now(), None, severity, EventKind::Notice, text);
        };
        let mut in_air = self.shared.vehicles.records();
        in_air.retain(|record| self.is_in_air(record));
        if in_air.is_empty() {
            return;
        }
        self.shared.begin_stopping();
        let on_stop = self.shared.config.node.on_stop;
        let asked: Vec<(Arc<VehicleRecord>, FlightMode)> = in_air
            .iter()
            .filter_map(|record| Some((record.clone(), self.ask_autopilot(record, on_stop)?)))
            .collect();
        say(Severity::Warning, words(&in_air, &asked, on_stop));
        let until = tokio::time::Instant::now() + CONFIRMED_WITHIN;
        let mut waiting = asked;
        while !waiting.is_empty() && tokio::time::Instant::now() < until {
            tokio::time::sleep(LOOK).await;
            waiting.retain(|(record, mode)| self.mode(record) != *mode && self.is_in_air(record));
        }
        for (record, mode) in waiting {
            let text = format!(
                "{} has not confirmed mode {mode} within {:.0} s: what it does without setpoints is up to its autopilot",
                record.name,
                CONFIRMED_WITHIN.as_secs_f64()
            );
            say(Severity::Critical, text);
        }
        self.shared.resume.forget();
    }

    /// Asks the autopilot of one vehicle; gives the mode it is to be in, or nothing if it is not asked for one.
    fn ask_autopilot(&self, record: &VehicleRecord, on_stop: OnStop) -> Option<FlightMode> {
        let state = record.state().flight_state;
        let others = matches!(
            state,
            FlightState::Idle | FlightState::PilotControl | FlightState::Faulted
        );
        let (command, mode) = parting(on_stop, self.mode(record)).filter(|_| !others && !record.is_stopped())?;
        // So that no regrouping calls it back, and those of other nodes close up.
        self.shared.vehicles.withdraw(record);
        self.shared.gate().autopilot(&command, true).ok()?;
        record.link().request(self.now(), PARTING_REQUEST, command);
        Some(mode)
    }

    fn mode(&self, record: &VehicleRecord) -> FlightMode {
        record.link().read(self.now()).0.mode
    }

    fn is_in_air(&self, record: &VehicleRecord) -> bool {
        airborne(&record.link().read(self.now()).0)
    }
}

/// What an autopilot in this mode is asked for, and the mode that confirms it. Whoever comes down or home by its autopilot already goes on, and
/// a take-off ends in a hold by itself.
fn parting(on_stop: OnStop, mode: FlightMode) -> Option<(AutopilotCommand, FlightMode)> {
    let asked = match on_stop {
        OnStop::Hold => (AutopilotCommand::SetMode { mode: FlightMode::Hold }, FlightMode::Hold),
        OnStop::Land => (AutopilotCommand::Land, FlightMode::Land),
        OnStop::Return => (AutopilotCommand::ReturnToLaunch, FlightMode::Return),
        OnStop::Leave => return None,
    };
    let due = match mode {
        FlightMode::Offboard => true,
        FlightMode::TakeOff | FlightMode::Hold => on_stop != OnStop::Hold,
        _ => false,
    };
    due.then_some(asked)
}

/// The sentence for operator and log.
fn words(in_air: &[Arc<VehicleRecord>], asked: &[(Arc<VehicleRecord>, FlightMode)], on_stop: OnStop) -> String {
    let does = match on_stop {
        OnStop::Hold => "hold",
        OnStop::Land => "land",
        OnStop::Return => "return",
        OnStop::Leave => {
            let count = in_air.len();
            return format!(
                "stopping with {count} in the air: they are left to what their autopilots do without setpoints"
            );
        }
    };
    let names = |records: Vec<&VehicleRecord>| {
        records
            .iter()
            .map(|record| record.name.as_str())
            .collect::<Vec<_>>()
            .join(", ")
    };
    let is_asked = |record: &VehicleRecord| asked.iter().any(|(of, _)| of.id == record.id);
    let told = names(asked.iter().map(|(record, _)| &**record).collect());
    let left = names(
        in_air
            .iter()
            .map(|record| &**record)
            .filter(|record| !is_asked(record))
            .collect(),
    );
    let mut text = format!("stopping with {} in the air", in_air.len());
    if !told.is_empty() {
        text += &format!(": asked to {does} by their autopilots: {told}");
    }
    if !left.is_empty() {
        text += &format!("; not touched, for a pilot or their autopilots have them already: {left}");
    }
    text
}

#[cfg(test)]
mod tests {
    //! Which autopilot is asked for what.

    use super::*;

    #[test]
    fn who_is_flown_by_setpoints_is_asked_unless_all_are_left() {
        let hold = AutopilotCommand::SetMode { mode: FlightMode::Hold };
        for (on_stop, asked) in [
            (OnStop::Hold, Some((hold, FlightMode::Hold))),
            (OnStop::Land, Some((AutopilotCommand::Land, FlightMode::Land))),
            (
                OnStop::Return,
                Some((AutopilotCommand::ReturnToLaunch, FlightMode::Return)),
            ),
            (OnStop::Leave, None),
        ] {
            assert_eq!(parting(on_stop, FlightMode::Offboard), asked);
        }
    }

    #[test]
    fn nobody_is_asked_out_of_a_pilots_mode_a_landing_or_a_return() {
        let only_by_setpoints = [FlightMode::Offboard, FlightMode::TakeOff, FlightMode::Hold];
        for mode in FlightMode::ALL.iter().filter(|mode| !only_by_setpoints.contains(mode)) {
            for on_stop in [OnStop::Hold, OnStop::Land, OnStop::Return, OnStop::Leave] {
                assert_eq!(parting(on_stop, *mode), None, "{mode}");
            }
        }
        assert_eq!(parting(OnStop::Hold, FlightMode::TakeOff), None);
    }
}
