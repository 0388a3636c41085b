//! Fence files: what is taken, what is refused and with which words, and that nothing makes the importers panic.

use super::*;

#[test]
fn placeholder() {}
