//! Tests of pipelines with the GStreamer that is installed: what gives pictures, and what does not says why.

use super::super::{Origin, StreamReader};
use super::*;

const PATIENCE: Duration = Duration::from_secs(60);

/// The first of some outcomes that is one.
fn next(reader: &mut StreamReader) -> Result<Coded, StreamFault> {
    let begun = Instant::now();
    while begun.elapsed() < PATIENCE {
        match reader.take(0.0) {
            Ok(Some(coded)) => return Ok(coded),
            Ok(None) => std::thread::yield_now(),
            Err(fault) => return Err(fault),
        }
    }
    panic!("nothing came");
}

fn reader(description: &str) -> StreamReader {
    StreamReader::start(Origin::Pipeline(description.to_owned())).expect("a thread")
}

fn fault_of(description: &str) -> PipelineFault {
    let mut reader = reader(description);
    loop {
        match next(&mut reader) {
            Ok(_) => {}
            Err(StreamFault::Pipeline(fault)) => return fault,
            Err(fault) => panic!("{fault}"),
        }
    }
}

/// Whether an encoder is there; without one its tests have nothing to say.
fn encoder() -> Option<&'static str> {
    gstreamer::init().expect("it is installed");
    let has = |name| gstreamer::ElementFactory::find(name).is_some();
    let known = [
        ("x264enc", "x264enc tune=zerolatency key-int-max=5"),
        ("openh264enc", "openh264enc gop-size=5"),
    ];
    let found = known
        .into_iter()
        .find(|(name, _)| has(name))
        .map(|(_, description)| description);
    if found.is_none() || !has("h264parse") {
        eprintln!("left out: GStreamer has no encoder for H.264, or no h264parse");
        return None;
    }
    found
}

#[test]
fn key_pictures_come_with_their_parameter_sets() {
    let Some(encoder) = encoder() else { return };
    let mut reader = reader(&format!(
        "videotestsrc is-live=true ! video/x-raw,width=64,height=48,framerate=30/1 ! {encoder}"
    ));
    let kinds = |bytes: &[u8]| -> Vec<u8> {
        let starts = bytes.windows(4).filter(|four| four[..3] == [0, 0, 1]);
        starts.map(|four| four[3] & 0x1f).collect()
    };
    let pictures: Vec<Vec<u8>> = (0..12)
        .map(|_| kinds(&next(&mut reader).expect("a picture").bytes))
        .collect();
    let keys: Vec<&Vec<u8>> = pictures.iter().filter(|kinds| kinds.contains(&5)).collect();
    assert!((2..12).contains(&keys.len()), "{pictures:?}");
    assert!(
        keys.iter().all(|kinds| kinds.contains(&7) && kinds.contains(&8)),
        "{pictures:?}"
    );
}

#[test]
fn what_cannot_be_made_or_gives_no_h264_says_why() {
    let nothing = fault_of("videotestsrc ! there-is-none");
    assert_eq!(nothing, PipelineFault::NoElement("there-is-none".to_owned()));
    let syntax = fault_of("videotestsrc ! ! !");
    assert!(matches!(syntax, PipelineFault::Unmade(_)), "{syntax}");
    let raw = fault_of("videotestsrc num-buffers=5");
    assert!(
        matches!(raw, PipelineFault::Unmade(_) | PipelineFault::Element { .. }),
        "{raw}"
    );
    let device = fault_of("filesrc location=/nowhere/video.h264");
    assert!(
        matches!(&device, PipelineFault::Element { element, .. } if element.starts_with("filesrc")),
        "{device}"
    );
}

#[test]
fn one_that_ends_says_so() {
    let Some(encoder) = encoder() else { return };
    let ended = fault_of(&format!(
        "videotestsrc num-buffers=3 ! video/x-raw,width=64,height=48 ! {encoder}"
    ));
    assert_eq!(ended, PipelineFault::Ended);
}
