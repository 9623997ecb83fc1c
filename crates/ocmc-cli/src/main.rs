//! The `ocmc` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    let status = ocmc_cli::run_from(std::env::args_os());
    u8::try_from(status).map_or(ExitCode::FAILURE, ExitCode::from)
}
