//! The leadership, step by step.

use super::*;
use proptest::prelude::*;

fn leadership(node: u64, priority: u8) -> Leadership {
    let mut leadership = Leadership::new(NodeId(node), None);
    leadership.set_priority(Some(priority));
    leadership
}

fn beacon(of: &Leadership) -> Beacon {
    Beacon {
        from: of.me,
        obeys: of.obeyed(),
        pulse: 1,
        standing: of.standing(),
    }
}

#[test]
fn a_claim_is_obeyed_by_whoever_hears_it_and_ends_the_former_holder() {
    let (mut a, mut b) = (leadership(1, 5), leadership(2, 5));
    let first = a.claim().unwrap();
    b.hear(&beacon(&a));
    assert_eq!(b.obeyed(), Some(first));
    let second = b.claim().unwrap();
    assert_eq!(second.number, 2);
    a.hear(&beacon(&b));
    assert_eq!((a.obeyed(), a.acting()), (Some(second), None));
    assert_eq!(a.order(first), Err(OrderError::Old { ordered: 1, obeyed: 2 }));
}

#[test]
fn of_two_holders_of_one_number_the_first_is_obeyed_until_the_better_one_claims_the_next() {
    let (mut a, mut b) = (leadership(1, 5), leadership(2, 9));
    let mut vehicle = Leadership::new(NodeId(3), None);
    let (of_a, of_b) = (a.claim().unwrap(), b.claim().unwrap());
    assert_eq!(vehicle.order(of_a), Ok(()));
    assert_eq!(vehicle.order(of_b), Err(OrderError::Rival { number: 1 }));
    a.hear(&beacon(&b));
    assert_eq!(a.acting(), Some(of_a), "the less suited waits for the other");
    b.hear(&beacon(&a));
    let settled = b.acting().unwrap();
    assert_eq!((settled.number, settled.holder.node), (2, NodeId(2)));
    vehicle.hear(&beacon(&b));
    a.hear(&beacon(&b));
    assert_eq!(
        (vehicle.obeyed(), a.obeyed(), a.acting()),
        (Some(settled), Some(settled), None)
    );
}

#[test]
fn who_was_started_again_does_not_act_in_its_old_term() {
    let mut a = leadership(1, 5);
    let term = a.claim().unwrap();
    let mut again = Leadership::new(NodeId(1), a.obeyed());
    again.set_priority(Some(5));
    assert_eq!((again.obeyed(), again.acting()), (Some(term), None));
    assert_eq!(again.claim().unwrap().number, 2);
}

#[test]
fn a_leadership_is_handed_over_to_the_one_meant_and_by_the_present_holder_only() {
    let (mut a, mut b) = (leadership(1, 9), leadership(2, 1));
    a.claim().unwrap();
    let offer = a.hand_over(NodeId(2)).unwrap();
    assert_eq!(leadership(3, 9).take_over(&offer), None, "not meant");
    assert_eq!(b.take_over(&offer).map(|term| term.number), Some(2));
    assert_eq!(
        a.acting().map(|term| term.number),
        Some(1),
        "goes on until it hears of it"
    );
    a.hear(&beacon(&b));
    assert_eq!(a.acting(), None);
    let mut late = leadership(2, 1);
    late.hear(&beacon(&b));
    assert_eq!(late.take_over(&offer), None, "of an old term");
    assert_eq!(a.hand_over(NodeId(2)), None, "nothing to hand over any more");
}

#[test]
fn who_cannot_coordinate_claims_nothing_and_numbers_do_not_wrap() {
    let mut vehicle = Leadership::new(NodeId(3), None);
    assert_eq!(vehicle.claim(), Err(ClaimError::NotCapable));
    let holder = Standing {
        priority: 1,
        node: NodeId(9),
    };
    let last = Term {
        number: u64::MAX,
        holder,
    };
    let mut at_the_end = Leadership::new(NodeId(1), Some(last));
    at_the_end.set_priority(Some(1));
    assert_eq!(at_the_end.claim(), Err(ClaimError::Exhausted));
    assert_eq!(at_the_end.obeyed(), Some(last));
}

proptest! {
    /// Whatever it hears in whatever order: one holder per number, and numbers only grow.
    #[test]
    fn no_number_is_obeyed_twice(terms in prop::collection::vec((0_u64..6, 0_u64..4, 0_u8..3, any::<bool>()), 0..60)) {
        let mut leadership = leadership(2, 1);
        let mut last: Option<Term> = None;
        for (number, node, priority, as_order) in terms {
            let term = Term { number, holder: Standing { priority, node: NodeId(node) } };
            if as_order {
                let carried_out = leadership.order(term).is_ok();
                prop_assert_eq!(carried_out, leadership.obeyed().is_some_and(|obeyed| obeyed.number == number && obeyed.holder.node == NodeId(node)));
            } else {
                leadership.hear(&Beacon { from: NodeId(node), obeys: Some(term), pulse: 0, standing: None });
            }
            let now = leadership.obeyed();
            if let (Some(before), Some(now)) = (last, now) {
                prop_assert!(now == before || now.number > before.number);
            }
            last = now;
        }
    }
}
