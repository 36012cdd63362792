//! An item of a scene: data, their appearance, placement, operators, clips and motion.
//!
//! Appearance is stored with the data that can have it, so that it cannot be given to others: values have a transfer
//! function or isosurfaces, points a colour; Gaussians have their own.

mod automatic;

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use crate::operator::PixelOperator;
use crate::points::check_frame;
use crate::{Bounds, Clip, Gaussians, Mesh, Motion, Points, SceneError, TransferFunction, Volume};

/// The data of an item and its appearance.
#[derive(Debug, Clone)]
pub enum Content {
    /// Samples on a regular grid.
    Volume {
        /// The data. Shared, so that renderers can keep what they derive from it between frames.
        volume: Arc<Volume>,
        /// Colour and opacity of its values.
        transfer_function: TransferFunction,
        /// Surfaces to show instead of material, where there are any: see [`Item::isosurfaces`].
        isosurfaces: Vec<Isosurface>,
        /// Whether values are label numbers: see [`Item::labels`].
        labels: bool,
    },
    /// Samples on any other grid.
    Mesh {
        /// The data.
        mesh: Arc<Mesh>,
        /// Colour and opacity of its values.
        transfer_function: TransferFunction,
        /// Surfaces to show instead of material, where there are any: see [`Item::mesh_isosurfaces`].
        isosurfaces: Vec<Isosurface>,
    },
    /// Points of surfaces.
    Points {
        /// The data.
        points: Arc<Points>,
        /// Appearance that the data do not define.
        look: PointLook,
    },
    /// 3-D Gaussians.
    Gaussians(Arc<Gaussians>),
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

impl Isosurface {
    /// A transfer function that marks the values near a crossing as visible, for data in this range; its density does
    /// not matter.
    fn transfer_function(surfaces: &[Self], [low, high]: [f64; 2]) -> Result<TransferFunction, SceneError> {
        surfaces.iter().try_for_each(Self::validate)?;
        let lowest = surfaces.iter().map(|surface| surface.value).reduce(f64::min);
        let (Some(lowest), Some(first)) = (lowest, surfaces.first()) else {
            return Err(SceneError::invalid("isosurfaces", surfaces, "at least one"));
        };
        let width = ((high - low) / 200.0).max(f64::MIN_POSITIVE);
        TransferFunction::isosurface(lowest, width, first.rgb)
    }

    fn validate(&self) -> Result<(), SceneError> {
        let unit = |value: f64| (0.0..=1.0).contains(&value);
        if self.value.is_finite() && unit(self.opacity) && self.rgb.into_iter().all(unit) {
            return Ok(());
        }
        Err(SceneError::invalid(
            "isosurface",
            self,
            "a finite value; rgb and opacity from 0 to 1",
        ))
    }
}

/// Appearance of points, for attributes that the data lack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointLook {
    /// sRGB of points without colour, 0..1.
    pub color: [f64; 3],
    /// Opacity of a surface of them, 0..1; times their own.
    pub opacity: f64,
    /// Radius of each, item space; `None` for their own, or what lies between them.
    pub radius: Option<f64>,
}

impl Default for PointLook {
    fn default() -> Self {
        Self {
            color: [0.8; 3],
            opacity: 1.0,
            radius: None,
        }
    }
}

impl PointLook {
    fn validate(&self) -> Result<(), SceneError> {
        let unit = |value: &f64| (0.0..=1.0).contains(value);
        if !self.color.iter().all(unit) {
            return Err(SceneError::invalid("colour of points", self.color, "0 to 1"));
        }
        if !unit(&self.opacity) {
            return Err(SceneError::invalid("opacity of points", self.opacity, "0 to 1"));
        }
        match self.radius {
            Some(radius) if !(radius.is_finite() && radius > 0.0) => Err(SceneError::invalid(
                "radius of points",
                radius,
                "finite and above zero",
            )),
            _ => Ok(()),
        }
    }
}

/// A thing of a scene.
#[derive(Debug, Clone)]
pub struct Item {
    /// Data and appearance.
    pub content: Content,
    /// Placement of the content's own space in the world.
    pub world_from_item: DAffine3,
    /// Operators that change the appearance of its material, applied in this order (post-classified pictures only);
    /// positions are in world space.
    pub operators: Vec<Arc<dyn PixelOperator>>,
    /// Clips of this item, item space: a point is visible if every clip keeps it.
    pub clips: Vec<Clip>,
    /// Motion while the shutter is open, world space.
    pub motion: Option<Motion>,
}

impl Item {
    /// An item at the placement given by its data.
    pub fn new(content: Content) -> Self {
        Self {
            content,
            world_from_item: DAffine3::IDENTITY,
            operators: Vec::new(),
            clips: Vec::new(),
            motion: None,
        }
    }

    /// A volume whose values have colours and opacities.
    pub fn volume(volume: impl Into<Arc<Volume>>, transfer_function: TransferFunction) -> Self {
        Self::new(Content::Volume {
            volume: volume.into(),
            transfer_function,
            isosurfaces: Vec::new(),
            labels: false,
        })
    }

    /// A label map: values are label numbers, each with its colour and opacity. Labels are not interpolated: voxels are
    /// classified before they are splatted, whatever the settings for other volumes. A label's surface is lit by the
    /// gradient of its own indicator, 1 in its voxels and 0 in others.
    pub fn labels(volume: impl Into<Arc<Volume>>, transfer_function: TransferFunction) -> Self {
        Self::new(Content::Volume {
            volume: volume.into(),
            transfer_function,
            isosurfaces: Vec::new(),
            labels: true,
        })
    }

    /// Surfaces of a volume: the points where the value between two sheets crosses theirs, exactly, lit by the gradient
    /// there.
    ///
    /// # Errors
    /// No surfaces, values that are not finite, or colours or opacities outside 0..1.
    pub fn isosurfaces(
        volume: impl Into<Arc<Volume>>,
        isosurfaces: &[Isosurface],
    ) -> Result<Self, SceneError> {
        let volume = volume.into();
        let range = volume.value_range();
        Ok(Self::new(Content::Volume {
            volume,
            transfer_function: Isosurface::transfer_function(isosurfaces, range)?,
            isosurfaces: isosurfaces.to_vec(),
            labels: false,
        }))
    }

    /// Surfaces of a mesh; see [`Item::isosurfaces`].
    ///
    /// # Errors
    /// No surfaces, values that are not finite, or colours or opacities outside 0..1.
    pub fn mesh_isosurfaces(
        mesh: impl Into<Arc<Mesh>>,
        isosurfaces: &[Isosurface],
    ) -> Result<Self, SceneError> {
        let mesh = mesh.into();
        let range = mesh.value_range().map(f64::from);
        Ok(Self::new(Content::Mesh {
            mesh,
            transfer_function: Isosurface::transfer_function(isosurfaces, range)?,
            isosurfaces: isosurfaces.to_vec(),
        }))
    }

    /// A mesh whose values have colours and opacities.
    pub fn mesh(mesh: impl Into<Arc<Mesh>>, transfer_function: TransferFunction) -> Self {
        Self::new(Content::Mesh {
            mesh: mesh.into(),
            transfer_function,
            isosurfaces: Vec::new(),
        })
    }

    /// Points of surfaces.
    pub fn points(points: impl Into<Arc<Points>>, look: PointLook) -> Self {
        Self::new(Content::Points {
            points: points.into(),
            look,
        })
    }

    /// 3-D Gaussians.
    pub fn gaussians(gaussians: impl Into<Arc<Gaussians>>) -> Self {
        Self::new(Content::Gaussians(gaussians.into()))
    }

    /// This item at another place.
    #[must_use]
    pub fn at(mut self, world_from_item: DAffine3) -> Self {
        self.world_from_item = world_from_item;
        self
    }

    /// Its box, world.
    pub fn bounds(&self) -> Bounds {
        let own = match &self.content {
            Content::Volume { volume, .. } => volume.grid().bounds(),
            Content::Mesh { mesh, .. } => mesh.bounds(),
            Content::Points { points, .. } => points.bounds(),
            Content::Gaussians(gaussians) => gaussians.bounds(),
        };
        if self.world_from_item == DAffine3::IDENTITY {
            return own;
        }
        let corners = own
            .corners()
            .map(|corner| self.world_from_item.transform_point3(corner));
        Bounds {
            min: corners.into_iter().fold(corners[0], DVec3::min),
            max: corners.into_iter().fold(corners[0], DVec3::max),
        }
    }

    /// Scale from the item's own space to the world: mean factor on lengths over all directions.
    pub fn scale(&self) -> f64 {
        libm::cbrt(self.world_from_item.matrix3.determinant().abs())
    }

    /// Whether it shows isosurfaces instead of material.
    pub fn shows_isosurfaces(&self) -> bool {
        match &self.content {
            Content::Volume { isosurfaces, .. } | Content::Mesh { isosurfaces, .. } => {
                !isosurfaces.is_empty()
            }
            Content::Points { .. } | Content::Gaussians(_) => false,
        }
    }

    /// Whether both items are the same: the same data in memory, looking alike, at the same place. Operators, clips
    /// and motion may differ.
    pub fn is_same(&self, other: &Self) -> bool {
        let content = match (&self.content, &other.content) {
            (
                Content::Volume {
                    volume: a,
                    transfer_function: ta,
                    isosurfaces: ia,
                    labels: la,
                },
                Content::Volume {
                    volume: b,
                    transfer_function: tb,
                    isosurfaces: ib,
                    labels: lb,
                },
            ) => Arc::ptr_eq(a, b) && ta == tb && ia == ib && la == lb,
            (
                Content::Mesh {
                    mesh: a,
                    transfer_function: ta,
                    isosurfaces: ia,
                },
                Content::Mesh {
                    mesh: b,
                    transfer_function: tb,
                    isosurfaces: ib,
                },
            ) => Arc::ptr_eq(a, b) && ta == tb && ia == ib,
            (Content::Points { points: a, look: la }, Content::Points { points: b, look: lb }) => {
                Arc::ptr_eq(a, b) && la == lb
            }
            (Content::Gaussians(a), Content::Gaussians(b)) => Arc::ptr_eq(a, b),
            _ => false,
        };
        content && self.world_from_item == other.world_from_item
    }

    /// Checks place, look and motion.
    ///
    /// # Errors
    /// A place that cannot be inverted, a look outside its domain, or a motion that does not fit.
    pub fn validate(&self) -> Result<(), SceneError> {
        check_frame(&self.world_from_item)?;
        if let Some(motion) = &self.motion {
            motion.validate(&self.content)?;
        }
        match &self.content {
            Content::Volume { isosurfaces, .. } | Content::Mesh { isosurfaces, .. } => {
                isosurfaces.iter().try_for_each(Isosurface::validate)
            }
            Content::Points { look, .. } => look.validate(),
            Content::Gaussians(_) => Ok(()),
        }
    }
}
