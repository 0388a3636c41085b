//! Control: which operator's console has control authority over which vehicles, at this node and, as the others tell, in the whole swarm.
//!
//! Must never do: keep anybody from stopping, holding or bringing down a vehicle.

use super::{NodeHandle, Targets};
use serde::{Deserialize, Serialize};
use skein_domain::control::{Console, VehicleControl};
use skein_domain::exchange::Severity;
use skein_domain::{Refusal, VehicleId};
use skein_view::EventKind;

/// What a console wants with vehicles.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "action", rename_all = "snake_case", deny_unknown_fields)]
pub enum ControlAction {
    /// To take control authority over them, if nobody has it, or who has it is not heard any more.
    Take,
    /// To ask who has them. Taken at once if nobody has them.
    Request,
    /// To let them go.
    Release,
    /// To give them to a console that asks for them.
    HandOver {
        /// Its id.
        to: String,
    },
}

/// What came of it at one vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct ControlReceipt {
    /// The vehicle.
    pub vehicle: VehicleId,
    /// Why not, if so.
    pub refusal: Option<Refusal>,
}

impl NodeHandle {
    /// Who has control authority over which vehicles, by ascending id; nobody has it over the others.
    #[must_use]
    pub fn control(&self) -> Vec<VehicleControl> {
        self.shared.operators.control().picture(self.now())
    }

    /// The name of a console that has control authority over a vehicle.
    #[must_use]
    pub fn console_name(&self, console: &str) -> Option<String> {
        let control = self.shared.operators.control();
        let mut holders = control.entries().keys().filter_map(|vehicle| control.holder(*vehicle));
        let named = holders.find(|holder| holder.id == console);
        named.map(|holder| holder.name.clone())
    }

    /// A console gives a sign of life.
    pub fn hear_console(&self, console: &str) {
        self.shared.operators.change_control().hear(console, self.now());
    }

    /// A console takes, asks for, hands over or lets go vehicles.
    ///
    /// # Errors
    /// For a console that cannot be told from others, or shown.
    pub fn change_control(
        &self,
        targets: &Targets,
        console: &Console,
        action: &ControlAction,
    ) -> Result<Vec<ControlReceipt>, Refusal> {
        if !console.is_sound() {
            return Err(Refusal::invalid(
                "a console has an id and a name of 1 to 64 characters each",
            ));
        }
        let ids = match targets {
            Targets::All => self.shared.vehicle_ids(),
            Targets::Vehicles(ids) => ids.clone(),
        };
        let receipts = ids.into_iter().map(|vehicle| ControlReceipt {
            vehicle,
            refusal: self.change_one(vehicle, console, action).err(),
        });
        Ok(receipts.collect())
    }

    fn change_one(&self, vehicle: VehicleId, console: &Console, action: &ControlAction) -> Result<(), Refusal> {
        if !self.shared.vehicle_ids().contains(&vehicle) {
            return Err(Refusal::UnknownVehicle { vehicle });
        }
        let now = self.now();
        let (before, after) = {
            let mut table = self.shared.operators.change_control();
            let before = table.holder(vehicle).map(|holder| holder.name.clone());
            match action {
                ControlAction::Take => table.take(vehicle, console, now),
                ControlAction::Request => table.request(vehicle, console, now),
                ControlAction::Release => table.release(vehicle, &console.id, now),
                ControlAction::HandOver { to } => table.hand_over(vehicle, &console.id, to, now),
            }?;
            (before, table.holder(vehicle).map(|holder| holder.name.clone()))
        };
        let text = match (&before, &after) {
            (before, after) if before == after && *action == ControlAction::Request => {
                format!("{} asks for it", console.name)
            }
            (before, after) if before == after => return Ok(()),
            (_, Some(name)) => format!("under the control of {name}"),
            (Some(name), None) => format!("{name} has let it go"),
            (None, None) => return Ok(()),
        };
        self.shared
            .events
            .record(now, Some(vehicle), Severity::Info, EventKind::Notice, text);
        Ok(())
    }

    /// Whether a console (none: a program that says of itself nothing) may command these vehicles.
    ///
    /// # Errors
    /// The first of them over which another one has control authority.
    pub fn may_command(&self, console: Option<&str>, vehicles: &[VehicleId]) -> Result<(), Refusal> {
        let (table, now) = (self.shared.operators.control(), self.shared.now());
        vehicles
            .iter()
            .try_for_each(|vehicle| table.may(*vehicle, console, now))
    }
}
