//! Frames: found, skipped, written.
