//! Tests of the plugin: on a simulated vehicle with a simulated camera, without a device, and against anything.

mod anything;
mod mavlink;
mod without_device;
