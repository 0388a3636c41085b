//! `skein vision evaluate` on clips made here, whose figures can be worked out by hand: the model always finds the same box.

use serde_json::Value;
use skein_domain::NodeTime;
use skein_domain::payload::{FrameHeader, PixelFormat};
use skein_video::{Coding, EncodedFrame, H264Encoder, Mp4Writer, Planes};
use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Output};

const SIZE_PX: (u32, u32) = (64, 48);
const PICTURES: u64 = 20;
/// The box that the model finds, as a label has it.
const FOUND: (f64, f64, f64, f64) = (12.0, 9.0, 8.0, 6.0);

/// A clip of twenty pictures of noise.
fn clip() -> Vec<u8> {
    let header = FrameHeader {
        width_px: SIZE_PX.0,
        height_px: SIZE_PX.1,
        format: PixelFormat::Gray8,
        ..FrameHeader::default()
    };
    let mut encoder = H264Encoder::new(SIZE_PX, 30.0).expect("an encoder");
    let frames: Vec<EncodedFrame> = (0..PICTURES)
        .map(|sequence| {
            let pixels: Vec<u8> = (0..SIZE_PX.0 * SIZE_PX.1)
                .map(|at| 90 + (at.wrapping_mul(31 + sequence as u32) % 13) as u8)
                .collect();
            let planes = Planes::of_frame(&header, &pixels).expect("pixels");
            let taken = NodeTime(5_000_000 + sequence * 33_333);
            let made = encoder
                .encode(taken, &planes, false)
                .expect("encoded")
                .expect("a picture");
            EncodedFrame {
                coding: Coding::H264,
                sequence,
                taken,
                width_px: SIZE_PX.0,
                height_px: SIZE_PX.1,
                key: made.key,
                bytes: made.bytes.into(),
            }
        })
        .collect();
    let (mut writer, mut file) = Mp4Writer::new(&frames[0]).expect("a file");
    for frame in &frames {
        file.extend(writer.push(frame).expect("taken").unwrap_or_default());
    }
    file.extend(writer.finish().expect("the rest"));
    file
}

/// A folder of clips: name, label, its file, and its labels' numbers and boxes.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("can be made"));
        std::fs::create_dir(folder.0.path().join("visible")).expect("can be made");
        folder.write("index.csv", b"camera,label,clip,frames,labelled_frames\n");
        folder
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.path().join(name), bytes).expect("can be written");
    }

    fn add(&self, name: &str, label: &str, video: &[u8], labels: impl Iterator<Item = (u64, (f64, f64, f64, f64))>) {
        let mut index = std::fs::read_to_string(self.path().join("index.csv")).expect("is there");
        writeln!(index, "visible,{label},{name}.mp4,{PICTURES},{PICTURES}").expect("is text");
        self.write("index.csv", index.as_bytes());
        self.write(&format!("visible/{name}.mp4"), video);
        let mut rows = "frame,x,y,width,height\n".to_owned();
        for (frame, (x, y, width, height)) in labels {
            writeln!(rows, "{frame},{x},{y},{width},{height}").expect("is text");
        }
        self.write(&format!("visible/{name}.csv"), rows.as_bytes());
    }

    fn evaluate(&self) -> (Option<i32>, String, String) {
        let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../plugins/detector/src/tests/models/constant.onnx");
        let config = serde_json::json!({ "path": model, "motion": false });
        let plugin = skein_testkit::plugins_dir().join("libdetector_plugin.so");
        let Output { status, stdout, stderr } = Command::new(skein_testkit::skein_binary())
            .args([
                "vision",
                "evaluate",
                "--json",
                "--config",
                &config.to_string(),
                "--clips",
            ])
            .arg(self.path())
            .arg("--plugin")
            .arg(plugin)
            .output()
            .expect("is started");
        let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
        (status.code(), text(stdout), text(stderr))
    }

    fn figures(&self) -> Value {
        let (code, said, told) = self.evaluate();
        assert_eq!(code, Some(0), "{told}");
        serde_json::from_str(&said).expect("is JSON")
    }
}

#[test]
fn figures_are_those_that_follow_from_clips_and_boxes() {
    let folder = Folder::new();
    let video = clip();
    // Told from the third picture on.
    folder.add("right", "drone", &video, (0..PICTURES).map(|n| (n, FOUND)));
    // Numbered from one.
    folder.add("from-one", "drone", &video, (1..=PICTURES).map(|n| (n, FOUND)));
    folder.add("bird", "bird", &video, (0..PICTURES).map(|n| (n, FOUND)));
    let figures = folder.figures();
    let camera = &figures["cameras"]["visible"];
    assert_eq!(
        (&camera["clips"], &camera["pictures"]),
        (&3.into(), &60.into()),
        "{figures}"
    );
    assert_eq!(camera["clips_numbered_from_one"], 1);
    assert_eq!(camera["pictures_not_decoded"], 0);
    let drone = &camera["classes"]["drone"];
    assert_eq!((&drone["objects"], &drone["told"]), (&40.into(), &54.into()));
    let share = |key: &str| drone[key].as_f64().expect("a number");
    assert!((share("precision") - 36.0 / 54.0).abs() < 1e-3, "{drone}");
    assert!((share("recall") - 36.0 / 40.0).abs() < 1e-3, "{drone}");
    assert!((share("f1") - 72.0 / 94.0).abs() < 1e-3, "{drone}");
    assert_eq!(drone["identity_switches"], 0);
    assert_eq!(camera["classes"]["bird"]["recall"], 0.0);
    assert_eq!(camera["clips_called"]["bird"]["drone"], 1);
}

#[test]
fn a_clip_that_ends_in_the_middle_of_a_picture_is_looked_at_as_far_as_it_goes() {
    let folder = Folder::new();
    let video = clip();
    folder.add(
        "cut",
        "drone",
        &video[..video.len() * 3 / 4],
        (0..PICTURES).map(|n| (n, FOUND)),
    );
    let (code, said, told) = folder.evaluate();
    // How much of a fragment is whole depends on the file; it is either looked at in part, or said to hold nothing.
    if code == Some(0) {
        let figures: Value = serde_json::from_str(&said).expect("is JSON");
        let pictures = figures["cameras"]["visible"]["pictures"].as_u64().expect("a number");
        assert!((1..PICTURES).contains(&pictures), "{figures}");
    } else {
        assert!(told.contains("cut.mp4"), "{told}");
    }
}

/// Makes a folder wrong.
type Spoil = fn(&Folder);

#[test]
fn what_is_wrong_with_a_folder_is_said_with_its_file() {
    let video = clip();
    let wrong: [(&str, Spoil, &str); 4] = [
        (
            "no list",
            |folder| std::fs::remove_file(folder.path().join("index.csv")).expect("is there"),
            "index.csv",
        ),
        (
            "no labels",
            |folder| std::fs::remove_file(folder.path().join("visible/a.csv")).expect("is there"),
            "a.csv",
        ),
        (
            "a label that is none",
            |folder| folder.write("visible/a.csv", b"frame,x,y,width,height\n0,1,2,NaN,4\n"),
            "a.csv",
        ),
        ("no video", |folder| folder.write("visible/a.mp4", b"no video"), "a.mp4"),
    ];
    for (what, make, named) in wrong {
        let folder = Folder::new();
        folder.add("a", "drone", &video, (0..PICTURES).map(|n| (n, FOUND)));
        make(&folder);
        let (code, _, told) = folder.evaluate();
        assert_eq!(code, Some(1), "{what}");
        assert!(told.contains(named), "{what}: {told}");
    }
}
