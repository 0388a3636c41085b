//! The library the node loads: `generic-uav` behind the plugin ABI. No logic here.

skein_plugin_sdk::export_uav_model!(generic_uav::GenericUav);
