//! The way of a DDS sample, from octets to a vehicle's link.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| skein_fuzz::drive_dds::drive(data));
