//! The one error type of this crate.

/// Why a scene part cannot be built. The text names the field and the value that is wrong.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A field holds a value outside its domain.
    #[error("{field}: {value} is not allowed ({expected})")]
    InvalidField {
        /// Name of the field, as users know it.
        field: &'static str,
        /// The offending value.
        value: String,
        /// Accepted values.
        expected: &'static str,
    },
    /// The number of samples does not fit the dimensions.
    #[error("dims {dims:?} need {expected} samples, found {found}")]
    SampleCount {
        /// Dimensions x y z.
        dims: [usize; 3],
        /// Product of the dimensions.
        expected: usize,
        /// Samples present.
        found: usize,
    },
    /// No sample of the volume is a finite number.
    #[error("the volume has no finite sample (all of its {count} samples are NaN or infinite)")]
    NoFiniteSample {
        /// Samples present.
        count: usize,
    },
    /// Rendering was stopped before the picture was finished.
    #[error("stopped before the picture was finished")]
    Stopped,
    /// Samples that a source failed to deliver.
    #[error("{name}: level {level}, samples from {first:?}: {reason}")]
    Source {
        /// The source, as users know it: a file, an address.
        name: String,
        /// Level of detail.
        level: usize,
        /// First sample of the requested region.
        first: [usize; 3],
        /// Cause of the failure.
        reason: String,
    },
    /// A device that failed, or whose memory is too small.
    #[error("{name}: {reason}")]
    Device {
        /// The device, as its driver names it.
        name: String,
        /// Message of the driver, or what is needed.
        reason: String,
    },
    /// Parts of a scene, or of a scene and the settings, that cannot be combined.
    #[error("{what} cannot be rendered: {why}")]
    Combination {
        /// The refused request.
        what: &'static str,
        /// Why it is refused, and what is possible instead.
        why: &'static str,
    },
}

impl SceneError {
    /// A value of a field that is not allowed.
    pub fn invalid(field: &'static str, value: impl std::fmt::Debug, expected: &'static str) -> Self {
        Self::InvalidField {
            field,
            value: format!("{value:?}"),
            expected,
        }
    }
}
