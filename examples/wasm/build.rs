//! Enlarges the module's stack beyond the linker's default of a mebibyte: kernels keep several
//! packets on it, and unoptimised code keeps every value.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-link-arg-cdylib=-zstack-size=16777216");
}
