//! Common code of the two VTK readers: the choice of the array and of the component that make up the volume, and the
//! position of an extent of samples in the world.
//!
//! VTK places point (i, j, k) of an image at `origin + direction * (spacing .* (i, j, k))`, with i, j, k running
//! from the extent's lower ends; a cell's centre is half a spacing farther on.

use glam::{DAffine3, DMat3, DVec3};
use splatvol_scene::{Samples, with_samples};

use super::{Description, Draft, ReadOptions, checked_dims};
use crate::error::Context;
use crate::samples::pick_component;
use crate::{IoError, SampleType};

/// Whether an array has its values at the points or at the cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Association {
    Point,
    Cell,
}

impl Association {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Point => "point data",
            Self::Cell => "cell data",
        }
    }
}

/// Header of an array.
#[derive(Debug, Clone)]
pub(crate) struct ArrayHead {
    pub(crate) association: Association,
    pub(crate) name: String,
    pub(crate) components: usize,
    /// The type as the file spells it.
    pub(crate) type_name: String,
    /// `None` for types without numbers that could be a volume (strings).
    pub(crate) sample_type: Option<SampleType>,
    /// True where the file marks the array as the one to show.
    pub(crate) active: bool,
    /// Whether the numbers are identifiers of points or cells: never shown unless requested.
    pub(crate) is_id: bool,
}

impl ArrayHead {
    /// Name, components, type, association.
    pub(crate) fn describe(&self) -> String {
        let Self {
            name,
            components,
            type_name,
            ..
        } = self;
        format!(
            "`{name}` ({components} x {type_name}, {})",
            self.association.name()
        )
    }
}

/// Choice of a tuple's value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Component {
    Index(usize),
    Magnitude,
}

/// The array to read, as an index into the heads, and its component.
///
/// Without a request: the active array of the point data, else its first scalar array, else the same in the cell
/// data. A request is a name, or `name:component`, or `name:magnitude`; [`ReadOptions::component`] also chooses a
/// component.
///
/// # Errors
/// What is wrong with the request, and the available arrays.
pub(crate) fn choose(
    heads: &[ArrayHead],
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<(usize, Component), IoError> {
    choice(heads, options.array.as_deref(), options.component).map_err(|text| context.unsupported(text))
}

fn choice(
    heads: &[ArrayHead],
    request: Option<&str>,
    component: Option<usize>,
) -> Result<(usize, Component), String> {
    let (index, in_request) = match request {
        Some(request) => requested(heads, request)?,
        None => preferred(heads)?,
    };
    let head = &heads[index];
    let component = in_request.or(component.map(Component::Index));
    if head.sample_type.is_none() {
        return Err(format!("array {} is not of a numeric type", head.describe()));
    }
    if let Some(Component::Index(component)) = component
        && component >= head.components
    {
        return Err(format!("array {} has no component {component}", head.describe()));
    }
    if let Some(component) = component {
        return Ok((index, component));
    }
    match head.components {
        1 => Ok((index, Component::Index(0))),
        n => Err(format!(
            "array {} is not a scalar; name a component: `{name}:0` to `{name}:{last}`, or `{name}:magnitude`",
            head.describe(),
            name = head.name,
            last = n.saturating_sub(1)
        )),
    }
}

/// Like [`choose`], but vectors give their magnitude, and without a scalar array the first array is taken.
///
/// # Errors
/// Same as [`choose`].
pub(crate) fn choose_scalar(
    heads: &[ArrayHead],
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<(usize, Component), IoError> {
    let numeric = |head: &ArrayHead| head.sample_type.is_some();
    let lenient = || {
        let scalar = preferred(heads);
        scalar.or_else(|error| position(heads, numeric).map(|index| (index, None)).ok_or(error))
    };
    let found = options
        .array
        .as_deref()
        .map_or_else(lenient, |request| requested(heads, request));
    let (index, in_request) = found.map_err(|text| context.unsupported(text))?;
    let asked = in_request.or(options.component.map(Component::Index));
    if asked.is_none() && heads[index].components > 1 && numeric(&heads[index]) {
        return Ok((index, Component::Magnitude));
    }
    let component = asked.unwrap_or(Component::Index(0));
    let legal = match component {
        Component::Index(component) => component < heads[index].components,
        Component::Magnitude => true,
    };
    match legal && numeric(&heads[index]) {
        true => Ok((index, component)),
        false => Err(context.unsupported(format!(
            "array {} is not numeric, or has no component {component:?}",
            heads[index].describe()
        ))),
    }
}

fn requested(heads: &[ArrayHead], request: &str) -> Result<(usize, Option<Component>), String> {
    if let Some(index) = position(heads, |head| head.name == request) {
        return Ok((index, None));
    }
    if let Some((name, suffix)) = request.rsplit_once(':')
        && let Some(index) = position(heads, |head| head.name == name)
    {
        return match suffix.parse() {
            _ if suffix == "magnitude" => Ok((index, Some(Component::Magnitude))),
            Ok(component) => Ok((index, Some(Component::Index(component)))),
            Err(_) => Err(format!(
                "array {} has no component `{suffix}`",
                heads[index].describe()
            )),
        };
    }
    Err(format!("no array `{request}`; there is {}", list(heads)))
}

fn preferred(heads: &[ArrayHead]) -> Result<(usize, Option<Component>), String> {
    for association in [Association::Point, Association::Cell] {
        let found = position(heads, |head| head.association == association && head.active).or_else(|| {
            position(heads, |head| {
                head.association == association
                    && head.components == 1
                    && head.sample_type.is_some()
                    && !head.is_id
            })
        });
        if let Some(index) = found {
            return Ok((index, None));
        }
    }
    Err(format!("no scalar array; there is {}", list(heads)))
}

/// First match, point data before cell data.
fn position(heads: &[ArrayHead], wanted: impl Fn(&ArrayHead) -> bool) -> Option<usize> {
    [Association::Point, Association::Cell]
        .into_iter()
        .find_map(|association| {
            heads
                .iter()
                .position(|head| head.association == association && wanted(head))
        })
}

fn list(heads: &[ArrayHead]) -> String {
    const SHOWN: usize = 20;
    if heads.is_empty() {
        return "none".to_owned();
    }
    let mut names: Vec<String> = heads.iter().take(SHOWN).map(ArrayHead::describe).collect();
    if heads.len() > SHOWN {
        names.push(format!("{} more", heads.len() - SHOWN));
    }
    names.join(", ")
}

/// One number of each tuple.
pub(crate) fn pick(samples: Samples, components: usize, component: Component) -> Samples {
    match component {
        Component::Index(_) if components == 1 => samples,
        Component::Index(component) => pick_component(&samples, components, component),
        Component::Magnitude => match samples {
            Samples::F64(data) => Samples::F64(magnitudes(&data, components).collect()),
            other => Samples::F32(with_samples!(other, data => {
                magnitudes(data, components).map(|m| m as f32).collect()
            })),
        },
    }
}

fn magnitudes<T: Copy + Into<f64>>(data: &[T], components: usize) -> impl Iterator<Item = f64> {
    data.chunks_exact(components.max(1)).map(|tuple| {
        let squares = tuple.iter().map(|&value| value.into() * value.into());
        squares.sum::<f64>().sqrt()
    })
}

/// An image's geometry in VTK's terms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ImageGeometry {
    /// First and last point index along x, y, z.
    pub(crate) extent: [[i64; 2]; 3],
    pub(crate) origin: DVec3,
    pub(crate) spacing: DVec3,
    pub(crate) direction: DMat3,
}

/// Number of tuples in an array; `None` if it is more than can be counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TupleCounts {
    pub(crate) points: Option<u64>,
    pub(crate) cells: Option<u64>,
}

impl TupleCounts {
    pub(crate) fn of(self, association: Association) -> Option<u64> {
        match association {
            Association::Point => self.points,
            Association::Cell => self.cells,
        }
    }
}

impl ImageGeometry {
    /// Number of points and cells.
    pub(crate) fn counts(&self) -> TupleCounts {
        TupleCounts {
            points: self.count(Association::Point),
            cells: self.count(Association::Cell),
        }
    }

    /// Number of values along x, y, z. A flat axis has one cell.
    fn sizes(&self, association: Association) -> [i64; 3] {
        self.extent.map(|[first, last]| {
            let points = last.saturating_sub(first).saturating_add(1);
            match association {
                Association::Point => points,
                Association::Cell => (points - 1).max(points.min(1)),
            }
        })
    }

    /// Number of values; `None` if an axis is empty or the product overflows.
    pub(crate) fn count(&self, association: Association) -> Option<u64> {
        let sizes = self.sizes(association);
        sizes.into_iter().try_fold(1u64, |product, size| {
            product.checked_mul(u64::try_from(size).ok().filter(|&size| size > 0)?)
        })
    }

    /// The spacing. Along an axis with one sample it may be 0, as nothing is measured by it; it is the least of the others then.
    fn spacing(&self) -> DVec3 {
        let steps = self.spacing.to_array();
        let least = steps.into_iter().filter(|step| *step != 0.0).map(f64::abs);
        let least = least.reduce(f64::min).unwrap_or(1.0);
        let step = |axis: usize| match self.extent[axis] {
            [first, last] if first == last && steps[axis] == 0.0 => least,
            _ => steps[axis],
        };
        DVec3::new(step(0), step(1), step(2))
    }

    fn world_from_voxel(&self, association: Association) -> DAffine3 {
        let first: [f64; 3] = std::array::from_fn(|axis| {
            let [first, last] = self.extent[axis];
            let half_cell = association == Association::Cell && last > first;
            first as f64 + if half_cell { 0.5 } else { 0.0 }
        });
        let matrix = self.direction * DMat3::from_diagonal(self.spacing());
        DAffine3::from_mat3_translation(matrix, self.origin + matrix * DVec3::from_array(first))
    }

    /// The draft of a volume of points or cells, its geometry checked.
    ///
    /// # Errors
    /// An extent that is empty or too large, or a grid that is not regular.
    pub(crate) fn draft(
        &self,
        association: Association,
        mut description: Description,
        context: &Context<'_>,
    ) -> Result<Draft, IoError> {
        let spacing = self.spacing();
        if !spacing.is_finite() || spacing.cmpeq(DVec3::ZERO).any() {
            return Err(context.field("spacing", spacing, None, "three finite numbers, none 0"));
        }
        let dims = checked_dims(&self.sizes(association), "extent", None, context)?;
        description.orientation = format!(
            "origin, spacing and direction as stored ({}); VTK does not say how a patient lies",
            association.name()
        );
        let mut draft = Draft::new(dims, description);
        draft.world_from_voxel = self.world_from_voxel(association);
        draft.grid(context)?;
        Ok(draft)
    }
}
