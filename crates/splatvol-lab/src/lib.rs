//! The experiments of the four papers, and our own, as numbers, plots and pictures.
//!
//! | paper | experiments |
//! |---|---|
//! | swan1997, "An Anti-Aliasing Technique for Splatting" | [`experiments::swan1997`] |
//! | mueller1998, "Splatting Errors and Antialiasing" | [`experiments::mueller1998`] |
//! | huang2000, "FastSplats: Optimized Splatting on Rectilinear Grids" | [`experiments::huang2000`] |
//! | zwicker2001, "EWA Volume Splatting" | [`experiments::zwicker2001`] |
//! | none: questions beyond the papers | [`experiments::beyond`] |
//!
//! An [`Experiment`] takes a [`Workbench`] and makes an [`Outcome`]: findings, tables, plots and pictures. A
//! [`Finding`] sets a measured number beside the published one, with the condition under which it counts as reproduced;
//! its [`Verdict`] is computed and never written down. If the numbers differ, the reasons are given as
//! [`Explanation`]s, each of which is itself a measurement and is given only if it holds.
//!
//! [`folder::write`] leaves pictures, plots and CSV in a folder, [`report::write`] makes one page of many experiments.
//!
//! All results are generated from seeds and, apart from findings marked as timed, identical on every run.
#![forbid(unsafe_code)]

mod catalogue;
mod error;
mod experiment;
pub mod experiments;
mod finding;
pub mod folder;
mod measure;
mod outcome;
mod plate;
mod plot;
pub mod report;
mod table;
mod workbench;

pub use catalogue::{experiment, experiments, papers};
pub use error::LabError;
pub use experiment::{Experiment, FigureEntry, Paper};
pub use finding::{Expectation, Explanation, Finding, Published, Verdict};
pub use outcome::{Outcome, Run};
pub use plate::{Panel, Plate};
pub use plot::{Axis, Curve, Mark, Plot, PlotKind, Scale};
pub use table::{Cell, Table};
pub use workbench::{Effort, Workbench};
