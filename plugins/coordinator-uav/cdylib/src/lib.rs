//! The library the node loads: `coordinator-uav` behind the plugin ABI. No logic here.

skein_plugin_sdk::export_uav_model!(coordinator_uav::CoordinatorUav);
