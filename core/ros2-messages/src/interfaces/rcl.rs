//! `rcl_interfaces`.
//!
//! Must never do: hold a message that nothing here speaks.

use super::messages;
use super::standard::Time;

messages! { "rcl_interfaces":
    /// A line of a node's log.
    Log { stamp: Time, level: u8, name: String, msg: String, file: String, function: String, line: u32 }
}
