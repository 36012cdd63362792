//! A scene: items of all kinds with their placements, apart from the camera and the settings.
//!
//! Items are composited sheet by sheet, so that translucent items interpenetrate as they do in space.

use std::sync::Arc;

use glam::DAffine3;

use crate::operator::PixelOperator;
use crate::{
    Bounds, Clip, Compositing, Content, GaussianMode, Isosurface, Item, Motion, RenderSettings, SceneError,
    TransferFunction, Volume,
};

/// Items that are rendered together.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// The items.
    pub items: Vec<Item>,
    /// Clips of all items, world space: a point is visible if every clip keeps it.
    pub clips: Vec<Clip>,
    /// Background, linear light, straight alpha. Gaussians rendered as published are composited over it, in display
    /// space as in the published renderer. Nothing else uses it.
    pub background: [f32; 4],
}

impl Scene {
    /// Scene of one volume.
    pub fn new(volume: impl Into<Arc<Volume>>, transfer_function: TransferFunction) -> Self {
        Item::volume(volume, transfer_function).into()
    }

    /// Scene of surfaces of one volume: see [`Item::isosurfaces`].
    ///
    /// # Errors
    /// No surfaces, values that are not finite, or colours or opacities outside 0..1.
    pub fn of_isosurfaces(
        volume: impl Into<Arc<Volume>>,
        isosurfaces: &[Isosurface],
    ) -> Result<Self, SceneError> {
        Item::isosurfaces(volume, isosurfaces).map(Self::from)
    }

    /// Scene of several things.
    ///
    /// # Errors
    /// No items, a place that cannot be inverted, or a look outside its domain.
    pub fn of_items(items: Vec<Item>) -> Result<Self, SceneError> {
        let scene = Self {
            items,
            ..Self::default()
        };
        scene.validate()?;
        Ok(scene)
    }

    /// This scene with one more operator on everything, which runs after the existing ones.
    #[must_use]
    pub fn with_operator(mut self, operator: impl PixelOperator + 'static) -> Self {
        let operator: Arc<dyn PixelOperator> = Arc::new(operator);
        for item in &mut self.items {
            item.operators.push(Arc::clone(&operator));
        }
        self
    }

    /// This scene with one more clip.
    #[must_use]
    pub fn with_clip(mut self, clip: Clip) -> Self {
        self.clips.push(clip);
        self
    }

    /// This scene, all of which moves while the shutter is open.
    #[must_use]
    pub fn with_motion(mut self, motion: &Motion) -> Self {
        for item in &mut self.items {
            item.motion = Some(motion.clone());
        }
        self
    }

    /// Whether volumes of it are read in chunks when they are drawn.
    pub fn reads_chunks(&self) -> bool {
        let chunked = |item: &Item| match &item.content {
            Content::Volume { volume, .. } => volume.chunks().is_some(),
            _ => false,
        };
        self.items.iter().any(chunked)
    }

    /// This scene with all volumes in memory, at full resolution, for methods that need all their samples.
    ///
    /// # Errors
    /// Samples that cannot be read, or that are larger than their budget.
    pub fn in_memory(mut self) -> Result<Self, SceneError> {
        for item in &mut self.items {
            if let Content::Volume { volume, .. } = &mut item.content
                && let Some(chunks) = volume.chunks()
            {
                *volume = Arc::new(chunks.in_memory(0)?);
            }
        }
        Ok(self)
    }

    /// Checks the items.
    ///
    /// # Errors
    /// No items, a place that cannot be inverted, or a look outside its domain.
    pub fn validate(&self) -> Result<(), SceneError> {
        if self.items.is_empty() {
            return Err(no_items());
        }
        self.items.iter().try_for_each(Item::validate)
    }

    /// Box of all items, world.
    ///
    /// # Errors
    /// No items.
    pub fn bounds(&self) -> Result<Bounds, SceneError> {
        let both = |a: Bounds, b: Bounds| Bounds {
            min: a.min.min(b.min),
            max: a.max.max(b.max),
        };
        self.items
            .iter()
            .map(Item::bounds)
            .reduce(both)
            .ok_or_else(no_items)
    }

    /// Whether whole splats are composited one by one, as the published renderer of Gaussians does, not sheets.
    pub fn is_published(&self, settings: &RenderSettings) -> bool {
        let all = |of: fn(&Content) -> bool| self.items.iter().all(|item| of(&item.content));
        match settings.gaussians {
            GaussianMode::Published => true,
            GaussianMode::Volumetric => false,
            GaussianMode::Auto => {
                let has_gaussians = !all(|content| !matches!(content, Content::Gaussians(_)));
                let whole = all(|content| matches!(content, Content::Gaussians(_) | Content::Points { .. }));
                let on_sheets = settings.method.compositing() == Compositing::ImageSheets;
                self.is_gaussians() || (has_gaussians && whole && on_sheets)
            }
        }
    }

    /// Whether all of it is Gaussians.
    pub fn is_gaussians(&self) -> bool {
        let is = |item: &Item| matches!(item.content, Content::Gaussians(_));
        self.items.iter().all(is)
    }

    /// The volume of a scene that holds nothing else.
    ///
    /// # Errors
    /// Several items, or one of another kind.
    pub fn single_volume(&self) -> Result<SingleVolume<'_>, SceneError> {
        let refuse = |found: &dyn std::fmt::Debug| Err(SceneError::invalid("items", found, "one volume"));
        let [item] = &self.items[..] else {
            return refuse(&self.items.len());
        };
        match &item.content {
            Content::Volume { .. } => item.as_volume().ok_or_else(no_items),
            Content::Mesh { .. } => refuse(&"a mesh"),
            Content::Points { .. } => refuse(&"points"),
            Content::Gaussians(_) => refuse(&"Gaussians"),
        }
    }

    /// The transfer function of a scene of one volume, to change it.
    ///
    /// # Errors
    /// Same as [`Scene::single_volume`].
    pub fn transfer_function_mut(&mut self) -> Result<&mut TransferFunction, SceneError> {
        self.single_volume()?;
        match self.items.first_mut().map(|item| &mut item.content) {
            Some(Content::Volume {
                transfer_function, ..
            }) => Ok(transfer_function),
            _ => Err(no_items()),
        }
    }
}

impl From<Item> for Scene {
    fn from(item: Item) -> Self {
        Self {
            items: vec![item],
            ..Self::default()
        }
    }
}

fn no_items() -> SceneError {
    SceneError::invalid("items", 0, "at least one")
}

impl Item {
    /// The item as a volume; `None` where it is something else.
    pub fn as_volume(&self) -> Option<SingleVolume<'_>> {
        match &self.content {
            Content::Volume {
                volume,
                transfer_function,
                isosurfaces,
                labels,
            } => Some(SingleVolume {
                item: self,
                volume,
                transfer_function,
                isosurfaces,
                labels: *labels,
            }),
            _ => None,
        }
    }
}

/// An item that is a volume, often the only one of a scene.
#[derive(Debug, Clone, Copy)]
pub struct SingleVolume<'a> {
    /// The item itself.
    pub item: &'a Item,
    /// Its data, item space.
    pub volume: &'a Arc<Volume>,
    /// Colour and opacity of its values.
    pub transfer_function: &'a TransferFunction,
    /// Surfaces to show instead of material, where there are any.
    pub isosurfaces: &'a [Isosurface],
    /// Whether values are label numbers.
    pub labels: bool,
}

impl SingleVolume<'_> {
    /// World length to which the transfer function's opacities refer.
    pub fn unit_distance(&self) -> f64 {
        let own = self.transfer_function.unit_distance;
        let own = own.unwrap_or_else(|| self.volume.finest_grid().mean_spacing());
        own * self.item.scale()
    }

    /// The volume where it lies: the same one if it was not moved.
    ///
    /// # Errors
    /// A place that cannot be inverted.
    pub fn placed(&self) -> Result<Arc<Volume>, SceneError> {
        if self.item.world_from_item == DAffine3::IDENTITY {
            return Ok(Arc::clone(self.volume));
        }
        let mut placed = Volume::clone(self.volume);
        placed.transform(self.item.world_from_item)?;
        Ok(Arc::new(placed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PointAttributes, PointLook, Points};
    use glam::DVec3;

    fn item(look: PointLook) -> Item {
        let positions = vec![[0.0; 3], [1.0, 2.0, 3.0]];
        Item::points(
            Points::new(positions, PointAttributes::default(), DAffine3::IDENTITY).unwrap(),
            look,
        )
    }

    #[test]
    fn items_lie_where_they_are_placed() {
        let placed = item(PointLook::default()).at(DAffine3::from_scale(DVec3::new(-2.0, 1.0, 1.0)));
        let scene = Scene::of_items(vec![item(PointLook::default()), placed]).unwrap();
        let bounds = scene.bounds().unwrap();
        assert_eq!(bounds.min, DVec3::new(-2.0, 0.0, 0.0));
        assert_eq!(bounds.max, DVec3::new(1.0, 2.0, 3.0));
        assert!(!scene.is_gaussians());
        let error = scene.single_volume().unwrap_err().to_string();
        assert!(error.starts_with("items: 2"), "{error}");
    }

    #[test]
    fn what_cannot_be_rendered_is_refused() {
        assert!(Scene::of_items(Vec::new()).is_err());
        let flat = item(PointLook::default()).at(DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0)));
        let looks = [
            PointLook {
                radius: Some(0.0),
                ..PointLook::default()
            },
            PointLook {
                opacity: 1.5,
                ..PointLook::default()
            },
            PointLook {
                color: [f64::NAN; 3],
                ..PointLook::default()
            },
        ];
        for item in looks.map(item).into_iter().chain([flat]) {
            assert!(Scene::of_items(vec![item]).is_err());
        }
    }

    #[test]
    fn the_same_data_looking_alike_is_the_same() {
        let a = item(PointLook::default());
        assert!(a.is_same(&a.clone()));
        assert!(!a.is_same(&item(PointLook::default())));
        assert!(!a.is_same(&a.clone().at(DAffine3::from_translation(DVec3::X))));
    }
}
