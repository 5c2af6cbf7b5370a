//! The name that programs look for when they start: as long as it is the same, libraries of other
//! versions can take this one's place. And that it stays loaded, because its threads do.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let name = if std::env::var_os("CARGO_FEATURE_RENDER").is_some() {
        "phalanx_files"
    } else {
        "phalanx"
    };
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "linux") {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,lib{name}.so.0,-z,nodelete");
    }
}
