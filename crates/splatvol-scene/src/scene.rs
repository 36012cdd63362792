//! A scene: what is rendered, apart from the camera and the settings.

use std::sync::Arc;

use crate::{TransferFunction, Volume};

/// A volume and how its values look.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The data. Shared, so that renderers can keep what they derive from it between frames.
    pub volume: Arc<Volume>,
    /// Colour and opacity of its values.
    pub transfer_function: TransferFunction,
}

impl Scene {
    /// Scene of one volume.
    pub fn new(volume: impl Into<Arc<Volume>>, transfer_function: TransferFunction) -> Self {
        Self {
            volume: volume.into(),
            transfer_function,
        }
    }

    /// World length to which the transfer function's opacities refer.
    pub fn unit_distance(&self) -> f64 {
        self.transfer_function
            .unit_distance
            .unwrap_or_else(|| self.volume.grid().mean_spacing())
    }
}
