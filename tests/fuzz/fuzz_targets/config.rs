//! The node's configuration as text.
#![no_main]

use libfuzzer_sys::fuzz_target;
use skein_config::NodeConfig;

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    if let Err(error) = NodeConfig::parse(text) {
        assert!(!error.to_string().trim().is_empty());
    }
});
