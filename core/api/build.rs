//! Has the crate built anew whenever the built dashboard changes: the embedded files are found by folder, not by name.

fn main() {
    println!("cargo::rerun-if-changed=../../web-ui/dist");
    println!("cargo::rerun-if-changed=build.rs");
}
