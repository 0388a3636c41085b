//! What the failsafe monitor of one vehicle remembers beyond the life of the vehicle's actor: its failsafe policy at work, its charge, where it
//! holds.
//!
//! Must never do: decide what is dangerous (that is `skein-safety`'s), or carry out a reaction.

use skein_config::SafetySettings;
use skein_domain::{
    EnergyState, FailsafeEvent, FailsafeSettings, FailsafeState, NodeTime, Order, PositionNed, Reaction, Refusal,
    VehicleCommand,
};
use skein_safety::FailsafePolicy;
use skein_safety::energy::{EnergyEstimator, EnergySample, WayHome};
use skein_safety::failsafe::{Health, TakenUpBy};
use skein_view::PeerEntry;

/// Time between two looks in seconds.
const LOOK_S: f64 = 0.05;
/// A vehicle slower than this stands, in metres per second.
const STANDS_M_S: f64 = 0.5;
/// Whoever holds stands by then, in seconds.
const STOPPED_WITHIN_S: f64 = 5.0;
/// A battery report older than this says nothing of now, in seconds.
const BATTERY_TOLD_S: f64 = 5.0;

/// The monitor of one vehicle.
#[derive(Debug, Default)]
pub struct FailsafeMonitor {
    policy: FailsafePolicy,
    estimator: EnergyEstimator,
    next: NodeTime,
    /// Where it began to hold, if it holds; a reference that is carried along with a drifting vehicle must not hide the drift.
    held: Option<PositionNed>,
    /// It was the monitor that took the vehicle out of its formation.
    withdrew: bool,
    energy: Option<EnergyState>,
}

/// How a vehicle holds, if it does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Holding {
    /// It holds its place.
    pub holds: bool,
    /// It gives way to somebody.
    pub gives_way: bool,
    /// For so long, in seconds.
    pub for_s: f64,
}

/// Only a hold is left, and what it was for is over.
fn is_over(order: &Order) -> bool {
    order.recovered && order.reaction == Reaction::Hold
}

impl FailsafeMonitor {
    /// Whether a reaction is in force that the coordinator cannot end.
    #[must_use]
    pub fn is_under_order(&self) -> bool {
        self.policy.order().is_some_and(|order| !is_over(order))
    }

    /// Alarms that stand now and would do more than warn in flight.
    #[must_use]
    pub fn would_act(&self, settings: &FailsafeSettings) -> Vec<String> {
        self.policy.would_act(settings)
    }

    /// The autopilot restarted.
    pub fn autopilot_restarted(&mut self) {
        self.policy.autopilot_restarted();
    }

    /// Whether it may come back into the formation that the monitor took it out of.
    #[must_use]
    pub fn may_rejoin(&self) -> bool {
        self.withdrew && self.policy.order().is_some_and(is_over)
    }

    /// The charge against the way home, as last assessed.
    #[must_use]
    pub fn energy(&self) -> Option<EnergyState> {
        self.energy
    }

    /// Whether it is time for the next look; if so, that look has begun.
    pub fn begin_look(&mut self, now: NodeTime) -> bool {
        let due = now >= self.next;
        if due {
            self.next = now.plus_seconds(LOOK_S);
        }
        due
    }

    /// Assesses the charge against the way home.
    pub fn assess(&mut self, entry: &PeerEntry, settings: &SafetySettings, now: NodeTime) -> Option<EnergyState> {
        self.energy = self.assessed(entry, settings, now);
        self.energy
    }

    fn assessed(&mut self, entry: &PeerEntry, settings: &SafetySettings, now: NodeTime) -> Option<EnergyState> {
        let told_s = now.seconds_since(entry.telemetry.heard.battery);
        let sample = EnergySample {
            // An old report is none: the estimator carries the charge on by itself.
            battery: Some(entry.telemetry.battery)
                .filter(|_| told_s <= BATTERY_TOLD_S)
                .unwrap_or_default(),
            simulated: entry.telemetry.simulated,
            airborne: entry.airborne,
            velocity: entry.telemetry.velocity,
            wind: entry.telemetry.wind,
        };
        self.estimator.observe(now, &sample, &settings.energy);
        let (position, home) = (entry.kinematics?.position, entry.home?);
        let away = position.vector() - home.vector();
        let distance_m = away.xy().norm();
        let receding_m_s = match entry.telemetry.velocity {
            Some(v) if distance_m > 1.0 => (v.vector().xy().dot(&away.xy()) / distance_m).max(0.0),
            _ => 0.0,
        };
        let way = WayHome::between(&position, &home, settings.returning.height_m, receding_m_s);
        self.estimator.assess(now, &way, &settings.energy)
    }

    /// How far a vehicle that holds is from where it began to, in metres. Giving way to somebody is no drift.
    pub fn drifted_m(&mut self, entry: &PeerEntry, holding: Holding) -> Option<f64> {
        let kinematics = entry.kinematics?;
        if !holding.holds || holding.gives_way || !entry.airborne {
            self.held = None;
            return None;
        }
        // Who never comes to stand is drifting from the start.
        let stands = kinematics.velocity.norm() < STANDS_M_S || holding.for_s > STOPPED_WITHIN_S;
        if self.held.is_none() && stands {
            self.held = Some(kinematics.position);
        }
        self.held.map(|place| place.distance_m(&kinematics.position))
    }

    /// The failsafe policy, for who records what it makes of something.
    #[must_use]
    pub fn policy(&self) -> &FailsafePolicy {
        &self.policy
    }

    /// Applies the failsafe policy to how it fares: what there is to tell, and the state to be shown.
    pub fn judge(
        &mut self,
        health: &Health,
        settings: &FailsafeSettings,
        now: NodeTime,
    ) -> (Vec<FailsafeEvent>, FailsafeState) {
        let events = self.policy.step(now, health, settings);
        (events, self.policy.state(settings))
    }

    /// A reaction is carried out; whether that took the vehicle out of its formation.
    pub fn reacted(&mut self, withdrew: bool) {
        self.withdrew = withdrew;
    }

    /// Somebody takes the vehicle up again.
    ///
    /// # Errors
    /// When a reaction is in force that this one cannot end.
    pub fn take_up(&mut self, by: TakenUpBy) -> Result<Option<FailsafeEvent>, Refusal> {
        self.withdrew &= by != TakenUpBy::Operator;
        self.policy.take_up(by)
    }

    /// What the policy says to a command of an operator.
    ///
    /// # Errors
    /// When a reaction that is in force forbids it.
    pub fn permits(&self, command: &VehicleCommand) -> Result<(), Refusal> {
        self.policy.permits(command)
    }
}
