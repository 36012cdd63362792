//! Why an experiment could not be run or written.

use std::path::PathBuf;

use splatvol::{EngineError, SceneError};
use splatvol_io::IoError;
use splatvol_samples::SampleError;

/// Why an experiment could not be run or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LabError {
    /// No experiment of this name.
    #[error("no experiment is called '{name}'{}", nearest.map(|near| format!("; did you mean '{near}'?")).unwrap_or_default())]
    UnknownName {
        /// The name asked for.
        name: String,
        /// The most similar name, if one is similar.
        nearest: Option<&'static str>,
    },
    /// A scene, camera or setting was refused.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A sample could not be generated.
    #[error(transparent)]
    Sample(#[from] SampleError),
    /// Data that are not part of the program are needed, and are not where they should be.
    #[error("{file} is needed{}", folder.as_ref().map(|folder| format!(", which {} lacks", folder.display())).unwrap_or_default())]
    NoData {
        /// The file, below a folder of data.
        file: &'static str,
        /// The folder of data, if there is one.
        folder: Option<PathBuf>,
    },
    /// Data could not be read.
    #[error(transparent)]
    Io(#[from] IoError),
    /// The engine did not start.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// The reference integrator refused the scene.
    #[error("reference: {0}")]
    Reference(String),
    /// A file could not be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A measurement makes no sense: an error in the experiment.
    #[error("{0}")]
    Measurement(String),
}
