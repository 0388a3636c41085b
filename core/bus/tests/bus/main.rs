//! Nodes that join, part and count each other, over the bus in memory.

mod group_size;
mod joining;
