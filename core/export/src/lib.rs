//! What is made of recordings after the flight: what is in them, whether they are whole, parts of them, several of them as one, and their
//! contents in the formats of other programs. The three types to know: [`Overview`], [`Findings`], [`Format`].
//!
//! Must never do: change a recording, write over a file that is there, or take more memory for a longer flight.
#![forbid(unsafe_code)]

mod again;
mod check;
mod cut;
mod decisions;
mod error;
mod exported;
mod formats;
mod merge;
mod origin;
mod overview;
mod rewrite;
mod rosbag;
mod tables;
mod target;
mod tlog;
mod told;
mod tracks;
mod utc;

pub use again::{Again, redecide};
pub use check::{Finding, Findings, check};
pub use cut::cut;
pub use decisions::decisions;
pub use error::ExportError;
pub use exported::Exported;
pub use formats::{Format, export};
pub use merge::{MergeReport, merge};
pub use overview::{Overview, TopicCount, list};
pub use rewrite::Rewritten;
pub use utc::time_of_day;

/// Who is told how far long work is, from 0 to 1.
pub type Progress<'a> = &'a mut dyn FnMut(f64);

#[cfg(test)]
mod tests;
