//! Couriers over a network that loses, doubles and turns around.

use super::*;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};

const SENDER: Boot = Boot(11);
const RECEIVER: Boot = Boot(22);

fn at(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

/// All that is due.
fn due(outbox: &mut Outbox, now: NodeTime) -> Vec<Parcel> {
    std::iter::from_fn(|| outbox.next(now)).collect()
}

fn pair() -> (Outbox, Inbox) {
    let settings = CourierSettings::default();
    (Outbox::new(settings, SENDER, NodeId(2)), Inbox::new(settings, RECEIVER))
}

#[test]
fn what_arrives_out_of_order_is_delivered_in_order() {
    let (mut outbox, mut inbox) = pair();
    for body in [b"a", b"b", b"c"] {
        outbox.post(at(0.0), body.to_vec()).unwrap();
    }
    let mut parcels = due(&mut outbox, at(0.0));
    parcels.reverse();
    let delivered: Vec<Vec<u8>> = parcels
        .into_iter()
        .flat_map(|parcel| inbox.take(at(0.0), parcel).unwrap().0)
        .collect();
    assert_eq!(delivered, [b"a".to_vec(), b"b".to_vec(), b"c".to_vec()]);
}

#[test]
fn a_sender_that_was_started_again_is_heard_and_its_former_run_is_not() {
    let (mut outbox, mut inbox) = pair();
    outbox.post(at(0.0), b"old".to_vec()).unwrap();
    let old = due(&mut outbox, at(0.0)).remove(0);
    let mut again = Outbox::new(CourierSettings::default(), Boot(12), NodeId(2));
    again.post(at(1.0), b"new".to_vec()).unwrap();
    let (first, _) = inbox.take(at(0.0), old.clone()).unwrap();
    let (second, _) = inbox.take(at(1.0), due(&mut again, at(1.0)).remove(0)).unwrap();
    assert_eq!((first, second), (vec![b"old".to_vec()], vec![b"new".to_vec()]));
    assert_eq!(inbox.take(at(1.0), old), None);
}

#[test]
fn a_command_for_a_receivers_former_run_is_not_delivered_to_its_next() {
    let (mut outbox, mut inbox) = pair();
    outbox.post(at(0.0), b"a".to_vec()).unwrap();
    let (_, receipt) = inbox.take(at(0.0), due(&mut outbox, at(0.0)).remove(0)).unwrap();
    assert_eq!(outbox.receipt(at(0.0), &receipt), [(1, Outcome::Delivered)]);
    outbox.post(at(1.0), b"b".to_vec()).unwrap();
    let mut again = Inbox::new(CourierSettings::default(), Boot(23));
    let (delivered, receipt) = again.take(at(1.0), due(&mut outbox, at(1.0)).remove(0)).unwrap();
    assert!(delivered.is_empty());
    assert_eq!(outbox.receipt(at(0.0), &receipt), [(2, Outcome::NotAnswered)]);
    outbox.post(at(2.0), b"c".to_vec()).unwrap();
    let (delivered, _) = again.take(at(2.0), due(&mut outbox, at(2.0)).remove(0)).unwrap();
    assert_eq!(delivered, [b"c".to_vec()]);
}

#[test]
fn who_does_not_answer_is_not_asked_without_end() {
    let (mut outbox, _) = pair();
    let settings = CourierSettings::default();
    for _ in 0..settings.most_under_way {
        outbox.post(at(0.0), Vec::new()).unwrap();
    }
    let crowded = outbox.post(at(0.0), Vec::new()).unwrap_err();
    assert_eq!(crowded.under_way, settings.most_under_way);
    assert!(outbox.expire(at(settings.give_up_after_s - 0.1)).is_empty());
    assert_eq!(
        outbox.expire(at(settings.give_up_after_s)).len(),
        settings.most_under_way
    );
    assert!(outbox.post(at(4.0), Vec::new()).is_ok());
}

#[test]
fn what_its_sender_has_given_up_is_not_delivered_later() {
    let (mut outbox, mut inbox) = pair();
    outbox.post(at(0.0), b"lost".to_vec()).unwrap();
    outbox.post(at(0.0), b"held".to_vec()).unwrap();
    let held = due(&mut outbox, at(0.0)).remove(1);
    assert!(
        inbox.take(at(0.1), held).unwrap().0.is_empty(),
        "waits for the one before it"
    );
    assert_eq!(outbox.expire(at(3.0)).len(), 2);
    outbox.post(at(3.0), b"next".to_vec()).unwrap();
    let (delivered, _) = inbox.take(at(3.1), due(&mut outbox, at(3.0)).remove(0)).unwrap();
    assert_eq!(delivered, [b"next".to_vec()]);
}

#[test]
fn what_has_waited_too_long_for_the_one_before_it_is_passed_over() {
    let (mut outbox, mut inbox) = pair();
    outbox.post(at(0.0), b"late".to_vec()).unwrap();
    outbox.post(at(0.0), b"held".to_vec()).unwrap();
    let mut parcels = due(&mut outbox, at(0.0));
    let (held, late) = (parcels.remove(1), parcels.remove(0));
    inbox.take(at(0.1), held).unwrap();
    let (delivered, receipt) = inbox.take(at(4.0), late).unwrap();
    assert_eq!(
        delivered,
        [b"late".to_vec()],
        "how long it was on its way can't be told; how long one waited here can"
    );
    assert_eq!(
        outbox.receipt(at(4.0), &receipt),
        [(1, Outcome::NotAnswered), (2, Outcome::NotAnswered)]
    );
}

/// What a network does with what is under way: picks one that arrives, loses some, keeps some to arrive again.
#[derive(Debug, Clone, Copy)]
struct Fate {
    arrives: usize,
    again: bool,
    loses: bool,
    answer: usize,
    answer_lost: bool,
    posts: bool,
    /// 0: the sender starts again; 1: the receiver does; otherwise nobody.
    restarts: u8,
}

fn fate() -> impl Strategy<Value = Fate> {
    let parts = (
        0_usize..8,
        any::<bool>(),
        any::<bool>(),
        0_usize..8,
        any::<bool>(),
        any::<bool>(),
        0_u8..60,
    );
    parts.prop_map(|(arrives, again, loses, answer, answer_lost, posts, restarts)| Fate {
        arrives,
        again,
        loses,
        answer,
        answer_lost,
        posts,
        restarts,
    })
}

/// One command as the test knows it: which run of the sender posted it, as which number.
type Name = (u64, u64);

struct World {
    now_s: f64,
    outbox: Outbox,
    inbox: Inbox,
    sender: u64,
    receiver: u64,
    there: Vec<Parcel>,
    back: Vec<Receipt>,
    posted: Vec<Name>,
    /// With the run of the receiver.
    delivered: Vec<(u64, Name)>,
    ended: BTreeMap<Name, Outcome>,
    /// The sender's run that the receiver takes parcels of, as the seal under it has it: one that has proven to be going on.
    proven: Option<u64>,
}

impl World {
    fn new() -> Self {
        let (outbox, inbox) = pair();
        Self {
            now_s: 0.0,
            outbox,
            inbox,
            sender: SENDER.0,
            receiver: RECEIVER.0,
            there: Vec::new(),
            back: Vec::new(),
            posted: Vec::new(),
            delivered: Vec::new(),
            ended: BTreeMap::new(),
            proven: None,
        }
    }

    fn end(&mut self, ended: Vec<(u64, Outcome)>) {
        for (number, outcome) in ended {
            let before = self.ended.insert((self.sender, number), outcome);
            assert_eq!(before, None, "ends once");
        }
    }

    fn restart(&mut self, who: u8) {
        let settings = CourierSettings::default();
        match who {
            0 => {
                self.sender += 100;
                self.outbox = Outbox::new(settings, Boot(self.sender), NodeId(2));
            }
            1 => {
                self.receiver += 1;
                self.proven = None;
                self.inbox = Inbox::new(settings, Boot(self.receiver));
            }
            _ => {}
        }
    }

    fn step(&mut self, fate: Fate) {
        self.now_s += 0.03;
        let now = at(self.now_s);
        self.restart(fate.restarts);
        if fate.posts {
            let name = |number: u64| [self.sender.to_le_bytes(), number.to_le_bytes()].concat();
            let next = self.posted.iter().filter(|(sender, _)| *sender == self.sender).count() as u64 + 1;
            if self.outbox.post(now, name(next)).is_ok() {
                self.posted.push((self.sender, next));
            }
        }
        self.there.extend(due(&mut self.outbox, now));
        let place = fate.arrives % self.there.len().max(1);
        if let Some(parcel) = self.there.get(place).cloned() {
            if !fate.again {
                self.there.remove(place);
            }
            self.arrive(now, parcel);
        }
        if fate.loses {
            self.there.pop();
        }
        let place = fate.answer % self.back.len().max(1);
        if let Some(receipt) = self.back.get(place).copied() {
            if fate.answer_lost {
                self.back.remove(place);
            } else {
                let ended = self.outbox.receipt(now, &receipt);
                self.end(ended);
            }
        }
        let ended = self.outbox.expire(now);
        self.end(ended);
    }

    fn arrive(&mut self, now: NodeTime, parcel: Parcel) {
        if parcel.boot.0 == self.sender {
            self.proven = Some(self.sender);
        } else if self.proven != Some(parcel.boot.0) {
            return;
        }
        let Some((bodies, receipt)) = self.inbox.take(now, parcel) else {
            return;
        };
        self.back.push(receipt);
        for body in bodies {
            let (sender, number) = body.split_at(8);
            let name = (
                u64::from_le_bytes(sender.try_into().unwrap()),
                u64::from_le_bytes(number.try_into().unwrap()),
            );
            self.delivered.push((self.receiver, name));
        }
    }
}

proptest! {
    /// Whatever the network does and whoever starts again: a run of the receiver is given each at most once, those of one run of the
    /// sender in their order and none of an earlier run after one of a later; what is called delivered was; and all end.
    #[test]
    fn delivered_once_and_in_order(fates in prop::collection::vec(fate(), 50..400)) {
        let mut world = World::new();
        for fate in fates {
            world.step(fate);
        }
        let ended = world.outbox.expire(at(world.now_s + 10.0));
        world.end(ended);
        for receiver in RECEIVER.0..=world.receiver {
            let names: Vec<Name> = world.delivered.iter().filter(|(run, _)| *run == receiver).map(|(_, name)| *name).collect();
            prop_assert!(names.windows(2).all(|pair| pair[0] < pair[1]), "{:?}", names);
        }
        let of_this_run = world.posted.iter().filter(|(sender, _)| *sender == world.sender);
        for name in of_this_run {
            prop_assert!(world.ended.contains_key(name), "{:?} has not ended", name);
        }
        for (name, outcome) in &world.ended {
            let times = world.delivered.iter().filter(|(_, delivered)| delivered == name).count();
            prop_assert!(*outcome != Outcome::Delivered || times > 0, "{:?} was called delivered", name);
        }
    }
}

#[test]
fn nearly_all_are_delivered_where_a_third_is_lost() {
    let mut luck = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let mut lost = move || luck.random::<f64>() < 0.33;
    let (mut posted, mut delivered) = (0, 0);
    for _ in 0..50 {
        let mut world = World::new();
        for number in 1..=20_u64 {
            let body = [SENDER.0.to_le_bytes(), number.to_le_bytes()].concat();
            world.outbox.post(at(0.0), body).unwrap();
        }
        while world.now_s < 4.0 {
            world.now_s += 0.01;
            let now = at(world.now_s);
            for parcel in due(&mut world.outbox, now) {
                if !lost() {
                    world.arrive(now, parcel);
                }
            }
            for receipt in std::mem::take(&mut world.back) {
                if !lost() {
                    let ended = world.outbox.receipt(now, &receipt);
                    world.end(ended);
                }
            }
            let ended = world.outbox.expire(now);
            world.end(ended);
        }
        posted += 20;
        delivered += world.delivered.len();
    }
    println!("{delivered} of {posted} commands delivered at 33 % loss");
    assert!(delivered * 100 >= posted * 99, "{delivered} of {posted}");
}
