//! Arguments of `splatvol lab`.

use std::path::PathBuf;

use clap::Args;

use super::WriteArgs;
use super::help::{GENERAL, OUTPUT};

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  splatvol lab                                    lists the experiments
  splatvol lab swan1997-checker                   runs one, files in lab/swan1997-checker
  splatvol lab huang2000 zwicker2001              runs those of two papers
  splatvol lab all --report out                   runs all, out/index.html shows them
  splatvol lab all --quick --report out           the same on smaller pictures, in minutes
  splatvol lab swan1997-volcano --data data       with data/terrain/dem.csv and dem.jpg")]
pub(crate) struct LabArgs {
    /// Experiments, papers (swan1997, mueller1998, huang2000, zwicker2001, beyond) or all; without any, they are listed
    #[arg(value_name = "NAME")]
    pub(crate) names: Vec<String>,
    /// Smaller pictures and fewer samples: roughly the same numbers in a tenth of the time
    #[arg(long, requires = "names")]
    pub(crate) quick: bool,
    /// Folder for pictures, plots and CSV, with a folder for each experiment
    #[arg(
        short,
        long,
        value_name = "FOLDER",
        default_value = "lab",
        help_heading = OUTPUT,
        conflicts_with = "report"
    )]
    pub(crate) output: PathBuf,
    /// Folder for one report on all that was run, instead of -o: index.html, lab.md
    ///
    /// Pictures, plots and CSV lie beside them.
    #[arg(long, value_name = "FOLDER", help_heading = OUTPUT, requires = "names")]
    pub(crate) report: Option<PathBuf>,
    /// Folder of data that are not part of splatvol [default: ../shared/data, if there is one]
    ///
    /// Experiments whose data are missing are skipped.
    #[arg(long, value_name = "FOLDER", requires = "names")]
    pub(crate) data: Option<PathBuf>,
    /// Number of threads; 0 is one per processor [default: 0]
    #[arg(long, value_name = "N", help_heading = GENERAL)]
    pub(crate) threads: Option<usize>,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
}
