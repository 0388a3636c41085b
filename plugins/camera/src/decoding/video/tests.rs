//! Tests of video: a file made here, whose pictures are known.

use super::*;
use crate::decoding::{self, Files, Reader};
use crate::stream::{Origin, StreamReader};
use skein_plugin_sdk::domain::NodeTime;
use skein_plugin_sdk::domain::payload::{FrameHeader, PixelFormat};
use skein_video::{Coding, EncodedFrame, H264Encoder, Mp4Writer, Planes};
use std::time::{Duration, Instant};

const WIDTH: usize = 64;
const HEIGHT: usize = 48;
const PICTURES: u32 = 20;
const RATE_HZ: u32 = 10;

fn brightness_of(index: u32) -> u8 {
    40 + 8 * index as u8
}

/// A video of grey pictures that become brighter one by one.
fn mp4() -> Vec<u8> {
    let header = FrameHeader {
        width_px: WIDTH as u32,
        height_px: HEIGHT as u32,
        format: PixelFormat::Gray8,
        ..FrameHeader::default()
    };
    let mut encoder = H264Encoder::new((header.width_px, header.height_px), f64::from(RATE_HZ)).unwrap();
    let (mut writer, mut bytes) = (None, Vec::new());
    for index in 0..PICTURES {
        let planes = Planes::of_frame(&header, &[brightness_of(index); WIDTH * HEIGHT]).unwrap();
        let taken = NodeTime::from_seconds(f64::from(index) / f64::from(RATE_HZ));
        let made = encoder.encode(taken, &planes, false).unwrap().expect("a picture");
        let frame = EncodedFrame {
            coding: Coding::H264,
            sequence: u64::from(index),
            taken,
            width_px: header.width_px,
            height_px: header.height_px,
            key: made.key,
            bytes: made.bytes.into(),
        };
        let writer = writer.get_or_insert_with(|| {
            let (writer, begin) = Mp4Writer::new(&frame).unwrap();
            bytes.extend(begin);
            writer
        });
        bytes.extend(writer.push(&frame).unwrap().unwrap_or_default());
    }
    bytes.extend(writer.and_then(Mp4Writer::finish).unwrap_or_default());
    bytes
}

fn file(bytes: &[u8]) -> tempfile::NamedTempFile {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    file
}

/// The next picture's brightness or the next error, however long it takes.
fn next(reader: &mut Reader) -> Result<u8, DecodeError> {
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(20) {
        match reader.take() {
            Ok(Some(picture)) => {
                assert_eq!((picture.width_px, picture.height_px), (WIDTH as u32, HEIGHT as u32));
                return Ok(picture.rgb[picture.rgb.len() / 2]);
            }
            Ok(None) => std::thread::yield_now(),
            Err(error) => return Err(error),
        }
    }
    panic!("no picture came");
}

fn reads(path: &Path, rate_hz: f64, taken: u64) -> Reader {
    let path = path.to_owned();
    decoding::start(Files::Video { path, rate_hz }, taken).unwrap()
}

fn assert_shows(reader: &mut Reader, indexes: impl IntoIterator<Item = u32>) {
    for index in indexes {
        let wanted = f64::from(brightness_of(index));
        let seen = f64::from(next(reader).unwrap());
        assert!((seen - wanted).abs() < 6.0, "picture {index}: {seen}, not {wanted}");
    }
}

#[test]
fn every_picture_comes_in_its_order_again_and_again() {
    let file = file(&mp4());
    let mut reader = reads(file.path(), f64::from(RATE_HZ), 0);
    assert_shows(&mut reader, (0..PICTURES).chain(0..5));
}

#[test]
fn at_a_lower_rate_the_video_keeps_its_speed() {
    let file = file(&mp4());
    let mut reader = reads(file.path(), 5.0, 0);
    assert_shows(&mut reader, (0..PICTURES).step_by(2).chain([0, 2]));
    // Another instance goes on behind what was taken.
    let mut reader = reads(file.path(), 5.0, 13);
    assert_shows(&mut reader, [6, 8]);
}

#[test]
fn a_file_cut_off_shows_what_is_there_or_says_why_not() {
    let bytes = mp4();
    let cut = file(&bytes[..bytes.len() * 3 / 4]);
    assert_shows(&mut reads(cut.path(), f64::from(RATE_HZ), 0), 0..5);
    assert!(matches!(
        next(&mut reads(Path::new("/nowhere"), 10.0, 0)),
        Err(DecodeError::Video(_))
    ));
    let text = file(b"this is no video at all, but a sentence");
    assert!(next(&mut reads(text.path(), 10.0, 0)).is_err());
}

#[test]
fn pictures_are_picked_by_time() {
    let shown: Vec<f64> = (0..30).map(|index| f64::from(index) / 30.0).collect();
    assert_eq!(pick(&shown, 5.0), [0, 6, 12, 18, 24]);
    assert_eq!(pick(&shown, 60.0).len(), 30);
    // A gap is not made up for.
    assert_eq!(pick(&[0.0, 0.1, 2.0, 2.1, 2.2], 5.0), [0, 2, 4]);
    assert_eq!(pick(&[], 5.0), [0_usize; 0]);
}

#[test]
fn as_a_stream_its_pictures_come_as_they_are_encoded_and_at_their_pace() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("video.mp4");
    std::fs::write(&path, mp4()).unwrap();
    // round and round
    let mut reader = StreamReader::start(Origin::File(path)).unwrap();
    let mut due_s = Vec::new();
    while due_s.len() < 2 * PICTURES as usize {
        match reader.take(f64::INFINITY).unwrap() {
            Some(coded) => due_s.push(coded.due_s.unwrap()),
            None => std::thread::yield_now(),
        }
    }
    assert!(
        due_s.windows(2).all(|pair| (pair[1] - pair[0] - 0.1).abs() < 1e-4),
        "{due_s:?}"
    );
}
