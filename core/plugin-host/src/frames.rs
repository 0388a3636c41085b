//! Frames: memory that an instance writes pictures into and everyone else reads, without a copy between the two. Each instance that gives
//! frames has a few slots of its own. The memory is a file without a name, so that a child process can share it.
//!
//! Must never do: lend a slot to two at once, or take it back while someone reads it.

mod source;

use crate::PluginError;
use parking_lot::Mutex;
use rustix::fs::{MemfdFlags, SealFlags};
use rustix::mm::{MapFlags, ProtFlags};
use skein_domain::payload::{FrameHeader, PixelFormat};
use skein_plugin_abi::FrameBuffer;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::ptr::NonNull;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

pub use source::FrameSource;

/// Slots of an instance. A camera that finds all of them in use drops the frame.
pub(crate) const SLOTS: usize = 4;
/// No frame is longer, in bytes: a picture of 4096 x 2160 points with three bytes each and some more. Memory that is not written to
/// is not used.
pub(crate) const MAX_FRAME_BYTES: usize = 32 << 20;
/// What comes before the first slot: [`Control`], and room up to the largest page there is.
const CONTROL_BYTES: usize = 64 << 10;
const TOTAL_BYTES: usize = CONTROL_BYTES + SLOTS * MAX_FRAME_BYTES;
/// Slots are told apart by the lowest bits of an id.
const SLOT_MASK: u64 = SLOTS as u64 - 1;
const _: () = assert!(SLOTS.is_power_of_two() && size_of::<Control>() <= CONTROL_BYTES);

/// A slot nobody uses.
const FREE: u64 = 0;
/// A slot that was given away and is being read.
const GIVEN: u64 = u64::MAX;

/// Names the frames of all instances of this process.
static NEXT_FRAME: AtomicU64 = AtomicU64::new(1);

/// Who has which slot. In memory that a child process shares: it holds nothing that this process relies on.
#[repr(C)]
struct Control {
    /// Per slot [`FREE`], [`GIVEN`] or the id under which it is lent.
    slots: [AtomicU64; SLOTS],
    /// Per slot, how many bytes were lent.
    lens: [AtomicU64; SLOTS],
    /// Counts the lendings.
    lent: AtomicU64,
}

/// The slots of one instance.
#[derive(Debug)]
pub(crate) struct FrameMemory {
    file: OwnedFd,
    base: NonNull<u8>,
    /// Which slots are being read. The truth of this process.
    reading: [AtomicBool; SLOTS],
    /// Whether a slot was ever lent to someone who writes through this mapping.
    lends: AtomicBool,
}

// SAFETY: the mapping belongs to this value; the control part is only used through atomics, and a slot by the one it is lent to or, once
// given away, by readers.
unsafe impl Send for FrameMemory {}
// SAFETY: as above.
unsafe impl Sync for FrameMemory {}

impl FrameMemory {
    /// New slots, all free.
    pub(crate) fn new() -> std::io::Result<Arc<Self>> {
        let file = rustix::fs::memfd_create("skein-frames", MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING)?;
        rustix::fs::ftruncate(&file, TOTAL_BYTES as u64)?;
        // Nobody can cut it off under a reader.
        rustix::fs::fcntl_add_seals(&file, SealFlags::SHRINK | SealFlags::GROW | SealFlags::SEAL)?;
        Self::map(file)
    }

    /// The slots in a file that another process made.
    pub(crate) fn map(file: OwnedFd) -> std::io::Result<Arc<Self>> {
        if rustix::fs::fstat(&file)?.st_size != TOTAL_BYTES as i64 {
            return Err(std::io::Error::other("the frame memory has another size"));
        }
        // SAFETY: a new mapping at a place of the system's choice.
        let base = unsafe {
            rustix::mm::mmap(
                std::ptr::null_mut(),
                TOTAL_BYTES,
                ProtFlags::READ | ProtFlags::WRITE,
                MapFlags::SHARED,
                &file,
                0,
            )
        }?;
        let base = NonNull::new(base.cast()).ok_or_else(|| std::io::Error::other("mapped at address 0"))?;
        Ok(Arc::new(Self {
            file,
            base,
            reading: [const { AtomicBool::new(false) }; SLOTS],
            lends: AtomicBool::new(false),
        }))
    }

    /// The file, to be shared.
    pub(crate) fn file(&self) -> BorrowedFd<'_> {
        self.file.as_fd()
    }

    fn control(&self) -> &Control {
        // SAFETY: the mapping begins with it, page-aligned, and lives as long as `self`; any bits make atomics.
        unsafe { self.base.cast::<Control>().as_ref() }
    }

    /// Where a slot begins. `slot` is below [`SLOTS`].
    fn slot(&self, slot: usize) -> *mut u8 {
        // SAFETY: within the mapping.
        unsafe { self.base.as_ptr().add(slot_offset(slot)) }
    }

    /// Lends a free slot. The bytes are what they were left as, zeros at first.
    pub(crate) fn acquire(&self, len: usize) -> FrameBuffer {
        if len == 0 || len > MAX_FRAME_BYTES {
            return FrameBuffer::NONE;
        }
        let control = self.control();
        for (slot, (state, lent_len)) in control.slots.iter().zip(&control.lens).enumerate() {
            if state.load(Ordering::Relaxed) != FREE {
                continue;
            }
            let count = control.lent.fetch_add(1, Ordering::Relaxed).wrapping_add(1) & (u64::MAX >> 8);
            let id = (count * SLOTS as u64) | slot as u64;
            if state
                .compare_exchange(FREE, id, Ordering::Acquire, Ordering::Relaxed)
                .is_ok()
            {
                lent_len.store(len as u64, Ordering::Relaxed);
                self.lends.store(true, Ordering::Relaxed);
                return FrameBuffer {
                    id,
                    data: self.slot(slot),
                    len,
                };
            }
        }
        FrameBuffer::NONE
    }

    /// Takes back a slot that was lent under this id and not given away.
    pub(crate) fn release(&self, id: u64) {
        if let Some(state) = self.control().slots.get(slot_of(id))
            && is_id(id)
        {
            // Anything else is none of the caller's, and stays as it is.
            let _ = state.compare_exchange(id, FREE, Ordering::Release, Ordering::Relaxed);
        }
    }

    /// A slot that was lent under the header's id is given away: makes a frame of it.
    pub(crate) fn give(self: &Arc<Self>, header: FrameHeader) -> Result<Arc<Frame>, PluginError> {
        let (id, slot) = (header.id, slot_of(header.id));
        let control = self.control();
        let not_lent = || PluginError::BadFrame {
            detail: format!("no buffer is lent under the number {id}"),
        };
        let (Some(state), Some(lent_len), Some(reading)) =
            (control.slots.get(slot), control.lens.get(slot), self.reading.get(slot))
        else {
            return Err(not_lent());
        };
        if !is_id(id)
            || state
                .compare_exchange(id, GIVEN, Ordering::AcqRel, Ordering::Relaxed)
                .is_err()
        {
            return Err(not_lent());
        }
        if reading.swap(true, Ordering::AcqRel) {
            // The other process says that it was lent, but it cannot be: it is being read.
            return Err(not_lent());
        }
        // From here on the slot comes back when the frame goes.
        let frame = Frame {
            len: 0,
            header,
            slot,
            memory: Arc::clone(self),
        };
        let lent_len = lent_len.load(Ordering::Relaxed).min(MAX_FRAME_BYTES as u64);
        frame.finished(lent_len).map(Arc::new)
    }
}

impl Drop for FrameMemory {
    fn drop(&mut self) {
        let is_lent = |slot: &AtomicU64| is_id(slot.load(Ordering::Acquire));
        if self.lends.load(Ordering::Relaxed) && self.control().slots.iter().any(is_lent) {
            // A thread of the plugin that outlives its instance may still write to it: it stays mapped until this process ends.
            return;
        }
        // SAFETY: made in `map` with this length; nobody borrows from it any more.
        let unmapped = unsafe { rustix::mm::munmap(self.base.as_ptr().cast(), TOTAL_BYTES) };
        debug_assert!(unmapped.is_ok());
    }
}

const fn slot_of(id: u64) -> usize {
    (id & SLOT_MASK) as usize
}

const fn is_id(id: u64) -> bool {
    id != FREE && id != GIVEN
}

const fn slot_offset(slot: usize) -> usize {
    CONTROL_BYTES + slot * MAX_FRAME_BYTES
}

/// A frame that an instance gave. Its bytes are where the instance wrote them; the slot goes back to the instance with the last of these.
#[derive(Debug)]
pub struct Frame {
    /// What is known of it. Its id is this process's own and never given twice.
    pub header: FrameHeader,
    slot: usize,
    len: usize,
    memory: Arc<FrameMemory>,
}

impl Frame {
    /// The bytes. Of an instance in a child process they are in memory that this process shares with it: an instance that breaks the rules
    /// can still change them, so that a reader must not take what it has read once for what it will read again.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        // SAFETY: the slot is initialised, at least this long and mapped as long as `self.memory` lives; by the rules of the boundary
        // nobody writes to it after it was given away, and it is lent again only when `self` goes.
        unsafe { std::slice::from_raw_parts(self.memory.slot(self.slot), self.len) }
    }

    /// The file the bytes are in, and where in it they begin.
    pub(crate) fn place(&self) -> (BorrowedFd<'_>, u64) {
        (self.memory.file(), slot_offset(self.slot) as u64)
    }

    fn finished(self, lent_len: u64) -> Result<Self, PluginError> {
        let bad = |detail: String| Err(PluginError::BadFrame { detail });
        let header = &self.header;
        if header.len == 0 || header.len > lent_len {
            return bad(format!("it has {} bytes in a buffer of {lent_len}", header.len));
        }
        let needed = match header.format {
            PixelFormat::Gray8 => rows(header, 1),
            PixelFormat::Rgb8 => rows(header, 3),
            PixelFormat::Jpeg => Some(1),
            // How large it is stands in it.
            PixelFormat::H264 => return Ok(self.named()),
        };
        let (width, height) = (header.width_px, header.height_px);
        match needed {
            Some(needed) if width > 0 && height > 0 && needed <= header.len => {}
            _ => {
                return bad(format!(
                    "{width} x {height} points with {} bytes a row do not fit into {} bytes",
                    header.stride_bytes, header.len
                ));
            }
        }
        Ok(self.named())
    }

    fn named(mut self) -> Self {
        self.len = usize::try_from(self.header.len).unwrap_or(0);
        self.header.id = NEXT_FRAME.fetch_add(1, Ordering::Relaxed);
        self
    }
}

/// How many bytes the rows take; `None` if the header contradicts itself.
fn rows(header: &FrameHeader, bytes_per_pixel: u64) -> Option<u64> {
    let row = u64::from(header.width_px) * bytes_per_pixel;
    let stride = match u64::from(header.stride_bytes) {
        0 => row,
        stride => stride,
    };
    if stride < row {
        return None;
    }
    let before_last = stride.checked_mul(u64::from(header.height_px).saturating_sub(1))?;
    before_last.checked_add(row)
}

impl Drop for Frame {
    fn drop(&mut self) {
        if let Some(reading) = self.memory.reading.get(self.slot) {
            reading.store(false, Ordering::Release);
        }
        if let Some(state) = self.memory.control().slots.get(self.slot) {
            state.store(FREE, Ordering::Release);
        }
    }
}

/// The slots of an instance, made when the first is asked for, if it may have any.
#[derive(Debug)]
pub(crate) struct Pool {
    lends: bool,
    memory: Mutex<Option<Arc<FrameMemory>>>,
}

impl Pool {
    /// A pool that lends, or none.
    pub(crate) fn new(lends: bool) -> Self {
        Self {
            lends,
            memory: Mutex::new(None),
        }
    }

    /// The slots that another process made, if it did.
    pub(crate) fn shared(memory: Option<Arc<FrameMemory>>) -> Self {
        Self {
            lends: memory.is_some(),
            memory: Mutex::new(memory),
        }
    }

    /// The slots, if any was asked for yet.
    pub(crate) fn memory(&self) -> Option<Arc<FrameMemory>> {
        self.memory.lock().clone()
    }

    /// The slots, made now if need be.
    pub(crate) fn memory_or_new(&self) -> Option<Arc<FrameMemory>> {
        let mut memory = self.memory.lock();
        if memory.is_none() && self.lends {
            match FrameMemory::new() {
                Ok(new) => *memory = Some(new),
                Err(error) => tracing::error!(target: "plugin", "no memory for frames: {error}"),
            }
        }
        memory.clone()
    }

    /// A slot given away under this header.
    pub(crate) fn give(&self, header: FrameHeader) -> Result<Arc<Frame>, PluginError> {
        let memory = self.memory().ok_or_else(|| PluginError::BadFrame {
            detail: "no buffer was ever lent".to_owned(),
        })?;
        memory.give(header)
    }
}

#[cfg(test)]
mod tests;
