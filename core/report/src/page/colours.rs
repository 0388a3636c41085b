//! One colour for each vehicle, the same on the whole page.
//!
//! Must never do: use the colours of warnings for a vehicle.

use crate::facts::Report;
use skein_domain::VehicleId;
use std::collections::BTreeMap;

/// Told apart on white, on paper, and by most who see colours otherwise.
const FIRST: [&str; 10] = [
    "#1f6fb4", "#d9730d", "#2d8a4e", "#8a4fbf", "#00939b", "#b0578d", "#7a6a1d", "#5867d6", "#6b7480", "#8c4a2f",
];

/// The colours.
pub struct Colours(BTreeMap<VehicleId, String>);

impl Colours {
    pub fn of(report: &Report) -> Self {
        let ids = report.vehicles.iter().map(|vehicle| vehicle.id).enumerate();
        Self(ids.map(|(at, id)| (id, colour(at))).collect())
    }

    pub fn of_vehicle(&self, id: VehicleId) -> &str {
        self.0.get(&id).map_or("#46515a", String::as_str)
    }
}

/// Beyond the first ones hues a golden angle apart, each round a little darker or lighter.
fn colour(at: usize) -> String {
    FIRST.get(at).map_or_else(
        || {
            let hue = (at as f64 * 137.508) % 360.0;
            let light = [38, 48, 30][at / 12 % 3];
            format!("hsl({hue:.0} 60% {light}%)")
        },
        |first| (*first).to_owned(),
    )
}
