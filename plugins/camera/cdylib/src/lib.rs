//! The library the node loads: `camera` behind the plugin ABI. No logic here.

skein_plugin_sdk::export_payload!(camera::Camera);
