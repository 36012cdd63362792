//! Pictures stacked into a volume: the pages of a file, or the slices of a folder.

use splatvol_scene::Samples;

use crate::IoError;
use crate::error::Context;
use crate::samples::pick_component;

/// A picture, row by row from the top.
pub(super) struct Plane {
    /// Columns and rows.
    pub(super) size: [usize; 2],
    /// Interleaved components.
    pub(super) components: usize,
    pub(super) samples: Samples,
}

impl Plane {
    /// One of its components.
    pub(super) fn component(self, component: usize) -> Samples {
        match self.components {
            1 => self.samples,
            components => pick_component(&self.samples, components, component),
        }
    }
}

/// Names of the interleaved components of a picture.
pub(super) fn component_names(components: usize) -> Vec<String> {
    let names: &[&str] = match components {
        2 => &["grey", "alpha"],
        3 => &["red", "green", "blue"],
        4 => &["red", "green", "blue", "alpha"],
        _ => &[],
    };
    let name = |i: usize| {
        names
            .get(i)
            .map_or_else(|| format!("component {i}"), |&name| name.to_owned())
    };
    (0..components).map(name).collect()
}

/// Adds the samples of the next slice, which must have the type and number of the samples before.
pub(super) fn append(pile: &mut Samples, slice: Samples, context: &Context<'_>) -> Result<(), IoError> {
    let (own, other) = (pile.type_name(), slice.type_name());
    match extend(pile, slice) {
        true => Ok(()),
        false => Err(context.unsupported(format!("samples are {other}, those of the slices before {own}"))),
    }
}

/// Adds samples to others, and returns whether they have the same type.
pub(super) fn extend(pile: &mut Samples, more: Samples) -> bool {
    macro_rules! extend {
        ($($variant:ident)*) => {
            match (pile, more) {
                $((Samples::$variant(pile), Samples::$variant(more)) => {
                    pile.to_mut().extend_from_slice(&more);
                    true
                })*
                _ => false,
            }
        };
    }
    extend!(U8 I8 U16 I16 U32 I32 F32 F64)
}
