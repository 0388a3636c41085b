//! A radio link as a payload: how good it is, how far it reaches, and a warning before the vehicle flies out of its range.
//!
//! Must never do: read a clock, wait for the kernel on the thread of a call, or leave a command without its end.
#![forbid(unsafe_code)]

mod link;
mod occurrence;
mod radio;
mod range;
mod settings;
mod wifi;

pub use occurrence::RadioEvent;
pub use radio::Radio;
pub use settings::{RssiScale, Settings, Source};

#[cfg(test)]
mod tests;
