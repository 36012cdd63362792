//! The settings of footprint tables and of the range of interest.

use splatvol_scene::{Extraction, FlatSettings, Rasterizer};

use crate::DocumentError;
use crate::keys::SettingKeys;
use crate::keys::names::RasterizerName;
use crate::settings::set_named;

/// Cells per pixel unless asked otherwise: the paper's.
const RLUT_CELLS: u32 = 10;
const BLIT_CELLS: u32 = 2;
/// The finest grid: small footprints take little memory.
const HYBRID_CELLS: u32 = 8;
/// Radius up to which `hybrid` copies footprints, pixels.
const BLIT_RADIUS: u32 = 4;

/// Sets what the keys ask for.
pub(super) fn set(keys: &SettingKeys, settings: &mut FlatSettings) -> Result<(), DocumentError> {
    settings.rasterizer = rasterizer(keys, settings.rasterizer)?;
    let table = &mut settings.table;
    let asked =
        keys.table_entries.is_some() || keys.table_precision.is_some() || keys.table_sections.is_some();
    if asked && !settings.rasterizer.has_table() {
        return Err(DocumentError::usage(
            "`settings.table-entries`, `settings.table-precision` and `settings.table-sections` need a `settings.rasterizer` with a table",
        ));
    }
    table.entries = keys.table_entries.unwrap_or(table.entries);
    table.sections = keys.table_sections.unwrap_or(table.sections);
    set_named(&mut table.precision, keys.table_precision);
    if keys.extract_density.is_some() || keys.extract_gradient.is_some() {
        let old = settings.extraction.unwrap_or_default();
        settings.extraction = Some(Extraction {
            density: keys.extract_density.or(old.density),
            gradient: keys.extract_gradient.unwrap_or(old.gradient),
        });
    }
    Ok(())
}

fn rasterizer(keys: &SettingKeys, old: Rasterizer) -> Result<Rasterizer, DocumentError> {
    let named = match keys.rasterizer {
        None => old,
        Some(RasterizerName::Auto) => Rasterizer::Auto,
        Some(RasterizerName::Linear1d) => Rasterizer::Linear1d,
        Some(RasterizerName::Square1d) => Rasterizer::Square1d,
        Some(RasterizerName::Ellipse1d) => Rasterizer::Ellipse1d,
        Some(RasterizerName::Rlut) => Rasterizer::Rlut {
            subpixels: RLUT_CELLS,
        },
        Some(RasterizerName::Blit2d) => Rasterizer::Blit2d {
            subpixels: BLIT_CELLS,
        },
        Some(RasterizerName::Hybrid) => Rasterizer::Hybrid {
            subpixels: HYBRID_CELLS,
            radius: BLIT_RADIUS,
        },
    };
    if keys.blit_radius.is_some() && !matches!(named, Rasterizer::Hybrid { .. }) {
        return Err(DocumentError::usage(
            "`settings.blit-radius` needs `settings.rasterizer` hybrid",
        ));
    }
    let cells = |old: u32| keys.subpixels.unwrap_or(old);
    match named {
        Rasterizer::Rlut { subpixels } => Ok(Rasterizer::Rlut {
            subpixels: cells(subpixels),
        }),
        Rasterizer::Blit2d { subpixels } => Ok(Rasterizer::Blit2d {
            subpixels: cells(subpixels),
        }),
        Rasterizer::Hybrid { subpixels, radius } => Ok(Rasterizer::Hybrid {
            subpixels: cells(subpixels),
            radius: keys.blit_radius.unwrap_or(radius),
        }),
        named if keys.subpixels.is_none() => Ok(named),
        _ => Err(DocumentError::usage(
            "`settings.subpixels` needs `settings.rasterizer` rlut, blit-2d or hybrid",
        )),
    }
}

#[cfg(test)]
mod tests {
    use splatvol_scene::RenderSettings;

    use crate::keys::names::PrecisionName;

    use super::*;

    #[test]
    fn flags_set_tables_and_ranges_over_those_of_before() {
        let mut settings = FlatSettings::from(RenderSettings::fastsplats2000());
        let args = SettingKeys {
            rasterizer: Some(RasterizerName::Rlut),
            subpixels: Some(100),
            table_entries: Some(256),
            table_precision: Some(PrecisionName::U16),
            extract_gradient: Some(0.1),
            ..SettingKeys::default()
        };
        set(&args, &mut settings).unwrap();
        assert_eq!(settings.rasterizer, Rasterizer::Rlut { subpixels: 100 });
        assert_eq!((settings.table.entries, settings.table.sections), (256, 128));
        let density = SettingKeys {
            extract_density: Some([1.0, 2.0]),
            ..SettingKeys::default()
        };
        set(&density, &mut settings).unwrap();
        let kept = settings.extraction.unwrap();
        assert_eq!((kept.density, kept.gradient), (Some([1.0, 2.0]), 0.1));
    }

    #[test]
    fn flags_without_meaning_are_refused() {
        let mut settings = FlatSettings::default();
        let entries = SettingKeys {
            table_entries: Some(64),
            ..SettingKeys::default()
        };
        assert!(set(&entries, &mut settings).is_err());
        let cells = SettingKeys {
            rasterizer: Some(RasterizerName::Square1d),
            subpixels: Some(4),
            ..SettingKeys::default()
        };
        assert!(set(&cells, &mut settings).is_err());
    }
}
