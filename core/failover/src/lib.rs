//! Who coordinates: terms that only grow, the fencing of former coordinators at every vehicle, and when a capable node takes over.
//!
//! Must never do: I/O, read a clock, draw random numbers, trust a message to be new. Messages may be lost, late, doubled and out of
//! order; time comes in as `NodeTime`. The model in `tests/model.rs` runs this very code.
//!
//! # The protocol
//!
//! Every node tells in its **beacons** which term it obeys and the newest **pulse** of that term's holder it knows of. A term has a number and
//! one holder. A node obeys one holder per number, and only ever a greater number than before. So
//!
//! * an order that carries another term than the obeyed one is not carried out;
//! * a coordinator that was cut off is fenced at every vehicle that obeys a greater number, whatever it still says;
//! * in a partition each part has a holder of its own; when the parts meet the greater number wins.
//!
//! What a node may do of this rests on [`Leadership::obeyed`] alone; whether the holder is still there, and what a vehicle does without one,
//! is said by [`LeaderMonitor::leader_state`].
//!
//! A holder is missed when no new pulse of it comes, heard from itself or from anyone ([`LeaderMonitor`]). Then the most suited of those who
//! are heard claims the next number ([`Leadership::claim`]): by configured priority, then by the smaller id, the others a little later each.
#![forbid(unsafe_code)]

mod leader_state;
mod leadership;
mod monitor;
mod term;

pub use leader_state::{LeaderState, Reaction, Unled};
pub use leadership::{ClaimError, Handover, Leadership, OrderError};
pub use monitor::{Apart, LeaderMonitor, LeaderMonitorSettings, Turn};
pub use term::{Beacon, Standing, Term};
