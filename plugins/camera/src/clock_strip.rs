//! The node's clock, drawn into a picture for machines: whoever shows the picture reads when it was drawn, and so how old it is.
//!
//! Cells of a width of an 80th of the picture stand beside each other, one cell from its left and upper edge: white and black for the levels, then
//! 32 bits of the clock in whole milliseconds, the most significant first, then 4 bits of a checksum, the sum of the eight groups of four bits.

use skein_domain::NodeTime;

/// Cells in the width of a picture.
const CELLS_ACROSS: u32 = 80;
const CLOCK_BITS: u32 = 32;
const SUM_BITS: u32 = 4;

/// Draws the clock into a picture of three bytes per pixel without room between its rows. A picture that is too small for it has none.
pub(crate) fn draw(now: NodeTime, width_px: u32, rgb: &mut [u8]) {
    let cell_px = (width_px / CELLS_ACROSS) as usize;
    let row_bytes = width_px as usize * 3;
    if cell_px == 0 {
        return;
    }
    let line = line(now, cell_px);
    for row in rgb.chunks_mut(row_bytes).skip(cell_px).take(cell_px) {
        if let Some(place) = row.get_mut(cell_px * 3..cell_px * 3 + line.len()) {
            place.copy_from_slice(&line);
        }
    }
}

/// One row of the strip.
fn line(now: NodeTime, cell_px: usize) -> Vec<u8> {
    // As many bits as the strip has; it begins anew after 49 days.
    let clock_ms = (now.0 / 1_000) as u32;
    let sum = (0..CLOCK_BITS / 4)
        .map(|group| clock_ms >> (4 * group) & 0xf)
        .sum::<u32>()
        & 0xf;
    let bits = |value: u32, count: u32| (0..count).rev().map(move |bit| value >> bit & 1 == 1);
    let cells = [true, false]
        .into_iter()
        .chain(bits(clock_ms, CLOCK_BITS))
        .chain(bits(sum, SUM_BITS));
    cells
        .flat_map(|white| std::iter::repeat_n(if white { 255 } else { 0 }, cell_px * 3))
        .collect()
}

#[cfg(test)]
mod tests;
