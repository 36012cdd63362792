//! Fig. 9: volume kernels beside surface kernels on a texture.
//!
//! The reference is the texture itself: sums of circular Gaussians in the plane, `sum c g / sum g`. They are evaluated
//! in 64 bits where the rays of 16 samples per pixel meet the plane, and weighted by the low-pass.

mod texture;

use glam::{DMat3, DVec2, DVec3};
use splatvol::{
    Alignment, Classification, Compositing, Filter, FlatSettings, Image, ImageSize, Kernel, RenderSettings,
    Scene,
};
use splatvol_core::splats::GaussianProfile;

use self::texture::Case;
use super::pictures::{Inside, Plane};
use super::splat::{Splat, covariance_of, widths};
use crate::{
    Axis, Cell, Curve, Expectation, Experiment, Finding, LabError, Outcome, Plate, Plot, Published, Table,
    Workbench,
};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "zwicker2001-surface",
    paper: "zwicker2001",
    title: "Volume kernels against surface kernels",
    figures: &["Fig. 9"],
    about: "The paper shows a texture of 512 x 512 x 3 voxels at 500 x 342 pixels, once with volume kernels and once \
            with surface kernels. The volume's are projected to near circles and blur a little too much; the \
            surface's are projected to ellipses, which is EWA texture filtering.\n\n\
            The texture is generated (wavy stripes); the camera is ours, since the paper's is not known: it looks at \
            the plane under 25 degrees. The volume has three slices; surface kernels are oriented discs, one per texel of \
            the middle slice. Both are added up in one sheet, so that nothing but the kernels differs, have a standard \
            deviation of one voxel, cut at 4, and the paper's low-pass of one pixel. (The paper's own sheets are the slices \
            of the grid that face the viewer. Under 25 degrees these stand upright on the texture, and the opaque tails of \
            each slice's kernels hide the slices behind: the table has that picture, too.)\n\n\
            The truth is the plane's texture itself, reconstructed by the same Gaussian and low-passed from 16 samples \
            per pixel in 64 bits, without any splats. Crispness is the root mean square gradient of the picture over \
            the truth's.",
    run,
};

/// Samples per pixel and axis of the truth.
const SAMPLES: usize = 4;
/// Reach of kernels, standard deviations.
const CUT: f64 = 4.0;
/// Elevation of the view, and its vertical angle, degrees.
const ELEVATION: f64 = 25.0;
const FOV: f64 = 40.0;

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let mut outcome = Outcome::default();
    footprints(&mut outcome)?;
    let (side, size) = bench.choose((512, [500, 342]), (128, [126, 86]));
    let case = Case::new(side, size)?;
    bench.step(0, 3, "volume kernels");
    let mut renderer = bench.renderer()?;
    let (scene, camera) = (Scene::new(case.volume.clone(), case.look.clone()), case.camera()?);
    let mut volume = |compositing| -> Result<Image, LabError> {
        Ok(renderer
            .render(&scene, &camera, &settings(size, compositing)?)?
            .image)
    };
    let [volume, slices] = [volume(Compositing::Xray)?, volume(Compositing::AxisSheets)?];
    bench.step(1, 3, "surface kernels");
    let settings = settings(size, Compositing::Xray)?;
    let surface = renderer.render(&case.surface()?, &camera, &settings)?.image;
    bench.step(2, 3, "texture in 64 bits");
    let samples = case.truth()?;
    compare(&case, [&volume, &surface, &slices], &samples, &mut outcome);
    outcome.plates.push(
        Plate::new("texture", "Fig. 9", "Volume kernels and surface kernels")
            .panel("EWA volume splatting", volume)
            .panel("EWA surface splatting", surface),
    );
    Ok(outcome)
}

fn settings([width, height]: [u32; 2], compositing: Compositing) -> Result<RenderSettings, LabError> {
    Ok(RenderSettings::try_from(FlatSettings {
        size: ImageSize::new(width, height)?,
        compositing,
        classification: Classification::Pre,
        alignment: Alignment::Affine,
        filter: Filter::Ewa { pixel_sigma: 1.0 },
        kernel: Kernel::Gaussian {
            sigma: 1.0,
            radius: CUT,
        },
        prefilter: false,
        lighting: None,
        termination: 0.0,
        ..RenderSettings::best().into()
    })?)
}

/// Shape of the footprints in this view.
fn footprints(outcome: &mut Outcome) -> Result<(), LabError> {
    let profile = GaussianProfile::new(CUT);
    let tilt = DMat3::from_rotation_x((90.0 - ELEVATION).to_radians()) * 0.02;
    let elongation = |centre: DVec3, flatness: f64| -> Result<f64, LabError> {
        let splat = Splat::sphere(centre, tilt).flattened(flatness);
        let [minor, major] = widths(covariance_of(&splat.footprint(
            Filter::None,
            Alignment::Affine,
            &profile,
        )?)?);
        Ok(major / minor)
    };
    let mut sum = 0.0;
    let up = (0.5 * FOV).to_radians().tan();
    for i in 0..100 {
        let at = DVec2::new(f64::from(i % 10) - 4.5, f64::from(i / 10) - 4.5) / 5.0;
        sum += elongation(DVec3::new(at.x * up * 500.0 / 342.0, at.y * up, 1.0), 1.0)? / 100.0;
    }
    outcome.find(
        Finding::new(
            "Fig. 9",
            "volume-elongation",
            "major over minor width of volume kernels on the screen, mean over the picture",
            sum,
            Expectation::Between(1.0, 1.1),
        )
        .published(Published::Claim(
            "the projection of a spherical kernel is almost a circle".to_owned(),
        )),
    );
    outcome.find(
        Finding::new(
            "Fig. 9",
            "surface-elongation",
            "major over minor width of surface kernels in the middle of the picture, times the sine of the elevation",
            elongation(DVec3::Z, f64::INFINITY)? * ELEVATION.to_radians().sin(),
            Expectation::relative(1.0, 0.01),
        )
        .published(Published::Claim("circular surface kernels are mapped to ellipses".to_owned())),
    );
    Ok(())
}

fn compare(case: &Case, images: [&Image; 3], [green, covered]: &[Plane; 2], outcome: &mut Outcome) {
    let truth = green.low_passed(SAMPLES, 1.0);
    // Kernels reach beyond the texture's border, which the truth does not.
    let inside = Inside::of(&covered.low_passed(SAMPLES, 1.0), 8);
    let planes = images.map(Plane::green);
    let mut table = Table::new(
        "pictures",
        "Fig. 9",
        "Pictures against the texture in 64 bits",
        &[
            "kernels",
            "PSNR (dB)",
            "crispness (share)",
            "difference (share of the contrast)",
        ],
    );
    let contrast = inside.contrast(&truth);
    let figures = planes.each_ref().map(|plane| {
        let psnr = inside.psnr(plane, &truth);
        let crisp = inside.crispness(plane) / inside.crispness(&truth);
        [psnr, crisp, inside.difference(plane, &truth) / contrast]
    });
    let labels = ["volume", "surface", "volume, on slices of the grid"];
    for (label, figures) in labels.into_iter().zip(figures) {
        table.row(std::iter::once(Cell::from(label)).chain(figures.map(Cell::from)));
    }
    outcome.tables.push(table);
    outcome
        .plots
        .push(by_row(case, [&planes[0], &planes[1], &truth], &inside));
    findings(outcome, figures);
}

/// Crispness from the near to the far side.
fn by_row(case: &Case, [volume, surface, truth]: [&Plane; 3], inside: &Inside) -> Plot {
    let height = case.size[1] as usize;
    let bands: Vec<(f64, Inside)> = (0..12)
        .map(|band| band * height / 12..(band + 1) * height / 12)
        .map(|rows| {
            (
                (rows.start + rows.end) as f64 * 0.5,
                inside.rows(truth.width, rows),
            )
        })
        .filter(|(_, rows)| rows.share() > 0.01)
        .collect();
    let curve = |plane: &Plane| {
        bands
            .iter()
            .map(|(row, rows)| [*row, rows.crispness(plane) / rows.crispness(truth)])
            .collect::<Vec<_>>()
    };
    Plot::curves(
        "crispness",
        "Fig. 9",
        "Crispness of the pictures over that of the texture, from the far to the near side",
        Axis::new("row of the picture (pixels from the top)"),
        Axis::new("root mean square gradient over the truth's").range(0.0, 1.2),
    )
    .curve(Curve::new("volume kernels", curve(volume)).dots())
    .curve(Curve::new("surface kernels", curve(surface)).dots())
}

fn findings(outcome: &mut Outcome, [volume, surface, slices]: [[f64; 3]; 3]) {
    let mut find = |key: &str, quantity: &str, measured, expected, claim: &str| {
        outcome.find(
            Finding::new("Fig. 9", key, quantity, measured, expected)
                .published(Published::Claim(claim.to_owned())),
        );
    };
    find(
        "volume-crispness",
        "crispness with volume kernels over the texture's",
        volume[1],
        Expectation::AtMost(0.9),
        "rendering with volume kernels produces textures that are slightly too blurry",
    );
    find(
        "surface-crispness",
        "crispness with surface kernels over the texture's",
        surface[1],
        Expectation::Near {
            value: 1.0,
            within: 0.05,
        },
        "high image quality because of anisotropic filtering",
    );
    find(
        "surface-difference",
        "difference of the picture with surface kernels from the texture, share of its contrast",
        surface[2],
        Expectation::AtMost(0.03),
        "splatting surface kernels is equivalent to EWA texture filtering",
    );
    find(
        "surface-gain",
        "PSNR with surface kernels less that with volume kernels, dB",
        surface[0] - volume[0],
        Expectation::AtLeast(3.0),
        "high image quality because of anisotropic filtering",
    );
    outcome.find(
        Finding::new(
            "Fig. 9",
            "volume-slices-crispness",
            "crispness with volume kernels that are composited on slices of the grid, as in section 6, over the texture's",
            slices[1],
            Expectation::AtMost(0.9),
        )
        .published(Published::Claim("slightly too blurry".to_owned()))
        .explained_by(
            "the slices that face a viewer this low stand upright on the texture and hide each other; cotangent of the \
             elevation",
            ELEVATION.to_radians().tan().recip(),
            Expectation::AtLeast(1.0),
        )
        .explained_by(
            "added up in one sheet, where nothing is hidden, the same kernels reach",
            volume[1],
            Expectation::AtMost(0.9),
        ),
    );
}
