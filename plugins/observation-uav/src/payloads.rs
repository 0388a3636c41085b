//! The payloads of the vehicle, as they report themselves.

use skein_plugin_sdk::domain::exchange::PayloadReport;
use skein_plugin_sdk::domain::payload::{CameraState, GimbalState, PayloadKind, RadioState};
use std::collections::BTreeMap;

/// What is known of the payloads, by name.
#[derive(Debug, Default)]
pub(crate) struct Payloads {
    gimbals: BTreeMap<String, GimbalState>,
    cameras: BTreeMap<String, CameraState>,
    radios: BTreeMap<String, RadioState>,
}

impl Payloads {
    /// Takes a report. A state that is not of the common vocabulary belongs to a payload of its own kind, which is left alone.
    pub(crate) fn take(&mut self, report: &PayloadReport) {
        match report.kind {
            PayloadKind::Gimbal => keep(&mut self.gimbals, report),
            PayloadKind::Camera => keep(&mut self.cameras, report),
            PayloadKind::Radio => keep(&mut self.radios, report),
            PayloadKind::Detector => {}
        }
    }

    /// The gimbal that is used: the first by name that is there.
    pub(crate) fn gimbal(&self) -> Option<(&str, &GimbalState)> {
        let mut connected = self.gimbals.iter().filter(|(_, state)| state.connected);
        connected.next().map(|(name, state)| (name.as_str(), state))
    }

    /// The camera that is used: the first by name that is there.
    pub(crate) fn camera(&self) -> Option<(&str, &CameraState)> {
        let mut connected = self.cameras.iter().filter(|(_, state)| state.connected);
        connected.next().map(|(name, state)| (name.as_str(), state))
    }

    /// The radio whose state counts: one that warns before one that does not.
    pub(crate) fn radio(&self) -> Option<(&str, &RadioState)> {
        let connected = || self.radios.iter().filter(|(_, state)| state.connected);
        let warning = connected().find(|(_, state)| state.warning);
        warning
            .or_else(|| connected().next())
            .map(|(name, state)| (name.as_str(), state))
    }
}

fn keep<S: serde::de::DeserializeOwned>(known: &mut BTreeMap<String, S>, report: &PayloadReport) {
    let state = report
        .state_json
        .as_deref()
        .and_then(|json| serde_json::from_str(json).ok());
    match state {
        Some(state) => drop(known.insert(report.name.clone(), state)),
        None => drop(known.remove(&report.name)),
    }
}
