//! The battery: drains at a constant rate while armed; four cells, voltage falls with the charge.

use crate::settings::BatterySettings;

const FULL_V: f64 = 16.2;
const EMPTY_V: f64 = 14.4;
const CAPACITY_MAH: f64 = 5000.0;

/// Charge and voltage.
#[derive(Debug, Clone)]
pub(crate) struct Battery {
    settings: BatterySettings,
    charge: f64,
}

impl Battery {
    pub(crate) fn new(settings: &BatterySettings) -> Self {
        Self {
            settings: *settings,
            charge: settings.initial.clamp(0.0, 1.0),
        }
    }

    /// Lets `dt_s` pass; gives the warning level that was just reached, if one was.
    pub(crate) fn step(&mut self, armed: bool, dt_s: f64) -> Option<BatteryLevel> {
        if !armed {
            return None;
        }
        let before = self.level();
        let left = self.charge - dt_s / self.settings.endurance_s.max(1.0);
        self.charge = left.max(self.settings.floor.min(self.charge));
        let after = self.level();
        (after != before).then_some(after)
    }

    /// Charge, 0..=1.
    pub(crate) fn charge(&self) -> f64 {
        self.charge
    }

    /// Voltage in volts.
    pub(crate) fn voltage_v(&self) -> f64 {
        EMPTY_V + (FULL_V - EMPTY_V) * self.charge
    }

    /// Current in amperes.
    pub(crate) fn current_a(&self, armed: bool) -> f64 {
        if armed {
            CAPACITY_MAH * 3.6 / self.settings.endurance_s.max(1.0)
        } else {
            0.4
        }
    }

    /// Charge used so far in milliampere hours.
    pub(crate) fn consumed_mah(&self) -> f64 {
        (1.0 - self.charge) * CAPACITY_MAH
    }

    /// Flight time left in seconds.
    pub(crate) fn remaining_s(&self) -> f64 {
        self.charge * self.settings.endurance_s
    }

    /// Warning level, with PX4's default thresholds.
    pub(crate) fn level(&self) -> BatteryLevel {
        match self.charge {
            c if c < 0.05 => BatteryLevel::Emergency,
            c if c < 0.07 => BatteryLevel::Critical,
            c if c < 0.15 => BatteryLevel::Low,
            _ => BatteryLevel::Good,
        }
    }
}

/// How worrying the charge is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BatteryLevel {
    Good,
    Low,
    Critical,
    Emergency,
}
