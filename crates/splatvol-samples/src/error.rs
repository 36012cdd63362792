//! The one error type of this crate.

use splatvol_scene::SceneError;

/// Why a sample cannot be generated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SampleError {
    /// No sample has this name.
    #[error("no sample is called {name:?}{}; there are: {known}", suggestion(*.nearest))]
    UnknownName {
        /// The requested name.
        name: String,
        /// The most similar known name, if one is similar.
        nearest: Option<&'static str>,
        /// All names, separated by commas.
        known: String,
    },
    /// This sample cannot have the requested size.
    #[error("sample {name}: size {size} is not allowed ({expected})")]
    InvalidSize {
        /// Name of the sample.
        name: &'static str,
        /// The requested size.
        size: String,
        /// Accepted values.
        expected: &'static str,
    },
    /// The scene types refused the generated data.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

fn suggestion(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |name| format!(" (did you mean {name:?}?)"))
}
