//! The C header and the layout that other languages build against.

mod header;
mod layout;
