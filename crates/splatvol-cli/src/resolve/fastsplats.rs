//! The settings of footprint tables and of the range of interest.

use splatvol::{Extraction, FlatSettings, Rasterizer, TablePrecision};

use crate::args::{FastSplatsArgs, PrecisionName, RasterizerName};
use crate::failure::Failure;

/// Cells per pixel unless asked otherwise: the paper's.
const RLUT_CELLS: u32 = 10;
const BLIT_CELLS: u32 = 2;

/// Sets what is asked for.
pub(crate) fn set(args: &FastSplatsArgs, settings: &mut FlatSettings) -> Result<(), Failure> {
    settings.rasterizer = rasterizer(args, settings.rasterizer)?;
    let table = &mut settings.table;
    let asked =
        args.table_entries.is_some() || args.table_precision.is_some() || args.table_sections.is_some();
    if asked && !settings.rasterizer.has_table() {
        return Err(Failure::usage(
            "--table-entries, --table-precision and --table-sections need a --rasterizer with a table",
        ));
    }
    table.entries = args.table_entries.unwrap_or(table.entries);
    table.sections = args.table_sections.unwrap_or(table.sections);
    if let Some(name) = args.table_precision {
        table.precision = match name {
            PrecisionName::U8 => TablePrecision::U8,
            PrecisionName::U16 => TablePrecision::U16,
            PrecisionName::F32 => TablePrecision::F32,
        };
    }
    if args.extract_density.is_some() || args.extract_gradient.is_some() {
        let old = settings.extraction.unwrap_or_default();
        settings.extraction = Some(Extraction {
            density: args.extract_density.or(old.density),
            gradient: args.extract_gradient.unwrap_or(old.gradient),
        });
    }
    Ok(())
}

fn rasterizer(args: &FastSplatsArgs, old: Rasterizer) -> Result<Rasterizer, Failure> {
    let named = match args.rasterizer {
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
    };
    let Some(subpixels) = args.subpixels else {
        return Ok(named);
    };
    match named {
        Rasterizer::Rlut { .. } => Ok(Rasterizer::Rlut { subpixels }),
        Rasterizer::Blit2d { .. } => Ok(Rasterizer::Blit2d { subpixels }),
        _ => Err(Failure::usage("--subpixels needs --rasterizer rlut or blit-2d")),
    }
}

#[cfg(test)]
mod tests {
    use splatvol::RenderSettings;

    use super::*;

    #[test]
    fn flags_set_tables_and_ranges_over_those_of_before() {
        let mut settings = FlatSettings::from(RenderSettings::fastsplats2000());
        let args = FastSplatsArgs {
            rasterizer: Some(RasterizerName::Rlut),
            subpixels: Some(100),
            table_entries: Some(256),
            table_precision: Some(PrecisionName::U16),
            extract_gradient: Some(0.1),
            ..FastSplatsArgs::default()
        };
        set(&args, &mut settings).unwrap();
        assert_eq!(settings.rasterizer, Rasterizer::Rlut { subpixels: 100 });
        assert_eq!((settings.table.entries, settings.table.sections), (256, 128));
        let density = FastSplatsArgs {
            extract_density: Some([1.0, 2.0]),
            ..FastSplatsArgs::default()
        };
        set(&density, &mut settings).unwrap();
        let kept = settings.extraction.unwrap();
        assert_eq!((kept.density, kept.gradient), (Some([1.0, 2.0]), 0.1));
    }

    #[test]
    fn flags_without_meaning_are_refused() {
        let mut settings = FlatSettings::default();
        let entries = FastSplatsArgs {
            table_entries: Some(64),
            ..FastSplatsArgs::default()
        };
        assert!(set(&entries, &mut settings).is_err());
        let cells = FastSplatsArgs {
            rasterizer: Some(RasterizerName::Square1d),
            subpixels: Some(4),
            ..FastSplatsArgs::default()
        };
        assert!(set(&cells, &mut settings).is_err());
    }
}
