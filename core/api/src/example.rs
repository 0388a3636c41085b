//! What every body of a request has: an example that would be taken.
//!
//! Must never do: hold the examples themselves.

use serde_json::Value;

/// A body that there is an example of.
pub trait Example {
    /// One that would be taken.
    fn example() -> Value;
}
