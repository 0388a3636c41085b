//! Two operators at two nodes of one swarm: who has control authority over a vehicle is known at both, and given on, and never stands in the way of a stop.

use skein_domain::control::{Console, VehicleControl};
use skein_domain::{PositionNed, Refusal, VehicleCommand, VehicleId};
use skein_runtime::{ControlAction, NodeHandle, Targets};
use skein_testkit::{Flock, Member, eventually, patience};
use skein_view::FleetSnapshot;
use std::time::Duration;

const TWO: VehicleId = VehicleId(2);
/// The page of each operator says so often that it is there.
const ALIVE_EVERY: Duration = Duration::from_secs(1);
/// A console that says nothing is relieved after ten seconds.
const RELIEVED_WITHIN: Duration = Duration::from_secs(20);

fn console(name: &str) -> Console {
    Console {
        id: name.to_lowercase(),
        name: name.to_owned(),
    }
}

/// An operator's page: it is there until this is dropped.
struct Page(tokio::task::JoinHandle<()>);

impl Page {
    fn open(at: NodeHandle, console: &Console) -> Self {
        let id = console.id.clone();
        Self(tokio::spawn(async move {
            loop {
                at.hear_console(&id);
                tokio::time::sleep(ALIVE_EVERY).await;
            }
        }))
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        self.0.abort();
    }
}

fn change(at: &NodeHandle, console: &Console, action: &ControlAction) -> Option<Refusal> {
    let receipts = at
        .change_control(&Targets::Vehicles(vec![TWO]), console, action)
        .expect("a sound console");
    receipts.into_iter().next().expect("one vehicle").refusal
}

/// What a console is told when it wants to fly the vehicle somewhere.
async fn fly(at: &NodeHandle, console: &Console) -> Option<Refusal> {
    let command = VehicleCommand::GoTo {
        position: PositionNed::new(10.0, 0.0, -10.0),
        yaw_rad: None,
        speed_m_s: None,
    };
    let targets = Targets::Vehicles(vec![TWO]);
    let receipts = at.command_from(Some(&console.id), &targets, command).await;
    receipts.into_iter().next().expect("one vehicle").refusal
}

/// Waits until a node knows it so.
async fn known(at: &NodeHandle, what: &str, extra: Duration, wanted: impl Fn(&VehicleControl) -> bool) {
    eventually(patience() + extra, what, async || {
        at.control().iter().any(&wanted).then_some(())
    })
    .await;
}

/// Whether it was refused because another operator has control authority.
fn is_for_control(refusal: Option<&Refusal>) -> bool {
    matches!(refusal, Some(Refusal::NoControlAuthority { .. }))
}

#[tokio::test(flavor = "multi_thread")]
async fn two_operators_at_two_nodes_have_control_authority() {
    let folder = tempfile::tempdir().expect("a folder");
    let members = [1, 2].map(|node| Member {
        node,
        priority: Some(node),
        flies: true,
    });
    let flock = Flock::start(&members, folder.path().to_owned(), |_| ()).await;
    for node in [1, 2] {
        let both = |fleet: &FleetSnapshot| fleet.vehicles.len() == 2;
        flock.until(node, "both vehicles", Duration::from_secs(10), both).await;
    }
    let (anna, ben) = (console("Anna"), console("Ben"));
    let (annas, bens) = (flock.node(1), flock.node(2));
    let page_of_anna = Page::open(annas.clone(), &anna);
    let _page_of_ben = Page::open(bens.clone(), &ben);

    // Under nobody's control: what is wrong with the command is something else.
    assert!(!is_for_control(fly(&bens, &ben).await.as_ref()));
    assert_eq!(change(&annas, &anna, &ControlAction::Take), None);
    known(&bens, "Ben sees that Anna has it", Duration::ZERO, |control| {
        control.vehicle == TWO && control.console == anna && control.is_heard
    })
    .await;

    // The node that flies it is Ben's, and refuses him all the same.
    let under_annas_control = Some(Refusal::NoControlAuthority {
        vehicle: TWO,
        holder: anna.name.clone(),
    });
    assert_eq!(fly(&bens, &ben).await, under_annas_control);
    assert_eq!(change(&bens, &ben, &ControlAction::Take), under_annas_control);
    let stops = [VehicleCommand::Hold, VehicleCommand::Land, VehicleCommand::Return];
    for stop in stops {
        for receipt in bens.command_from(Some(&ben.id), &Targets::All, stop).await {
            let refusal = receipt.refusal;
            assert!(!is_for_control(refusal.as_ref()), "{refusal:?}");
        }
    }
    assert!(!is_for_control(fly(&annas, &anna).await.as_ref()));

    // Ben asks, Anna gives.
    assert_eq!(change(&bens, &ben, &ControlAction::Request), None);
    known(&annas, "Anna sees that Ben asks", Duration::ZERO, |control| {
        control.requests.iter().any(|request| request.console == ben)
    })
    .await;
    let to_ben = ControlAction::HandOver { to: ben.id.clone() };
    assert_eq!(change(&annas, &anna, &to_ben), None);
    known(&bens, "Ben has it", Duration::ZERO, |control| control.console == ben).await;
    assert!(!is_for_control(fly(&bens, &ben).await.as_ref()));
    assert!(is_for_control(fly(&annas, &anna).await.as_ref()));

    relieved((&annas, &anna, page_of_anna), (&bens, &ben)).await;
    flock.stop().await;
}

/// Back at Anna, whose page then closes: whoever is there relieves her.
async fn relieved((annas, anna, page_of_anna): (&NodeHandle, &Console, Page), (bens, ben): (&NodeHandle, &Console)) {
    assert_eq!(change(annas, anna, &ControlAction::Request), None);
    known(bens, "Ben sees that Anna asks", Duration::ZERO, |control| {
        control.requests.iter().any(|request| request.console == *anna)
    })
    .await;
    assert_eq!(change(bens, ben, &ControlAction::Release), None);
    known(annas, "Anna has it again", Duration::ZERO, |control| {
        control.console == *anna
    })
    .await;
    drop(page_of_anna);
    known(bens, "Anna is not heard any more", RELIEVED_WITHIN, |control| {
        control.console == *anna && !control.is_heard
    })
    .await;
    assert_eq!(change(bens, ben, &ControlAction::Take), None);
    known(annas, "Ben has relieved her", Duration::ZERO, |control| {
        control.console == *ben
    })
    .await;
}
