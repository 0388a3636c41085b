//! `builtin_interfaces`, `std_msgs` and `std_srvs`.
//!
//! Must never do: hold a message that nothing here speaks.

use super::{messages, services};

messages! { "builtin_interfaces":
    /// A moment: seconds and nanoseconds since 1970.
    Time { sec: i32, nanosec: u32 }
}

messages! { "std_msgs":
    /// When something was, and in which frame.
    Header { stamp: Time, frame_id: String }
}

messages! { "std_srvs":
    /// What [`SetBool`] is asked.
    SetBoolRequest { data: bool }
    /// What [`SetBool`] and [`Trigger`] answer.
    Outcome { success: bool, message: String }
    /// What [`Trigger`] is asked: nothing, for which one octet stands on the wire.
    Empty { structure_needs_at_least_one_member: u8 }
}

services! { "std_srvs":
    /// Switches something on or off.
    SetBool = SetBoolRequest => Outcome,
    /// Has something done.
    Trigger = Empty => Outcome,
}
