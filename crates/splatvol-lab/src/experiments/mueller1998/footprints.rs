//! Section 4.2 in a whole picture: each alignment against exact footprints.

use splatvol::{Alignment, Camera, Filter, FlatSettings, Image, RenderSettings, Renderer, Scene};

use super::scenes::settings;
use crate::measure::psnr;
use crate::{Expectation, Finding, LabError, Outcome, Published, Table};

/// The footprints of section 4.2 in a whole picture, against exact ones.
pub(super) fn alignments(
    outcome: &mut Outcome,
    renderer: &mut Renderer,
    (scene, camera): (&Scene, &Camera),
    size: [u32; 2],
) -> Result<(), LabError> {
    let mut picture = |alignment: Alignment| -> Result<Image, LabError> {
        let settings = RenderSettings::try_from(FlatSettings {
            alignment,
            ..settings(size, Filter::Swan)?.into()
        })?;
        Ok(renderer.render(scene, camera, &settings)?.image)
    };
    let exact = picture(Alignment::Exact)?;
    let columns = ["alignment", "PSNR against exact (dB)"];
    let caption = "whole pictures of the tunnel, anti-aliased";
    let mut table = Table::new("alignments", "Section 4.2", caption, &columns);
    let mut decibels = |name: &str, alignment: Alignment| -> Result<f64, LabError> {
        let decibels = psnr(&picture(alignment)?, &exact);
        table.row([name.into(), decibels.into()]);
        Ok(decibels)
    };
    let grid = decibels("grid", Alignment::Grid)?;
    decibels("affine", Alignment::Affine)?;
    let ray = decibels("ray", Alignment::Ray)?;
    decibels("ray-ideal", Alignment::RayIdeal)?;
    let auto = decibels("auto", Alignment::AUTO)?;
    outcome.tables.push(table);
    outcome.find(
        Finding::new(
            "Section 4.2",
            "ray-against-grid",
            "how much nearer the exact picture the ray-perpendicular footprints come than the grid-aligned ones",
            ray - grid,
            Expectation::AtLeast(3.0),
        )
        .unit("dB")
        .published(Published::Claim("significantly smaller errors close to z_k and far off axis".to_owned()))
        .detail(format!("{ray:.1} against {grid:.1} dB")),
    );
    outcome.find(
        Finding::new(
            "Section 4.2",
            "auto",
            "picture with footprints switched by an error budget of a level, against the exact one",
            auto,
            Expectation::AtLeast(48.0),
        )
        .unit("dB"),
    );
    Ok(())
}
