//! The settings of footprints.

use splatvol::{
    Absorption, Alignment, Classification, FlatSettings, Occlusion, Reconstruction, SheetContent, Stretch,
};

use crate::args::{
    AbsorptionName, AlignmentName, FootprintArgs, OcclusionName, ReconstructionName, SheetName, StretchName,
};
use crate::failure::Failure;

/// Default flatness.
const FLATNESS: f64 = 10.0;
/// Default gradient of a surface, value ranges per voxel.
const SURFACE_GRADIENT: f64 = 0.05;

/// Sets what is asked for.
pub(crate) fn set(args: &FootprintArgs, settings: &mut FlatSettings) -> Result<(), Failure> {
    if let Some(name) = args.absorption {
        settings.absorption = match name {
            AbsorptionName::Exp => Absorption::Exp,
            AbsorptionName::Linear => Absorption::Linear,
        };
    }
    if let Some(name) = args.occlusion {
        settings.occlusion = match name {
            OcclusionName::Auto => Occlusion::Auto,
            OcclusionName::None => Occlusion::None,
            OcclusionName::Sat => Occlusion::Sat,
        };
    }
    match args.stretch {
        Some(StretchName::Box) => settings.stretch = Stretch::Box,
        Some(StretchName::Trapezoid) => settings.stretch = Stretch::Trapezoid,
        None => {}
    }
    settings.alignment = alignment(args, settings.alignment)?;
    settings.reconstruction = reconstruction(args, settings.reconstruction)?;
    Ok(())
}

fn alignment(args: &FootprintArgs, old: Alignment) -> Result<Alignment, Failure> {
    let named = match args.alignment {
        Some(AlignmentName::Sheet) => Alignment::Sheet,
        Some(AlignmentName::Affine) => Alignment::Affine,
        Some(AlignmentName::Exact) => Alignment::Exact,
        Some(AlignmentName::Grid) => Alignment::Grid,
        Some(AlignmentName::Ray) => Alignment::Ray,
        Some(AlignmentName::RayIdeal) => Alignment::RayIdeal,
        Some(AlignmentName::Auto) if matches!(old, Alignment::Auto { .. }) => old,
        Some(AlignmentName::Auto) => Alignment::AUTO,
        None => old,
    };
    match (named, args.alignment_budget) {
        (Alignment::Auto { .. }, Some(budget)) => Ok(Alignment::Auto { budget }),
        (_, Some(_)) => Err(Failure::usage("--alignment-budget needs --alignment auto")),
        (_, None) => Ok(named),
    }
}

fn reconstruction(args: &FootprintArgs, old: Reconstruction) -> Result<Reconstruction, Failure> {
    let (old_flatness, old_gradient) = match old {
        Reconstruction::Volume => (FLATNESS, SURFACE_GRADIENT),
        Reconstruction::Surface { flatness } => (flatness, SURFACE_GRADIENT),
        Reconstruction::Mixed { flatness, gradient } => (flatness, gradient),
    };
    let flatness = args.flatness.unwrap_or(old_flatness);
    let gradient = args.surface_gradient.unwrap_or(old_gradient);
    let name = args.reconstruction.unwrap_or(match old {
        Reconstruction::Volume => ReconstructionName::Volume,
        Reconstruction::Surface { .. } => ReconstructionName::Surface,
        Reconstruction::Mixed { .. } => ReconstructionName::Mixed,
    });
    match name {
        ReconstructionName::Volume if args.flatness.is_some() || args.surface_gradient.is_some() => Err(
            Failure::usage("--flatness and --surface-gradient need --reconstruction surface or mixed"),
        ),
        ReconstructionName::Surface if args.surface_gradient.is_some() => {
            Err(Failure::usage("--surface-gradient needs --reconstruction mixed"))
        }
        ReconstructionName::Volume => Ok(Reconstruction::Volume),
        ReconstructionName::Surface => Ok(Reconstruction::Surface { flatness }),
        ReconstructionName::Mixed => Ok(Reconstruction::Mixed { flatness, gradient }),
    }
}

/// Completes the settings that no flag gives: colours where whole footprints are composited or flattened, sections where
/// data are splatted as footprints. `is_free`: whether the classification may be chosen.
pub(crate) fn complete(args: &FootprintArgs, settings: &mut FlatSettings, is_free: bool) {
    let colors = settings.compositing.needs_colors() || settings.reconstruction != Reconstruction::Volume;
    if is_free && colors {
        settings.classification = Classification::Pre;
    }
    if let Some(name) = args.sheet {
        settings.sheet = Some(match name {
            SheetName::Section => SheetContent::Section,
            SheetName::Sample => SheetContent::Sample,
        });
    } else if settings.sheet.is_none()
        && settings.classification == Classification::Post
        && settings.uses_footprints()
    {
        settings.sheet = Some(SheetContent::Section);
    }
}
