//! Several things in one picture: volumes, meshes with data, points and Gaussians, each where it belongs.
//!
//! They are composited sheet by sheet, so that translucent things interpenetrate as they do in space.

use std::sync::Arc;

use glam::DAffine3;

use crate::points::check_frame;
use crate::{Bounds, Gaussians, Mesh, Points, SceneError, TransferFunction, Volume};

/// What an item is.
#[derive(Debug, Clone)]
pub enum Content {
    /// Samples on a regular grid, classified.
    Volume {
        /// The data.
        volume: Arc<Volume>,
        /// Colour and opacity of its values.
        transfer_function: TransferFunction,
    },
    /// Samples on any other grid, classified.
    Mesh {
        /// The data.
        mesh: Arc<Mesh>,
        /// Colour and opacity of its values.
        transfer_function: TransferFunction,
    },
    /// Points of surfaces.
    Points {
        /// The data.
        points: Arc<Points>,
        /// What is not in the data.
        look: PointLook,
    },
    /// 3-D Gaussians.
    Gaussians(Arc<Gaussians>),
}

/// How points look where they do not say so themselves.
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

/// A thing of a composition.
#[derive(Debug, Clone)]
pub struct Item {
    /// What it is.
    pub content: Content,
    /// Where the content's own world lies.
    pub world_from_item: DAffine3,
}

impl Item {
    /// An item where its data say.
    pub fn new(content: Content) -> Self {
        Self {
            content,
            world_from_item: DAffine3::IDENTITY,
        }
    }

    /// Its box, world.
    pub fn bounds(&self) -> Bounds {
        let own = match &self.content {
            Content::Volume { volume, .. } => volume.grid().bounds(),
            Content::Mesh { mesh, .. } => mesh.bounds(),
            Content::Points { points, .. } => points.bounds(),
            Content::Gaussians(gaussians) => gaussians.bounds(),
        };
        let corners = own
            .corners()
            .map(|corner| self.world_from_item.transform_point3(corner));
        Bounds {
            min: corners.into_iter().fold(corners[0], glam::DVec3::min),
            max: corners.into_iter().fold(corners[0], glam::DVec3::max),
        }
    }

    /// Whether it is the same: the same data in memory, looking alike, at the same place.
    pub fn is_same(&self, other: &Self) -> bool {
        let content = match (&self.content, &other.content) {
            (
                Content::Volume {
                    volume: a,
                    transfer_function: ta,
                },
                Content::Volume {
                    volume: b,
                    transfer_function: tb,
                },
            ) => Arc::ptr_eq(a, b) && ta == tb,
            (
                Content::Mesh {
                    mesh: a,
                    transfer_function: ta,
                },
                Content::Mesh {
                    mesh: b,
                    transfer_function: tb,
                },
            ) => Arc::ptr_eq(a, b) && ta == tb,
            (Content::Points { points: a, look: la }, Content::Points { points: b, look: lb }) => {
                Arc::ptr_eq(a, b) && la == lb
            }
            (Content::Gaussians(a), Content::Gaussians(b)) => Arc::ptr_eq(a, b),
            _ => false,
        };
        content && self.world_from_item == other.world_from_item
    }

    fn validate(&self) -> Result<(), SceneError> {
        check_frame(&self.world_from_item)?;
        let Content::Points { look, .. } = &self.content else {
            return Ok(());
        };
        let unit = |value: &f64| (0.0..=1.0).contains(value);
        if !look.color.iter().all(unit) {
            return Err(SceneError::invalid("colour of points", look.color, "0 to 1"));
        }
        if !unit(&look.opacity) {
            return Err(SceneError::invalid("opacity of points", look.opacity, "0 to 1"));
        }
        match look.radius {
            Some(radius) if !(radius.is_finite() && radius > 0.0) => Err(SceneError::invalid(
                "radius of points",
                radius,
                "finite and above zero",
            )),
            _ => Ok(()),
        }
    }
}

/// Things that are rendered together.
#[derive(Debug, Clone, Default)]
pub struct Composition {
    /// The things.
    pub items: Vec<Item>,
    /// Linear light, straight alpha: what Gaussians in the published renderer's way are composited over, in display space
    /// as there. Nothing else takes notice of it.
    pub background: [f32; 4],
}

impl Composition {
    /// Things over nothing.
    ///
    /// # Errors
    /// No items, a place that cannot be inverted, or a look of points outside its domain.
    pub fn new(items: Vec<Item>) -> Result<Self, SceneError> {
        if items.is_empty() {
            return Err(SceneError::invalid("items", items.len(), "at least one"));
        }
        items.iter().try_for_each(Item::validate)?;
        Ok(Self {
            items,
            background: [0.0; 4],
        })
    }

    /// Box of all items, world.
    pub fn bounds(&self) -> Option<Bounds> {
        self.items.iter().map(Item::bounds).reduce(|a, b| Bounds {
            min: a.min.min(b.min),
            max: a.max.max(b.max),
        })
    }

    /// Whether all of it is Gaussians.
    pub fn is_gaussians(&self) -> bool {
        let is = |item: &Item| matches!(item.content, Content::Gaussians(_));
        self.items.iter().all(is)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PointAttributes;
    use glam::DVec3;

    fn points() -> Arc<Points> {
        let positions = vec![[0.0; 3], [1.0, 2.0, 3.0]];
        Arc::new(Points::new(positions, PointAttributes::default(), DAffine3::IDENTITY).unwrap())
    }

    fn item(look: PointLook) -> Item {
        let points = points();
        Item::new(Content::Points { points, look })
    }

    #[test]
    fn items_lie_where_they_are_placed() {
        let mut placed = item(PointLook::default());
        placed.world_from_item = DAffine3::from_scale(DVec3::new(-2.0, 1.0, 1.0));
        let composition = Composition::new(vec![item(PointLook::default()), placed]).unwrap();
        let bounds = composition.bounds().unwrap();
        assert_eq!(bounds.min, DVec3::new(-2.0, 0.0, 0.0));
        assert_eq!(bounds.max, DVec3::new(1.0, 2.0, 3.0));
        assert!(!composition.is_gaussians());
    }

    #[test]
    fn what_cannot_be_rendered_is_refused() {
        assert!(Composition::new(Vec::new()).is_err());
        let mut flat = item(PointLook::default());
        flat.world_from_item = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
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
            assert!(Composition::new(vec![item]).is_err());
        }
    }

    #[test]
    fn the_same_data_looking_alike_is_the_same() {
        let a = item(PointLook::default());
        assert!(a.is_same(&a.clone()));
        assert!(!a.is_same(&item(PointLook::default())));
        let mut moved = a.clone();
        moved.world_from_item = DAffine3::from_translation(DVec3::X);
        assert!(!a.is_same(&moved));
    }
}
