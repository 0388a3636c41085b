//! Which services there are, and what each asks of the node.
//!
//! Must never do: decide whether something may be done.

use super::answer;
use crate::endpoints::Place;
use crate::interfaces::skein::{
    CommandOutcome, Follow, FormationOutcome, GoTo, PointGimbal, PointGimbalRequest, SetFormation, TakeOff,
};
use crate::interfaces::standard::{Outcome, SetBool, Trigger};
use crate::{Ros2Error, Tasks, names, requests};
use skein_domain::payload::PayloadKind;
use skein_domain::{FormationRequest, Refusal, VehicleCommand, VehicleId};
use skein_runtime::{NodeHandle, Targets};
use skein_view::CommandReceipt;

/// The services of one vehicle, answered by tasks that end with it.
///
/// # Errors
/// When DDS refuses one.
pub fn of_vehicle(
    place: &mut Place,
    node: &NodeHandle,
    id: VehicleId,
    name: &str,
    tasks: &mut Tasks,
) -> Result<(), Ros2Error> {
    let height_m = node.config().ros2.take_off_height_m;
    let triggers = [
        ("take_off", VehicleCommand::TakeOff { height_m }),
        ("land", VehicleCommand::Land),
        ("hold", VehicleCommand::Hold),
        ("return_home", VehicleCommand::Return),
    ];
    for (service, command) in triggers {
        let (server, handle) = (place.server::<Trigger>(service)?, node.clone());
        tasks.add(answer::<Trigger>(
            node.clone(),
            server,
            what(name, service),
            async move |_| give(&handle, one(id), command).await,
        ));
    }
    let (server, handle) = (place.server::<SetBool>("arm")?, node.clone());
    tasks.add(answer::<SetBool>(
        node.clone(),
        server,
        what(name, "arm"),
        async move |request| {
            let command = if request.data {
                VehicleCommand::Arm
            } else {
                VehicleCommand::Disarm
            };
            give(&handle, one(id), command).await
        },
    ));
    let (server, handle) = (place.server::<TakeOff>("take_off_to")?, node.clone());
    tasks.add(answer::<TakeOff>(
        node.clone(),
        server,
        what(name, "take_off_to"),
        async move |request| command(&handle, id, requests::take_off(&request)).await,
    ));
    let (server, handle) = (place.server::<GoTo>("go_to")?, node.clone());
    tasks.add(answer::<GoTo>(
        node.clone(),
        server,
        what(name, "go_to"),
        async move |request| command(&handle, id, requests::go_to(&request)).await,
    ));
    let (server, handle) = (place.server::<PointGimbal>("point_gimbal")?, node.clone());
    let base_link = names::base_link(name);
    tasks.add(answer::<PointGimbal>(
        node.clone(),
        server,
        what(name, "point_gimbal"),
        async move |request| point_gimbal(&handle, id, &base_link, &request).await,
    ));
    Ok(())
}

/// The services of the swarm.
///
/// # Errors
/// When DDS refuses one.
pub fn of_swarm(place: &mut Place, node: &NodeHandle, tasks: &mut Tasks) -> Result<(), Ros2Error> {
    let height_m = node.config().ros2.take_off_height_m;
    let triggers = [
        ("take_off", VehicleCommand::TakeOff { height_m }),
        ("land", VehicleCommand::Land),
        ("hold", VehicleCommand::Hold),
        ("return_home", VehicleCommand::Return),
    ];
    for (service, command) in triggers {
        let (server, handle) = (place.server::<Trigger>(service)?, node.clone());
        tasks.add(answer::<Trigger>(
            node.clone(),
            server,
            what("swarm", service),
            async move |_| give(&handle, Targets::All, command).await,
        ));
    }
    let (server, handle) = (place.server::<Trigger>("dissolve_formation")?, node.clone());
    tasks.add(answer::<Trigger>(
        node.clone(),
        server,
        what("swarm", "dissolve_formation"),
        async move |_| outcome(handle.dissolve_formation().await),
    ));
    let (server, handle) = (place.server::<SetFormation>("set_formation")?, node.clone());
    tasks.add(answer::<SetFormation>(
        node.clone(),
        server,
        what("swarm", "set_formation"),
        async move |request| form(&handle, requests::formation(&request)).await,
    ));
    let (server, handle) = (place.server::<Follow>("follow")?, node.clone());
    tasks.add(answer::<Follow>(
        node.clone(),
        server,
        what("swarm", "follow"),
        async move |request| form(&handle, requests::follow(&request)).await,
    ));
    Ok(())
}

fn what(of: &str, service: &str) -> String {
    format!("{of}/{service}")
}

fn one(id: VehicleId) -> Targets {
    Targets::Vehicles(vec![id])
}

/// Whether all took it up; else each one's reason with its number.
async fn give(node: &NodeHandle, targets: Targets, command: VehicleCommand) -> Outcome {
    let receipts = node.command(&targets, command).await;
    if receipts.is_empty() {
        return outcome(Err(Refusal::NotEnoughVehicles { have: 0, need: 1 }));
    }
    let refusals: Vec<_> = receipts
        .iter()
        .filter_map(|r| Some((r.vehicle, r.refusal.as_ref()?)))
        .collect();
    match (targets, refusals.as_slice()) {
        (_, []) => outcome(Ok(())),
        (Targets::Vehicles(_), [(_, refusal), ..]) => outcome(Err((*refusal).clone())),
        (Targets::All, refusals) => Outcome {
            success: false,
            message: refusals
                .iter()
                .map(|(vehicle, refusal)| format!("vehicle {vehicle}: {}: {refusal}", refusal.code()))
                .collect::<Vec<_>>()
                .join("; "),
        },
    }
}

fn outcome(result: Result<(), Refusal>) -> Outcome {
    match result {
        Ok(()) => Outcome {
            success: true,
            message: String::new(),
        },
        Err(refusal) => Outcome {
            success: false,
            message: format!("{}: {refusal}", refusal.code()),
        },
    }
}

async fn command(node: &NodeHandle, id: VehicleId, command: Result<VehicleCommand, Refusal>) -> CommandOutcome {
    match command {
        Err(refusal) => refused(&refusal),
        Ok(command) => match node.command(&one(id), command).await.pop() {
            Some(receipt) => taken(receipt),
            None => refused(&Refusal::UnknownVehicle { vehicle: id }),
        },
    }
}

fn taken(receipt: CommandReceipt) -> CommandOutcome {
    match receipt.refusal {
        Some(refusal) => CommandOutcome {
            command: receipt.id.0,
            ..refused(&refusal)
        },
        None => CommandOutcome {
            success: true,
            command: receipt.id.0,
            ..CommandOutcome::default()
        },
    }
}

fn refused(refusal: &Refusal) -> CommandOutcome {
    CommandOutcome {
        success: false,
        code: refusal.code().to_owned(),
        message: refusal.to_string(),
        command: 0,
    }
}

async fn point_gimbal(
    node: &NodeHandle,
    id: VehicleId,
    base_link: &str,
    request: &PointGimbalRequest,
) -> CommandOutcome {
    let command = match requests::point_gimbal(request, base_link) {
        Ok(command) => command,
        Err(refusal) => return refused(&refusal),
    };
    let picture = node.snapshot();
    let vehicle = picture.vehicles.iter().find(|vehicle| vehicle.id == id);
    let mut gimbals = vehicle
        .iter()
        .flat_map(|v| &v.payloads)
        .filter(|p| p.kind == PayloadKind::Gimbal);
    let gimbal = gimbals.find(|gimbal| request.gimbal.is_empty() || gimbal.name == request.gimbal);
    let Some(gimbal) = gimbal else {
        return refused(&Refusal::UnknownPayload {
            vehicle: id,
            payload: request.gimbal.clone(),
        });
    };
    match serde_json::to_value(command) {
        Ok(command) => taken(node.command_payload(id, &gimbal.name, &command).await),
        Err(error) => refused(&Refusal::invalid(error.to_string())),
    }
}

async fn form(node: &NodeHandle, request: Result<FormationRequest, Refusal>) -> FormationOutcome {
    let receipt = match request {
        Ok(request) => node.set_formation(request).await,
        Err(refusal) => Err(refusal),
    };
    match receipt {
        Err(refusal) => requests::refused_formation(&refusal),
        Ok(receipt) => FormationOutcome {
            success: true,
            code: String::new(),
            message: String::new(),
            has_leader: receipt.leader.is_some(),
            leader: receipt.leader.map_or(0, |leader| leader.0),
            members: receipt.members.iter().map(|member| member.0).collect(),
            duration_s: receipt.duration_s,
            planned_min_distance_m: receipt.planned_min_distance_m.unwrap_or(f64::INFINITY),
        },
    }
}
