//! Has the linker keep functions of the same instructions once, where it can: a wheel of 9.9 MB is
//! 0.2 MB smaller.

#![allow(clippy::print_stdout, reason = "cargo reads it")]

use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::{env, fs};

/// Known to LLD, mold and gold. GNU ld refuses it.
const FOLDED: &str = "-Wl,--icf=all";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let is_linux = env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "linux");
    if is_linux && links_with(FOLDED).unwrap_or(false) {
        println!("cargo::rustc-link-arg-cdylib={FOLDED}");
    }
}

/// Whether an empty library can be linked with this argument as the extension will be: by the same
/// compiler with the same flags. None where that cannot be tried.
fn links_with(argument: &str) -> Option<bool> {
    let folder = PathBuf::from(env::var_os("OUT_DIR")?);
    let source = folder.join("empty.rs");
    fs::write(&source, "").ok()?;
    let mut command = Command::new(env::var_os("RUSTC")?);
    command.args(["--crate-type=cdylib", "--crate-name=empty", "--target"]);
    command.arg(env::var_os("TARGET")?).arg("--out-dir").arg(&folder).arg(source);
    let flags = env::var("CARGO_ENCODED_RUSTFLAGS").unwrap_or_default();
    command.args(flags.split('\x1f').filter(|flag| !flag.is_empty()));
    if let Ok(linker) = env::var("RUSTC_LINKER") {
        command.arg(format!("-Clinker={linker}"));
    }
    command.arg(format!("-Clink-arg={argument}")).stdout(Stdio::null()).stderr(Stdio::null());
    Some(command.status().ok()?.success())
}
