//! The way of a MAVLink frame, from bytes to a vehicle's link.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| skein_fuzz::drive::drive(data));
