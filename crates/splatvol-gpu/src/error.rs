//! Errors at start.

/// Why the engine cannot start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No adapter with compute shaders, or none of the wanted name.
    #[error("gpu: no adapter found{wanted} ({there})")]
    NoAdapter {
        /// What was asked for.
        wanted: String,
        /// The adapters that there are.
        there: String,
    },
    /// A device that does not open.
    #[error("gpu: {adapter} does not open: {reason}")]
    Device {
        /// Name of the adapter.
        adapter: String,
        /// Message of the driver.
        reason: String,
    },
    /// A shader that the driver does not take.
    #[error("gpu: {adapter} does not take the shaders: {reason}")]
    Shader {
        /// Name of the adapter.
        adapter: String,
        /// Message of the driver.
        reason: String,
    },
}
