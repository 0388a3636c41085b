//! A bag of ROS 2: a folder with an MCAP file of CDR messages and `metadata.yaml`, as `ros2 bag` writes and plays it. Topics and frames are
//! called as the node itself calls them in ROS 2 (`core/ros2`).
//!
//! Must never do: tell a message in another layout than its definition has; what is not known has the value that the definition says.

mod bag;
mod translate;

use crate::told::{Kind, Told, each};
use crate::{ExportError, Exported, Progress, target};
use bag::Bag;
use skein_domain::{Geodetic, SwarmFrame, VehicleId};
use skein_recording::{Recording, Topic, VehicleTelemetry};
use skein_ros2_messages::interfaces::geometry::TFMessage;
use skein_ros2_messages::names::Names;
use skein_view::FleetSnapshot;
use std::collections::BTreeMap;
use std::path::Path;

/// Where log lines go.
const LOG: &str = "/rosout";
/// Where transforms go.
const TF: &str = "/tf";

/// Writes a recording as a bag.
pub fn write(recording: &Recording, out: &Path, progress: Progress<'_>) -> Result<Exported, ExportError> {
    let folder = target::folder(out)?;
    let mut writer = Writer {
        bag: Bag::create(&folder)?,
        names: Names::default(),
        homes: BTreeMap::new(),
        frame: None,
        transforms: None,
    };
    let wants = |topic: &Topic| {
        matches!(
            topic,
            Topic::Telemetry(_) | Topic::Setpoint(_) | Topic::Events | Topic::Fleet
        )
    };
    let unread = each(recording, wants, progress, |told| writer.take(told))?;
    writer.tell_transforms()?;
    let mut exported = writer.bag.finish()?;
    exported.files.sort();
    Ok(exported.without(unread))
}

struct Writer {
    bag: Bag,
    names: Names,
    homes: BTreeMap<VehicleId, Geodetic>,
    frame: Option<SwarmFrame>,
    /// Those of one moment, of all vehicles: who begins to read in the middle of a bag takes the last message alone.
    transforms: Option<(Told, TFMessage)>,
}

impl Writer {
    /// What a vehicle is called; before anything told its name, by its number.
    fn name(&mut self, vehicle: VehicleId) -> String {
        self.names.of(vehicle, "")
    }

    fn take(&mut self, told: &Told) -> Result<(), ExportError> {
        if self.transforms.as_ref().is_some_and(|(of, _)| of.at_ns != told.at_ns) {
            self.tell_transforms()?;
        }
        match &told.kind {
            Kind::Fleet(fleet) => {
                self.fleet(fleet, told.node.is_none());
                Ok(())
            }
            Kind::Telemetry(telemetry) => self.telemetry(told, telemetry),
            Kind::Setpoint(setpoint) => {
                let Some(flown) = setpoint.flown else {
                    return Ok(());
                };
                let name = self.name(setpoint.vehicle);
                match translate::setpoint(told, &flown) {
                    Some(message) => self.bag.write(&topic(&name, "setpoint"), told, &message),
                    None => Ok(()),
                }
            }
            Kind::Event(event) => {
                let name = event.vehicle.map(|vehicle| self.name(vehicle));
                self.bag.write(LOG, told, &translate::log(told, event, name.as_deref()))
            }
        }
    }

    fn tell_transforms(&mut self) -> Result<(), ExportError> {
        self.transforms
            .take()
            .map_or(Ok(()), |(told, transforms)| self.bag.write(TF, &told, &transforms))
    }

    /// What is known of vehicles beside their telemetry. The frame is that of the node of the file.
    fn fleet(&mut self, fleet: &FleetSnapshot, own: bool) {
        if own {
            self.frame = fleet.frame.or(self.frame);
        }
        for vehicle in &fleet.vehicles {
            self.names.of(vehicle.id, &vehicle.name);
            if let Some(home) = vehicle.home.filter(Geodetic::is_valid) {
                self.homes.insert(vehicle.id, home);
            }
        }
    }

    fn telemetry(&mut self, told: &Told, of: &VehicleTelemetry) -> Result<(), ExportError> {
        let name = self.name(of.vehicle);
        if let Some(moves) = &of.kinematics {
            let stamp_ns = told.moment_ns(of.time, moves.measured);
            let pose = translate::pose(stamp_ns, of, moves);
            self.bag.write(&topic(&name, "pose"), told, &pose)?;
            let twist = translate::twist(stamp_ns, moves);
            self.bag.write(&topic(&name, "velocity"), told, &twist)?;
            let home = self.homes.get(&of.vehicle);
            let origin = self.frame.zip(home).map(|(frame, home)| frame.position(home));
            let transforms = translate::transforms(&pose, &moves.position, &name, &origin.unwrap_or_default());
            let (_, all) = self
                .transforms
                .get_or_insert_with(|| (told.clone(), TFMessage::default()));
            all.transforms.extend(transforms);
        }
        if let Some(fix) = translate::fix(told.at_ns, of, &name) {
            self.bag.write(&topic(&name, "nav_sat_fix"), told, &fix)?;
        }
        let battery = translate::battery(told.at_ns, of, &name);
        self.bag.write(&topic(&name, "battery"), told, &battery)
    }
}

fn topic(vehicle: &str, part: &str) -> String {
    format!("/skein/{vehicle}/{part}")
}
