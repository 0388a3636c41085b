//! The settings of the failsafe policy: per trigger its limit, the steps with their times, and whether it reacts at all.

use super::{Reaction, Trigger};
use serde::{Deserialize, Serialize};

/// Whether a trigger reacts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TriggerMode {
    /// Its steps are taken.
    #[default]
    React,
    /// It is reported, nothing is done about it.
    WarnOnly,
    /// It is not looked at. Not for link loss and stale estimates: these count as `warn_only` then.
    Off,
}

/// One step of a trigger: what is done once it has lasted so long.
#[derive(Debug, Clone, Copy, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FailsafeStep {
    /// How long the trigger has lasted, in seconds.
    pub after_s: f64,
    /// What is done.
    pub reaction: Reaction,
}

macro_rules! rules {
    ($(
        $(#[$doc:meta])*
        $name:ident $mode:ident { $($(#[$fdoc:meta])* $field:ident: $type:ty = $default:expr),* $(,)? }
        steps [$($after_s:literal $reaction:ident),*]
    )+) => { $(
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            /// Whether it reacts.
            pub mode: TriggerMode,
            $($(#[$fdoc])* pub $field: $type,)*
            /// What is done after how long, weakest first.
            pub steps: Vec<FailsafeStep>,
        }

        impl Default for $name {
            fn default() -> Self {
                Self {
                    mode: TriggerMode::$mode,
                    $($field: $default,)*
                    steps: vec![$(FailsafeStep { after_s: $after_s, reaction: Reaction::$reaction }),*],
                }
            }
        }
    )+ };
}

rules! {
    /// `[safety.failsafe.link_loss]`: times count from the last frame of the vehicle.
    LinkLossRule React {} steps [1.5 Warn, 5.0 Release]

    /// `[safety.failsafe.gnss_loss]`: times count from the last report of a good fix.
    GnssLossRule React {
        /// Fewer satellites than this are no fix, whatever the receiver calls it.
        min_satellites: u8 = 4,
    } steps [1.0 Warn, 3.0 Hold, 20.0 Land]

    /// `[safety.failsafe.gnss_disagreement]`
    GnssDisagreementRule React {
        /// Distance between two sources of the position beyond which it is one, in metres.
        limit_m: f64 = 5.0,
        /// Below this it is over, in metres.
        clear_m: f64 = 3.0,
    } steps [0.5 Warn, 2.0 Hold, 20.0 Land]

    /// `[safety.failsafe.tracking_error]`
    TrackingErrorRule React {
        /// Distance from where the setpoint wants it beyond which it is one, in metres.
        limit_m: f64 = 5.0,
        /// Below this it is over, in metres.
        clear_m: f64 = 3.0,
    } steps [1.0 Warn, 3.0 Hold, 10.0 Return, 30.0 Land]

    /// `[safety.failsafe.stale_estimate]`: times are the age of the newest position.
    StaleEstimateRule React {} steps [0.3 Warn, 0.5 Hold, 2.0 Release]

    /// `[safety.failsafe.clock_fault]`
    ClockFaultRule React {
        /// Deviation of the offset between the two clocks from where it was beyond which it is one, in seconds.
        limit_s: f64 = 0.1,
        /// Below this it is over, in seconds.
        clear_s: f64 = 0.05,
        /// A slower drift than this is a clock's nature, in seconds per second.
        max_drift_s_per_s: f64 = 0.0005,
        /// An offset that has been steady for so long after a jump is taken as the new one, in seconds.
        settled_after_s: f64 = 5.0,
    } steps [0.0 Warn, 0.5 Hold, 60.0 Return]

    /// `[safety.failsafe.coordinator_loss]`: times count from its last sign of life.
    CoordinatorLossRule React {} steps [2.0 Warn, 20.0 Hold, 120.0 Return]

    /// `[safety.failsafe.operator_dead_man]`: times count from the last sign of life of any operator.
    OperatorDeadManRule Off {} steps [20.0 Warn, 30.0 Hold, 90.0 Return]
}

/// `[safety.failsafe.fence_breach]`: the reaction is the one of the fence.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FenceBreachRule {
    /// Whether it reacts.
    pub mode: TriggerMode,
    /// Outside for so long before the fence's reaction is ordered, in seconds.
    pub after_s: f64,
    /// A hold outside of the fence becomes a return after so long, in seconds.
    pub hold_for_s: f64,
    /// So much further out than when the reaction was ordered: the next stronger follows, in metres.
    pub worse_by_m: f64,
}

impl Default for FenceBreachRule {
    fn default() -> Self {
        Self {
            mode: TriggerMode::React,
            after_s: 0.2,
            hold_for_s: 30.0,
            // More than the way from the highest speed to a stop.
            worse_by_m: 30.0,
        }
    }
}

/// `[safety.failsafe.energy]`: the reaction is the one of the level.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct EnergyRule {
    /// Whether it reacts.
    pub mode: TriggerMode,
    /// A level lasts so long before it counts, in seconds.
    pub after_s: f64,
}

impl Default for EnergyRule {
    fn default() -> Self {
        Self {
            mode: TriggerMode::React,
            after_s: 1.0,
        }
    }
}

/// `[safety.failsafe]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FailsafeSettings {
    /// A reaction not seen to take effect within this time is followed by the next stronger one, in seconds.
    pub reaction_within_s: f64,
    /// A trigger is over once its value has been good for so long, in seconds.
    pub recovered_after_s: f64,
    /// The vehicle is not heard.
    pub link_loss: LinkLossRule,
    /// No satellite fix.
    pub gnss_loss: GnssLossRule,
    /// Two sources of the position disagree.
    pub gnss_disagreement: GnssDisagreementRule,
    /// Not where the setpoint wants it.
    pub tracking_error: TrackingErrorRule,
    /// The newest position is old.
    pub stale_estimate: StaleEstimateRule,
    /// A clock jumped or drifts.
    pub clock_fault: ClockFaultRule,
    /// Outside of a fence.
    pub fence_breach: FenceBreachRule,
    /// No coordinator.
    pub coordinator_loss: CoordinatorLossRule,
    /// No operator.
    pub operator_dead_man: OperatorDeadManRule,
    /// The charge comes to an end.
    pub energy: EnergyRule,
}

impl Default for FailsafeSettings {
    fn default() -> Self {
        Self {
            reaction_within_s: 2.5,
            recovered_after_s: 2.0,
            link_loss: LinkLossRule::default(),
            gnss_loss: GnssLossRule::default(),
            gnss_disagreement: GnssDisagreementRule::default(),
            tracking_error: TrackingErrorRule::default(),
            stale_estimate: StaleEstimateRule::default(),
            clock_fault: ClockFaultRule::default(),
            fence_breach: FenceBreachRule::default(),
            coordinator_loss: CoordinatorLossRule::default(),
            operator_dead_man: OperatorDeadManRule::default(),
            energy: EnergyRule::default(),
        }
    }
}

/// What is left of the steps of a trigger that cannot be switched off.
const REPORTED_AT_LEAST: &[FailsafeStep] = &[FailsafeStep {
    after_s: 1.0,
    reaction: Reaction::Warn,
}];

impl FailsafeSettings {
    /// How a trigger is set. Link loss and stale estimates are at least reported.
    #[must_use]
    pub fn mode(&self, trigger: Trigger) -> TriggerMode {
        let mode = match trigger {
            Trigger::LinkLoss => self.link_loss.mode,
            Trigger::GnssLoss => self.gnss_loss.mode,
            Trigger::GnssDisagreement => self.gnss_disagreement.mode,
            Trigger::TrackingError => self.tracking_error.mode,
            Trigger::StaleEstimate => self.stale_estimate.mode,
            Trigger::ClockFault => self.clock_fault.mode,
            Trigger::FenceBreach => self.fence_breach.mode,
            Trigger::CoordinatorLoss => self.coordinator_loss.mode,
            Trigger::OperatorDeadMan => self.operator_dead_man.mode,
            Trigger::Energy => self.energy.mode,
        };
        match (trigger, mode) {
            (Trigger::LinkLoss | Trigger::StaleEstimate, TriggerMode::Off) => TriggerMode::WarnOnly,
            _ => mode,
        }
    }

    /// The steps of a trigger; none for those whose reaction comes with their value. Link loss and stale estimates have at least one.
    #[must_use]
    pub fn steps(&self, trigger: Trigger) -> &[FailsafeStep] {
        let steps: &[FailsafeStep] = match trigger {
            Trigger::LinkLoss => &self.link_loss.steps,
            Trigger::GnssLoss => &self.gnss_loss.steps,
            Trigger::GnssDisagreement => &self.gnss_disagreement.steps,
            Trigger::TrackingError => &self.tracking_error.steps,
            Trigger::StaleEstimate => &self.stale_estimate.steps,
            Trigger::ClockFault => &self.clock_fault.steps,
            Trigger::CoordinatorLoss => &self.coordinator_loss.steps,
            Trigger::OperatorDeadMan => &self.operator_dead_man.steps,
            Trigger::FenceBreach | Trigger::Energy => &[],
        };
        match trigger {
            Trigger::LinkLoss | Trigger::StaleEstimate if steps.is_empty() => REPORTED_AT_LEAST,
            _ => steps,
        }
    }
}
