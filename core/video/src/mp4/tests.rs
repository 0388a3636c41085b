//! Tests of recordings, read by another library.

use super::*;
use crate::codec::H264Encoder;
use crate::frame::Coding;
use crate::planes::Planes;
use mp4parse::unstable::{CheckedInteger, create_sample_table};
use skein_domain::payload::{FrameHeader, PixelFormat};

fn frames(count: u64) -> Vec<EncodedFrame> {
    let header = FrameHeader {
        width_px: 96,
        height_px: 64,
        format: PixelFormat::Gray8,
        ..FrameHeader::default()
    };
    let mut encoder = H264Encoder::new((96, 64), 30.0).expect("an encoder");
    let of = |sequence: u64| {
        let planes = Planes::of_frame(&header, &vec![(sequence * 2) as u8; 96 * 64]).expect("pixels");
        let taken = NodeTime(5_000_000 + sequence * 33_333);
        let made = encoder
            .encode(taken, &planes, false)
            .expect("encoded")
            .expect("a picture");
        EncodedFrame {
            coding: Coding::H264,
            sequence,
            taken,
            width_px: 96,
            height_px: 64,
            key: made.key,
            bytes: made.bytes.into(),
        }
    };
    (0..count).map(of).collect()
}

/// The file, and where it was whole.
fn written(frames: &[EncodedFrame]) -> (Vec<u8>, Vec<usize>) {
    let (mut writer, mut file) = Mp4Writer::new(&frames[0]).expect("a file");
    let mut whole_at = vec![file.len()];
    for frame in frames {
        if let Some(bytes) = writer.push(frame).expect("taken") {
            file.extend(bytes);
            whole_at.push(file.len());
        }
    }
    file.extend(writer.finish().expect("the rest"));
    (file, whole_at)
}

#[test]
fn it_is_a_file_that_tells_its_size_and_codec() {
    let (file, whole_at) = written(&frames(100));
    assert_eq!(whole_at.len(), 4, "one after each second");
    let context = mp4parse::read_mp4(&mut file.as_slice()).expect("an MP4 file");
    let track = &context.tracks[0];
    let entry = &track.stsd.as_ref().expect("a description").descriptions[0];
    let mp4parse::SampleEntry::Video(video) = entry else {
        panic!("{entry:?}")
    };
    assert_eq!(
        (video.width, video.height, video.codec_type),
        (96, 64, mp4parse::CodecType::H264)
    );
    // its pictures are in the fragments, which this reader does not look into
    assert!(create_sample_table(track, CheckedInteger(0)).is_none_or(|table| table.is_empty()));
}

#[test]
fn it_begins_with_a_key_picture() {
    let frames = frames(3);
    assert!(matches!(Mp4Writer::new(&frames[1]), Err(Mp4Error::NoKeyPicture)));
}
