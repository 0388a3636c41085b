//! Tests of RTP: what comes in any order, with losses, from several senders, and anything at all.

mod sender;

use super::assembly::{MOST_UNIT_BYTES, Picture};
use super::order::WINDOW;
use super::*;
use crate::feed::Feed;
use proptest::prelude::*;
use sender::{Sender, Shot, Style, is_same, units_of};

const AT_ONCE: Duration = Duration::ZERO;

fn pictures(reception: &mut Reception, now: Duration, datagrams: &[Vec<u8>]) -> Vec<Picture> {
    let pictures = datagrams.iter().flat_map(|datagram| reception.take(now, datagram));
    pictures.collect()
}

/// Which of these access units they are; each has to be one.
fn which(pictures: &[Picture], whole: &[Vec<u8>]) -> Vec<usize> {
    let which = |picture: &Picture| whole.iter().position(|unit| is_same(&picture.bytes, unit));
    pictures
        .iter()
        .map(|picture| which(picture).expect("it is as it was sent"))
        .collect()
}

fn numbers(range: std::ops::Range<usize>) -> Vec<usize> {
    range.collect()
}

/// A key picture and others, three packets each at least.
fn film(len: usize, key_every: usize) -> Vec<Shot> {
    (0..len)
        .map(|index| Shot {
            is_key: index % key_every == 0,
            slice_lens: vec![3_000, 40],
        })
        .collect()
}

#[test]
fn a_stream_in_order_comes_whole() {
    let shots = film(9, 4);
    for style in Style::ALL {
        let mut sender = Sender::new(7, 65_530, style);
        let datagrams = sender.send(&shots).concat();
        let mut reception = Reception::new(Vec::new());
        let given = which(&pictures(&mut reception, AT_ONCE, &datagrams), &units_of(&shots, style));
        // A slice alone may be the rest of a picture whose parameter sets were missed.
        let first = if style == Style::SetsNever { 4 } else { 0 };
        assert_eq!(given, numbers(first..9), "{style:?}");
        let useless = reception.counts().useless_since(&Counts::default());
        assert_eq!(useless, None, "{style:?}");
        assert!(reception.counts().datagrams > 27, "the pictures were cut into packets");
    }
}

#[test]
fn after_a_loss_it_goes_on_with_the_next_key_picture() {
    let shots = film(40, 4);
    let style = Style::SetsEachTime;
    let mut by_shot = Sender::new(7, 100, style).send(&shots);
    by_shot[2].remove(1);
    let mut reception = Reception::new(Vec::new());
    let pictures = pictures(&mut reception, AT_ONCE, &by_shot.concat());
    let given = which(&pictures, &units_of(&shots, style));
    assert_eq!(given, [numbers(0..2), numbers(4..40)].concat());
    let left_out: u64 = pictures.iter().map(|picture| picture.left_out).sum();
    assert_eq!((left_out, reception.counts().lost), (2, 1));
}

#[test]
fn a_picture_that_is_lost_whole_is_missed_by_those_that_refer_to_it() {
    let shots = film(40, 4);
    let style = Style::Delimited;
    let mut by_shot = Sender::new(7, 100, style).send(&shots);
    by_shot.remove(2);
    let mut reception = Reception::new(Vec::new());
    let given = which(
        &pictures(&mut reception, AT_ONCE, &by_shot.concat()),
        &units_of(&shots, style),
    );
    // Each picture begins with a delimiter: that it is whole is known, and is not enough.
    assert_eq!(given, [numbers(0..2), numbers(4..40)].concat());
}

#[test]
fn who_comes_in_the_middle_waits_for_a_key_picture_and_nothing_counts_as_missed() {
    let shots = film(12, 4);
    let style = Style::SetsEachTime;
    let by_shot = Sender::new(7, 100, style).send(&shots);
    let mut reception = Reception::new(Vec::new());
    // Without the beginning of the key picture at 4.
    let pictures = pictures(&mut reception, AT_ONCE, &by_shot[4..].concat()[1..]);
    assert_eq!(which(&pictures, &units_of(&shots, style)), numbers(8..12));
    assert_eq!(pictures[0].left_out, 0);
}

#[test]
fn parameter_sets_that_come_once_or_never_stand_before_the_first_key_picture() {
    let shots = film(6, 2);
    let style = Style::SetsNever;
    let mut sets = Vec::new();
    sender::sets().iter().for_each(|set| sender::append(set, &mut sets));
    let after = |sets: &[u8]| {
        let mut whole = units_of(&shots, style);
        whole[0] = [sets, &whole[0]].concat();
        whole
    };
    // By themselves at the beginning.
    let mut reception = Reception::new(Vec::new());
    let mut sender = Sender::new(7, 1, style);
    let mut datagrams = sender.send_sets();
    datagrams.extend(sender.send(&shots).concat());
    let given = pictures(&mut reception, AT_ONCE, &datagrams);
    assert_eq!(which(&given, &after(&sets)), numbers(0..6));
    // As they are configured, for each sender.
    let configured = parameter_sets("Z0LAHtkDxWhAAAADAEAAAAwDxYuS, aMuMsg==").expect("they are some");
    let mut reception = Reception::new(configured.clone());
    for (ssrc, seconds) in [(1, 0), (2, 10)] {
        let datagrams = Sender::new(ssrc, 1, style).send(&shots).concat();
        let given = pictures(&mut reception, Duration::from_secs(seconds), &datagrams);
        assert_eq!(which(&given, &after(&configured)), numbers(0..6));
    }
}

#[test]
fn parameter_sets_that_are_none_are_refused() {
    assert_eq!(parameter_sets(""), Ok(Vec::new()));
    for none in ["Z0LAHtkDxWhA AA", "%", "ZZ==", "AAAA", "Z0LAHtkD,AAAA"] {
        assert!(parameter_sets(none).is_err(), "{none}");
    }
    let many = vec!["aMuMsg=="; 4_000].join(",");
    assert!(parameter_sets(&many).is_err());
}

#[test]
fn a_sender_that_begins_anew_is_followed_and_a_second_one_beside_it_is_not() {
    let shots = film(4, 2);
    let style = Style::SetsEachTime;
    let whole = units_of(&shots, style);
    let mut reception = Reception::new(Vec::new());
    let mut at = |seconds: f64, ssrc: u32, sequence: u16| {
        let datagrams = Sender::new(ssrc, sequence, style).send(&shots).concat();
        let given = pictures(&mut reception, Duration::from_secs_f64(seconds), &datagrams);
        which(&given, &whole)
    };
    assert_eq!(at(0.0, 1, 500), numbers(0..4));
    assert_eq!(at(0.1, 2, 700), numbers(0..0), "the first one sent 0.1 s ago");
    assert_eq!(at(0.7, 2, 700), numbers(0..4), "the first one is gone");
    // The same SSRC again, wherever its numbers begin: behind, ahead, far away.
    for (run, sequence) in [660, 2_000, 40_000].into_iter().enumerate() {
        assert_eq!(at(2.0 + run as f64, 2, sequence), numbers(0..4), "from {sequence}");
    }
    assert!(reception.counts().other_sender > 10);
}

#[test]
fn a_stray_number_does_not_end_a_stream_and_a_new_sequence_is_followed() {
    let shots = film(4, 2);
    let style = Style::SetsEachTime;
    let mut sender = Sender::new(7, 100, style);
    let mut datagrams = sender.send(&shots).concat();
    let mut stray = datagrams[0].clone();
    stray[2..4].copy_from_slice(&30_000_u16.to_be_bytes());
    datagrams.insert(5, stray);
    let mut reception = Reception::new(Vec::new());
    let whole = units_of(&shots, style);
    assert_eq!(
        which(&pictures(&mut reception, AT_ONCE, &datagrams), &whole),
        numbers(0..4)
    );
    assert_eq!(reception.counts().late, 1);
    // Without a pause its first packet is not believed; the second key picture is whole.
    let datagrams = Sender::new(7, 50_000, style).send(&shots).concat();
    assert_eq!(
        which(&pictures(&mut reception, AT_ONCE, &datagrams), &whole),
        numbers(2..4)
    );
}

#[test]
fn what_is_of_no_use_is_counted_and_told() {
    let rtp = |second: u8, payload: &[u8]| {
        let mut datagram = vec![0x80, second, 0, 1, 0, 0, 0, 0, 0, 0, 0, 7];
        datagram.extend(payload);
        datagram
    };
    let cases: [(Vec<u8>, Lack); 8] = [
        (Vec::new(), Lack::Empty),
        (vec![0x80; MOST_DATAGRAM_BYTES + 1], Lack::Oversized),
        (b"no RTP at all, but long enough".to_vec(), Lack::NotRtp),
        (vec![0x47; 188], Lack::NotRtp),
        (rtp(33, &[0x47; 188]), Lack::PayloadType(33)),
        (rtp(96, &[0x62, 0x01, 0x93, 0]), Lack::H265),
        (rtp(96, &[0x7f, 1, 2, 3]), Lack::NotH264),
        (rtp(96, &[0x41, 0x9a, 0, 0]), Lack::NoKeyPicture),
    ];
    for (datagram, lack) in cases {
        let mut reception = Reception::new(Vec::new());
        assert_eq!(reception.take_lack(), Lack::Nothing);
        assert_eq!(reception.take(AT_ONCE, &datagram), []);
        assert_eq!(reception.take_lack(), lack);
        let useless = reception.counts().useless_since(&Counts::default());
        assert_eq!(useless.is_some(), lack != Lack::NoKeyPicture, "{lack}: {useless:?}");
    }
    // Reports of RTCP on the same port are nothing to tell.
    let mut reception = Reception::new(Vec::new());
    reception.take(AT_ONCE, &rtp(200, &[0; 16]));
    assert_eq!(reception.take_lack(), Lack::Nothing);
}

#[test]
fn a_port_that_is_taken_is_said() {
    let taken = UdpSocket::bind("127.0.0.1:0").expect("a port");
    let port = RtpPort {
        listen: taken.local_addr().expect("an address"),
        parameter_sets: Vec::new(),
    };
    let mut feed = Feed::start("test", 4, move |outlet| read(&port, None, outlet)).expect("a thread");
    let fault = loop {
        match feed.take() {
            Ok(_) => std::thread::yield_now(),
            Err(fault) => break fault,
        }
    };
    assert!(matches!(fault, StreamFault::Port { .. }), "{fault}");
}

#[test]
fn what_is_sent_to_the_port_or_the_group_comes_out() {
    let shots = film(4, 2);
    let style = Style::SetsEachTime;
    for group in [None, Some(Ipv4Addr::new(239, 255, 77, 1))] {
        let address = group.unwrap_or(Ipv4Addr::LOCALHOST);
        let socket = match open(SocketAddr::new(address.into(), 0)) {
            Ok(socket) => socket,
            Err(error) if group.is_some() => return eprintln!("left out: {error}"),
            Err(error) => panic!("{error}"),
        };
        let to = socket.local_addr().expect("an address");
        let port = RtpPort {
            listen: to,
            parameter_sets: Vec::new(),
        };
        let mut feed = Feed::start("test", 8, move |outlet| {
            receive(&socket, &port, None, outlet).map_err(|_| crate::feed::Ended.into())
        })
        .expect("a thread");
        let sender = UdpSocket::bind("0.0.0.0:0").expect("a port");
        for datagram in Sender::new(7, 1, style).send(&shots).concat() {
            match sender.send_to(&datagram, to) {
                Ok(_) => {}
                // A computer without a way to any group has nothing to be tested here.
                Err(error) if group.is_some() => return eprintln!("left out: {error}"),
                Err(error) => panic!("{error}"),
            }
        }
        let mut given = Vec::new();
        while given.len() < shots.len() {
            match feed.take() {
                Ok(Some(coded)) => given.push(coded.bytes),
                Ok(None) => std::thread::yield_now(),
                Err(fault) => panic!("{fault}"),
            }
        }
        assert!(given == units_of(&shots, style), "it is as it was sent");
    }
}

fn drawn_shots() -> impl Strategy<Value = Vec<Shot>> {
    let shot = (prop::bool::weighted(0.3), prop::collection::vec(2_usize..4_000, 1..4));
    prop::collection::vec(shot.prop_map(|(is_key, slice_lens)| Shot { is_key, slice_lens }), 1..30)
}

proptest! {
    #[test]
    fn no_order_and_no_loss_give_a_damaged_picture(
        shots in drawn_shots(),
        style in prop::sample::select(Style::ALL.to_vec()),
        first in any::<u16>(),
        delays in prop::collection::vec(0_usize..20, 400),
        losses in prop::collection::vec(prop::bool::weighted(0.02), 400),
        copies in prop::collection::vec(prop::bool::weighted(0.1), 400),
        loses in any::<bool>(),
    ) {
        let datagrams = Sender::new(9, first, style).send(&shots).concat();
        let mut sent: Vec<(usize, &Vec<u8>)> = Vec::new();
        for (index, datagram) in datagrams.iter().enumerate() {
            // The first one is not overtaken: what was before it nobody knows.
            let delay = if index == 0 { 0 } else { delays[index % 400] };
            if !(loses && losses[index % 400]) {
                sent.push((index + delay, datagram));
            }
            if copies[index % 400] && !(loses && losses[index % 400]) {
                sent.push((index + delay + 3, datagram));
            }
        }
        sent.sort_by_key(|(place, _)| *place);
        let whole = units_of(&shots, style);
        let mut reception = Reception::new(Vec::new());
        let mut given = Vec::new();
        for (_, datagram) in sent {
            for picture in reception.take(AT_ONCE, datagram) {
                let from = given.last().map_or(0, |last| last + 1);
                let index = (from..whole.len()).find(|index| is_same(&picture.bytes, &whole[*index]));
                prop_assert!(index.is_some(), "it is as it was sent, and in its order");
                given.extend(index);
            }
        }
        for (before, index) in std::iter::once(None).chain(given.iter().map(Some)).zip(&given) {
            let follows = before.is_some_and(|before| before + 1 == *index);
            prop_assert!(shots[*index].is_key || follows, "what it refers to was given: {given:?}");
        }
        if !loses {
            let first_key = shots.iter().position(|shot| shot.is_key);
            // Where key pictures begin with a slice, the first of all is not known to begin there.
            let first_key = if style == Style::SetsNever && first_key == Some(0) {
                shots.iter().skip(1).position(|shot| shot.is_key).map(|index| index + 1)
            } else {
                first_key
            };
            let expected: Vec<usize> = first_key.map_or(Vec::new(), |key| (key..shots.len()).collect());
            prop_assert_eq!(given, expected);
        }
    }

    #[test]
    fn anything_is_borne_within_bounds(
        datagrams in prop::collection::vec((any::<u16>(), any::<u8>(), prop::collection::vec(any::<u8>(), 0..60), any::<bool>(), 0_u64..2_000), 1..300),
    ) {
        let mut reception = Reception::new(Vec::new());
        let mut now = Duration::ZERO;
        for (number, second, bytes, looks_right, later_ms) in datagrams {
            now += Duration::from_millis(later_ms / 20);
            let mut datagram = Vec::new();
            if looks_right {
                datagram.extend([0x80, 96 | second & 0x80]);
                datagram.extend((number % 200).to_be_bytes());
                datagram.extend([0, 0, 0, second % 4, 0, 0, 0, second % 2]);
            }
            datagram.extend(bytes);
            reception.take(now, &datagram);
            prop_assert!(reception.kept_bytes() <= WINDOW * MOST_DATAGRAM_BYTES + MOST_UNIT_BYTES);
        }
    }
}

#[test]
fn a_unit_without_an_end_takes_no_more_than_its_bound() {
    let mut reception = Reception::new(Vec::new());
    let mut most = 0;
    for number in 0..1_000_u16 {
        let mut datagram = vec![0x80, 96];
        datagram.extend(number.to_be_bytes());
        datagram.extend([0, 0, 0, 0, 0, 0, 0, 7]);
        // The first fragment of a slice, and ever more of them.
        datagram.extend([0x7c, if number == 0 { 0x85 } else { 0x05 }]);
        datagram.extend([0x55; 9_000]);
        assert_eq!(reception.take(AT_ONCE, &datagram), []);
        most = most.max(reception.kept_bytes());
    }
    assert!(most <= MOST_UNIT_BYTES, "{most}");
}
