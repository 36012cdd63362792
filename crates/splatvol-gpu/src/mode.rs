//! Mode: what a pixel makes of the planes, and the shaders that do it.

use splatvol_core::level::{Level, Wanted};
use splatvol_scene::{Gradient, SheetSettings};

use crate::effects::Effects;

const FRAME: &str = include_str!("../shaders/frame.wgsl");
const FIELD: &str = include_str!("../shaders/field.wgsl");
const JET: &str = include_str!("../shaders/jet.wgsl");
const LIGHT: &str = include_str!("../shaders/light.wgsl");
const TABLE: &str = include_str!("../shaders/table.wgsl");
const NODES: &str = include_str!("../shaders/nodes.wgsl");
const EYE: &str = include_str!("../shaders/eye.wgsl");
const ACROSS: &str = include_str!("../shaders/across.wgsl");
const PLANES: &str = include_str!("../shaders/planes.wgsl");
const CLIPS: &str = include_str!("../shaders/clips.wgsl");
const EFFECTS: &str = include_str!("../shaders/effects.wgsl");
const MATERIAL: &str = include_str!("../shaders/material.wgsl");
const ENDS: &str = include_str!("../shaders/ends.wgsl");
const ANALYTIC: &str = include_str!("../shaders/analytic.wgsl");
const CUBIC: &str = include_str!("../shaders/cubic.wgsl");
const VALUES: &str = include_str!("../shaders/values.wgsl");
const EXACT_VALUES: &str = include_str!("../shaders/exact_values.wgsl");
const MARCH: &str = include_str!("../shaders/march.wgsl");

/// What a ray shows of its values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Kept {
    Largest,
    Smallest,
    Mean,
}

/// What a pixel makes of the planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Mode {
    /// Material, lit by differences of four planes.
    Material,
    /// The same where clips leave it, or isosurfaces instead.
    Effects,
    /// Material, lit by the field's gradients.
    Analytic,
    /// One value of the ray, of cubics through four planes.
    Values(Kept),
    /// One value of the ray, of cubics with the field's slopes.
    ExactValues(Kept),
}

impl Mode {
    /// The mode of these settings; `None` for voxels that are classified before they are splatted.
    pub(crate) fn of(wanted: Wanted, sheets: &SheetSettings, effects: &Effects) -> Option<Self> {
        let kept = match wanted {
            Wanted::Visible => None,
            Wanted::Largest => Some(Kept::Largest),
            Wanted::Smallest => Some(Kept::Smallest),
            Wanted::All => Some(Kept::Mean),
            Wanted::Classified => return None,
        };
        Some(match (kept, sheets.gradient) {
            (None, Gradient::Differences) if effects.is_none() => Self::Material,
            (None, Gradient::Differences) => Self::Effects,
            (None, Gradient::Analytic) => Self::Analytic,
            (Some(kept), Gradient::Differences) => Self::Values(kept),
            (Some(kept), Gradient::Analytic) => Self::ExactValues(kept),
        })
    }

    /// What rays keep, if it is a value.
    pub(crate) fn kept(self) -> Option<Kept> {
        match self {
            Self::Values(kept) | Self::ExactValues(kept) => Some(kept),
            Self::Material | Self::Effects | Self::Analytic => None,
        }
    }

    /// The text of its shaders: entry points `march` and, where rays keep values, `settle`.
    pub(crate) fn text(self) -> String {
        [self.library(), MARCH.to_owned()].join("\n")
    }

    /// The text without the loop over planes.
    pub(crate) fn library(self) -> String {
        let parts: &[&str] = match self {
            Self::Material => &[FRAME, FIELD, JET, EYE, TABLE, LIGHT, ACROSS, PLANES, MATERIAL],
            Self::Effects => &[
                FRAME, FIELD, JET, EYE, TABLE, LIGHT, ACROSS, PLANES, CLIPS, EFFECTS,
            ],
            Self::Analytic => &[FRAME, FIELD, JET, NODES, LIGHT, ENDS, ANALYTIC],
            Self::Values(_) => &[FRAME, FIELD, JET, EYE, NODES, LIGHT, CUBIC, VALUES],
            Self::ExactValues(_) => &[FRAME, FIELD, JET, NODES, LIGHT, ENDS, CUBIC, EXACT_VALUES],
        };
        parts.join("\n")
    }

    /// Constants of its entry points, apart from the kernel's.
    pub(crate) fn constants(self, from_eye: bool) -> Vec<(&'static str, f64)> {
        let from_eye = ("FROM_EYE", f64::from(u8::from(from_eye)));
        let keeps = |kept| ("KEEPS", f64::from(kept as u8));
        match self {
            Self::Material | Self::Effects => vec![from_eye],
            Self::Analytic => Vec::new(),
            Self::Values(kept) => vec![from_eye, keeps(kept)],
            Self::ExactValues(kept) => vec![keeps(kept)],
        }
    }

    /// The transfer function as its shaders look it up.
    pub(crate) fn look(self, level: &Level) -> Vec<[f32; 4]> {
        match self {
            Self::Material | Self::Effects => level.table.cells().to_vec(),
            _ => nodes(level),
        }
    }
}

/// Per node integrals, then extinction and linear colour.
fn nodes(level: &Level) -> Vec<[f32; 4]> {
    use splatvol_core::classification::ClassificationTable;
    (0..=ClassificationTable::CELLS)
        .flat_map(|index| {
            let (integrals, [extinction, ..], [r, g, b]) = level.classification.node(index);
            [integrals.map(|k| k as f32), [extinction, r, g, b]]
        })
        .collect()
}
