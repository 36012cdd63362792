//! The settings of footprints.

use splatvol_scene::{
    Alignment, Classification, FlatSettings, KernelEdge, Rasterizer, Reconstruction, SheetContent,
    SheetValues,
};

use crate::DocumentError;
use crate::keys::SettingKeys;
use crate::keys::names::{AlignmentName, ReconstructionName};
use crate::settings::set_named;

/// Default flatness.
const FLATNESS: f64 = 10.0;
/// Default gradient of a surface, value ranges per voxel.
const SURFACE_GRADIENT: f64 = 0.05;

/// Sets what the keys ask for.
pub(super) fn set(keys: &SettingKeys, settings: &mut FlatSettings) -> Result<(), DocumentError> {
    set_named(&mut settings.absorption, keys.absorption);
    set_named(&mut settings.occlusion, keys.occlusion);
    set_named(&mut settings.stretch, keys.stretch);
    set_named(&mut settings.sheet_values, keys.sheet_values);
    set_named(&mut settings.sheet_precision, keys.sheet_precision);
    set_named(&mut settings.kernel_edge, keys.kernel_edge);
    if keys.kernel_edge.is_none() && !has_edge(settings) {
        settings.kernel_edge = KernelEdge::Smooth;
    }
    settings.alignment = alignment(keys, settings.alignment)?;
    settings.reconstruction = reconstruction(keys, settings.reconstruction)?;
    Ok(())
}

/// Whether footprints have an edge of their own: those of other kernels, and those in tables, end as the kernel does.
fn has_edge(settings: &FlatSettings) -> bool {
    settings.kernel.gaussian().is_some() && settings.rasterizer == Rasterizer::Auto
}

fn alignment(keys: &SettingKeys, old: Alignment) -> Result<Alignment, DocumentError> {
    let named = match keys.alignment {
        Some(AlignmentName::Sheet) => Alignment::Sheet,
        Some(AlignmentName::Affine) => Alignment::Affine,
        Some(AlignmentName::Exact) => Alignment::Exact,
        Some(AlignmentName::Grid) => Alignment::Grid,
        Some(AlignmentName::Ray) => Alignment::Ray,
        Some(AlignmentName::RayIdeal) => Alignment::RayIdeal,
        Some(AlignmentName::Switch) if matches!(old, Alignment::Switch { .. }) => old,
        Some(AlignmentName::Switch) => Alignment::SWITCH,
        Some(AlignmentName::Auto) if matches!(old, Alignment::Auto { .. }) => old,
        Some(AlignmentName::Auto) => Alignment::AUTO,
        None => old,
    };
    match (named, keys.alignment_budget, keys.alignment_switch) {
        (Alignment::Auto { .. }, Some(budget), None) => Ok(Alignment::Auto { budget }),
        (Alignment::Switch { .. }, None, Some(behind)) => Ok(Alignment::Switch { behind }),
        (_, Some(_), _) => Err(DocumentError::usage(
            "`settings.alignment-budget` needs `settings.alignment` auto",
        )),
        (_, _, Some(_)) => Err(DocumentError::usage(
            "`settings.alignment-switch` needs `settings.alignment` switch",
        )),
        (_, None, None) => Ok(named),
    }
}

fn reconstruction(keys: &SettingKeys, old: Reconstruction) -> Result<Reconstruction, DocumentError> {
    let (old_flatness, old_gradient) = match old {
        Reconstruction::Volume => (FLATNESS, SURFACE_GRADIENT),
        Reconstruction::Surface { flatness } => (flatness, SURFACE_GRADIENT),
        Reconstruction::Mixed { flatness, gradient } => (flatness, gradient),
    };
    let flatness = keys.flatness.unwrap_or(old_flatness);
    let gradient = keys.surface_gradient.unwrap_or(old_gradient);
    let name = keys.reconstruction.unwrap_or(match old {
        Reconstruction::Volume => ReconstructionName::Volume,
        Reconstruction::Surface { .. } => ReconstructionName::Surface,
        Reconstruction::Mixed { .. } => ReconstructionName::Mixed,
    });
    match name {
        ReconstructionName::Volume if keys.flatness.is_some() || keys.surface_gradient.is_some() => {
            Err(DocumentError::usage(
                "`settings.flatness` and `settings.surface-gradient` need `settings.reconstruction` surface or mixed",
            ))
        }
        ReconstructionName::Surface if keys.surface_gradient.is_some() => Err(DocumentError::usage(
            "`settings.surface-gradient` needs `settings.reconstruction` mixed",
        )),
        ReconstructionName::Volume => Ok(Reconstruction::Volume),
        ReconstructionName::Surface => Ok(Reconstruction::Surface { flatness }),
        ReconstructionName::Mixed => Ok(Reconstruction::Mixed { flatness, gradient }),
    }
}

/// Completes the settings that no key gives: colours if whole footprints are composited or flattened, sections if data
/// are splatted as footprints. `is_free`: whether the classification may be chosen.
pub(super) fn complete(keys: &SettingKeys, settings: &mut FlatSettings, is_free: bool) {
    let colors = settings.compositing.needs_colors() || settings.reconstruction != Reconstruction::Volume;
    if is_free && colors {
        settings.classification = Classification::Pre;
    }
    if keys.sheet_values.is_none() && settings.extraction.is_some() {
        settings.sheet_values = SheetValues::Sum;
    }
    if let Some(name) = keys.sheet {
        settings.sheet = Some(name.into());
    } else if settings.sheet.is_none()
        && settings.classification == Classification::Post
        && settings.uses_footprints()
    {
        settings.sheet = Some(SheetContent::Section);
    }
}
