//! What the fuzz targets share.
#![forbid(unsafe_code)]

pub mod drive;
pub mod drive_dds;
