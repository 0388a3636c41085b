//! Frames of others that came with a call to this child, read where they are.

use super::message::FramePlace;
use crate::services::Readable;
use rustix::mm::{MapFlags, ProtFlags};
use std::os::fd::OwnedFd;
use std::ptr::NonNull;
use std::sync::OnceLock;

/// A frame that came with a call; its bytes are looked up when they are asked for.
#[derive(Debug)]
pub(crate) struct ReceivedFrame {
    place: FramePlace,
    file: OwnedFd,
    mapped: OnceLock<Option<NonNull<u8>>>,
}

// SAFETY: the mapping belongs to this value and is only read.
unsafe impl Send for ReceivedFrame {}
// SAFETY: as above.
unsafe impl Sync for ReceivedFrame {}

impl ReceivedFrame {
    pub(crate) fn new(place: FramePlace, file: OwnedFd) -> Self {
        Self {
            place,
            file,
            mapped: OnceLock::new(),
        }
    }

    fn len(&self) -> usize {
        usize::try_from(self.place.len).unwrap_or(0)
    }

    fn map(&self) -> Option<NonNull<u8>> {
        let (len, offset) = (self.len(), self.place.offset);
        // SAFETY: a new mapping at a place of the system's choice; the node vouches for place and length.
        let base = unsafe {
            rustix::mm::mmap(
                std::ptr::null_mut(),
                len,
                ProtFlags::READ,
                MapFlags::SHARED,
                &self.file,
                offset,
            )
        };
        base.ok().and_then(|base| NonNull::new(base.cast()))
    }
}

impl Readable for ReceivedFrame {
    fn id(&self) -> u64 {
        self.place.id
    }

    fn bytes(&self) -> &[u8] {
        match self.mapped.get_or_init(|| self.map()) {
            // SAFETY: mapped with this length as long as `self` lives.
            Some(base) => unsafe { std::slice::from_raw_parts(base.as_ptr(), self.len()) },
            None => &[],
        }
    }
}

impl Drop for ReceivedFrame {
    fn drop(&mut self) {
        if let Some(Some(base)) = self.mapped.get() {
            // SAFETY: made in `map` with this length; nobody borrows from it any more.
            let unmapped = unsafe { rustix::mm::munmap(base.as_ptr().cast(), self.len()) };
            debug_assert!(unmapped.is_ok());
        }
    }
}
