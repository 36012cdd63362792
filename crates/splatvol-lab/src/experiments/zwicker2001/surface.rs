//! Fig. 9: volume kernels beside surface kernels on a texture.
//!
//! What is compared with is the texture itself: sums of circular Gaussians in the plane, `sum c g / sum g`, evaluated in 64 bits
//! where the rays of 16 samples per pixel meet the plane, and weighted by the low-pass.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3};
use rayon::prelude::*;
use splatvol::transfer_function::linear_from_srgb;
use splatvol::{
    Alignment, Camera, Classification, Compositing, Composition, Content, Filter, Grid, Image, ImageSize,
    Item, Kernel, PointAttributes, PointLook, Points, Projection, RenderSettings, Scene, Volume,
};
use splatvol_core::splats::GaussianProfile;
use splatvol_samples::{Sample, SampleSize};

use super::pictures::{Inside, Plane};
use super::splat::{FOCAL, Splat, covariance_of, widths};
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
            the plane under 25 degrees. Volume kernels are added up on slices of the grid. Surface kernels are \
            oriented discs, one per texel of the middle slice, added up in one sheet. Both have a standard deviation of \
            one voxel, cut at 4, and the paper's low-pass of one pixel.\n\n\
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

/// The texture and the picture of it.
struct Case {
    side: usize,
    size: [u32; 2],
    volume: Arc<Volume>,
    look: splatvol::TransferFunction,
}

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let mut outcome = Outcome::default();
    footprints(&mut outcome)?;
    let (side, size) = bench.choose((512, [500, 342]), (128, [126, 86]));
    let case = Case::new(side, size)?;
    bench.step(0, 3, "volume kernels");
    let mut renderer = bench.renderer()?;
    let volume = renderer
        .render(
            &Scene::new(case.volume.clone(), case.look.clone()),
            &case.camera()?,
            &settings(size, Compositing::AxisSheets)?,
        )?
        .image;
    bench.step(1, 3, "surface kernels");
    let surface = renderer
        .render_composition(
            &case.surface()?,
            &case.camera()?,
            &settings(size, Compositing::Xray)?,
            &|_| {},
        )?
        .image;
    bench.step(2, 3, "texture in 64 bits");
    let samples = case.truth()?;
    compare(&case, [&volume, &surface], &samples, &mut outcome);
    outcome.plates.push(
        Plate::new("texture", "Fig. 9", "Volume kernels and surface kernels")
            .panel("EWA volume splatting", volume)
            .panel("EWA surface splatting", surface),
    );
    Ok(outcome)
}

fn settings([width, height]: [u32; 2], compositing: Compositing) -> Result<RenderSettings, LabError> {
    Ok(RenderSettings {
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
        ..RenderSettings::best()
    })
}

impl Case {
    fn new(side: usize, size: [u32; 2]) -> Result<Self, LabError> {
        let dims = [side, side, 3];
        let stripes = Sample::Zebra.generate(Some(SampleSize::Dims(dims)))?;
        let grid = Grid::centred(dims, DVec3::ONE)?;
        let volume = Volume::new(grid, stripes.samples().clone(), stripes.rescale(), stripes.unit())?;
        Ok(Self {
            side,
            size,
            volume: Arc::new(volume),
            look: Sample::Zebra.default_transfer_function()?,
        })
    }

    fn camera(&self) -> Result<Camera, LabError> {
        let side = self.side as f64;
        let height = 0.35 * side;
        let eye = DVec3::new(0.0, -0.7 * side, height);
        let target = DVec3::new(0.0, eye.y + height / ELEVATION.to_radians().tan(), 0.0);
        let projection = Projection::Perspective { fov_degrees: FOV };
        Ok(Camera::new(eye, target, DVec3::Z, projection)?)
    }

    /// sRGB of the texels of the middle slice, in eight bits.
    fn texels(&self) -> Vec<[u8; 3]> {
        let slice = self.side * self.side;
        (slice..2 * slice)
            .map(|index| self.look.color(self.volume.value(index)))
            .map(|rgb| rgb.map(|level| (255.0 * level).round() as u8))
            .collect()
    }

    /// Discs in the plane, whose standard deviation, .6 of the radius, is one voxel.
    fn surface(&self) -> Result<Composition, LabError> {
        let grid = self.volume.grid();
        let slice = self.side * self.side;
        let place = |i: usize| {
            let voxel = DVec3::new((i % self.side) as f64, (i / self.side) as f64, 1.0);
            grid.world_from_voxel()
                .transform_point3(voxel)
                .as_vec3()
                .to_array()
        };
        let attributes = PointAttributes {
            colors: self
                .texels()
                .into_iter()
                .map(|[r, g, b]| [r, g, b, 255])
                .collect(),
            normals: vec![[0.0, 0.0, 1.0]; slice],
            radii: vec![1.0 / 0.6; slice],
        };
        let points = Points::new((0..slice).map(place).collect(), attributes, DAffine3::IDENTITY)?;
        let content = Content::Points {
            points: Arc::new(points),
            look: PointLook::default(),
        };
        Ok(Composition::new(vec![Item::new(content)])?)
    }

    /// The texture's green in linear light and its coverage, 16 samples per pixel.
    fn truth(&self) -> Result<[Plane; 2], LabError> {
        let [width, height] = self.size.map(|side| side as usize * SAMPLES);
        let camera = self.camera()?;
        let screen = camera.screen_from_camera(ImageSize::new(width as u32, height as u32)?);
        let world_from_camera = camera.camera_from_world().inverse();
        let voxel_from_world = self.volume.grid().world_from_voxel().inverse();
        let green: Vec<f64> = self
            .texels()
            .iter()
            .map(|[_, g, _]| linear_from_srgb(f64::from(*g) / 255.0))
            .collect();
        let value = |index: usize| {
            let pixel = DVec2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
            let (origin, direction) = screen.ray(pixel);
            let origin = voxel_from_world.transform_point3(world_from_camera.transform_point3(origin));
            let direction =
                voxel_from_world.transform_vector3(world_from_camera.transform_vector3(direction));
            // The middle slice.
            let along = (1.0 - origin.z) / direction.z;
            match along > 0.0 {
                true => self.reconstructed(&green, (origin + direction * along).truncate()),
                false => [0.0; 2],
            }
        };
        let values: Vec<[f64; 2]> = (0..width * height).into_par_iter().map(value).collect();
        Ok([0, 1].map(|channel| Plane {
            width,
            values: values.iter().map(|value| value[channel]).collect(),
        }))
    }

    /// `sum c g / sum g` at a place of the plane, voxels, and 1; nothing outside the texture.
    fn reconstructed(&self, colors: &[f64], at: DVec2) -> [f64; 2] {
        let last = self.side as f64 - 0.5;
        if !(at.min_element() >= -0.5 && at.max_element() <= last) {
            return [0.0; 2];
        }
        let first = |at: f64| (at - CUT).ceil().max(0.0) as usize;
        let end = |at: f64| ((at + CUT).floor() as usize + 1).min(self.side);
        let (mut sum, mut total) = (0.0, 0.0);
        for y in first(at.y)..end(at.y) {
            for x in first(at.x)..end(at.x) {
                let weight = (-0.5 * at.distance_squared(DVec2::new(x as f64, y as f64))).exp();
                sum += weight * colors[y * self.side + x];
                total += weight;
            }
        }
        [sum / total, 1.0]
    }
}

/// What footprints look like in this view.
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
        .published(Published::Claim("circular surface kernels are mapped to ellipses".to_owned()))
        .detail(format!("scale {FOCAL} pixels")),
    );
    Ok(())
}

fn compare(
    case: &Case,
    [volume, surface]: [&Image; 2],
    [green, covered]: &[Plane; 2],
    outcome: &mut Outcome,
) {
    let truth = green.low_passed(SAMPLES, 1.0);
    // Kernels reach beyond the texture's border, which the truth does not.
    let inside = Inside::of(&covered.low_passed(SAMPLES, 1.0), 8);
    let planes = [Plane::green(volume), Plane::green(surface)];
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
    for (label, figures) in ["volume", "surface"].into_iter().zip(figures) {
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

fn findings(outcome: &mut Outcome, [volume, surface]: [[f64; 3]; 2]) {
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
}
