//! Room for the module's stack, of which a linker gives a mebibyte: kernels keep several packets on
//! it, and code that is not optimised keeps every value.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-link-arg-cdylib=-zstack-size=16777216");
}
