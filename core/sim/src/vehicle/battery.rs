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
    /// How many times as fast as it should it drains.
    drain: f64,
}

impl Battery {
    pub(crate) fn new(settings: &BatterySettings) -> Self {
        Self {
            settings: *settings,
            charge: settings.initial.clamp(0.0, 1.0),
            drain: 1.0,
        }
    }

    /// It drains so many times as fast as it should.
    pub(crate) fn set_drain(&mut self, factor: f64) {
        self.drain = if factor.is_finite() { factor.max(0.0) } else { 1.0 };
    }

    /// It has this charge from now on.
    pub(crate) fn set_charge(&mut self, charge: f64) {
        if charge.is_finite() {
            self.charge = charge.clamp(0.0, 1.0);
        }
    }

    /// Lets `dt_s` pass; gives the warning level that was just reached, if one was.
    pub(crate) fn step(&mut self, armed: bool, dt_s: f64) -> Option<BatteryLevel> {
        if !armed {
            if self.settings.full_when_disarmed {
                self.charge = 1.0;
            }
            return None;
        }
        let before = self.level();
        let left = self.charge - self.drain * dt_s / self.settings.endurance_s.max(1.0);
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
            self.drain * CAPACITY_MAH * 3.6 / self.settings.endurance_s.max(1.0)
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
        self.charge * self.settings.endurance_s / self.drain.max(0.01)
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
