//! Tests of pipelines with the GStreamer that is installed: what gives pictures, and what does not says why. Where it is not installed that is what is said.

use super::super::{Origin, StreamReader};
use super::*;

const PATIENCE: Duration = Duration::from_secs(60);

/// The first of some outcomes that is one.
fn next(reader: &mut StreamReader) -> Result<Coded, StreamFault> {
    let begun = Instant::now();
    while begun.elapsed() < PATIENCE {
        match reader.take(0.0) {
            Ok(Some(coded)) => return Ok(coded),
            Ok(None) => std::thread::sleep(Duration::from_millis(1)),
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

fn has(element: &str) -> bool {
    let mut inspect = Command::new("gst-inspect-1.0");
    inspect.args(["--exists", element]).stderr(Stdio::null());
    inspect.status().is_ok_and(|status| status.success())
}

/// Whether it is there; without it nothing more is to be tested than that this is said.
fn is_installed() -> bool {
    let is_installed = has("fdsink");
    if !is_installed {
        let fault = fault_of("videotestsrc");
        assert!(matches!(fault, PipelineFault::NotInstalled(_)), "{fault}");
        eprintln!("left out: GStreamer is not installed");
    }
    is_installed
}

/// Whether an encoder is there; without one its tests have nothing to say.
fn encoder() -> Option<&'static str> {
    let known = [
        ("x264enc", "x264enc tune=zerolatency key-int-max=5"),
        ("openh264enc", "openh264enc gop-size=5"),
    ];
    let found = known
        .into_iter()
        .find(|(name, _)| has(name))
        .map(|(_, description)| description);
    let is_there = is_installed() && ["h264parse", "rtph264pay", "rtpstreampay"].into_iter().all(has);
    if found.is_none() || !is_there {
        eprintln!("left out: GStreamer has no encoder for H.264, or no h264parse or rtph264pay");
        return None;
    }
    found
}

/// Those of the units in it.
fn kinds(bytes: &[u8]) -> Vec<u8> {
    let starts = bytes.windows(4).filter(|four| four[..3] == [0, 0, 1]);
    starts.map(|four| four[3] & 0x1f).collect()
}

#[test]
fn key_pictures_come_with_their_parameter_sets() {
    let Some(encoder) = encoder() else { return };
    let mut reader = reader(&format!(
        "videotestsrc is-live=true ! 'video/x-raw, width=64, height=48, framerate=30/1' ! {encoder}"
    ));
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
fn large_pictures_come_whole() {
    let Some(encoder) = encoder() else { return };
    // Noise takes many packets for a picture.
    let mut reader = reader(&format!(
        "videotestsrc is-live=true pattern=snow num-buffers=30 ! video/x-raw,width=640,height=480,framerate=30/1 ! {encoder}"
    ));
    let mut decoder = skein_video::H264Decoder::new().expect("a decoder");
    let mut shown = 0;
    loop {
        match next(&mut reader) {
            Ok(coded) => shown += usize::from(matches!(decoder.decode(&coded.bytes), Ok(Some(_)))),
            Err(StreamFault::Pipeline(PipelineFault::Ended)) => break,
            Err(fault) => panic!("{fault}"),
        }
    }
    assert!(shown >= 25, "{shown} of 30");
}

#[test]
fn what_cannot_be_made_or_gives_no_h264_says_why() {
    if !is_installed() {
        return;
    }
    let nothing = fault_of("videotestsrc ! there-is-none");
    assert_eq!(nothing, PipelineFault::NoElement("there-is-none".to_owned()));
    let syntax = fault_of("videotestsrc ! ! !");
    assert!(matches!(syntax, PipelineFault::Unmade(_)), "{syntax}");
    let open = fault_of("filesrc location='a");
    assert!(matches!(open, PipelineFault::Unmade(_)), "{open}");
    if encoder().is_none() {
        return;
    }
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

#[test]
fn nothing_of_one_is_left_that_nobody_wants_any_more() {
    let Some(encoder) = encoder() else { return };
    // One that gives pictures, and one that never does.
    let lasting =
        |pattern: &str| format!("videotestsrc is-live=true pattern={pattern} ! video/x-raw,width=64,height=48");
    for (mark, pipeline, gives) in [
        ("ball", format!("{} ! {encoder}", lasting("ball")), true),
        (
            "circular",
            format!("{} ! valve drop=true ! {encoder}", lasting("circular")),
            false,
        ),
    ] {
        let mut reader = reader(&pipeline);
        if gives {
            next(&mut reader).expect("a picture");
        }
        let runs = || {
            let mut search = Command::new("pgrep");
            search.args(["-P", &std::process::id().to_string(), "-f", &format!("pattern={mark}")]);
            search.stdout(Stdio::null()).status().expect("pgrep runs").success()
        };
        let until = |wanted: bool| {
            let begun = Instant::now();
            while runs() != wanted {
                assert!(begun.elapsed() < PATIENCE, "{mark}: {wanted} in vain");
                std::thread::sleep(Duration::from_millis(20));
            }
        };
        until(true);
        drop(reader);
        until(false);
    }
}

#[test]
fn what_it_prints_is_read_however_it_comes() {
    let of = |text: &str, code| {
        let mut said = Said::default();
        text.as_bytes().chunks(7).for_each(|bytes| said.take(bytes));
        said.fault(code)
    };
    let element = of(
        "ERROR: from element /GstPipeline:pipeline0/GstV4l2Src:v4l2src0: Cannot identify device '/dev/video9'.\nAdditional debug info:\n…\n",
        Some(1),
    );
    let expected = PipelineFault::Element {
        element: "v4l2src0".to_owned(),
        reason: "Cannot identify device '/dev/video9'.".to_owned(),
    };
    assert_eq!(element, expected);
    assert_eq!(of("", Some(0)), PipelineFault::Ended);
    let endless = "x".repeat(1 << 20);
    assert_eq!(of(&endless, None), PipelineFault::Ended);
    assert!(matches!(
        of("setpriv: failed\n", Some(127)),
        PipelineFault::NotInstalled(_)
    ));
}
