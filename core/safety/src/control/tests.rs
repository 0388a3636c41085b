//! One vehicle, one console; and all nodes agree which.

use super::*;
use proptest::prelude::*;

const ONE: VehicleId = VehicleId(1);

fn console(id: &str) -> Console {
    Console {
        id: id.to_owned(),
        name: format!("console {id}"),
    }
}

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

#[test]
fn what_is_under_nobodys_control_is_for_everybody() {
    let mut table = ControlTable::new(NodeId(1));
    assert_eq!(table.may(ONE, None, at(0.0)), Ok(()));
    table.take(ONE, &console("a"), at(0.0)).expect("is free");
    assert_eq!(table.may(ONE, Some("a"), at(1.0)), Ok(()));
    for other in [None, Some("b")] {
        let refused = table.may(ONE, other, at(1.0)).expect_err("a has it");
        assert!(refused.to_string().contains("console a"), "{refused}");
    }
    assert!(table.take(ONE, &console("b"), at(1.0)).is_err());
    table.release(ONE, "a", at(2.0)).expect("it has it");
    assert_eq!(table.may(ONE, Some("b"), at(2.0)), Ok(()));
    assert!(table.release(ONE, "a", at(2.0)).is_err());
}

#[test]
fn it_is_handed_to_who_asks_and_to_nobody_else() {
    let mut table = ControlTable::new(NodeId(1));
    table.take(ONE, &console("a"), at(0.0)).expect("is free");
    assert!(table.hand_over(ONE, "a", "b", at(0.0)).is_err(), "nobody asks");
    table.request(ONE, &console("b"), at(1.0)).expect("may ask");
    assert!(table.may(ONE, Some("b"), at(1.0)).is_err(), "asking is not having");
    assert!(table.hand_over(ONE, "b", "b", at(1.0)).is_err(), "nor taking");
    table.hand_over(ONE, "a", "b", at(2.0)).expect("b asks");
    assert_eq!(table.may(ONE, Some("b"), at(2.0)), Ok(()));
    assert!(table.may(ONE, Some("a"), at(2.0)).is_err());
    assert!(table.picture(at(2.0))[0].requests.is_empty());
}

#[test]
fn what_is_let_go_comes_to_who_asked_first_and_is_there() {
    let mut table = ControlTable::new(NodeId(1));
    table.take(ONE, &console("a"), at(0.0)).expect("is free");
    table.request(ONE, &console("gone"), at(0.0)).expect("may ask");
    for i in 1..=12 {
        table.hear("a", at(f64::from(i)));
    }
    table.request(ONE, &console("b"), at(12.0)).expect("may ask");
    table.release(ONE, "a", at(12.0)).expect("it has it");
    assert_eq!(table.picture(at(12.0))[0].console.id, "b");
}

#[test]
fn who_is_not_heard_is_relieved() {
    let mut table = ControlTable::new(NodeId(1));
    table.take(ONE, &console("a"), at(0.0)).expect("is free");
    assert!(table.take(ONE, &console("b"), at(RELIEVED_AFTER_S - 0.1)).is_err());
    // Until somebody else takes it, it is for everybody, and for its holder if that comes back.
    assert_eq!(table.may(ONE, None, at(RELIEVED_AFTER_S)), Ok(()));
    table.take(ONE, &console("b"), at(RELIEVED_AFTER_S)).expect("a is gone");
    table.hear("a", at(RELIEVED_AFTER_S + 1.0));
    assert!(table.may(ONE, Some("a"), at(RELIEVED_AFTER_S + 1.0)).is_err());
}

#[test]
fn stops_are_for_everybody() {
    for command in [VehicleCommand::Hold, VehicleCommand::Land, VehicleCommand::Return] {
        assert!(is_for_everybody(&command));
    }
    for command in [
        VehicleCommand::Arm,
        VehicleCommand::TakeOff { height_m: 5.0 },
        VehicleCommand::Steer,
    ] {
        assert!(!is_for_everybody(&command));
    }
}

/// What a console does at a node.
#[derive(Debug, Clone, Copy)]
enum Step {
    Take,
    Request,
    Release,
    HandOver,
    Tell,
}

proptest! {
    /// Whatever several consoles do at several nodes: once all have told all, all say the same, and one console at most may command.
    #[test]
    fn all_nodes_agree(steps in prop::collection::vec((0_usize..3, 0_usize..4, prop::sample::select(vec![
        Step::Take, Step::Request, Step::Release, Step::HandOver, Step::Tell,
    ])), 0..60)) {
        let mut nodes: Vec<ControlTable> = (1..=3).map(|n| ControlTable::new(NodeId(n))).collect();
        let names = ["a", "b", "c", "d"];
        for (i, (node, who, step)) in steps.into_iter().enumerate() {
            let now = at(i as f64 * 0.1);
            let (id, other) = (names[who], names[(who + 1) % names.len()]);
            match step {
                Step::Take => drop(nodes[node].take(ONE, &console(id), now)),
                Step::Request => drop(nodes[node].request(ONE, &console(id), now)),
                Step::Release => drop(nodes[node].release(ONE, id, now)),
                Step::HandOver => drop(nodes[node].hand_over(ONE, id, other, now)),
                Step::Tell => {
                    let told = nodes[node].entries().clone();
                    nodes[(node + 1) % 3].merge(told);
                }
            }
        }
        let all: Vec<_> = nodes.iter().map(|node| node.entries().clone()).collect();
        for node in &mut nodes {
            for told in &all {
                node.merge(told.clone());
            }
            for name in names {
                node.hear(name, at(7.0));
            }
        }
        for node in &nodes {
            prop_assert_eq!(node.entries(), nodes[0].entries());
            let may = names.iter().filter(|name| node.may(ONE, Some(name), at(7.0)).is_ok()).count();
            prop_assert!(may == 1 || may == names.len(), "{} may", may);
        }
    }
}
