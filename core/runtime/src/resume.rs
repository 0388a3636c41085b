//! Going on after a restart of the node in flight: the actor that keeps what is flown in a file, and what it does with an old one.
//!
//! Must never do: undo what a pilot, another ground station or another failsafe has done since.

mod flown;
mod keeper;

pub use keeper::{Keeper, KeeperArguments};
