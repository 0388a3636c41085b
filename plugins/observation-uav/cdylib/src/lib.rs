//! The library the node loads: `observation-uav` behind the plugin ABI. No logic here.

skein_plugin_sdk::export_uav_model!(observation_uav::ObservationUav);
