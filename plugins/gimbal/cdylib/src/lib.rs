//! The library the node loads: `gimbal` behind the plugin ABI. No logic here.

skein_plugin_sdk::export_payload!(gimbal::Gimbal);
