//! The library the node loads: `detector` behind the plugin ABI. No logic here.

skein_plugin_sdk::export_payload!(detector::Detector);
