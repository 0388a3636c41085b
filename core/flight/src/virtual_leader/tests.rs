//! Virtual leader.
