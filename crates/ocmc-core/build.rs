//! Says whether this crate is compiled without optimisation: as a dependency of a program in the
//! making, which waits for the build and not for its answers. Four trucks stand side by side then,
//! as in WebAssembly.

use std::env;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(unoptimised, four_lanes)");
    let is = |name, value: &str| env::var(name).is_ok_and(|found| found == value);
    let unoptimised = is("OPT_LEVEL", "0");
    if unoptimised {
        println!("cargo::rustc-cfg=unoptimised");
    }
    if unoptimised || is("CARGO_CFG_TARGET_ARCH", "wasm32") {
        println!("cargo::rustc-cfg=four_lanes");
    }
}
