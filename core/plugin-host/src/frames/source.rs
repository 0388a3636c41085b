//! Frames of the host's own: pictures that no instance gave, shown to instances as a camera's are.

use super::{Frame, FrameMemory};
use crate::PluginError;
use skein_domain::payload::FrameHeader;
use std::sync::Arc;

/// Makes frames. A few at a time: each gives its place back with the last of its readers.
#[derive(Debug)]
pub struct FrameSource(Arc<FrameMemory>);

impl FrameSource {
    /// # Errors
    ///
    /// The system gives no memory that can be shared.
    pub fn new() -> std::io::Result<Self> {
        FrameMemory::new().map(Self)
    }

    /// A frame of these bytes; the header's id and length are filled in.
    ///
    /// # Errors
    ///
    /// Its header does not fit the bytes, they are too many, or too many frames are in use.
    pub fn frame(&self, header: FrameHeader, bytes: &[u8]) -> Result<Arc<Frame>, PluginError> {
        let buffer = self.0.acquire(bytes.len());
        if buffer.data.is_null() {
            return Err(PluginError::BadFrame {
                detail: format!("there is no room for {} bytes", bytes.len()),
            });
        }
        // SAFETY: `acquire` lends as many bytes to nobody else until `give`.
        unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), buffer.data, bytes.len()) };
        self.0.give(FrameHeader {
            id: buffer.id,
            len: bytes.len() as u64,
            ..header
        })
    }
}
