//! Tests of streams and their viewers.

use super::*;

fn frame(sequence: u64, key: bool) -> EncodedFrame {
    EncodedFrame {
        coding: Coding::H264,
        sequence,
        taken: NodeTime(sequence * 33_333),
        width_px: 64,
        height_px: 48,
        key,
        bytes: vec![0; 10].into(),
    }
}

#[tokio::test]
async fn a_viewer_waits_for_pictures_and_gets_all_of_them() {
    let stream = Arc::new(VideoStream::default());
    let mut viewer = stream.view();
    let source = stream.clone();
    let pushed = tokio::spawn(async move {
        for sequence in 0..50 {
            source.push(frame(sequence, sequence == 0));
            tokio::task::yield_now().await;
        }
    });
    for sequence in 0..50 {
        assert_eq!(viewer.next().await.frame.sequence, sequence);
    }
    pushed.await.expect("it ends");
}

#[test]
fn viewers_are_counted_and_ask_for_key_pictures() {
    let stream = Arc::new(VideoStream::default());
    let mut viewer = stream.view();
    assert_eq!(stream.viewers(), 1);
    stream.push(frame(0, false));
    assert!(viewer.try_next().is_none());
    assert!(stream.take_wish_for_key() && !stream.take_wish_for_key());
    drop(viewer);
    assert_eq!(stream.viewers(), 0);
}

#[test]
fn only_one_makes_the_pictures_of_a_stream() {
    let stream = Arc::new(VideoStream::default());
    let making = stream.begin_making();
    assert!(making.is_some() && stream.begin_making().is_none());
    drop(making);
    assert!(stream.begin_making().is_some());
}

#[test]
fn a_camera_that_gives_nothing_is_told_by_when_it_began() {
    let video = Video::default();
    video.begin(NodeTime(0));
    assert_eq!(video.health(NodeTime(1_000_000)).state, VideoState::Starting);
    assert_eq!(video.health(NodeTime(6_000_000)).state, VideoState::NoPictures);
}

#[test]
fn after_a_lost_picture_none_is_shown_until_the_next_key_picture() {
    let mut source = Source::default();
    let mut shown = |sequence, key| !source.breaks_off(&frame(sequence, key));
    assert!(shown(1, true) && shown(2, false));
    // 3 is lost
    assert!(!shown(4, false) && !shown(5, false));
    assert!(shown(6, true) && shown(7, false));
    // the camera begins anew, in the middle of a group
    assert!(!shown(1, false) && shown(2, true));
    // a number that nothing can follow
    let last = EncodedFrame {
        sequence: u64::MAX,
        ..frame(0, true)
    };
    assert!(!source.breaks_off(&last) && source.breaks_off(&frame(0, false)));
}
