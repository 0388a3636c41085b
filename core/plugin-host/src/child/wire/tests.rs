//! Messages over a real socket: whole, in parts, with files, and made of garbage.

use super::*;
use crate::child::process::socket_pair;
use rustix::net::SocketType;

fn pair() -> (Wire<OwnedFd>, Wire<OwnedFd>) {
    let (a, b) = socket_pair(SocketType::STREAM).expect("a pair");
    (Wire::new(a, false), Wire::new(b, true))
}

const HEAD: Head = Head {
    kind: kind::INVOKE,
    numbers: [1, 2, 3, u32::MAX],
};

/// As it is written on the wire.
fn raw(len: u32, body: &[u8]) -> Vec<u8> {
    let numbers = [len, HEAD.kind, 1, 2, 3, u32::MAX];
    let mut bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_ne_bytes()).collect();
    bytes.extend(body);
    bytes
}

#[test]
fn a_message_comes_as_it_was_sent() {
    let (mut a, mut b) = pair();
    assert!(b.try_receive(100).expect("is open").is_none());
    let library = std::fs::File::open("/proc/self/exe").expect("is there");
    a.send(HEAD, &[b"one ", b"", b"two"], &[library.as_fd(), library.as_fd()], None)
        .expect("is sent");
    let message = b.spin_receive(100).expect("is open").expect("is there");
    assert_eq!(
        (message.head, message.body.as_slice(), message.files.len()),
        (HEAD, b"one two".as_slice(), 2)
    );
    b.send(Head::default(), &[], &[library.as_fd()], None).expect("is sent");
    let message = a.spin_receive(0).expect("is open").expect("is there");
    assert_eq!(
        (message.head, message.body.len(), message.files.len()),
        (Head::default(), 0, 0),
        "takes no files"
    );
}

#[test]
fn a_long_message_comes_whole() {
    let (mut a, mut b) = pair();
    let body: Vec<u8> = (0..3_000_000_u32).map(|i| (i % 251) as u8).collect();
    let sent = body.clone();
    let sender = std::thread::spawn(move || a.send(HEAD, &[&sent], &[], None).expect("is sent"));
    let message = loop {
        if let Some(message) = b.try_receive(body.len()).expect("is open") {
            break message;
        }
        wait(&[b.socket()], PollFlags::IN, None).expect("waits");
    };
    assert!(message.body == body);
    sender.join().expect("ends");
}

#[test]
fn a_receiver_that_takes_nothing_is_given_up() {
    let (mut a, _b) = pair();
    let until = Instant::now() + Duration::from_millis(20);
    let error = a
        .send(HEAD, &[&[0; 8 << 20]], &[], Some(until))
        .expect_err("nobody takes it");
    assert_eq!(error.kind(), ErrorKind::TimedOut);
    assert!(Instant::now() >= until);
}

#[test]
fn parts_are_put_together_and_garbage_is_refused() {
    let (a, b) = socket_pair(SocketType::STREAM).expect("a pair");
    let mut b = Wire::new(b, true);
    let say = |bytes: &[u8]| assert_eq!(rustix::io::write(&a, bytes).expect("is written"), bytes.len());
    let bytes = raw(3, b"abc");
    for byte in &bytes[..bytes.len() - 1] {
        say(&[*byte]);
        assert!(b.try_receive(100).expect("is open").is_none());
    }
    say(b"c");
    assert_eq!(b.try_receive(100).expect("is open").expect("is whole").body, b"abc");
    say(&raw(101, b""));
    let error = b.try_receive(100).expect_err("is too long").to_string();
    assert!(error.contains("101 bytes, the limit is 100"), "{error}");

    for (garbage, said) in [(raw(1, b"abc"), "more than one"), (vec![0xff; 500], "4294967295 bytes")] {
        let (a, b) = socket_pair(SocketType::STREAM).expect("a pair");
        let mut b = Wire::new(b, true);
        rustix::io::write(&a, &garbage).expect("is written");
        let error = b.try_receive(100).expect_err("is garbage").to_string();
        assert!(error.contains(said), "{error}");
    }
}

#[test]
fn the_end_of_the_other_side_is_an_error() {
    let (a, mut b) = pair();
    drop(a);
    assert_eq!(
        b.try_receive(100).expect_err("has ended").kind(),
        ErrorKind::UnexpectedEof
    );
    let error = b.send(HEAD, &[b"x"], &[], None).expect_err("has ended");
    assert_eq!(error.kind(), ErrorKind::BrokenPipe);
}
