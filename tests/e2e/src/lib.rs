//! Tests of the program as it ships, from outside; they are in `tests/`. Must never hold code that ships.
#![forbid(unsafe_code)]
