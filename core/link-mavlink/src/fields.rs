//! The numbers of a payload, whose trailing zeroes may have been left out.
//!
//! Must never do: panic on a short payload.

/// A payload whose trailing zeroes may have been left out.
pub(crate) struct Fields<'a>(pub &'a [u8]);

impl Fields<'_> {
    pub fn u8(&self, at: usize) -> u8 {
        self.0.get(at).copied().unwrap_or(0)
    }

    pub fn u16(&self, at: usize) -> u16 {
        u16::from_le_bytes([self.u8(at), self.u8(at + 1)])
    }

    pub fn u32(&self, at: usize) -> u32 {
        u32::from_le_bytes([self.u8(at), self.u8(at + 1), self.u8(at + 2), self.u8(at + 3)])
    }

    pub fn f32(&self, at: usize) -> f32 {
        f32::from_bits(self.u32(at))
    }

    pub fn i32(&self, at: usize) -> i32 {
        self.u32(at).cast_signed()
    }
}
