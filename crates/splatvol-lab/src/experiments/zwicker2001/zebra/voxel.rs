//! The picture of one voxel, whose width is compared with that of the ideal filter.

use glam::{DMat2, DVec2};
use splatvol::{Absorption, Compositing, Filter, FlatSettings, RenderSettings, Renderer};

use super::case::{Case, settings};
use super::{Plane, widths};
use crate::{Cell, LabError, Table};

/// The paper's low-pass, the engine's default, and the width of a square pixel.
const LOW_PASSES: [f64; 3] = [1.0, 0.55, 0.3];

/// Widths of one voxel's picture, minor and major, pixels: the mean of 3 x 3 places within a pixel.
fn voxel_widths(
    case: &Case,
    renderer: &mut Renderer,
    (filter, cut): (Filter, f64),
    samples: u32,
) -> Result<[f64; 2], LabError> {
    let mut sum = DMat2::ZERO;
    let settings = RenderSettings::try_from(FlatSettings {
        compositing: Compositing::Xray,
        absorption: Absorption::Exp,
        ..settings(case.size.map(|side| side * samples), filter, cut)?.into()
    })?;
    for shift in 0..9 {
        let shift = DVec2::new(f64::from(shift % 3), f64::from(shift / 3)) / 3.0;
        let frame = renderer.render(&case.voxel(shift)?, &case.camera()?, &settings)?;
        let plane = Plane {
            width: settings.size.width() as usize,
            values: frame.optical_depth.iter().map(|&tau| f64::from(tau)).collect(),
        };
        sum += plane.moments();
    }
    Ok(widths(sum * (1.0 / 9.0)).map(|width| width / f64::from(samples)))
}

/// Over-blur of EWA and Swan, the ratio of the axes on the screen, and Swan's width over the equation's.
pub(super) fn one_voxel(
    case: &Case,
    renderer: &mut Renderer,
    table: &mut Table,
) -> Result<([f64; 2], f64, f64), LabError> {
    let [minor, major] = voxel_widths(case, renderer, (Filter::None, 4.0), 8)?;
    let ideal = |low_pass: f64| major.hypot(low_pass);
    let ewa = |pixel_sigma| Filter::Ewa { pixel_sigma };
    let mut blur = Vec::new();
    for (label, filter, cut) in [
        ("EWA, low-pass 1", ewa(1.0), 4.0),
        ("Swan", Filter::Swan, 4.0),
        ("EWA, low-pass .55 (default)", ewa(0.55), 4.0),
        ("EWA, low-pass .3 (square pixel)", ewa(0.3), 4.0),
        ("EWA, low-pass 1, cut at 2", ewa(1.0), 2.0),
        ("Swan, cut at 2", Filter::Swan, 2.0),
    ] {
        let [_, found] = voxel_widths(case, renderer, (filter, cut), 1)?;
        let row: [Cell; 3] = [case.name().into(), label.into(), found.into()];
        table.row(
            row.into_iter()
                .chain(LOW_PASSES.map(|low_pass| (found / ideal(low_pass)).into())),
        );
        blur.push((found, found / ideal(1.0)));
    }
    let [ewa, swan] = [blur[0], blur[1]];
    Ok((
        [ewa.1, swan.1],
        major / minor,
        swan.0 / (major / minor).max(major),
    ))
}
