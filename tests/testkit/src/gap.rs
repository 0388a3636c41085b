//! How long a vehicle may be without a setpoint in a test that flies in real time.
//!
//! Must never do: judge how evenly setpoints come. That is measured by `skein bench fleet`, and judged by the demonstration's referee.

/// The longest time between two setpoints in seconds, less what the simulator's stall probe saw. PX4 leaves OFFBOARD after 1 s
/// (`COM_OF_LOSS_T`) and asks for 2 setpoints per second. A test process holds several nodes with their simulations, and other tiers run
/// beside it: on two busy cores some of its threads wait for 0.2 s.
pub const LONGEST_GAP_S: f64 = 0.5;
