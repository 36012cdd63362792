//! Kernel cut-off: the lost mass of the footprint, and the pattern that the edge leaves on a constant field.
//!
//! The share `exp(-c^2 / 2)` of a two-dimensional Gaussian lies beyond c standard deviations. It is also the step at
//! the edge relative to the peak: 13.5 % at zwicker2001's `r < 4` (section 6; r is the squared radius). The engine cuts
//! at the kernel's radius, subtracts the value there, and restores the mass: `q(r) = (exp(-r^2 / 2 s^2) - e) / 2 pi s^2
//! (1 - e - e c^2 / 2)`, `e = exp(-c^2 / 2)`.
//!
//! Ripple is peak to peak, as a share of the mean, of `sum_k q(x - k)` over a square cell of the lattice: the picture
//! of a layer of equal voxels.

mod layer;

use glam::DVec3;
use splatvol::{
    Alignment, Compositing, FlatSettings, Grid, Kernel, LengthUnit, RenderSettings, Renderer, Rescale,
    Samples, Scene, Volume,
};
use splatvol_core::radial::{RadialKernel, analyse};
use splatvol_testing::transfer::constant_extinction;

use super::scenes::{colors, grey, orthographic};
use crate::measure::mean;
use crate::{
    Axis, Curve, Expectation, Experiment, Finding, LabError, Mark, Outcome, Plate, Plot, Published, Table,
    Workbench,
};

use layer::{Edge, beyond, footprint, layer, ripple};

const FIGURE: &str = "Footprint cut-off";
/// Pixels per voxel, and voxels across, of pictures of a constant layer.
const ZOOM: u32 = 32;
const VOXELS: u32 = 4;
/// Optical depth of the layer.
const OPTICAL_DEPTH: f64 = 0.1;
/// Contrast gain of its pictures.
const CONTRAST: f64 = 5.0;

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "beyond-cut-off",
    paper: "beyond",
    title: "Footprint cut-off: the energy beyond the cut and the ripple it makes",
    figures: &[FIGURE],
    about: "zwicker2001 evaluates its Gaussians of one voxel within two standard deviations only. How much of a footprint \
            lies beyond, and what the edge does to a constant layer of voxels, is computed here in f64 from the kernels' \
            equations, for the cut as the paper describes it.\n\n\
            The engine subtracts the edge's value and gives the mass back (`--kernel-edge smooth`; the preset `ewa2001` leaves both, `raw`), and its default Gaussian is cut at four standard \
            deviations. Its ripple is measured in X-ray pictures of one layer of equal voxels, 32 pixels per voxel, and \
            compared with the closed form. Kernels that end by themselves are rendered too.",
    run,
};

const fn gaussian(sigma: f64, radius: f64) -> Kernel {
    Kernel::Gaussian { sigma, radius }
}

/// Kernels as they are used, with the ripple in space that docs/kernels.md states, per cent.
const KERNELS: [(&str, &str, Kernel, f64); 6] = [
    (
        "gaussian 1, cut at 2 (zwicker2001)",
        "zwicker2001",
        gaussian(1.0, 2.0),
        14.0,
    ),
    ("gaussian .602, cut at 2", "papers", gaussian(0.602, 2.0), 1.06),
    (
        "gaussian .74, cut at 3 (default)",
        "default",
        gaussian(0.74, 3.0),
        0.138,
    ),
    ("crawfis-max", "crawfis-max", Kernel::CrawfisMax, 0.766),
    ("cubic-bspline", "cubic-bspline", Kernel::CubicBspline, 0.372),
    ("kaiser-bessel", "kaiser-bessel", Kernel::KAISER_BESSEL, 0.046),
];

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let mut outcome = Outcome::default();
    let mut renderer = bench.renderer()?;
    bench.step(0, 3, "energy beyond the cut");
    energy(&mut outcome);
    bench.step(1, 3, "ripple by cut");
    ripple_by_cut(bench, &mut renderer, &mut outcome)?;
    bench.step(2, 3, "kernels");
    kernels(&mut renderer, &mut outcome)?;
    Ok(outcome)
}

fn energy(outcome: &mut Outcome) {
    let uncut = [
        ("gaussian, sigma 1", gaussian(1.0, 8.0)),
        ("gaussian, sigma .74", gaussian(0.74, 5.9)),
        ("gaussian, sigma .602", gaussian(0.602, 4.8)),
        ("crawfis-max", Kernel::CrawfisMax),
        ("cubic-bspline", Kernel::CubicBspline),
        ("kaiser-bessel", Kernel::KAISER_BESSEL),
    ]
    .map(|(name, kernel)| (name, RadialKernel::new(kernel)));
    let columns = ["kernel", "radius (voxels)", "energy beyond (of the footprint's)"];
    let mut table = Table::new("energy", FIGURE, "Energy beyond a radius", &columns).hidden();
    let mut plot = Plot::curves(
        "energy",
        FIGURE,
        "What a cut takes from a footprint",
        Axis::new("radius of the cut (voxels)").range(0.0, 4.0),
        Axis::logarithmic("energy beyond (of the footprint's)").range(1e-5, 1.0),
    )
    .mark(Mark::Vertical {
        at: 2.0,
        label: "zwicker2001".to_owned(),
    });
    for (name, kernel) in &uncut {
        let points: Vec<[f64; 2]> = (0..=80)
            .map(|i| 0.05 * f64::from(i))
            .map(|radius| [radius, beyond(kernel, radius)])
            .collect();
        for [radius, share] in &points {
            table.row([(*name).into(), (*radius).into(), (*share).into()]);
        }
        plot = plot.curve(Curve::new(
            name,
            points.into_iter().filter(|point| point[1] >= 1e-5),
        ));
    }
    outcome.tables.push(table);
    outcome.plots.push(plot);
    let finding = |key: &str, quantity: &str, measured: f64, closed: f64| {
        Finding::new(
            FIGURE,
            key,
            quantity,
            100.0 * measured,
            Expectation::relative(100.0 * closed, 0.01),
        )
        .unit("%")
    };
    outcome.find(
        finding(
            "beyond-two",
            "energy of a Gaussian's footprint beyond two standard deviations (closed form exp(-2))",
            beyond(&uncut[0].1, 2.0),
            (-2.0f64).exp(),
        )
        .published(Published::Claim(
            "zwicker2001 section 6: evaluated for r < 4 only".to_owned(),
        )),
    );
    let (sigma, radius) = (0.74, 3.0);
    outcome.find(finding(
        "beyond-default",
        "energy of the default Gaussian's footprint beyond its cut, 3 voxels of sigma .74",
        beyond(&uncut[1].1, radius),
        (-0.5 * (radius / sigma) * (radius / sigma)).exp(),
    ));
}

/// An X-ray of the middle of one layer of equal voxels, relative to its optical depth; [`VOXELS`] across.
fn rendered(renderer: &mut Renderer, kernel: Kernel) -> Result<Vec<f64>, LabError> {
    let grid = Grid::centred([20, 20, 1], DVec3::ONE)?;
    let samples = Samples::F32(vec![1.0; grid.sample_count()].into());
    let volume = Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown)?;
    let scene = Scene::new(volume, constant_extinction(OPTICAL_DEPTH, [1.0; 3]));
    let settings = RenderSettings::try_from(FlatSettings {
        compositing: Compositing::Xray,
        alignment: Alignment::Affine,
        ..colors(ZOOM * VOXELS, kernel)?.into()
    })?;
    let camera = orthographic(DVec3::Z, DVec3::Y, f64::from(VOXELS))?;
    let frame = renderer.render(&scene, &camera, &settings)?;
    Ok(frame
        .optical_depth
        .iter()
        .map(|depth| f64::from(*depth) / OPTICAL_DEPTH)
        .collect())
}

fn ripple_by_cut(
    bench: &Workbench<'_>,
    renderer: &mut Renderer,
    outcome: &mut Outcome,
) -> Result<(), LabError> {
    const SIGMA: f64 = 1.0;
    let columns = [
        "cut (sigma)",
        "step at the edge (%)",
        "less the edge (%)",
        "engine (%)",
    ];
    let caption = "Ripple of a layer, Gaussian of sigma 1 voxel";
    let mut table = Table::new("ripple-by-cut", FIGURE, caption, &columns);
    let mut curves: [Vec<[f64; 2]>; 3] = Default::default();
    let mut worst = 0.0f64;
    let steps = bench.choose(10, 5);
    for step in 0..=steps {
        let cut = 1.5 + 2.5 * f64::from(step) / f64::from(steps);
        let theory = |edge| ripple(&layer(|square| footprint(SIGMA, cut, edge, square), cut * SIGMA));
        let ripples = [
            theory(Edge::Step),
            theory(Edge::Subtracted),
            ripple(&rendered(renderer, gaussian(SIGMA, cut * SIGMA))?),
        ]
        .map(|ripple| 100.0 * ripple);
        for (curve, ripple) in curves.iter_mut().zip(ripples) {
            curve.push([cut, ripple]);
        }
        worst = worst.max((ripples[2] - ripples[1]).abs());
        table.row(std::iter::once(cut).chain(ripples).map(Into::into));
    }
    outcome.find(
        Finding::new(
            FIGURE,
            "engine-against-closed-form",
            "ripple of the engine's pictures against the closed form, largest distance over all cuts",
            worst,
            Expectation::AtMost(0.05),
        )
        .unit("% of the mean"),
    );
    let plot = Plot::curves(
        "ripple-by-cut",
        FIGURE,
        "A layer of equal voxels: ripple by where a Gaussian of one voxel is cut",
        Axis::new("cut (standard deviations)").range(1.5, 4.0),
        Axis::logarithmic("ripple (% of the mean, peak to peak)"),
    );
    let [step, closed, engine] = curves;
    outcome.plots.push(
        plot.curve(Curve::new("cut with a step", step))
            .curve(Curve::new("less the edge, engine", engine).dots())
            .curve(Curve::new("less the edge, closed form", closed).dashed()),
    );
    outcome.tables.push(table);
    Ok(())
}

fn kernels(renderer: &mut Renderer, outcome: &mut Outcome) -> Result<(), LabError> {
    let columns = [
        "kernel",
        "ripple in space (%)",
        "documented (%)",
        "ripple of a layer, engine (%)",
    ];
    let mut table = Table::new(
        "kernels",
        FIGURE,
        "Ripple of a constant field, peak to peak",
        &columns,
    );
    let caption = format!("A constant layer, which should be even grey; {CONTRAST} times the contrast");
    let mut plate = Plate::new("layers", FIGURE, &caption);
    let paper = layer(|square| footprint(1.0, 2.0, Edge::Step, square), 2.0);
    outcome.find(
        Finding::new(
            FIGURE,
            "step",
            "ripple of a layer of Gaussians of one voxel cut at two, with the step, as zwicker2001 describes them",
            100.0 * ripple(&paper),
            Expectation::AtLeast(5.0),
        )
        .unit("%"),
    );
    plate = plate.panel("sigma 1, cut at 2 with a step", contrasted(&tiled(&paper))?);
    for (name, key, kernel, documented) in KERNELS {
        let in_space = 100.0 * analyse(&RadialKernel::new(kernel)).ripple();
        let picture = rendered(renderer, kernel)?;
        let in_picture = 100.0 * ripple(&picture);
        table.row([name.into(), in_space.into(), documented.into(), in_picture.into()]);
        let quantity = format!("ripple in space of {name} (docs/kernels.md: {documented} %)");
        outcome.find(
            Finding::new(
                FIGURE,
                &format!("ripple-{key}"),
                &quantity,
                in_space,
                Expectation::relative(documented, 0.05),
            )
            .unit("%")
            .detail(format!("in the engine's picture of a layer {in_picture:.3} %")),
        );
        plate = plate.panel(name, contrasted(&picture)?);
    }
    outcome.tables.push(table);
    outcome.plates.push(plate);
    Ok(())
}

/// A cell repeated as the engine's pictures show the layer: their middle is that of a cell's edge.
fn tiled(cell: &[f64]) -> Vec<f64> {
    let side = ZOOM * VOXELS;
    let wrapped = |i: u32| (i + ZOOM / 2) % ZOOM;
    let at = |index: u32| cell[(wrapped(index / side) * ZOOM + wrapped(index % side)) as usize];
    (0..side * side).map(at).collect()
}

/// Values around their mean, in grey.
fn contrasted(values: &[f64]) -> Result<splatvol::Image, LabError> {
    let mean = mean(values);
    let level = |value: &f64| 0.2 * (1.0 + CONTRAST * (value / mean - 1.0));
    grey(values.iter().map(level), ZOOM * VOXELS)
}
