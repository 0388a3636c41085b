//! Commands to vehicles, whichever node of the swarm flies them: what is to be flown is worked out here, where it is asked; each node
//! carries out what is for its own.
//!
//! Must never do: let the answer of one vehicle delay the stop of another.

use super::{ANSWER_WITHIN, NodeHandle, Targets};
use ractor::rpc::CallResult;
use skein_coordination::returns;
use skein_coordination::ways;
use skein_domain::{CommandId, NodeId, Refusal, VehicleCommand, VehicleId};
use skein_safety::control::is_for_everybody;
use skein_state::SharedState;
use skein_state::VehicleMessage;
use skein_state::asks::{Answer, Ask, Order};
use skein_view::CommandReceipt;
use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

/// Longest wait for another node's receipts: as long as its own actors may take, and the way there and back.
const NODE_ANSWERS_WITHIN: Duration = Duration::from_secs(5);

impl NodeHandle {
    /// Gives a command to vehicles; each answers for itself. A take-off of several is staggered.
    pub async fn command(&self, targets: &Targets, command: VehicleCommand) -> Vec<CommandReceipt> {
        self.command_from(None, targets, command).await
    }

    /// As [`Self::command`], from a console: a vehicle over which another one has control authority refuses, unless the command stops it.
    pub async fn command_from(
        &self,
        console: Option<&str>,
        targets: &Targets,
        command: VehicleCommand,
    ) -> Vec<CommandReceipt> {
        let ids: Vec<VehicleId> = match targets {
            Targets::All => self.shared.vehicle_ids(),
            Targets::Vehicles(ids) => ids.clone(),
        };
        let may = |id: &VehicleId| match is_for_everybody(&command) {
            true => Ok(()),
            false => self.may_command(console, &[*id]),
        };
        let (mut mine, mut controlled_by_others) = (Vec::with_capacity(ids.len()), Vec::new());
        for id in &ids {
            match may(id) {
                Ok(()) => mine.push(*id),
                Err(refusal) => controlled_by_others.push(self.refused(*id, refusal)),
            }
        }
        let (orders, mut receipts) = self.orders(&mine, command);
        receipts.append(&mut controlled_by_others);
        let (mut own, mut others): (Vec<Order>, BTreeMap<NodeId, Vec<Order>>) = (Vec::new(), BTreeMap::new());
        for order in orders {
            match self.shared.host(order.vehicle) {
                Some(node) => others.entry(node).or_default().push(order),
                None => own.push(order),
            }
        }
        let asked: Vec<_> = others
            .into_iter()
            .map(|(node, orders)| {
                let handle = self.clone();
                tokio::spawn(async move { handle.command_elsewhere(node, orders).await })
            })
            .collect();
        receipts.extend(self.carry_out(own).await);
        for answer in asked {
            receipts.extend(answer.await.unwrap_or_default());
        }
        // In the order in which they were named.
        let place = |receipt: &CommandReceipt| ids.iter().position(|id| *id == receipt.vehicle);
        receipts.sort_by_key(place);
        receipts
    }

    /// Commands this node's own vehicles once more, whoever has control authority over them.
    pub(crate) async fn command_again(&self, ids: &[VehicleId], command: VehicleCommand) {
        let (orders, _) = self.orders(ids, command);
        self.carry_out(orders).await;
    }

    /// What is to be flown for a command, or why it cannot be.
    fn orders(&self, ids: &[VehicleId], command: VehicleCommand) -> (Vec<Order>, Vec<CommandReceipt>) {
        let stagger_s = match command {
            VehicleCommand::TakeOff { .. } => self.shared.config.coordinator.take_off_stagger_s,
            _ => 0.0,
        };
        let mut legs = match command {
            VehicleCommand::Return if ids.len() > 1 => {
                let (gate, peers) = (self.shared.gate(), self.shared.peers());
                returns::legs(&gate, &peers, &self.shared.config.safety.returning, ids)
            }
            _ => BTreeMap::new(),
        };
        let traceparent = skein_telemetry::traceparent();
        let (mut orders, mut receipts) = (Vec::new(), Vec::new());
        for (i, id) in ids.iter().enumerate() {
            match legs_of(&self.shared, *id, &command, legs.remove(id).unwrap_or_default()) {
                Ok(legs) => orders.push(Order {
                    vehicle: *id,
                    command,
                    legs,
                    delay_s: stagger_s * i as f64,
                    by_operator: true,
                    traceparent: traceparent.clone(),
                }),
                Err(refusal) => receipts.push(self.refused(*id, refusal)),
            }
        }
        (orders, receipts)
    }

    fn refused(&self, vehicle: VehicleId, refusal: Refusal) -> CommandReceipt {
        CommandReceipt {
            vehicle,
            id: self.shared.next_command_id(),
            refusal: Some(refusal),
        }
    }

    /// Has another node carry out what is for its vehicles.
    async fn command_elsewhere(&self, node: NodeId, orders: Vec<Order>) -> Vec<CommandReceipt> {
        let ids: Vec<VehicleId> = orders.iter().map(|order| order.vehicle).collect();
        if self.shared.coordinates()
            && let Some(command) = orders.first().map(|order| order.command)
        {
            // So that no regrouping comes between; the node that flies them says the same from now on.
            self.withdraw(&ids, &command);
        }
        match self.ask(node, Ask::Orders(orders), NODE_ANSWERS_WITHIN).await {
            Ok(Answer::Receipts(receipts)) => receipts,
            Ok(_) => Vec::new(),
            Err(refusal) => ids.iter().map(|id| self.refused(*id, refusal.clone())).collect(),
        }
    }

    /// Carries out what is for this node's own vehicles.
    pub(crate) async fn carry_out(&self, orders: Vec<Order>) -> Vec<CommandReceipt> {
        let ids: Vec<VehicleId> = orders.iter().map(|order| order.vehicle).collect();
        if let Some(command) = orders.first().map(|order| order.command) {
            self.withdraw(&ids, &command);
        }
        let asked: Vec<_> = orders
            .into_iter()
            .map(|order| {
                let handle = self.clone();
                // All at once: a slow answer of one must not delay the stop of another.
                tokio::spawn(async move { handle.command_one(order).await })
            })
            .collect();
        let mut receipts = Vec::with_capacity(asked.len());
        for (vehicle, answer) in ids.into_iter().zip(asked) {
            receipts.push(answer.await.unwrap_or_else(|_| CommandReceipt {
                vehicle,
                id: CommandId(0),
                refusal: Some(Refusal::not_running(format!("actor of vehicle {vehicle}"))),
            }));
        }
        // Who did not take the command up goes on as before; the coordinator takes it back in.
        let refused = receipts.iter().filter(|r| r.refusal.is_some()).map(|r| r.vehicle);
        self.shared.vehicles.call_back(&refused.collect::<Vec<_>>());
        receipts
    }

    /// A command that moves or stops a vehicle by itself takes it out of the formation, and all its targets at once: a regrouping of
    /// the rest must call none of them back. A take-off makes it a newcomer again.
    fn withdraw(&self, ids: &[VehicleId], command: &VehicleCommand) {
        match command {
            // Who leads and is steered stays in the formation; of others the vehicle's actor says that they have left it.
            VehicleCommand::Steer
            | VehicleCommand::Arm
            | VehicleCommand::Disarm
            | VehicleCommand::LookAt { .. }
            | VehicleCommand::StopObserving => {}
            VehicleCommand::TakeOff { .. } => drop(self.shared.vehicles.call_back(ids)),
            VehicleCommand::Land
            | VehicleCommand::LandAt { .. }
            | VehicleCommand::Hold
            | VehicleCommand::Return
            | VehicleCommand::Observe { .. }
            | VehicleCommand::GoTo { .. } => {
                for id in ids {
                    match self.shared.vehicles.record(*id) {
                        Some(record) => drop(self.shared.vehicles.withdraw(&record)),
                        None => drop(self.shared.vehicles.leave_out(*id)),
                    }
                }
            }
        }
    }

    async fn command_one(&self, order: Order) -> CommandReceipt {
        let Order {
            vehicle,
            command,
            legs,
            delay_s,
            by_operator,
            traceparent,
        } = order;
        let not_before = self.shared.now().plus_seconds(delay_s);
        let id = self.shared.next_command_id();
        let refused = |refusal| CommandReceipt {
            vehicle,
            id,
            refusal: Some(refusal),
        };
        let Some(record) = self.shared.vehicles.record(vehicle) else {
            return refused(Refusal::UnknownVehicle { vehicle });
        };
        let not_running = Refusal::not_running(format!("actor of vehicle {vehicle}"));
        let Some(actor) = record.actor.get() else {
            return refused(not_running);
        };
        let span = tracing::debug_span!(
            "command",
            otel.name = format!("command {}", command.name()),
            otel.status_code = tracing::field::Empty,
            vehicle = vehicle.0,
            command_id = id.0,
            outcome = tracing::field::Empty,
        );
        skein_telemetry::follow(&span, traceparent.as_deref());
        record.commanded.trace(id, span);
        let message = |reply| VehicleMessage::Command {
            id,
            command,
            legs,
            not_before,
            reply,
        };
        if !by_operator {
            return match actor.cast(message(None)) {
                Ok(()) => CommandReceipt {
                    vehicle,
                    id,
                    refusal: None,
                },
                Err(_) => refused(not_running),
            };
        }
        match actor.call(|reply| message(Some(reply)), Some(ANSWER_WITHIN)).await {
            Ok(CallResult::Success(receipt)) => receipt,
            Ok(CallResult::Timeout) => refused(Refusal::timed_out(
                format!("the actor of vehicle {vehicle}"),
                ANSWER_WITHIN.as_secs_f64(),
            )),
            _ => refused(not_running),
        }
    }
}

/// How a command is flown: along the legs that were worked out for several at once, or around what is closed.
fn legs_of(
    shared: &SharedState,
    vehicle: VehicleId,
    command: &VehicleCommand,
    legs: VecDeque<VehicleCommand>,
) -> Result<VecDeque<VehicleCommand>, Refusal> {
    match ways::legs(shared.gate().fences(), &shared.peers(), vehicle, command) {
        Ok(around) if legs.is_empty() => Ok(around),
        Ok(_) => Ok(legs),
        // A return that finds no way is better begun than not; the gate stops it where it must.
        Err(_) if *command == VehicleCommand::Return => Ok(legs),
        Err(refusal) => Err(refusal),
    }
}
