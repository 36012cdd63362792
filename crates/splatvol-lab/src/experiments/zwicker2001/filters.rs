//! Fig. 8: the shape of the resampling filter; Fig. 7: the box in which it is rasterised.
//!
//! With V the screen covariance of a kernel, the EWA filter has `V + I` (eq. 22). Swan's, as the paper has it, is V
//! scaled until its minor radius is that of the low-pass.

use glam::{DMat2, DMat3, DVec3};
use splatvol::{Alignment, Filter};
use splatvol_core::splats::GaussianProfile;
use splatvol_testing::Random;

use super::splat::{FOCAL, Splat, covariance_of, norm, outline, widths};
use crate::{
    Axis, Curve, Expectation, Experiment, Finding, LabError, Outcome, Plot, Published, Table, Workbench,
};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "zwicker2001-filters",
    paper: "zwicker2001",
    title: "Shapes of the resampling filter",
    figures: &["Fig. 7", "Fig. 8"],
    about: "The paper draws the resampling filter of EWA and of Swan's method for a volume that is minified, one that \
            is magnified, and one that is stretched in one direction and shrunk in the other.\n\n\
            We take one kernel of one voxel's standard deviation with 1/8, 8, and 4 x 1/4 pixels per voxel, and a \
            low-pass of one pixel, the paper's identity matrix. We plot the ellipses of the engine's own footprints. \
            The sizes are ours: the figure has none. (The engine's default low-pass is .55 pixels wide, and a square \
            pixel is as wide as .29: see the experiment with the zebra.)\n\n\
            Eq. 22 is checked on random kernels, and so is the box of Fig. 7, which must touch the ellipse.",
    run,
};

/// The paper's low-pass: the identity matrix.
const EWA: Filter = Filter::Ewa { pixel_sigma: 1.0 };

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let mut outcome = Outcome::default();
    bench.step(0, 1, "filters");
    shapes(&mut outcome)?;
    spheres(&mut outcome)?;
    equations(&mut outcome, bench.choose(10_000, 1000))?;
    Ok(outcome)
}

/// A kernel on the axis whose voxels are this many pixels wide along x and y, turned by 30 degrees.
fn kernel([along, across]: [f64; 2]) -> Splat {
    let turn = DMat3::from_rotation_z(30f64.to_radians());
    let pixels = DMat3::from_diagonal(DVec3::new(along, across, 1.0) / FOCAL);
    Splat::sphere(DVec3::Z, turn * pixels)
}

fn covariance(splat: &Splat, filter: Filter) -> Result<DMat2, LabError> {
    let profile = GaussianProfile::new(4.0);
    covariance_of(&splat.footprint(filter, Alignment::Affine, &profile)?)
}

/// Fig. 8, column by column.
fn shapes(outcome: &mut Outcome) -> Result<(), LabError> {
    let mut table = Table::new(
        "shapes",
        "Fig. 8",
        "Standard deviations of the filters",
        &["volume", "filter", "minor (pixels)", "major (pixels)"],
    );
    for (name, pixels, reach) in [
        ("minified", [0.125, 0.125], 2.0),
        ("magnified", [8.0, 8.0], 12.0),
        ("stretched and shrunk", [4.0, 0.25], 10.0),
    ] {
        let splat = kernel(pixels);
        let mut plot = Plot::curves(
            name.split(' ').next().unwrap_or(name),
            "Fig. 8",
            &format!("The volume is {name}: filters at one standard deviation"),
            Axis::new("x (pixels)").range(-1.56 * reach, 1.56 * reach),
            Axis::new("y (pixels)").range(-reach, reach),
        );
        let ellipses = [
            ("reconstruction kernel", covariance(&splat, Filter::None)?),
            ("low-pass", DMat2::IDENTITY),
            ("EWA filter", covariance(&splat, EWA)?),
            ("Swan's filter", covariance(&splat, Filter::Swan)?),
        ];
        for (label, ellipse) in ellipses {
            let [minor, major] = widths(ellipse);
            table.row([name.into(), label.into(), minor.into(), major.into()]);
        }
        // Ellipses that others are likely to cover come first.
        for (label, ellipse) in ellipses.into_iter().rev() {
            let curve = Curve::new(label, outline(ellipse));
            plot = plot.curve(match label {
                "Swan's filter" => curve.dots(),
                "EWA filter" => curve,
                _ => curve.dashed(),
            });
        }
        outcome.plots.push(plot);
        let [kernel, low_pass, ewa, swan] = ellipses.map(|(_, ellipse)| widths(ellipse));
        findings(outcome, name, [kernel, low_pass, ewa, swan]);
    }
    outcome.tables.push(table);
    Ok(())
}

fn findings(outcome: &mut Outcome, name: &str, [kernel, low_pass, ewa, swan]: [[f64; 2]; 4]) {
    let mut find = |key: &str, quantity: &str, measured, expected, claim: &str| {
        outcome.find(
            Finding::new("Fig. 8", key, quantity, measured, expected)
                .published(Published::Claim(claim.to_owned())),
        );
    };
    let alike = Expectation::Between(1.0, 1.1);
    match name {
        "minified" => find(
            "minified-low-pass",
            "major width of the EWA filter over that of the low-pass, 1/8 pixel per voxel",
            ewa[1] / low_pass[1],
            alike,
            "minified: dominated by the low-pass filter",
        ),
        "magnified" => find(
            "magnified-kernel",
            "major width of the EWA filter over that of the reconstruction kernel, 8 pixels per voxel",
            ewa[1] / kernel[1],
            alike,
            "magnified: dominated by the reconstruction kernel",
        ),
        _ => {
            let claim = "scaled anisotropically where stretched in one direction and shrunk in the other";
            find(
                "anisotropic-major",
                "major width of the EWA filter over that of the kernel, 4 x 1/4 pixels per voxel",
                ewa[1] / kernel[1],
                alike,
                claim,
            );
            find(
                "anisotropic-minor",
                "minor width of the EWA filter over that of the low-pass",
                ewa[0] / low_pass[0],
                alike,
                claim,
            );
            find(
                "swan-minor",
                "minor width of Swan's filter over that of the low-pass",
                swan[0] / low_pass[0],
                Expectation::AtLeast(0.999),
                "its minor radius is at least as long as that of the low-pass",
            );
            find(
                "swan-major",
                "major width of Swan's filter over that of the EWA filter",
                swan[1] / ewa[1],
                Expectation::AtLeast(1.5),
                "overly blurred in the direction of the major axis",
            );
        }
    }
}

/// Widths of both filters of a sphere against pixels per voxel.
fn spheres(outcome: &mut Outcome) -> Result<(), LabError> {
    let scales = (-40..=40).map(|i| 2f64.powf(f64::from(i) / 8.0));
    let mut rows: Vec<[f64; 3]> = Vec::new();
    for scale in scales {
        let splat = kernel([scale, scale]);
        let width = |filter| Ok::<_, LabError>(widths(covariance(&splat, filter)?)[1]);
        rows.push([scale, width(EWA)?, width(Filter::Swan)?]);
    }
    let mut table = Table::new(
        "spheres",
        "Fig. 8",
        "Widths of the filters of a sphere",
        &["pixels per voxel", "EWA (pixels)", "Swan (pixels)"],
    )
    .hidden();
    rows.iter().for_each(|row| table.row(row.map(Into::into)));
    outcome.tables.push(table);
    let column = |index: usize| {
        rows.iter()
            .map(move |row| [row[0], row[index]])
            .collect::<Vec<_>>()
    };
    outcome.plots.push(
        Plot::curves(
            "spheres",
            "Fig. 8",
            "Width of the filter of a spherical kernel, from minification to magnification",
            Axis::logarithmic("pixels per voxel"),
            Axis::logarithmic("standard deviation (pixels)"),
        )
        .curve(Curve::new("EWA", column(1)))
        .curve(Curve::new("Swan", column(2)).dashed()),
    );
    let apart = |least: f64| {
        let far = rows.iter().filter(|row| row[0].log2().abs() >= least);
        far.map(|row| (row[1] / row[2]).max(row[2] / row[1]))
            .fold(1.0, f64::max)
    };
    outcome.find(
        Finding::new(
            "Fig. 8",
            "spheres-apart",
            "largest ratio of the widths of the two filters of a sphere, at any scale",
            apart(0.0),
            Expectation::AtMost(1.1),
        )
        .published(Published::Claim(
            "for spherical kernels, basically equivalent to the EWA filter".to_owned(),
        ))
        .explained_by(
            "variances add up where a voxel is about as large as a pixel, while Swan's takes the larger width; \
             four times off that, the ratio is within 5 %",
            apart(2.0),
            Expectation::AtMost(1.05),
        ),
    );
    let bend = |index: usize| {
        let slope =
            |pair: &[[f64; 3]]| (pair[1][index] / pair[0][index]).ln() / (pair[1][0] / pair[0][0]).ln();
        let slopes: Vec<f64> = rows.windows(2).map(slope).collect();
        slopes
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).abs())
            .fold(0.0, f64::max)
    };
    outcome.find(
        Finding::new(
            "Fig. 8",
            "smooth-transition",
            "largest change of the slope of log width over log scale within an eighth of an octave, EWA",
            bend(1),
            Expectation::AtMost(0.1),
        )
        .detail(format!("Swan's {:.2}", bend(2)))
        .published(Published::Claim(
            "a smooth transition between magnification and minification".to_owned(),
        )),
    );
    Ok(())
}

/// Eq. 22 and the box of Fig. 7 on random kernels.
fn equations(outcome: &mut Outcome, count: usize) -> Result<(), LabError> {
    let mut random = Random::new(22);
    let cut = 2.0;
    let profile = GaussianProfile::new(cut);
    let (mut apart, mut loose) = (0.0f64, 0.0f64);
    for _ in 0..count {
        let centre =
            DVec3::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0), 1.0) * random.range(1.0, 10.0);
        let turn = DMat3::from_axis_angle(random.direction(), random.range(0.0, 3.0));
        let axes = DVec3::from_array([0; 3].map(|_| random.range(-7.0, -3.0).exp()));
        let splat = Splat::sphere(centre, turn * DMat3::from_diagonal(axes));
        let footprint = splat.footprint(EWA, Alignment::Affine, &profile)?;
        let expected = splat.covariance(1.0) + DMat2::IDENTITY;
        apart = apart.max(norm(covariance_of(&footprint)? - expected) / norm(expected));
        let [x0, y0, x1, y1] = footprint.bounds.map(f64::from);
        let half = [0.5 * (x1 - x0), 0.5 * (y1 - y0)];
        let touching = [expected.x_axis.x, expected.y_axis.y].map(|variance| cut * variance.sqrt());
        for (half, touching) in half.into_iter().zip(touching) {
            loose = loose.max((half / touching - 1.0).abs());
        }
    }
    outcome.find(
        Finding::new(
            "Fig. 8",
            "equation-22",
            "largest distance of the engine's filter from eq. 22 in 64 bits, share of it",
            apart,
            Expectation::AtMost(1e-3),
        )
        .detail(format!("{count} random ellipsoids")),
    );
    outcome.find(
        Finding::new(
            "Fig. 7",
            "box",
            "largest deviation of the box from the one that touches r = c, share of it",
            loose,
            Expectation::AtMost(1e-3),
        )
        .published(Published::Claim(
            "a rectangular, axis aligned bounding box, c = 4".to_owned(),
        )),
    );
    Ok(())
}
