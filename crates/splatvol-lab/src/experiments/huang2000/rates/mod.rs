//! Scan-conversion rates: section 6.3, Fig. 5 and 6.

mod findings;
mod show;

use std::f64::consts::PI;

use glam::DVec3;
use splatvol::{
    Camera, Classification, ColorPoint, FlatSettings, Grid, ImageSize, OpacityPoint, Projection, Rasterizer,
    RenderSettings, Samples, Scene, TableLayout, TablePrecision, TransferFunction, Volume,
};

use super::method::{FASTSPLATS, RLUT, Subject, fastsplats};
use crate::measure::median;
use crate::{Expectation, Experiment, Finding, LabError, Outcome, Published, Workbench};
use findings::{channel_findings, rate_findings};
use show::{numbers, plots};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "huang2000-rates",
    paper: "huang2000",
    title: "Pixels per second of the four FastSplats, and of ours, by the splats' radius",
    figures: &["Fig. 5", "Fig. 6", "Section 6.3"],
    about: "The paper splats footprints of one radius at scattered places of a 512 x 512 picture, with different sections of the \
kernel, and counts pixels per second: of four channels (pre-classified) and of one (post-classified). Its rates are curves without numbers in the text, so \
orders and shapes are compared.

We render a tilted slab of four layers of voxels that fills such a picture, so close that a kernel has the radius asked for. A \
pixel is one of a footprint's disc, of one sheet. The time is that of opening splats and drawing their sections, without compositing; \
medians of interleaved rounds, one thread. Pre-classified sheets hold five channels here: four, and the depth. Post-classified ones hold two: the \
value and its weight.

Two curves are ours. *auto* evaluates footprints instead of looking them up, within the same engine. *default engine* is what renders \
grids unless FastSplats are asked for, with the preset `fast`: every voxel at once into the four sheets that it meets, four channels \
pre-classified and one post-classified. Its time holds bringing voxels to the screen, splatting, and taking finished sheets. Footprints \
wider than its kernels it splats on a coarser raster, which is interpolated; their pixels are counted as if it did not.",
    run,
};

const RADII: [f64; 6] = [2.0, 4.0, 8.0, 12.0, 16.0, 24.0];
const ROUNDS: usize = 9;
/// Progress steps: the rounds and the warm-up round before them, twice, and the variants.
const STEPS: usize = 2 * (ROUNDS + 1) + 1;
/// Voxels of the slab along depth.
const LAYERS: usize = 4;
/// The name of the engine that renders grids by default.
const ENGINE: &str = "default engine";

/// A slab of equal voxels that fills a picture when kernels of radius 2 voxels have this radius in pixels.
fn slab(radius: f64, edge: f64) -> Result<(Scene, Camera), LabError> {
    let per_voxel = radius / 2.0;
    // The slab is turned within the picture, and its footprints stay inside.
    let voxels = ((edge - 2.0 * radius - 4.0) / (1.3 * per_voxel)) as usize;
    let dims = [voxels.max(2), voxels.max(2), LAYERS];
    let grid = Grid::centred(dims, DVec3::ONE)?;
    let mut values = vec![200_u8; dims.iter().product()];
    // One other value keeps the range of values open.
    values[0] = 100;
    let volume = Volume::new(
        grid,
        Samples::U8(values.into()),
        Default::default(),
        Default::default(),
    )?;
    let faint = TransferFunction::new(
        vec![ColorPoint::new(0.0, [0.8, 0.7, 0.5])],
        vec![OpacityPoint::new(0.0, 0.02)],
        None,
    )?;
    let camera = Camera::new(
        DVec3::new(17.0, 11.0, 100.0) * 10.0,
        DVec3::ZERO,
        DVec3::new(0.23, 1.0, 0.0),
        Projection::Orthographic {
            height: edge / per_voxel,
        },
    )?;
    Ok((Scene::new(volume, faint), camera))
}

/// Settings with the picture as one tile, in which no pixel is ever finished.
fn settings(size: ImageSize, rasterizer: Rasterizer, classification: Classification) -> FlatSettings {
    FlatSettings {
        classification,
        lighting: None,
        termination: 0.0,
        ..fastsplats(size, rasterizer)
    }
}

/// Settings of the engine that renders grids by default.
fn engine_settings(size: ImageSize, classification: Classification) -> FlatSettings {
    FlatSettings {
        size,
        classification,
        lighting: None,
        termination: 0.0,
        ..RenderSettings::fast().into()
    }
}

/// Pixels of all footprints' sections in a frame, and the seconds for them. The footprint engine counts opening as
/// splatting, and takes no sheets out of a ring.
fn rate(subject: &mut Subject<'_>, radius: f64) -> Result<f64, LabError> {
    subject.render()?;
    let statistics = subject.statistics();
    let pixels = statistics.slices as f64 * PI * radius * radius;
    let seconds = &statistics.seconds;
    Ok(pixels / (seconds.activate + seconds.splat + seconds.take))
}

/// Rates of all methods at all radii: `[method][radius]`, pixels per second.
struct Rates {
    methods: Vec<&'static str>,
    values: Vec<Vec<f64>>,
}

impl Rates {
    fn of(&self, method: &str) -> &[f64] {
        let index = self.methods.iter().position(|one| *one == method);
        index.map_or(&[], |index| self.values[index].as_slice())
    }

    /// At a radius of [`RADII`].
    fn at(&self, method: &str, radius: f64) -> f64 {
        let index = RADII.iter().position(|one| *one == radius);
        let rate = index.and_then(|index| self.of(method).get(index));
        rate.copied().unwrap_or(f64::NAN)
    }
}

/// The splats of one radius, by all methods.
struct Station<'a> {
    radius: f64,
    subjects: Vec<Subject<'a>>,
    /// Per method and round.
    rates: Vec<Vec<f64>>,
}

impl<'a> Station<'a> {
    fn new(
        (radius, slab): (f64, &'a (Scene, Camera)),
        methods: &[(&str, FlatSettings)],
    ) -> Result<Self, LabError> {
        let (scene, camera) = slab;
        let subject = |(_, settings): &(&str, FlatSettings)| Subject::new(scene, camera, *settings);
        Ok(Self {
            radius,
            subjects: methods.iter().map(subject).collect::<Result<_, _>>()?,
            rates: vec![Vec::new(); methods.len()],
        })
    }

    /// Every method once.
    fn round(&mut self, counted: bool) -> Result<(), LabError> {
        for (subject, rates) in self.subjects.iter_mut().zip(&mut self.rates) {
            let one = rate(subject, self.radius)?;
            rates.extend(counted.then_some(one));
        }
        Ok(())
    }
}

/// FastSplats, footprints that are evaluated, and the default engine, with four channels or one.
fn methods(size: ImageSize, channels: usize) -> Vec<(&'static str, FlatSettings)> {
    let classification = match channels {
        1 => Classification::Post,
        _ => Classification::Pre,
    };
    let auto = ("auto", Rasterizer::Auto);
    let of_footprints = |(name, rasterizer)| (name, settings(size, rasterizer, classification));
    let mut methods: Vec<_> = FASTSPLATS.into_iter().chain([auto]).map(of_footprints).collect();
    methods.push((ENGINE, engine_settings(size, classification)));
    methods
}

/// Medians over rounds in which every method takes its turn at every radius.
fn all_radii(bench: &Workbench<'_>, channels: usize, done: usize) -> Result<Rates, LabError> {
    let edge = bench.choose(512, 192);
    let methods = methods(ImageSize::new(edge, edge)?, channels);
    let slabs = RADII.map(|radius| slab(radius, f64::from(edge)));
    let slabs = slabs.into_iter().collect::<Result<Vec<_>, _>>()?;
    let stations = RADII.into_iter().zip(&slabs);
    let mut stations = stations
        .map(|slab| Station::new(slab, &methods))
        .collect::<Result<Vec<_>, _>>()?;
    for round in 0..=ROUNDS {
        bench.step(
            done + round,
            STEPS,
            &format!("channels: {channels}, round {round} of {ROUNDS}"),
        );
        for station in &mut stations {
            station.round(round > 0)?;
        }
    }
    let mut values = vec![Vec::new(); methods.len()];
    for station in stations {
        for (of_method, rates) in values.iter_mut().zip(station.rates) {
            of_method.push(median(rates));
        }
    }
    let methods = methods.into_iter().map(|(name, _)| name).collect();
    Ok(Rates { methods, values })
}

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let four = all_radii(bench, 4, 0)?;
    let one = all_radii(bench, 1, ROUNDS + 1)?;
    let mut outcome = Outcome::default();
    for (figure, key, rates) in [("Fig. 5", "four", &four), ("Fig. 6", "one", &one)] {
        rate_findings(&mut outcome, (figure, key), rates);
    }
    channel_findings(&mut outcome, [&four, &one]);
    bench.step(STEPS - 1, STEPS, "precision and positions");
    variants(bench, &mut outcome)?;
    for (figure, name, rates) in [
        ("Fig. 5", "four-channels", &four),
        ("Fig. 6", "one-channel", &one),
    ] {
        outcome.tables.push(numbers(figure, name, rates));
        outcome.plots.extend(plots(figure, name, rates));
    }
    Ok(outcome)
}

/// Variants that do not affect the rates, according to the paper: precision, and cells of RLUT.
fn variants(bench: &Workbench<'_>, outcome: &mut Outcome) -> Result<(), LabError> {
    let radius = 8.0;
    let edge = bench.choose(512, 192);
    let size = ImageSize::new(edge, edge)?;
    let (scene, camera) = slab(radius, f64::from(edge))?;
    let square = settings(size, Rasterizer::Square1d, Classification::Pre);
    let wide = FlatSettings {
        table: TableLayout {
            precision: TablePrecision::U16,
            ..square.table
        },
        ..square
    };
    let rlut = |rasterizer| FlatSettings { rasterizer, ..square };
    let each = [square, wide, rlut(RLUT), rlut(Rasterizer::Rlut { subpixels: 10 })];
    let mut subjects = each
        .into_iter()
        .map(|settings| Subject::new(&scene, &camera, settings))
        .collect::<Result<Vec<_>, _>>()?;
    let mut rates = vec![Vec::new(); subjects.len()];
    for _ in 0..7 {
        for (subject, rates) in subjects.iter_mut().zip(&mut rates) {
            rates.push(rate(subject, radius)?);
        }
    }
    let rates: Vec<f64> = rates.into_iter().map(median).collect();
    for (key, quantity, ratio) in [
        (
            "sixteen-bits",
            "rate of square with 16 bits over that with 8, radius 8",
            rates[1] / rates[0],
        ),
        (
            "rlut-cells",
            "rate of RLUT with 100 x 100 cells over that with 10 x 10, radius 8",
            rates[2] / rates[3],
        ),
    ] {
        outcome.find(
            Finding::new("Fig. 5", key, quantity, ratio, Expectation::relative(1.0, 0.1))
                .published(Published::Claim("the same rates".to_owned()))
                .timed(),
        );
    }
    Ok(())
}
