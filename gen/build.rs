//! The families' cells are a part of the crate: a change of them makes it anew.

fn main() {
    println!("cargo::rerun-if-changed=../rtl/devices");
}
