//! Bytes as they cross: borrowed ([`Slice`]) and owned by the plugin that made them ([`Buffer`]).

/// Borrowed bytes, valid for the time of one call.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Slice {
    /// First byte; may be null when `len` is 0.
    pub data: *const u8,
    /// Number of bytes.
    pub len: usize,
}

impl Slice {
    /// The bytes of `bytes`, borrowed: the caller keeps them alive as long as the slice is used.
    #[must_use]
    pub const fn of(bytes: &[u8]) -> Self {
        Self {
            data: bytes.as_ptr(),
            len: bytes.len(),
        }
    }

    /// The bytes.
    ///
    /// # Safety
    /// `data` must point to `len` initialised bytes that stay valid and unchanged for `'a`, or be null.
    #[must_use]
    pub unsafe fn as_bytes<'a>(self) -> &'a [u8] {
        if self.data.is_null() || self.len == 0 {
            return &[];
        }
        // SAFETY: not null; the caller vouches for length, initialisation and life time.
        unsafe { std::slice::from_raw_parts(self.data, self.len) }
    }
}

/// Bytes owned by the plugin that made them; they go back to it through [`crate::PluginTable::free`].
#[derive(Debug)]
#[repr(C)]
pub struct Buffer {
    /// First byte; null for an empty buffer that needs no freeing.
    pub data: *mut u8,
    /// Number of bytes in use.
    pub len: usize,
    /// Number of bytes allocated; only its maker makes sense of it.
    pub capacity: usize,
}

impl Buffer {
    /// No bytes, nothing to free.
    pub const EMPTY: Self = Self {
        data: std::ptr::null_mut(),
        len: 0,
        capacity: 0,
    };

    /// Hands a vector over. It comes back with [`Self::into_vec`] on the same side of the boundary.
    #[must_use]
    pub fn from_vec(mut bytes: Vec<u8>) -> Self {
        if bytes.capacity() == 0 {
            return Self::EMPTY;
        }
        let buffer = Self {
            data: bytes.as_mut_ptr(),
            len: bytes.len(),
            capacity: bytes.capacity(),
        };
        std::mem::forget(bytes);
        buffer
    }

    /// The vector that was handed over.
    ///
    /// # Safety
    /// The buffer must come from [`Self::from_vec`] of the same library, unchanged, and be used once.
    #[must_use]
    pub unsafe fn into_vec(self) -> Vec<u8> {
        if self.data.is_null() {
            return Vec::new();
        }
        // SAFETY: the caller vouches that these three came from a `Vec<u8>` of this library's allocator.
        unsafe { Vec::from_raw_parts(self.data, self.len, self.capacity) }
    }

    /// The bytes, borrowed.
    #[must_use]
    pub const fn as_slice(&self) -> Slice {
        Slice {
            data: self.data.cast_const(),
            len: self.len,
        }
    }
}
