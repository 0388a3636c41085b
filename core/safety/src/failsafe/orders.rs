//! The reaction in force: which one, whether it takes effect, and who may end it.

use super::{FailsafePolicy, Health, Means, Tracker, calls_back, effect, words};
use skein_domain::failsafe::TriggerMode;
use skein_domain::{
    FailsafeEvent, FailsafeEventKind, FailsafeSettings, Order, Reaction, Refusal, Trigger, VehicleCommand,
};

/// Who takes a vehicle up again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum TakenUpBy {
    /// A person who commands it: also while a trigger lasts, whose present step is overruled then.
    Operator,
    /// The coordinator, with a new task: only out of a hold whose triggers are all over.
    Coordinator,
}

/// Triggers under which nothing that needs a position is flown.
const POSITION_IN_DOUBT: [Trigger; 5] = [
    Trigger::LinkLoss,
    Trigger::GnssLoss,
    Trigger::GnssDisagreement,
    Trigger::StaleEstimate,
    Trigger::ClockFault,
];

impl FailsafePolicy {
    /// Whether a command may be given to the vehicle now: what is in force bounds what makes sense. Stopping, returning and landing
    /// are always permitted. Call [`FailsafePolicy::take_up`] with a command that is accepted.
    ///
    /// # Errors
    /// [`Refusal::NotPermitted`] with the trigger that forbids it.
    pub fn permits(&self, command: &VehicleCommand) -> Result<(), Refusal> {
        let flies_somewhere = match command {
            VehicleCommand::GoTo { .. }
            | VehicleCommand::Steer
            | VehicleCommand::Observe { .. }
            | VehicleCommand::LandAt { .. }
            | VehicleCommand::TakeOff { .. } => true,
            VehicleCommand::Arm
            | VehicleCommand::Disarm
            | VehicleCommand::Land
            | VehicleCommand::Hold
            | VehicleCommand::Return
            | VehicleCommand::LookAt { .. }
            | VehicleCommand::StopObserving => false,
        };
        if !flies_somewhere || self.order.is_none() {
            return Ok(());
        }
        let lands = matches!(command, VehicleCommand::LandAt { .. });
        let forbids = self.trackers.iter().find(|(trigger, tracker)| {
            let acts = tracker.stand().is_some_and(|s| s.reaction >= Reaction::Hold);
            acts && (POSITION_IN_DOUBT.contains(trigger) || (*trigger == Trigger::Energy && !lands))
        });
        match forbids {
            None => Ok(()),
            Some((trigger, _)) => Err(Refusal::not_permitted(format!(
                "{} while: {}",
                command.name(),
                words::title(*trigger)
            ))),
        }
    }

    /// What stands now and would do more than warn in the air, in words: such a vehicle is not to be armed. Fences and signs of life
    /// are not looked at: where a vehicle stands has a check of its own, and people and coordinators speak up with the command.
    #[must_use]
    pub fn would_act(&self, settings: &FailsafeSettings) -> Vec<String> {
        let acts = |trigger: Trigger, tracker: &Tracker| {
            let by_steps = settings
                .steps(trigger)
                .iter()
                .any(|step| step.reaction > Reaction::Warn);
            by_steps || tracker.wanted().is_some_and(|reaction| reaction > Reaction::Warn)
        };
        let looked_at = |trigger: Trigger| POSITION_IN_DOUBT.contains(&trigger) || trigger == Trigger::Energy;
        self.trackers
            .iter()
            .filter(|(trigger, tracker)| looked_at(*trigger) && tracker.is_raised() && acts(*trigger, tracker))
            .filter(|(trigger, _)| settings.mode(*trigger) == TriggerMode::React)
            .map(|(trigger, tracker)| {
                let (value, limit, unit) = tracker.figures();
                format!(
                    "{} ({value:.2} {unit}, limit {limit:.2} {unit})",
                    words::title(*trigger)
                )
            })
            .collect()
    }

    /// The vehicle is taken up again: what was in force ends. Nothing happens if nothing was.
    ///
    /// # Errors
    /// [`Refusal::NotPermitted`] when the coordinator may not: a trigger lasts, or more than a hold is in force.
    pub fn take_up(&mut self, by: TakenUpBy) -> Result<Option<FailsafeEvent>, Refusal> {
        let Some(order) = self.order else {
            return Ok(None);
        };
        if by == TakenUpBy::Coordinator && (!order.recovered || order.reaction != Reaction::Hold) {
            let lasts = if order.recovered { "" } else { ", which lasts" };
            let what = words::title(order.trigger);
            let detail = format!(
                "{} is in force ({what}{lasts}): an operator must end it",
                order.reaction
            );
            return Err(Refusal::NotPermitted { detail });
        }
        for (_, tracker) in &mut self.trackers {
            tracker.overrule();
        }
        self.order = None;
        self.ineffective_since = None;
        let who = match by {
            TakenUpBy::Operator => "an operator took the vehicle up again",
            TakenUpBy::Coordinator => "the coordinator took the vehicle up again",
        };
        Ok(Some(self.about_order(FailsafeEventKind::TakenUp, &order, who)))
    }

    /// Gives the order that is due, if any, and watches the one in force.
    pub(super) fn give_orders(
        &mut self,
        health: &Health,
        settings: &FailsafeSettings,
        events: &mut Vec<FailsafeEvent>,
    ) {
        let in_force = self.order.map_or(Reaction::Warn, |o| o.reaction);
        let demanded = self.demand(settings);
        if let Some(order) = &mut self.order {
            order.recovered = demanded.is_none();
        }
        if self.reacting_since.is_none() {
            return;
        }
        let trusts_gnss = self.trusts_gnss();
        let means = Means::of(health, trusts_gnss);
        let is_due = |reaction: Reaction| reaction > in_force && !(health.lands && calls_back(reaction));
        if let Some((trigger, reaction)) = demanded.filter(|(_, reaction)| is_due(*reaction)) {
            let feasible = effect::feasible(reaction, means);
            let why = if feasible == reaction {
                format!("{}: {reaction}", words::title(trigger))
            } else {
                format!("{}: {reaction} is not possible, {feasible}", words::title(trigger))
            };
            self.order_now(feasible, trigger, why, settings, events);
            return;
        }
        // A way home that is not found any more: the return becomes a landing. Whether it is paid for, the energy trigger says in its
        // time; and whoever loses his position is brought down by the autopilot itself.
        let finds_home = trusts_gnss && health.home_known;
        if let Some(order) = self.order.filter(|o| !o.recovered && o.reaction == Reaction::Return)
            && !finds_home
        {
            let why = "the way home is not found any more: land".to_owned();
            self.order_now(Reaction::Land, order.trigger, why, settings, events);
            return;
        }
        self.watch_effect(health, means, settings, events);
    }

    /// The strongest reaction that a trigger asks for, of those that are to be carried out.
    fn demand(&self, settings: &FailsafeSettings) -> Option<(Trigger, Reaction)> {
        self.trackers
            .iter()
            .filter(|(trigger, _)| settings.mode(*trigger) == TriggerMode::React)
            .map(|(trigger, tracker)| (*trigger, tracker.demand()))
            .filter(|(_, reaction)| *reaction > Reaction::Warn)
            // Of equals the first of the written table.
            .fold(None, |best, found| match best {
                Some((_, strongest)) if strongest >= found.1 => best,
                _ => Some(found),
            })
    }

    /// Whether the way home by satellite can be relied on. Doubts count from the step at which they lead to a reaction.
    fn trusts_gnss(&self) -> bool {
        self.trackers
            .iter()
            .filter(|(trigger, _)| matches!(trigger, Trigger::GnssLoss | Trigger::GnssDisagreement))
            .all(|(_, tracker)| tracker.stand().is_none_or(|s| s.reaction < Reaction::Hold))
    }

    fn order_now(
        &mut self,
        reaction: Reaction,
        trigger: Trigger,
        why: String,
        settings: &FailsafeSettings,
        events: &mut Vec<FailsafeEvent>,
    ) {
        self.order = Some(Order {
            reaction,
            trigger,
            ordered_at: self.now,
            effective_at: None,
            recovered: false,
        });
        self.ineffective_since = Some(self.now);
        let found = self.trackers.iter().find(|(t, _)| *t == trigger);
        let Some((_, tracker)) = found else { return };
        let alarm = self.alarm(trigger, tracker, settings);
        events.push(FailsafeEvent {
            kind: FailsafeEventKind::Ordered,
            trigger,
            value: alarm.value,
            limit: alarm.limit,
            unit: alarm.unit,
            since: alarm.since,
            at: self.now,
            reaction,
            report_only: None,
            reason: why,
        });
    }

    /// Whether the order in force is carried out; if not within its bound, the next stronger.
    fn watch_effect(
        &mut self,
        health: &Health,
        means: Means,
        settings: &FailsafeSettings,
        events: &mut Vec<FailsafeEvent>,
    ) {
        // What is over and was carried out is not enforced any more: somebody will take the vehicle up.
        let is_done = |o: &Order| o.recovered && o.effective_at.is_some();
        let Some(mut order) = self.order.filter(|o| !is_done(o)) else {
            return;
        };
        if effect::is_effective(order.reaction, health) {
            self.ineffective_since = None;
            if order.effective_at.is_none() {
                order.effective_at = Some(self.now);
                self.order = Some(order);
                let took_s = self.now.seconds_since(order.ordered_at);
                let why = format!("{} takes effect after {took_s:.2} s", order.reaction);
                let mut event = self.about_order(FailsafeEventKind::Effective, &order, &why);
                (event.value, event.limit) = (took_s, settings.reaction_within_s);
                events.push(event);
            }
            return;
        }
        let since = *self.ineffective_since.get_or_insert(self.now);
        let for_s = self.now.seconds_since(since);
        if for_s < settings.reaction_within_s {
            return;
        }
        let why = format!("{} is not seen to take effect after {for_s:.1} s", order.reaction);
        let mut event = self.about_order(FailsafeEventKind::Ineffective, &order, &why);
        (event.value, event.limit) = (for_s, settings.reaction_within_s);
        events.push(event);
        let next = effect::next_after(order.reaction, means);
        let why = format!("{} had no effect: {next}", order.reaction);
        self.order_now(next, order.trigger, why, settings, events);
    }

    /// An event about the order in force rather than about a trigger's value: the value is the time since it was ordered.
    pub(super) fn about_order(&self, kind: FailsafeEventKind, order: &Order, why: &str) -> FailsafeEvent {
        FailsafeEvent {
            kind,
            trigger: order.trigger,
            value: self.now.seconds_since(order.ordered_at),
            limit: 0.0,
            unit: "s".to_owned(),
            since: order.ordered_at,
            at: self.now,
            reaction: order.reaction,
            report_only: None,
            reason: why.to_owned(),
        }
    }
}
