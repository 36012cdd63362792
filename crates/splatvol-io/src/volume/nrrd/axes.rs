//! Roles of the axes: spatial axes, components, and time points.
//!
//! Axes before the first spatial one vary faster: they are components of a vector. Axes after the last spatial one
//! vary slower: time points or lists of volumes (or components, where their kind says so).

use glam::DVec3;

use super::header::Header;
use super::space::{Direction, Space};
use crate::IoError;
use crate::error::Context;
use crate::volume::fields::Field;
use crate::volume::stored::Selection;
use crate::volume::{ReadOptions, checked_dims, choose_component, choose_time};

/// One axis.
#[derive(Debug, Clone)]
struct Axis {
    size: usize,
    role: Role,
    /// World step in the file's space; `None` if the file has none.
    step: Option<DVec3>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    Spatial,
    Time,
    Components,
}

/// The spatial axes, and the selected indices along the others.
#[derive(Debug)]
pub(super) struct Axes {
    pub(super) selection: Selection,
    /// Numbers of the spatial axes.
    pub(super) spatial: Vec<usize>,
    /// Steps along the spatial axes in the file's space.
    pub(super) steps: Vec<Option<DVec3>>,
}

/// Sorts the axes of `header`.
pub(super) fn select(
    header: &Header,
    space: &Space,
    options: &ReadOptions,
    context: &Context<'_>,
) -> Result<Axes, IoError> {
    let axes = axes(header, space, context)?;
    let spatial: Vec<usize> = (0..axes.len())
        .filter(|&i| axes[i].role == Role::Spatial)
        .collect();
    let (Some(&first), Some(&last)) = (spatial.first(), spatial.last()) else {
        return Err(context.unsupported("no axis is spatial"));
    };
    if spatial.len() > 3 {
        return Err(context.unsupported(format!(
            "{} spatial axes; \"kinds\" must say which are not space",
            spatial.len()
        )));
    }
    let between = (first..last).any(|i| axes[i].role != Role::Spatial && axes[i].size > 1);
    if between {
        return Err(context.unsupported("an axis of components lies between spatial axes"));
    }
    let sizes: Vec<i64> = spatial
        .iter()
        .map(|&i| i64::try_from(axes[i].size).unwrap_or(i64::MAX))
        .collect();
    let offset = header.fields.get("sizes").map(|field| field.offset);
    let dims = checked_dims(&sizes, "sizes", offset, context)?;
    let components = product(&axes[..first], options, context)?;
    let volumes = product(&axes[last + 1..], options, context)?;
    let slow = axes[last + 1..].iter().find(|axis| axis.size > 1);
    let (component, volume) = match (components, slow.map(|axis| axis.role)) {
        (1, Some(Role::Components)) => (0, choose_component(volumes, "vectors", options, context)?),
        (_, Some(Role::Components)) => {
            return Err(context.unsupported("components both before and after the spatial axes"));
        }
        _ => (
            choose_component(components, "vectors", options, context)?,
            choose_time(volumes, options, context)?,
        ),
    };
    Ok(Axes {
        selection: Selection {
            dims,
            components,
            component,
            volumes,
            times: match slow.map(|axis| axis.role) {
                Some(Role::Components) => 1,
                _ => volumes,
            },
            volume,
        },
        steps: spatial.iter().map(|&i| axes[i].step).collect(),
        spatial,
    })
}

/// Number of entries along some axes together.
fn product(axes: &[Axis], options: &ReadOptions, context: &Context<'_>) -> Result<usize, IoError> {
    let product = axes
        .iter()
        .try_fold(1usize, |product, axis| product.checked_mul(axis.size));
    product.ok_or_else(|| context.limit(u64::MAX, options.max_bytes))
}

fn axes(header: &Header, space: &Space, context: &Context<'_>) -> Result<Vec<Axis>, IoError> {
    let count = header.sizes.len();
    let kinds = kinds(header.fields.get("kinds"), count, context)?;
    let spacings: Option<Vec<f64>> = header
        .fields
        .get("spacings")
        .map(|field| field.exactly(count, "numbers", context))
        .transpose()?;
    let directions = match header.fields.get("spacedirections") {
        Some(field) => Some(space.directions(field, count, context)?),
        None => None,
    };
    let mut spatial = 0;
    let axis = |(i, &size): (usize, &usize)| {
        let spacing = spacings.as_ref().map(|spacings| spacings[i]);
        let (role, step) = match directions.as_ref().map(|directions| directions[i]) {
            Some(Direction::Space(step)) => (Role::Spatial, Some(step)),
            Some(Direction::Time) => (Role::Time, None),
            Some(Direction::None) => (
                kinds[i]
                    .filter(|&role| role != Role::Spatial)
                    .unwrap_or(Role::Components),
                None,
            ),
            None => match (kinds[i], spacing) {
                (Some(role), _) if role != Role::Spatial => (role, None),
                // Without a kind, "not a number" is how writers say that an axis has no spacing.
                (None, Some(spacing)) if spacing.is_nan() => (Role::Components, None),
                _ => {
                    let unit = [DVec3::X, DVec3::Y, DVec3::Z][spatial % 3];
                    (Role::Spatial, spacing.map(|spacing| unit * spacing))
                }
            },
        };
        spatial += usize::from(role == Role::Spatial);
        Axis { size, role, step }
    };
    Ok(header.sizes.iter().enumerate().map(axis).collect())
}

/// Roles by the field `kinds`; `None` without information.
fn kinds(field: Option<&Field>, count: usize, context: &Context<'_>) -> Result<Vec<Option<Role>>, IoError> {
    let Some(field) = field else {
        return Ok(vec![None; count]);
    };
    let kinds: Vec<String> = field.exactly(count, "kinds", context)?;
    let role = |kind: &String| match kind.to_ascii_lowercase().as_str() {
        "domain" | "space" => Some(Role::Spatial),
        "time" | "list" => Some(Role::Time),
        "???" | "none" => None,
        _ => Some(Role::Components),
    };
    Ok(kinds.iter().map(role).collect())
}
