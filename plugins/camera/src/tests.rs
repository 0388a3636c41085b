//! Tests of the plugin: on a simulated vehicle with a simulated camera, without a device, of the simulated scene, and against anything.

mod anything;
mod mavlink;
mod scene;
mod without_device;
