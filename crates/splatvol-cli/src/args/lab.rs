//! Arguments of `splatvol lab`.

use std::path::PathBuf;

use clap::Args;

use super::WriteArgs;

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  splatvol lab                                    lists the experiments
  splatvol lab swan1997-checker                   runs one, files in lab/swan1997-checker
  splatvol lab huang2000 zwicker2001              runs those of two papers
  splatvol lab all --report out                   runs all, out/index.html shows them
  splatvol lab all --quick --report out           the same on smaller pictures, in minutes
  splatvol lab swan1997-volcano --data data       on data/terrain/dem.csv and dem.jpg, which are not part of splatvol")]
pub(crate) struct LabArgs {
    /// Experiments, papers (swan1997, mueller1998, huang2000, zwicker2001, beyond) or all; without any, they are listed
    #[arg(value_name = "NAME")]
    pub(crate) names: Vec<String>,
    /// Smaller pictures, fewer samples: the same numbers, roughly, in a tenth of the time
    #[arg(long, requires = "names")]
    pub(crate) quick: bool,
    /// Folder for pictures, plots and CSV, one folder in it per experiment; not together with --report
    #[arg(
        short,
        long,
        value_name = "FOLDER",
        default_value = "lab",
        conflicts_with = "report"
    )]
    pub(crate) output: PathBuf,
    /// In place of -o: a folder for one report of all that was run, index.html and lab.md, with pictures, plots and CSV
    /// beside them
    #[arg(long, value_name = "FOLDER", requires = "names")]
    pub(crate) report: Option<PathBuf>,
    /// Folder of data that are not part of splatvol; what is missing is skipped [default: ../shared/data, where it is there]
    #[arg(long, value_name = "FOLDER", requires = "names")]
    pub(crate) data: Option<PathBuf>,
    /// Threads; 0 takes one per processor. Changes times, nothing else [default: 0]
    #[arg(long)]
    pub(crate) threads: Option<usize>,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
}
