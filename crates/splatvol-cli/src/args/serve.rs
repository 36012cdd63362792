//! `splatvol serve`.

use std::net::IpAddr;
use std::path::PathBuf;

use clap::Args;

use super::help::SERVER;
use super::{ChunkArgs, PageArgs};

/// Raw arguments of `serve`.
#[derive(Debug, Clone, Args)]
#[command(
    after_help = "Examples:
  splatvol serve scan.nii.gz            prints an address, for a browser on this machine
  splatvol serve ct.nrrd --port 8080    for ssh -L 8080:localhost:8080 from another one",
    after_long_help = "Only browsers that were given the printed address are answered: it holds a token that is made anew each
time. Requests name no files, so that nothing is shown but INPUT, and nothing is written. Pictures at rest are rendered
here, and are those of splatvol render; while the view turns the browser draws smaller data itself, if this program has
the engine for browsers, else the drafts come from here, too. Volumes larger than half of --memory are
read chunk by chunk, as splatvol render does; browsers then draw drafts of a coarse level. Many pages may be open: drafts
go first, then whoever was served longest ago. The server ends when nobody has asked for --idle minutes, or by Ctrl-C. There is no
encryption: across a network go through ssh -L, or a proxy that encrypts.

Examples:
  splatvol serve sample:head
  splatvol serve scene.toml --size 1600x1200 --idle 0
  splatvol serve brain.ome.zarr --memory 4G
  splatvol serve ct.nrrd --iso 300 --bind 0.0.0.0 --host lab.example.org"
)]
pub(crate) struct ServeArgs {
    #[command(flatten)]
    pub(crate) page: PageArgs,
    #[command(flatten)]
    pub(crate) chunks: ChunkArgs,
    /// Port; 0 takes a free one
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = SERVER)]
    pub(crate) port: u16,
    /// Address of this machine on which it listens
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1", help_heading = SERVER)]
    pub(crate) bind: IpAddr,
    /// Name of this machine by which browsers may ask, beside localhost; repeatable
    #[arg(long, value_name = "NAME", help_heading = SERVER)]
    pub(crate) host: Vec<String>,
    /// Minutes without a request after which it ends; 0 is never
    #[arg(long, value_name = "MINUTES", default_value_t = 60, help_heading = SERVER)]
    pub(crate) idle: u32,
    /// Write the address to this file, too, for scripts
    #[arg(long, value_name = "FILE", help_heading = SERVER)]
    pub(crate) url_file: Option<PathBuf>,
}
