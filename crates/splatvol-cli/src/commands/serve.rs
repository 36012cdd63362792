//! `splatvol serve`: a page from this machine, whose pictures at rest are rendered here.

use std::net::SocketAddr;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use splatvol_serve::{Place, Served, Server};
use splatvol_web::Shown;

use super::asked::{self, Asked};
use super::export::Exported;
use super::outputs::short_name;
use crate::args::ServeArgs;
use crate::failure::{Failure, Step};
use crate::output::Target;
use crate::terminal::Terminal;

pub(crate) fn run(args: &ServeArgs, terminal: &Terminal) -> Result<(), Failure> {
    let asked = Asked::of_page(args.input.as_deref(), args.size, &args.picture)?;
    let name = short_name(asked.document.reference());
    let title = args.title.as_deref().unwrap_or(&name);
    let threads = asked::threads(args.threads, terminal);
    let exported = Exported::new(&asked, &args.picture, threads, terminal)?;
    let (page, sentences) = exported.served_page(title, args.max_size)?;
    let (document, held) = exported.document_and_data();
    let served = Served {
        page,
        shown: Shown::new(&document, held).map_err(refused)?,
        threads,
    };
    let place = Place {
        address: SocketAddr::new(args.bind, args.port),
        names: args.host.clone(),
        idle: (args.idle > 0).then(|| Duration::from_secs(60 * u64::from(args.idle))),
    };
    let server = Server::new(served, &place).map_err(refused)?;
    let url = server
        .url()
        .map_err(|error| Failure::of(Step::Output, error.into()))?;
    for sentence in sentences {
        terminal.note(sentence);
    }
    say(&url, args, terminal)?;
    server
        .run(&AtomicBool::new(false))
        .map_err(|error| Failure::of(Step::Output, error.into()))?;
    terminal.note(format!(
        "nobody has asked for {} minutes: the server ends",
        args.idle
    ));
    Ok(())
}

/// Says where it is, to people and to scripts.
fn say(url: &str, args: &ServeArgs, terminal: &Terminal) -> Result<(), Failure> {
    if let Some(path) = &args.url_file {
        std::fs::write(path, format!("{url}\n")).map_err(|error| Failure::of(Step::Output, error.into()))?;
    }
    let port = url.rsplit(':').next().and_then(|rest| rest.split('/').next());
    let port = port.unwrap_or_default();
    Target::Stdout.write(format!("{url}\n").as_bytes(), true)?;
    if args.bind.is_loopback() {
        terminal.note(format!(
            "from another machine: ssh -L {port}:localhost:{port} THIS_MACHINE, then the same address there"
        ));
    } else {
        terminal.warn("what is sent is not encrypted, and everybody who sees the address may look");
    }
    terminal.note("Ctrl-C ends it");
    Ok(())
}

fn refused(error: splatvol_web::WebError) -> Failure {
    Failure::of(Step::Usage, error.into())
}
