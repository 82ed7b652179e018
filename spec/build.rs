//! The devices' files are a part of the crate: a change of them makes it anew.

fn main() {
    println!("cargo::rerun-if-changed=devices");
}
