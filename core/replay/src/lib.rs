//! Shows a recorded flight again: at another pace, from any moment on, as a node of which nothing runs. The three types to know: [`Replay`],
//! [`ReplayState`], [`Timeline`].
//!
//! Must never do: have an actor, a link or a plugin. No command can leave what has none.
#![forbid(unsafe_code)]

mod player;
mod position;
mod replay;
mod stage;
mod state;
mod timeline;

pub use replay::{Replay, ReplayError};
pub use state::{RATES, ReplayChange, ReplayState};
pub use timeline::{Timeline, TimelineMark};

#[cfg(test)]
mod tests;
