//! Why an experiment could not be run or written.

use std::path::PathBuf;

use splatvol::{EngineError, SceneError};
use splatvol_samples::SampleError;

/// Why an experiment could not be run or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LabError {
    /// No experiment of this name.
    #[error("no experiment is called '{name}'{}", nearest.map(|near| format!("; did you mean '{near}'?")).unwrap_or_default())]
    UnknownName {
        /// What was asked for.
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
        /// What the system said.
        source: std::io::Error,
    },
    /// A measurement made no sense, which is an error of the experiment.
    #[error("{0}")]
    Measurement(String),
}
