//! Mode: what a pixel makes of the planes, and the shaders that do it.

use splatvol_core::classification::ClassificationTable;
use splatvol_core::level::{Level, Wanted};
use splatvol_scene::{Gradient, SheetSettings, Shows};

use crate::effects::Effects;
use crate::footprints::{BATCH, SPLAT, VIEW};
use crate::sort::LISTS;

const FRAME: &str = include_str!("../shaders/frame.wgsl");
const OPEN_PIXELS: &str = include_str!("../shaders/open.wgsl");
const FIELD: &str = include_str!("../shaders/field.wgsl");
const JET: &str = include_str!("../shaders/jet.wgsl");
const WHOLE: &str = include_str!("../shaders/whole.wgsl");
const HOLES: &str = include_str!("../shaders/holes.wgsl");
const BESIDE: &str = include_str!("../shaders/beside.wgsl");
const AROUND: &str = include_str!("../shaders/around.wgsl");
const LIGHT: &str = include_str!("../shaders/light.wgsl");
const TABLE: &str = include_str!("../shaders/table.wgsl");
const NODES: &str = include_str!("../shaders/nodes.wgsl");
const LOW_PASS: &str = include_str!("../shaders/low_pass.wgsl");
const COEFFICIENTS: &str = include_str!("../shaders/coefficients.wgsl");
const SLAB: &str = include_str!("../shaders/slab.wgsl");
const SUMS: &str = include_str!("../shaders/sums.wgsl");
const CLASSES: &str = include_str!("../shaders/classes.wgsl");
const COMPOSE: &str = include_str!("../shaders/compose.wgsl");
const XRAY: &str = include_str!("../shaders/xray.wgsl");
const INTEGRALS: &str = include_str!("../shaders/integrals.wgsl");
const CLASSIFY: &str = include_str!("../shaders/classify.wgsl");
const SETTLE: &str = include_str!("../shaders/settle.wgsl");
const DIRECT: &str = include_str!("../shaders/direct.wgsl");
const GATHER: &str = include_str!("../shaders/gather.wgsl");
const MIXTURE: &str = include_str!("../shaders/mixture.wgsl");
const EYE: &str = include_str!("../shaders/eye.wgsl");
const ACROSS: &str = include_str!("../shaders/across.wgsl");
const PLANES: &str = include_str!("../shaders/planes.wgsl");
const CLIPS: &str = include_str!("../shaders/clips.wgsl");
const SAMPLE: &str = include_str!("../shaders/sample.wgsl");
const EFFECTS: &str = include_str!("../shaders/effects.wgsl");
const MATERIAL: &str = include_str!("../shaders/material.wgsl");
const ENDS: &str = include_str!("../shaders/ends.wgsl");
const ANALYTIC: &str = include_str!("../shaders/analytic.wgsl");
const CUBIC: &str = include_str!("../shaders/cubic.wgsl");
const VALUES: &str = include_str!("../shaders/values.wgsl");
const EXACT_VALUES: &str = include_str!("../shaders/exact_values.wgsl");
const CLOUD_SPLAT: &str = include_str!("../shaders/clouds/splat.wgsl");
const KERNEL: &str = include_str!("../shaders/clouds/kernel.wgsl");
const OPEN: &str = include_str!("../shaders/clouds/open.wgsl");
const CLOUD_PROJECT: &str = include_str!("../shaders/clouds/project.wgsl");
const INTEGRATE: &str = include_str!("../shaders/clouds/integrate.wgsl");
const CLOUD_PAIRS: &str = include_str!("../shaders/clouds/pairs.wgsl");
const RING: &str = include_str!("../shaders/clouds/ring.wgsl");
const CLOUD_COLORS: &str = include_str!("../shaders/clouds/colors.wgsl");
const CLOUD_VALUES: &str = include_str!("../shaders/clouds/values.wgsl");
const CLOUD_PLANES: &str = include_str!("../shaders/clouds/planes.wgsl");
const READ: &str = include_str!("../shaders/clouds/read.wgsl");
const CLOUD_MEANS: &str = include_str!("../shaders/clouds/means.wgsl");
const CLOUD_RAYS: &str = include_str!("../shaders/clouds/rays.wgsl");
const EMISSION: &str = include_str!("../shaders/clouds/emission.wgsl");
const CLOUD_FIELD: &str = include_str!("../shaders/clouds/field.wgsl");
const MARCH: &str = include_str!("../shaders/march.wgsl");

/// What a ray shows of its values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Kept {
    Largest,
    Smallest,
    Mean,
}

impl Kept {
    /// What is kept with these settings; `None` where rays composite material, or integrate it.
    pub(crate) fn of(wanted: Wanted) -> Option<Self> {
        match wanted {
            Wanted::Visible | Wanted::Classified => None,
            Wanted::Largest => Some(Self::Largest),
            Wanted::Smallest => Some(Self::Smallest),
            Wanted::All => Some(Self::Mean),
        }
    }

    /// As constant of shaders.
    fn constant(self) -> (&'static str, f64) {
        ("KEEPS", f64::from(self as u8))
    }
}

/// What a pixel makes of the planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Mode {
    /// Material, lit by differences of four planes.
    Material,
    /// The same where clips leave it, or isosurfaces instead; with operators.
    Effects,
    /// Material, lit by the field's gradients.
    Analytic,
    /// One value of the ray, of cubics through four planes.
    Values(Kept),
    /// One value of the ray, of cubics with the field's slopes.
    ExactValues(Kept),
    /// Material of voxels that are classified before they are splatted.
    Compose,
    /// Integrals of the same.
    Xray,
}

impl Mode {
    /// The mode of these settings.
    pub(crate) fn of(wanted: Wanted, sheets: &SheetSettings, effects: &Effects) -> Self {
        if wanted == Wanted::Classified {
            return match sheets.shows {
                Shows::Xray => Self::Xray,
                _ => Self::Compose,
            };
        }
        match (Kept::of(wanted), sheets.gradient) {
            (None, Gradient::Differences) if effects.is_none() => Self::Material,
            (None, Gradient::Differences) => Self::Effects,
            (None, Gradient::Analytic) => Self::Analytic,
            (Some(kept), Gradient::Differences) => Self::Values(kept),
            (Some(kept), Gradient::Analytic) => Self::ExactValues(kept),
        }
    }

    /// Whether rays keep something that is no colour yet.
    pub(crate) fn settles(self) -> bool {
        matches!(self, Self::Values(_) | Self::ExactValues(_) | Self::Xray)
    }

    /// Whether voxels are classified before they are splatted.
    pub(crate) fn splats_classes(self) -> bool {
        matches!(self, Self::Compose | Self::Xray)
    }

    /// The text of its shaders: entry points `march` and, where rays keep something else than colours, `settle`.
    /// `has_holes`: samples are missing; `gathers`: intervals are kept beside those of other layers; `operators`: the function
    /// `operate` of an item with effects.
    pub(crate) fn text(self, [has_holes, gathers]: [bool; 2], operators: &str) -> String {
        let settle = if self.settles() && !gathers { SETTLE } else { "" };
        let target = if gathers { GATHER } else { DIRECT };
        let operators = if self == Self::Effects { operators } else { "" };
        [&self.library(has_holes), operators, MARCH, target, settle].join("\n")
    }

    /// The text without the loop over planes. `has_holes`: samples are missing.
    pub(crate) fn library(self, has_holes: bool) -> String {
        let field = [
            FRAME,
            OPEN_PIXELS,
            FIELD,
            JET,
            LOW_PASS,
            LIGHT,
            if has_holes { HOLES } else { WHOLE },
        ];
        let own: &[&str] = match self {
            Self::Material => &[
                COEFFICIENTS,
                BESIDE,
                EYE,
                AROUND,
                TABLE,
                ACROSS,
                PLANES,
                SUMS,
                MATERIAL,
            ],
            Self::Effects => &[
                COEFFICIENTS,
                BESIDE,
                EYE,
                AROUND,
                TABLE,
                ACROSS,
                PLANES,
                SUMS,
                CLIPS,
                SAMPLE,
                EFFECTS,
            ],
            Self::Analytic => &[COEFFICIENTS, NODES, ENDS, ANALYTIC],
            Self::Values(_) => &[COEFFICIENTS, BESIDE, EYE, AROUND, NODES, CUBIC, VALUES],
            Self::ExactValues(_) => &[COEFFICIENTS, NODES, ENDS, CUBIC, EXACT_VALUES],
            Self::Compose => &[CLASSES, SLAB, EYE, COMPOSE],
            Self::Xray => &[CLASSES, SLAB, XRAY, INTEGRALS],
        };
        [field.as_slice(), own].concat().join("\n")
    }

    /// Constants of its entry points, apart from the kernel's.
    pub(crate) fn constants(self, from_eye: bool) -> Vec<(&'static str, f64)> {
        let from_eye = ("FROM_EYE", f64::from(u8::from(from_eye)));
        match self {
            Self::Material | Self::Effects | Self::Compose => vec![from_eye],
            Self::Analytic | Self::Xray => Vec::new(),
            Self::Values(kept) => vec![from_eye, kept.constant()],
            Self::ExactValues(kept) => vec![kept.constant()],
        }
    }

    /// Smallest and largest visible value.
    pub(crate) fn hull(self, level: &Level) -> [f32; 2] {
        if self.splats_classes() {
            level.hull
        } else {
            level.table.hull
        }
    }

    /// The transfer function as its shaders look it up.
    pub(crate) fn look(self, level: &Level) -> Vec<[f32; 4]> {
        match self {
            Self::Material | Self::Effects => level.table.cells().to_vec(),
            _ => nodes(&level.classification),
        }
    }
}

/// The text of the pass that classifies voxels.
pub(crate) fn classify_shader() -> String {
    [FRAME, NODES, LIGHT, CLIPS, CLASSIFY].join("\n")
}

/// What a pixel makes of a cloud's planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum CloudMode {
    /// Material of kernels that are classified before they are splatted.
    Colors,
    /// Material of a mesh's values, lit by differences of four planes.
    Field,
    /// The same where clips leave it, or isosurfaces instead; with operators.
    FieldEffects,
    /// One value of the ray through a mesh.
    Values(Kept),
}

impl CloudMode {
    /// Whether rays keep something that is no colour yet. Otherwise intervals are kept beside those of other layers.
    pub(crate) fn settles(self) -> bool {
        matches!(self, Self::Values(_))
    }

    /// The text of its shaders: entry points `march` and, where rays keep something else than colours, `settle`. `operators`:
    /// the function `operate` of a mesh with effects.
    pub(crate) fn text(self, operators: &str) -> String {
        let field = [
            RING,
            CLOUD_VALUES,
            READ,
            CLOUD_MEANS,
            TABLE,
            PLANES,
            CLOUD_FIELD,
            EYE,
        ]
        .as_slice();
        let own: Vec<&str> = match self {
            Self::Colors => vec![RING, CLOUD_COLORS, READ, SLAB, EMISSION],
            Self::Field => [field, &[MATERIAL]].concat(),
            Self::FieldEffects => [field, &[CLIPS, SAMPLE, EFFECTS, operators]].concat(),
            Self::Values(_) => vec![RING, CLOUD_VALUES, READ, CLOUD_MEANS, NODES, CUBIC, CLOUD_RAYS],
        };
        let target: &[&str] = match self.settles() {
            true => &[DIRECT, SETTLE],
            false => &[GATHER],
        };
        [
            &[FRAME, OPEN_PIXELS, LIGHT, CLOUD_SPLAT],
            &own[..],
            &[MARCH],
            target,
        ]
        .concat()
        .join("\n")
    }

    /// Constants of its entry points.
    pub(crate) fn constants(self) -> Vec<(&'static str, f64)> {
        match self {
            Self::Values(kept) => vec![kept.constant()],
            _ => Vec::new(),
        }
    }
}

/// The texts of the passes that make a cloud's planes: open, pairs, and planes of colours and of values.
pub(crate) fn cloud_shaders() -> [String; 4] {
    let planes = |sums| [FRAME, CLOUD_SPLAT, RING, sums, CLOUD_PLANES].join("\n");
    [
        [FRAME, LIGHT, CLIPS, CLOUD_SPLAT, KERNEL, OPEN].join("\n"),
        [FRAME, CLOUD_SPLAT, LISTS, CLOUD_PAIRS].join("\n"),
        planes(CLOUD_COLORS),
        planes(CLOUD_VALUES),
    ]
}

/// The texts of the passes of a cloud's integrals: project, and integrate with settle.
pub(crate) fn integral_shaders() -> [String; 2] {
    [
        [SPLAT, VIEW, KERNEL, CLOUD_PROJECT].join("\n"),
        [FRAME, LIGHT, SLAB, SPLAT, BATCH, INTEGRATE, INTEGRALS, SETTLE].join("\n"),
    ]
}

/// The text of the pass that composites several layers.
pub(crate) fn mixture_shader() -> String {
    [FRAME, MIXTURE].join("\n")
}

/// Per node integrals, then extinction and linear colour.
pub(crate) fn nodes(classified: &ClassificationTable) -> Vec<[f32; 4]> {
    (0..=ClassificationTable::CELLS)
        .flat_map(|index| {
            let (integrals, [extinction, ..], [r, g, b]) = classified.node(index);
            [integrals.map(|k| k as f32), [extinction, r, g, b]]
        })
        .collect()
}
