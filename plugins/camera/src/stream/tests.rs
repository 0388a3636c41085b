//! Tests of streams that fail.

use super::*;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

#[test]
fn a_file_that_is_none_is_told_and_ends_the_stream() {
    let mut reader = StreamReader::start(Origin::File(PathBuf::from("/nowhere/video.mp4"))).expect("a thread");
    let mut outcome = reader.take(0.0);
    while outcome == Ok(None) {
        std::thread::yield_now();
        outcome = reader.take(0.0);
    }
    assert!(matches!(outcome, Err(StreamFault::File(_))), "{outcome:?}");
    let mut outcome = reader.take(0.0);
    while outcome == Ok(None) {
        std::thread::yield_now();
        outcome = reader.take(0.0);
    }
    assert_eq!(outcome, Err(Ended.into()));
}

/// What a camera in the network says to each request, in order; then nothing more.
fn camera(answers: &'static [&'static str]) -> (String, std::thread::JoinHandle<()>) {
    let (url, served, _) = camera_that_tells(answers);
    (url, served)
}

/// The same, and when a visitor came.
fn camera_that_tells(answers: &'static [&'static str]) -> (String, std::thread::JoinHandle<()>, Receiver<()>) {
    let (tell, visited) = channel();
    let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address");
    let served = std::thread::spawn(move || {
        let (mut line, _) = listener.accept().expect("a visitor");
        // Most tests do not ask.
        let _ = tell.send(());
        let mut read = [0; 4096];
        for answer in answers {
            let len = std::io::Read::read(&mut line, &mut read).unwrap_or(0);
            let asked = String::from_utf8_lossy(&read[..len]).into_owned();
            let number = asked
                .lines()
                .find_map(|one| one.strip_prefix("CSeq: "))
                .unwrap_or("1")
                .to_owned();
            let answer = answer.replace("NUMBER", number.trim());
            let _ = std::io::Write::write_all(&mut line, answer.as_bytes());
        }
        // open until the visitor goes
        while matches!(std::io::Read::read(&mut line, &mut read), Ok(1..)) {}
    });
    (format!("rtsp://{address}/stream"), served, visited)
}

fn fault_of(url: &str, user: &str) -> StreamFault {
    let origin = Origin::Rtsp(RtspCamera {
        url: url.to_owned(),
        user: user.to_owned(),
        password: "a secret".to_owned(),
    });
    let mut reader = StreamReader::start(origin).expect("a thread");
    loop {
        match reader.take(0.0) {
            Ok(None) => std::thread::sleep(Duration::from_millis(5)),
            Ok(Some(_)) => panic!("no picture was sent"),
            Err(fault) => return fault,
        }
    }
}

#[test]
fn a_camera_that_wants_a_password_says_so_and_the_password_stays_unsaid() {
    let (url, served) =
        camera(&["RTSP/1.0 401 Unauthorized\r\nCSeq: NUMBER\r\nWWW-Authenticate: Basic realm=\"camera\"\r\n\r\n"]);
    let fault = fault_of(&url, "");
    assert!(
        matches!(&fault, StreamFault::Rtsp { reason, .. } if reason.contains("401")),
        "{fault}"
    );
    served.join().expect("it ends");
    let debug = format!(
        "{:?}",
        RtspCamera {
            url,
            user: "pilot".into(),
            password: "a secret".into()
        }
    );
    assert!(debug.contains("pilot") && !debug.contains("secret"), "{debug}");
}

#[test]
fn what_is_no_rtsp_or_has_no_h264_is_said() {
    let (url, served) = camera(&["HTTP/1.1 200 OK\r\n\r\n"]);
    assert!(matches!(fault_of(&url, ""), StreamFault::Rtsp { .. }));
    served.join().expect("it ends");
    let (url, served) = camera(&[
        "RTSP/1.0 200 OK\r\nCSeq: NUMBER\r\nContent-Type: application/sdp\r\nContent-Length: 91\r\n\r\nv=0\r\no=- 0 0 IN IP4 127.0.0.1\r\ns=camera\r\nt=0 0\r\nm=audio 0 RTP/AVP 0\r\na=rtpmap:0 PCMU/8000\r\n",
    ]);
    let fault = fault_of(&url, "");
    assert!(
        matches!(&fault, StreamFault::NoH264 { has, .. } if has.contains("pcmu")),
        "{fault}"
    );
    served.join().expect("it ends");
}

#[test]
fn a_reader_of_a_camera_that_hangs_ends_at_once_when_nobody_wants_it() {
    let (url, served, visited) = camera_that_tells(&[]);
    let origin = Origin::Rtsp(RtspCamera {
        url,
        user: String::new(),
        password: String::new(),
    });
    let mut reader = StreamReader::start(origin).expect("a thread");
    // Not before it has come: one that is not wanted any more does not even go there.
    visited.recv().expect("a visitor");
    assert_eq!(reader.take(0.0), Ok(None));
    drop(reader);
    // its end of the line is closed: the camera sees the visitor go
    served.join().expect("it ends");
}
