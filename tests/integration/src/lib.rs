//! Tests of a whole node with simulated vehicles in one process; they are in `tests/`. Must never hold code that ships.
#![forbid(unsafe_code)]
