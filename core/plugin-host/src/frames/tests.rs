//! Slots: who has them, when they come back, which headers fit.

use super::*;

fn header(id: u64, format: PixelFormat, size: (u32, u32), stride_bytes: u32, len: u64) -> FrameHeader {
    FrameHeader {
        id,
        width_px: size.0,
        height_px: size.1,
        stride_bytes,
        format,
        len,
        ..FrameHeader::default()
    }
}

fn gray(id: u64, len: u32) -> FrameHeader {
    header(id, PixelFormat::Gray8, (len, 1), 0, len.into())
}

#[test]
fn a_slot_is_lent_once_and_comes_back_with_the_last_frame() {
    let memory = FrameMemory::new().expect("there is memory");
    let lent: Vec<_> = (1..=SLOTS).map(|i| memory.acquire(10 * i)).collect();
    assert!(lent.iter().all(|buffer| buffer.id != 0 && !buffer.data.is_null()));
    assert_eq!(memory.acquire(1).id, 0, "all are in use");
    // SAFETY: lent and not given away; ten bytes.
    unsafe { lent[0].data.write_bytes(7, 10) };
    let frame = memory.give(gray(lent[0].id, 10)).expect("was lent");
    assert_eq!(frame.bytes(), [7; 10]);
    assert!(memory.give(gray(lent[0].id, 10)).is_err(), "given away once");
    memory.release(lent[0].id);
    assert_eq!(
        memory.acquire(1).id,
        0,
        "what was given away is not the plugin's to release"
    );
    let second = Arc::clone(&frame);
    drop(frame);
    assert_eq!(memory.acquire(1).id, 0, "it is still being read");
    drop(second);
    let again = memory.acquire(10);
    assert_ne!(again.id, lent[0].id, "an old number is worth nothing");
    assert_eq!(again.data, lent[0].data, "the same place");
    assert!(memory.give(gray(lent[0].id, 10)).is_err());
    memory.release(lent[0].id);
    assert_eq!(memory.acquire(1).id, 0, "released under an old number");
    memory.release(again.id);
    assert_ne!(memory.acquire(1).id, 0);
}

#[test]
fn sizes_are_bounded_and_buffers_are_zero_at_first() {
    let memory = FrameMemory::new().expect("there is memory");
    assert_eq!(memory.acquire(0).id, 0);
    assert_eq!(memory.acquire(MAX_FRAME_BYTES + 1).id, 0);
    assert_eq!(memory.acquire(usize::MAX).id, 0);
    let buffer = memory.acquire(MAX_FRAME_BYTES);
    let len = MAX_FRAME_BYTES as u32;
    let frame = memory.give(gray(buffer.id, len)).expect("fits");
    assert_eq!(frame.bytes().len(), MAX_FRAME_BYTES);
    assert!(frame.bytes().iter().step_by(4096).all(|byte| *byte == 0));
}

#[test]
fn headers_are_held_against_the_bytes() {
    use PixelFormat::{Gray8, Jpeg, Rgb8};
    let memory = FrameMemory::new().expect("there is memory");
    let cases = [
        (Gray8, (10, 10), 0, 100, true),
        (Gray8, (10, 10), 10, 100, true),
        (Gray8, (10, 10), 12, 118, true),
        (Gray8, (10, 10), 12, 117, false),
        (Gray8, (10, 10), 9, 100, false),
        (Gray8, (0, 10), 0, 100, false),
        (Gray8, (10, 0), 0, 100, false),
        (Gray8, (10, 11), 0, 100, false),
        (Gray8, (10, 10), 0, 99, false),
        (Gray8, (u32::MAX, u32::MAX), u32::MAX, 100, false),
        (Rgb8, (10, 10), 0, 300, true),
        (Rgb8, (10, 10), 0, 299, false),
        (Rgb8, (10, 10), 10, 300, false),
        (Jpeg, (4000, 3000), 0, 20, true),
        (Jpeg, (4000, 3000), 0, 0, false),
        (Jpeg, (0, 0), 0, 20, false),
        (Jpeg, (1, 1), 0, 301, false),
        (Jpeg, (1, 1), 0, u64::MAX, false),
    ];
    for (format, size, stride, len, fits) in cases {
        let buffer = memory.acquire(300);
        assert_ne!(buffer.id, 0, "what does not fit gives its slot back");
        let given = memory.give(header(buffer.id, format, size, stride, len));
        assert_eq!(given.is_ok(), fits, "{format:?} {size:?} {stride} {len}: {given:?}");
    }
}

#[test]
fn another_mapping_of_the_file_is_the_same_memory_and_cannot_take_what_is_read() {
    let here = FrameMemory::new().expect("there is memory");
    let there = FrameMemory::map(here.file().try_clone_to_owned().expect("is duplicated")).expect("is mapped");
    let buffer = there.acquire(4);
    // SAFETY: lent and not given away; four bytes.
    unsafe { buffer.data.copy_from_nonoverlapping(b"seen".as_ptr(), 4) };
    let frame = here.give(gray(buffer.id, 4)).expect("was lent there");
    assert_eq!(frame.bytes(), b"seen");
    // The other side breaks the rules: frees what is being read and lends it again.
    there.control().slots[frame.slot].store(FREE, Ordering::Relaxed);
    let stolen = there.acquire(4);
    assert!(here.give(gray(stolen.id, 4)).is_err(), "it is being read here");
    drop(frame);
    assert!(here.reading.iter().all(|reading| !reading.load(Ordering::Relaxed)));
    let small = rustix::fs::memfd_create("too-small", MemfdFlags::CLOEXEC).expect("is made");
    assert!(FrameMemory::map(small).is_err());
}

#[test]
fn a_buffer_that_was_not_given_back_stays_where_it_is() {
    let memory = FrameMemory::new().expect("there is memory");
    let buffer = memory.acquire(4);
    drop(memory);
    // SAFETY: lent and not given away; four bytes.
    let bytes = unsafe { std::slice::from_raw_parts_mut(buffer.data, 4) };
    bytes.copy_from_slice(b"late");
    assert_eq!(bytes, b"late");
}

#[test]
fn the_file_can_be_cut_off_by_nobody() {
    let memory = FrameMemory::new().expect("there is memory");
    assert!(rustix::fs::ftruncate(memory.file(), 0).is_err());
}

#[test]
fn a_pool_that_lends_none_has_no_memory() {
    assert!(Pool::new(false).memory_or_new().is_none());
    let pool = Pool::new(true);
    assert!(pool.memory().is_none(), "made when it is asked for");
    assert!(pool.give(gray(5, 1)).is_err());
    assert!(pool.memory_or_new().is_some() && pool.memory().is_some());
}
