//! Tests of the link core: frames in, frames and events out, in time that the test gives.
