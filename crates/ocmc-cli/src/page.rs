//! `ocmc page`: a page to ask with, in the browser, served on this machine alone.

use crate::arguments::QuietOption;
use crate::failure::Failure;
use crate::interrupt::{self, Patience};
use crate::output;
use clap::Args;
use ocmc_page::{Page, PageError};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

/// Time between two looks at whether the page is to end.
const TICK: Duration = Duration::from_millis(50);

/// A page.
#[derive(Clone, Debug, Args)]
pub(crate) struct PageArguments {
    /// Files that lie on the page as if they had been dropped there: routes, tracks, stop plans,
    /// tables of trips, study files
    #[arg(value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Port of the loopback; 0: any that is free
    #[arg(long, value_name = "N", default_value = "0")]
    port: u16,
    /// Opens no browser: the address is printed
    #[arg(long)]
    no_open: bool,
    /// Goes on when the last tab with the page is closed
    #[arg(long)]
    stay: bool,
    #[command(flatten)]
    quiet: QuietOption,
}

/// Serves the page until its last tab is closed, or a signal ends it.
pub(crate) fn page(arguments: &PageArguments) -> Result<(), Failure> {
    let PageArguments { files, port, no_open, stay, quiet: QuietOption { quiet } } = arguments;
    interrupt::listen(Patience::UntilKept);
    let page = Page::serve(*port, files).map_err(|error| failure(error, *port))?;
    let address = page.address();
    output::answer(&format!("{address}\n"))?;
    if !no_open && !opened(&address) && !quiet {
        output::note("No browser could be opened: open this address in one.");
    }
    if !quiet {
        let how = if *stay { "Ctrl-C ends it" } else { "closing its tab, or Ctrl-C, ends it" };
        output::note(&format!("The page is served to this machine alone; {how}."));
    }
    while !interrupt::asked() && (*stay || !page.is_left()) {
        thread::sleep(TICK);
    }
    Ok(())
}

fn failure(error: PageError, port: u16) -> Failure {
    match error {
        PageError::System(error) if error.kind() == std::io::ErrorKind::AddrInUse => {
            Failure::Usage(format!(
                "port {port} is taken by another program: allowed is any other, or 0 for a free one"
            ))
        }
        PageError::System(error) => Failure::Page(error.to_string()),
        PageError::File(path, reason) => Failure::Page(format!("`{}`: {reason}", path.display())),
    }
}

/// Opens an address in the browser of the person; whether there is a program for that.
fn opened(address: &str) -> bool {
    let (program, before): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("rundll32", &["url.dll,FileProtocolHandler"])
    } else {
        ("xdg-open", &[])
    };
    let mut command = Command::new(program);
    command.args(before).arg(address);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().is_ok()
}
