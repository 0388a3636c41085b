//! The services as a plugin calls them: through the table it is given.

use super::*;
use crate::frames::MAX_FRAME_BYTES;

fn services(lends: bool) -> Services {
    Services::new(LogSink::new("p".to_owned(), "vehicle-1".to_owned()), Pool::new(lends))
}

#[test]
fn any_line_is_taken() {
    let services = services(false);
    let given = services.for_plugin();
    for (level, bytes) in [(0, b"\xff\xfe".as_slice()), (3, b""), (99, &[b'x'; 10_000])] {
        // SAFETY: the services live; the bytes are lent for the call.
        unsafe { (given.log)(given.context, level, Slice::of(bytes)) };
    }
    let impossible = Slice {
        data: std::ptr::dangling(),
        len: usize::MAX,
    };
    // SAFETY: as above; a length that cannot be is looked at first.
    unsafe { (given.log)(given.context, 3, impossible) };
}

#[test]
fn buffers_are_lent_by_those_who_may_and_taken_back() {
    let none = services(false);
    let given = none.for_plugin();
    // SAFETY: the services live.
    assert_eq!(unsafe { (given.acquire_frame)(given.context, 10) }.id, 0);
    let some = services(true);
    let given = some.for_plugin();
    for _ in 0..100 {
        // SAFETY: the services live.
        let buffer = unsafe { (given.acquire_frame)(given.context, MAX_FRAME_BYTES) };
        assert_ne!(buffer.id, 0);
        assert_eq!(buffer.len, MAX_FRAME_BYTES);
        // SAFETY: the services live.
        unsafe { (given.release_frame)(given.context, buffer.id) };
    }
    for id in [0, 1, 77, u64::MAX] {
        // SAFETY: the services live; a number nobody was given has no effect.
        unsafe { (given.release_frame)(given.context, id) };
    }
}

#[derive(Debug)]
struct Picture(u64, Vec<u8>);

impl Readable for Picture {
    fn id(&self) -> u64 {
        self.0
    }

    fn bytes(&self) -> &[u8] {
        &self.1
    }
}

#[test]
fn frames_can_be_read_during_the_call_only() {
    let services = services(false);
    let given = services.for_plugin();
    let read = |id| {
        // SAFETY: the services live, and the picture as long as the call.
        unsafe { (given.read_frame)(given.context, id).as_bytes() }.to_vec()
    };
    let pictures: [Arc<dyn Readable>; 2] = [Arc::new(Picture(3, vec![1, 2])), Arc::new(Picture(4, vec![9]))];
    let seen = services.with_frames(pictures.to_vec(), || (read(3), read(4), read(5)));
    assert_eq!(seen, (vec![1, 2], vec![9], vec![]));
    assert_eq!(read(3), Vec::<u8>::new());
}
