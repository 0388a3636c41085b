//! The library the node loads: `radio` behind the plugin ABI. No logic here.

skein_plugin_sdk::export_payload!(radio::Radio);
