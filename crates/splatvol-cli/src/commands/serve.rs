//! `splatvol serve`: a page from this machine, whose pictures at rest are rendered here.

use std::net::SocketAddr;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use splatvol_serve::{Place, Served, Server};
use splatvol_web::Shown;

use super::asked::Asked;
use super::export::{Exported, warn_of_outdated};
use super::outputs::short_name;
use crate::args::ServeArgs;
use crate::failure::{During, Failure, Step};
use crate::output::Target;
use crate::terminal::Terminal;

pub(crate) fn run(args: &ServeArgs, terminal: &Terminal) -> Result<(), Failure> {
    warn_of_outdated(terminal);
    let asked = Asked::of_page(&args.page)?;
    let name = short_name(asked.document.reference());
    let title = args.page.title.as_deref().unwrap_or(&name);
    let exported = Exported::new(&asked, (&args.page, Some(args.chunks.rules())), terminal)?;
    let (page, sentence) = exported.served_page(title, args.page.max_size)?;
    let (document, held) = exported.document_and_data()?;
    let served = Served {
        page,
        shown: Shown::new(&document, held).during(Step::Usage)?,
        threads: exported.threads(),
    };
    let place = Place {
        address: SocketAddr::new(args.bind, args.port),
        names: args.host.clone(),
        idle: (args.idle > 0).then(|| Duration::from_secs(60 * u64::from(args.idle))),
    };
    let server = Server::new(served, &place).during(Step::Usage)?;
    let url = server.url().during(Step::Output)?;
    terminal.note(sentence);
    say(&url, args, terminal)?;
    server.run(&AtomicBool::new(false)).during(Step::Output)?;
    terminal.note(format!(
        "nobody has asked for {} minutes: the server ends",
        args.idle
    ));
    Ok(())
}

/// Says where it is, to people and to scripts.
fn say(url: &str, args: &ServeArgs, terminal: &Terminal) -> Result<(), Failure> {
    if let Some(path) = &args.url_file {
        Target::new(path).write(format!("{url}\n").as_bytes(), true)?;
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
