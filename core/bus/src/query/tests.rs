//! Questions, step by step.

use super::*;

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

fn answer(id: u64) -> QueryAnswer {
    QueryAnswer { id, body: vec![1] }
}

#[test]
fn a_question_is_asked_again_until_it_is_answered_once() {
    let mut asking = Asking::new(QuerySettings::default());
    let id = asking.ask(at(0.0), NodeId(2), vec![7], 2.0).unwrap();
    let tries = (0..200)
        .filter(|step| asking.next(at(f64::from(*step) * 0.01)).is_some())
        .count();
    assert_eq!(tries, 4, "at 0, 0.2, 0.6, 1.4 s");
    assert_eq!(asking.answered(at(1.9), NodeId(3), answer(id)), None, "of another node");
    assert_eq!(asking.answered(at(1.9), NodeId(2), answer(id)), Some((id, vec![1])));
    assert_eq!(asking.answered(at(1.9), NodeId(2), answer(id)), None);
    assert!(asking.expire(at(9.0)).is_empty() && asking.next(at(9.0)).is_none());
}

#[test]
fn an_answer_after_the_deadline_is_none() {
    let mut asking = Asking::new(QuerySettings::default());
    let id = asking.ask(at(0.0), NodeId(2), vec![7], 1.0).unwrap();
    assert_eq!(asking.answered(at(1.1), NodeId(2), answer(id)), None);
    assert_eq!(asking.expire(at(1.1)), [(id, NodeId(2))]);
}

#[test]
fn there_is_a_bound_of_open_questions() {
    let mut asking = Asking::new(QuerySettings::default());
    for _ in 0..QuerySettings::default().most_open {
        asking.ask(at(0.0), NodeId(2), Vec::new(), 1.0).unwrap();
    }
    assert_eq!(
        asking.ask(at(0.0), NodeId(2), Vec::new(), 1.0),
        Err(TooManyOpen { open: 64 })
    );
}
