//! Values that colour a surface.

use splatvol_scene::Samples;

use super::Look;
use crate::IoError;
use crate::error::Context;
use crate::mesh::assemble::to_f64;
use crate::volume::ReadOptions;
use crate::volume::vtk_array::{self, ArrayHead, Association, Component};

/// One array's values, of the points or of the cells.
#[derive(Debug)]
pub(crate) struct Scalars {
    /// Name of the array.
    pub(crate) name: String,
    /// Whether somebody asked for the array.
    pub(crate) is_asked: bool,
    association: Association,
    pub(crate) points: Vec<f64>,
    pub(crate) polygons: Vec<f64>,
    pub(crate) strips: Vec<f64>,
}

/// The array of a file that colours, and its component.
#[derive(Debug, Clone)]
pub(crate) struct Choice {
    pub(crate) head: ArrayHead,
    component: Component,
    is_asked: bool,
}

/// The array that colours: the one that is asked for; otherwise, where there are no colours, the active scalar, the first
/// one of the points or of the cells. An array of colours that is asked for is one of colours.
pub(crate) fn choose(
    heads: &[ArrayHead],
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<Option<Choice>, IoError> {
    let is_look = |head: &ArrayHead| Look::of(head).is_some();
    let found = match &options.array {
        Some(_) => Some(vtk_array::choose_scalar(heads, options, context)?),
        None if heads.iter().any(|head| Look::of(head) == Some(Look::Colors)) => None,
        None => vtk_array::choose(heads, options, context).ok(),
    };
    let found =
        found.filter(|&(index, component)| !is_look(&heads[index]) || component != Component::Magnitude);
    Ok(found.map(|(index, component)| Choice {
        head: heads[index].clone(),
        component,
        is_asked: options.array.is_some(),
    }))
}

impl Choice {
    /// The same array of another piece.
    pub(crate) fn position(&self, heads: &[ArrayHead]) -> Option<usize> {
        let same = |head: &ArrayHead| {
            head.name == self.head.name
                && head.association == self.head.association
                && head.components == self.head.components
        };
        heads.iter().position(same)
    }

    pub(crate) fn is_of_points(&self) -> bool {
        self.head.association == Association::Point
    }

    /// One number of each tuple.
    pub(crate) fn pick(&self, samples: Samples) -> Vec<f64> {
        to_f64(&vtk_array::pick(samples, self.head.components, self.component))
    }

    pub(crate) fn scalars(&self) -> Scalars {
        Scalars {
            name: self.head.name.clone(),
            is_asked: self.is_asked,
            association: self.head.association,
            points: Vec::new(),
            polygons: Vec::new(),
            strips: Vec::new(),
        }
    }
}

impl Scalars {
    pub(crate) fn is_of_points(&self) -> bool {
        self.association == Association::Point
    }

    /// Whether there is a value for each of these numbers of points, polygons and strips.
    pub(super) fn fits(&self, [points, polygons, strips]: [usize; 3]) -> bool {
        match self.association {
            Association::Point => self.points.len() == points,
            Association::Cell => self.polygons.len() == polygons && self.strips.len() == strips,
        }
    }

    /// All values.
    pub(crate) fn values(&self) -> impl Iterator<Item = f64> {
        [&self.points, &self.polygons, &self.strips]
            .into_iter()
            .flatten()
            .copied()
    }
}
