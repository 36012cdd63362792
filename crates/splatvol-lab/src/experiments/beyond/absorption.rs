//! Absorption: `1 - tau`, and nothing below it, in place of `exp(-tau)` (zwicker2001 eq. 4; the papers' opacities).
//!
//! One sheet of optical depth tau is `min(tau, 1)` opaque instead of `1 - exp(-tau)`: too much by `1/e` at tau = 1.
//! Through a homogeneous medium of extinction kappa on sheets of thickness d the effective extinction is
//! `-ln(1 - kappa d) / d`; splat by splat, with footprints `q_k` on a pixel, it is `-sum_k ln(1 - kappa q_k)` per
//! voxel.

use std::f64::consts::TAU;

use glam::DVec3;
use splatvol::{
    Absorption, Alignment, Compositing, FlatSettings, Grid, LengthUnit, RenderSettings, Renderer, Rescale,
    Samples, Scene, SceneError, Volume,
};
use splatvol_testing::transfer::constant_extinction;

use super::scenes::{SMOOTH, colors, difference, noise_ball, orthographic, rms, shown};
use crate::{
    Axis, Curve, Expectation, Experiment, Finding, LabError, Outcome, Plate, Plot, Table, Workbench,
};

const FIGURE: &str = "Absorption";
/// Thicknesses of two boxes, voxels; kernels reach 4 beyond each end, so the boxes' difference is free of
/// ends.
const LENGTHS: [usize; 2] = [12, 24];
/// The extinction per voxel at which pictures are compared in words: an opacity of .39.
const HALF: f64 = 0.5;
const GAIN: f32 = 4.0;

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "beyond-absorption",
    paper: "beyond",
    title: "Absorption: exp(-x) against the papers' 1 - x",
    figures: &[FIGURE],
    about: "zwicker2001 (equation 4) and its predecessors replace exp(-x) by 1 - x within each splat or sheet. Here a single \
            sheet is rendered at optical depths from .05 to 4; then boxes of a homogeneous medium, of which the difference \
            between a long and a short one has no ends: its extinction per voxel is compared with the one that was asked \
            for. Closed forms say what should come out in either case.\n\n\
            At last the ball of noise of the other experiments is rendered in both ways on sheets of several thicknesses. \
            The thinner the sheets, the less it matters.",
    run,
};

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let mut outcome = Outcome::default();
    let mut renderer = bench.renderer()?;
    bench.step(0, 3, "one sheet");
    one_sheet(&mut renderer, &mut outcome)?;
    bench.step(1, 3, "homogeneous medium");
    medium(&mut renderer, &mut outcome)?;
    bench.step(2, 3, "pictures");
    pictures(bench, &mut renderer, &mut outcome)?;
    Ok(outcome)
}

/// A box of one value, `length` voxels along z.
fn constant(length: usize) -> Result<Volume, SceneError> {
    let dims = [21, 21, length];
    let grid = Grid::centred(dims, DVec3::ONE)?;
    let samples = Samples::F32(vec![1.0; grid.sample_count()].into());
    Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown)
}

/// Optical depth and opacity in the middle of the box, seen along z. The picture is one voxel wide and has one pixel,
/// whose centre is that of a voxel.
fn through(
    renderer: &mut Renderer,
    volume: &Volume,
    extinction: f64,
    settings: &RenderSettings,
) -> Result<[f64; 2], LabError> {
    let scene = Scene::new(volume.clone(), constant_extinction(extinction, [1.0; 3]));
    let camera = orthographic(DVec3::Z, DVec3::Y, 1.0)?;
    let frame = renderer.render(&scene, &camera, settings)?;
    Ok([frame.optical_depth[0], frame.image.pixels[0][3]].map(f64::from))
}

/// Classified splats in a picture of one pixel.
fn one_pixel(compositing: Compositing, absorption: Absorption) -> Result<RenderSettings, LabError> {
    Ok(RenderSettings::try_from(FlatSettings {
        compositing,
        absorption,
        alignment: Alignment::Affine,
        ..colors(1, SMOOTH)?.into()
    })?)
}

fn one_sheet(renderer: &mut Renderer, outcome: &mut Outcome) -> Result<(), LabError> {
    let volume = constant(1)?;
    let columns = [
        "optical depth",
        "opacity, linear",
        "opacity, exponential",
        "1 - exp(-x)",
    ];
    let mut table = Table::new("one-sheet", FIGURE, "Opacity of one sheet", &columns).hidden();
    let [mut linear_error, mut exact_error] = [0.0f64; 2];
    let mut curves: [Vec<[f64; 2]>; 2] = Default::default();
    for step in 1..=80 {
        let tau = 0.05 * f64::from(step);
        let mut opacity = |absorption| {
            let settings = one_pixel(Compositing::AxisSheets, absorption)?;
            through(renderer, &volume, tau, &settings).map(|[_, alpha]| alpha)
        };
        let [linear, exact] = [opacity(Absorption::Linear)?, opacity(Absorption::Exp)?];
        let truth = -(-tau).exp_m1();
        table.row([tau, linear, exact, truth].map(Into::into));
        linear_error = linear_error.max((linear - truth).abs());
        exact_error = exact_error.max((exact - truth).abs());
        curves[0].push([tau, linear]);
        curves[1].push([tau, exact]);
    }
    outcome.find(Finding::new(
        FIGURE,
        "one-sheet-linear",
        "one sheet, 1 - x: largest error of the opacity (1/e, at optical depth 1)",
        linear_error,
        Expectation::relative((-1.0f64).exp(), 0.01),
    ));
    outcome.find(Finding::new(
        FIGURE,
        "one-sheet-exponential",
        "one sheet, exp(-x): largest error of the opacity",
        exact_error,
        Expectation::AtMost(1e-3),
    ));
    let plot = Plot::curves(
        "one-sheet",
        FIGURE,
        "Opacity of one sheet",
        Axis::new("optical depth"),
        Axis::new("opacity"),
    );
    let [linear, exact] = curves;
    let closed = (0..=80)
        .map(|i| 0.05 * f64::from(i))
        .map(|tau| [tau, -(-tau).exp_m1()]);
    outcome.plots.push(
        plot.curve(Curve::new("1 - x, rendered", linear))
            .curve(Curve::new("exp(-x), rendered", exact))
            .curve(Curve::new("1 - exp(-x)", closed).dashed()),
    );
    outcome.tables.push(table);
    Ok(())
}

/// Compositing of a medium, and its extinction per voxel in theory.
struct Way {
    name: &'static str,
    key: &'static str,
    compositing: Compositing,
    absorption: Absorption,
    thickness: f64,
    theory: fn(f64) -> f64,
}

const WAYS: [Way; 4] = [
    Way {
        name: "1 - x, sheets of 1 voxel",
        key: "linear-1",
        compositing: Compositing::ImageSheets,
        absorption: Absorption::Linear,
        thickness: 1.0,
        theory: |kappa| -(-kappa).ln_1p(),
    },
    Way {
        name: "1 - x, sheets of 1/4 voxel",
        key: "linear-quarter",
        compositing: Compositing::ImageSheets,
        absorption: Absorption::Linear,
        thickness: 0.25,
        theory: |kappa| -4.0 * (-0.25 * kappa).ln_1p(),
    },
    Way {
        name: "1 - x, splats one by one",
        key: "linear-per-splat",
        compositing: Compositing::PerSplat,
        absorption: Absorption::Linear,
        thickness: 1.0,
        theory: splat_by_splat,
    },
    Way {
        name: "exp(-x), sheets of 1 voxel",
        key: "exponential",
        compositing: Compositing::ImageSheets,
        absorption: Absorption::Exp,
        thickness: 1.0,
        theory: |kappa| kappa,
    },
];

/// Extinction of a layer of voxels on the ray through a voxel's centre, each splat being `1 - kappa q` transparent.
fn splat_by_splat(kappa: f64) -> f64 {
    let (sigma, radius) = SMOOTH.gaussian().unwrap_or((f64::NAN, f64::NAN));
    let reach = radius.ceil() as i32;
    let offsets = || (-reach..=reach).map(f64::from);
    let squares = offsets().flat_map(|x| offsets().map(move |y| x * x + y * y));
    squares
        .map(|square| (-0.5 * square / (sigma * sigma)).exp() / (TAU * sigma * sigma))
        .map(|footprint| -(-kappa * footprint).ln_1p())
        .sum()
}

impl Way {
    /// Extinction per voxel of the part by which the longer box exceeds the other.
    fn measured(&self, renderer: &mut Renderer, kappa: f64) -> Result<f64, LabError> {
        let settings = RenderSettings::try_from(FlatSettings {
            sheet_thickness: self.thickness,
            ..one_pixel(self.compositing, self.absorption)?.into()
        })?;
        let mut depth = |length| through(renderer, &constant(length)?, kappa, &settings).map(|[tau, _]| tau);
        let [short, long] = LENGTHS;
        Ok((depth(long)? - depth(short)?) / (long - short) as f64)
    }
}

fn medium(renderer: &mut Renderer, outcome: &mut Outcome) -> Result<(), LabError> {
    let columns = [
        "method",
        "extinction asked for (per voxel)",
        "extinction rendered",
        "closed form",
    ];
    let mut table = Table::new("medium", FIGURE, "A homogeneous medium", &columns).hidden();
    let mut plot = Plot::curves(
        "medium",
        FIGURE,
        "A homogeneous medium: how dense it comes out",
        Axis::new("extinction asked for (per voxel)"),
        Axis::new("extinction rendered (of that asked for)"),
    );
    for way in WAYS {
        let mut points = Vec::new();
        let mut worst = 0.0f64;
        for step in 1..=18 {
            let kappa = 0.05 * f64::from(step);
            let [measured, theory] = [way.measured(renderer, kappa)?, (way.theory)(kappa)];
            table.row([way.name.into(), kappa.into(), measured.into(), theory.into()]);
            points.push([kappa, measured / kappa]);
            worst = worst.max((measured / theory - 1.0).abs());
        }
        let at_half = way.measured(renderer, HALF)? / HALF;
        let quantity = format!(
            "{}: extinction rendered of an extinction of {HALF} per voxel",
            way.name
        );
        outcome.find(Finding::new(
            FIGURE,
            way.key,
            &quantity,
            at_half,
            Expectation::relative((way.theory)(HALF) / HALF, 0.01),
        ));
        outcome.find(Finding::new(
            FIGURE,
            &format!("{}-worst", way.key),
            &format!(
                "{}: largest distance from the closed form, .05 to .9 per voxel",
                way.name
            ),
            worst,
            Expectation::AtMost(0.01),
        ));
        plot = plot.curve(Curve::new(way.name, points).dots());
    }
    outcome.plots.push(plot);
    outcome.tables.push(table);
    Ok(())
}

fn pictures(bench: &Workbench<'_>, renderer: &mut Renderer, outcome: &mut Outcome) -> Result<(), LabError> {
    let side = bench.choose(48, 24);
    let scene = noise_ball(side, 0.6)?;
    let camera = orthographic(DVec3::new(0.48, -0.75, 0.4), DVec3::Z, side as f64)?;
    let base = RenderSettings::try_from(FlatSettings {
        alignment: Alignment::Affine,
        ..colors(bench.choose(160, 64), SMOOTH)?.into()
    })?;
    let thicknesses = [1.0, 0.5, 0.25, 0.125];
    let caption = format!("Opacity .6 per voxel; right, {GAIN} times the difference");
    let mut plate = Plate::new("pictures", FIGURE, &caption);
    let mut errors = Vec::new();
    for sheet_thickness in thicknesses {
        let mut image = |absorption| {
            let settings = RenderSettings::try_from(FlatSettings {
                absorption,
                sheet_thickness,
                ..base.into()
            })?;
            renderer
                .render(&scene, &camera, &settings)
                .map(|frame| frame.image)
        };
        let [exact, linear] = [image(Absorption::Exp)?, image(Absorption::Linear)?];
        errors.push(rms(&linear, &exact));
        if sheet_thickness == 1.0 {
            plate = plate
                .panel("exp(-x), sheets of 1 voxel", shown(&exact))
                .panel("1 - x", shown(&linear))
                .panel("difference", difference(&linear, &exact, GAIN));
        }
    }
    let columns = ["sheets (voxels)", "difference (rms)"];
    let mut table = Table::new("pictures", FIGURE, "1 - x against exp(-x)", &columns);
    for (thickness, error) in thicknesses.into_iter().zip(&errors) {
        table.row([thickness.into(), (*error).into()]);
    }
    outcome.find(Finding::new(
        FIGURE,
        "order",
        "order at which 1 - x approaches exp(-x) with thinner sheets, 1/2 to 1/8 voxel",
        (errors[1] / errors[3]).log2() / 2.0,
        Expectation::Between(0.8, 1.2),
    ));
    outcome.tables.push(table);
    outcome.plates.push(plate);
    Ok(())
}
