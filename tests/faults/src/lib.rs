//! Tests in which something is killed, lost or hostile; they are in `tests/`. Must never hold code that ships.
#![forbid(unsafe_code)]
