//! A scene: what is rendered, apart from the camera and the settings.

use std::sync::Arc;

use crate::operator::PixelOperator;
use crate::{Clip, SceneError, TransferFunction, Volume};

/// A volume and how its values look.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The data. Shared, so that renderers can keep what they derive from it between frames.
    pub volume: Arc<Volume>,
    /// Colour and opacity of its values.
    pub transfer_function: TransferFunction,
    /// What changes the appearance of material, in this order (post-classified pictures only).
    pub operators: Vec<Arc<dyn PixelOperator>>,
    /// What is cut away: a point is seen where every clip keeps it.
    pub clips: Vec<Clip>,
    /// Surfaces to show instead of material, where there are any: see [`Scene::of_isosurfaces`].
    pub isosurfaces: Vec<Isosurface>,
}

/// The surface of one value, infinitely thin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Isosurface {
    /// Data value.
    pub value: f64,
    /// sRGB, 0..1.
    pub rgb: [f64; 3],
    /// Opacity, 0..1.
    pub opacity: f64,
}

impl Scene {
    /// Scene of one volume.
    pub fn new(volume: impl Into<Arc<Volume>>, transfer_function: TransferFunction) -> Self {
        Self {
            volume: volume.into(),
            transfer_function,
            operators: Vec::new(),
            clips: Vec::new(),
            isosurfaces: Vec::new(),
        }
    }

    /// Scene of surfaces: the points where the value between two sheets crosses theirs, exactly, lit by the gradient there.
    ///
    /// # Errors
    /// No surfaces, values that are not finite, or colours or opacities outside 0..1.
    pub fn of_isosurfaces(
        volume: impl Into<Arc<Volume>>,
        isosurfaces: &[Isosurface],
    ) -> Result<Self, SceneError> {
        let volume = volume.into();
        let unit = |value: f64| (0.0..=1.0).contains(&value);
        for surface in isosurfaces {
            if !(surface.value.is_finite() && unit(surface.opacity) && surface.rgb.into_iter().all(unit)) {
                return Err(SceneError::invalid(
                    "isosurface",
                    surface,
                    "a finite value; rgb and opacity from 0 to 1",
                ));
            }
        }
        let lowest = isosurfaces.iter().map(|surface| surface.value).reduce(f64::min);
        let (Some(lowest), Some(first)) = (lowest, isosurfaces.first()) else {
            return Err(SceneError::invalid("isosurfaces", isosurfaces, "at least one"));
        };
        // What may lie behind a crossing has to be there; how dense it is does not matter.
        let [low, high] = volume.value_range();
        let width = ((high - low) / 200.0).max(f64::MIN_POSITIVE);
        let transfer_function = TransferFunction::isosurface(lowest, width, first.rgb)?;
        Ok(Self {
            isosurfaces: isosurfaces.to_vec(),
            ..Self::new(volume, transfer_function)
        })
    }

    /// This scene with one more operator, which runs after those it has.
    #[must_use]
    pub fn with_operator(mut self, operator: impl PixelOperator + 'static) -> Self {
        self.operators.push(Arc::new(operator));
        self
    }

    /// This scene with one more clip.
    #[must_use]
    pub fn with_clip(mut self, clip: Clip) -> Self {
        self.clips.push(clip);
        self
    }

    /// World length to which the transfer function's opacities refer.
    pub fn unit_distance(&self) -> f64 {
        self.transfer_function
            .unit_distance
            .unwrap_or_else(|| self.volume.grid().mean_spacing())
    }
}
