//! Who goes when there is no room.

use super::*;

fn address(last: u8) -> IpAddr {
    IpAddr::from([10, 0, 0, last])
}

fn is_open(ended: &mut oneshot::Receiver<()>) -> bool {
    matches!(ended.try_recv(), Err(oneshot::error::TryRecvError::Empty))
}

#[test]
fn whoever_asks_nothing_goes_for_the_next_and_the_longest_first() {
    let (all, start) = (Connections::default(), Instant::now());
    let at = |i: usize| start + Duration::from_millis(i as u64);
    let mut held: Vec<_> = (0..OF_ONE_ADDRESS_MAX)
        .map(|i| all.admit(at(i), address(1)).expect("there is room"))
        .collect();
    let asked = held[0].0.asked(at(200));
    let (_another, mut its) = all.admit(at(300), address(1)).expect("the second goes");
    assert!(
        is_open(&mut its) && is_open(&mut held[0].1),
        "the one that is answered stays"
    );
    assert!(!is_open(&mut held[1].1) && is_open(&mut held[2].1));
    drop(asked);
    for _ in 0..2_000 {
        all.admit(at(400), address(1)).expect("whoever comes is taken in");
    }
}

#[test]
fn one_address_leaves_room_for_others_and_gives_way_to_them() {
    let (all, now) = (Connections::default(), Instant::now());
    let hold =
        |of: u8, count: usize| -> Vec<_> { (0..count).map(|_| all.admit(now, address(of)).expect("room")).collect() };
    let mut flood = hold(1, OF_ONE_ADDRESS_MAX);
    let mut others: Vec<_> = (2..=65).flat_map(|of| hold(of, 1)).collect();
    let (_operator, mut its) = all.admit(now, address(99)).expect("room is made");
    assert!(is_open(&mut its) && others.iter_mut().all(|(_, ended)| is_open(ended)));
    assert_eq!(
        flood
            .iter_mut()
            .filter_map(|(_, ended)| is_open(ended).then_some(()))
            .count(),
        OF_ONE_ADDRESS_MAX - 1
    );
}

#[test]
fn with_everybody_being_answered_a_new_one_is_closed_until_they_are_slow() {
    let (all, now) = (Connections::default(), Instant::now());
    let mut held: Vec<_> = (0..OF_ONE_ADDRESS_MAX)
        .map(|_| all.admit(now, address(1)).expect("room"))
        .collect();
    let _asked: Vec<_> = held.iter().map(|(admitted, _)| admitted.asked(now)).collect();
    assert!(all.admit(now, address(1)).is_none());
    assert!(all.admit(now, address(2)).is_some(), "another address has room");
    assert!(all.admit(now + SLOW, address(1)).is_some());
    assert!(!is_open(&mut held[0].1));
}

#[test]
fn who_has_gone_leaves_room() {
    let (all, now) = (Connections::default(), Instant::now());
    for _ in 0..10 * CONNECTIONS_MAX {
        let (admitted, _) = all.admit(now, address(1)).expect("room");
        drop(admitted.asked(now));
    }
    assert!(all.0.lock().open.is_empty());
}

#[test]
fn a_page_that_is_open_stays_while_others_come_and_ask_nothing() {
    let (all, now) = (Connections::default(), Instant::now());
    let (page, mut its) = all.admit(now, address(1)).expect("room");
    drop(page.asked(now));
    let mut flood: std::collections::VecDeque<_> = std::collections::VecDeque::new();
    for _ in 0..5_000 {
        flood.push_back(all.admit(now, address(1)).expect("whoever comes is taken in"));
        flood.truncate(1_000);
    }
    assert!(is_open(&mut its));
}

#[test]
fn who_comes_among_many_that_have_asked_before_has_time_to_ask() {
    let (all, now) = (Connections::default(), Instant::now());
    let mut held = Vec::new();
    for _ in 0..OF_ONE_ADDRESS_MAX {
        let (admitted, ended) = all.admit(now, address(1)).expect("room");
        drop(admitted.asked(now));
        held.push((admitted, ended));
    }
    let later = now + Duration::from_secs(1);
    let (_operator, mut its) = all.admit(later, address(1)).expect("room is made");
    let _flood: Vec<_> = (0..50)
        .map(|_| all.admit(later, address(1)).expect("room is made"))
        .collect();
    assert!(is_open(&mut its));
}
