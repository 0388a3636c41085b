//! Who coordinates: explored by a model checker, and acted out over a bus.

mod model;
mod over_the_bus;
