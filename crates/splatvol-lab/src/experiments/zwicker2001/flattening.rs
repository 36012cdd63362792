//! Fig. 5 and 6, eq. 23 and 24: a flattened volume kernel becomes a surface kernel.
//!
//! With T = J W, the screen covariance of a kernel flattened by s is `t0 t0^T + t1 t1^T + t2 t2^T / s^2`, t being T's
//! columns: it converges to `T2D T2D^T` (eq. 24) as `1 / s^2`. T2D is the derivative, at the centre, of the plane's
//! picture with respect to the plane's own coordinates, which is how Heckbert's texture filter is defined.

use glam::{DMat2, DMat3, DVec2, DVec3};
use splatvol::{Alignment, Filter};
use splatvol_core::splats::GaussianProfile;

use super::splat::{FOCAL, Splat, covariance_of, norm, outline};
use crate::{
    Axis, Curve, Expectation, Experiment, Finding, LabError, Outcome, Plot, Published, Table, Workbench,
};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "zwicker2001-flattening",
    paper: "zwicker2001",
    title: "From volume kernels to surface kernels",
    figures: &["Fig. 5", "Fig. 6", "Section 5"],
    about: "The paper flattens a spherical kernel by s along the surface's normal and shows that its footprint \
            becomes that of a circular kernel in the plane, `V = T2D T2D^T` (eq. 23 and 24), for infinite s, and that \
            this is Heckbert's texture filter.\n\n\
            We take a kernel 20 degrees off the axis whose normal is tilted by 5, 20, 45 and 85 degrees against the \
            ray, and flatten it by 1 to 256. We measure how far the covariance of the engine's footprint is from eq. \
            24, which is evaluated in 64 bits. The paper shows the limit only; that it is approached as 1 / s^2 \
            follows from its matrix elements. T2D itself is checked against the numerical derivative of the \
            perspective picture of the plane.",
    run,
};

/// Angles between the normal and the ray, degrees.
const TILTS: [f64; 4] = [5.0, 20.0, 45.0, 85.0];

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let mut outcome = Outcome::default();
    bench.step(0, 1, "flattening");
    convergence(&mut outcome)?;
    limits(&mut outcome)?;
    outcome.plots.push(outlines(70.0)?);
    Ok(outcome)
}

/// A kernel 20 degrees off the axis whose z axis is tilted against the ray.
fn splat(tilt: f64) -> Splat {
    let ray = DVec3::new(20f64.to_radians().tan(), 0.0, 1.0);
    let across = DVec3::new(1.0, 2.0, 0.0);
    let across = (across - ray * across.dot(ray) / ray.length_squared()).normalize();
    let (sin, cos) = tilt.to_radians().sin_cos();
    let normal = ray.normalize() * cos + across * sin;
    let first = normal.any_orthonormal_vector();
    let frame = DMat3::from_cols(first, normal.cross(first), normal) * 0.02;
    Splat::sphere(ray, frame)
}

/// The engine's covariance.
fn covariance(splat: &Splat) -> Result<DMat2, LabError> {
    let profile = GaussianProfile::new(4.0);
    covariance_of(&splat.footprint(Filter::None, Alignment::Affine, &profile)?)
}

/// Distance of the kernel flattened by `flatness` from the limit, share of the limit's norm.
fn distance(tilt: f64, flatness: f64) -> Result<f64, LabError> {
    let splat = splat(tilt);
    let limit = splat.covariance(f64::INFINITY);
    Ok(norm(covariance(&splat.flattened(flatness))? - limit) / norm(limit))
}

fn convergence(outcome: &mut Outcome) -> Result<(), LabError> {
    let mut table = Table::new(
        "convergence",
        "Fig. 5",
        "Distance of the footprint's covariance from that of the surface kernel",
        &["tilt (degrees)", "flatness s", "distance (share of the limit)"],
    )
    .hidden();
    let mut plot = Plot::curves(
        "convergence",
        "Fig. 5",
        "Convergence to the surface kernel of eq. 23 and 24",
        Axis::logarithmic("flatness s").range(1.0, 300.0),
        Axis::logarithmic("distance from the limit (share of it)").range(1e-8, 100.0),
    );
    for tilt in TILTS {
        let mut points = Vec::new();
        for exponent in 0..=16 {
            let flatness = 2f64.powf(0.5 * f64::from(exponent));
            let found = distance(tilt, flatness)?;
            points.push([flatness, found.max(1e-8)]);
            table.row([tilt.into(), flatness.into(), found.into()]);
        }
        plot = plot.curve(Curve::new(&format!("normal tilted {tilt} degrees"), points).dots());
    }
    let theory = [1.0, 256.0].map(|s: f64| [s, 0.01 * s.powi(-2)]);
    outcome
        .plots
        .push(plot.curve(Curve::new("slope -2", theory).dashed()));
    outcome.tables.push(table);
    for tilt in TILTS {
        let order = (distance(tilt, 2.0)? / distance(tilt, 32.0)?).log2() / 4.0;
        outcome.find(
            Finding::new(
                "Fig. 5",
                &format!("order-{tilt}-degrees"),
                &format!(
                    "order in 1 / s of the distance from the limit, s 2 to 32, normal tilted {tilt} degrees"
                ),
                order,
                Expectation::Near {
                    value: 2.0,
                    within: 0.05,
                },
            )
            .published(Published::Claim(
                "matrix elements differ from the limit by t t / s^2".to_owned(),
            )),
        );
    }
    Ok(())
}

fn limits(outcome: &mut Outcome) -> Result<(), LabError> {
    let worst = |measure: &dyn Fn(f64) -> Result<f64, LabError>| {
        TILTS
            .into_iter()
            .try_fold(0.0f64, |worst, tilt| Ok::<_, LabError>(worst.max(measure(tilt)?)))
    };
    let flat = worst(&|tilt| distance(tilt, f64::INFINITY))?;
    outcome.find(
        Finding::new(
            "Fig. 5",
            "infinite-flatness",
            "distance of the engine's infinitely flat kernel from eq. 24, share of it, largest of all tilts",
            flat,
            Expectation::AtMost(1e-4),
        )
        .published(Published::Claim("s = infinity: a circular 2D kernel".to_owned())),
    );
    let round = worst(&|tilt| {
        let splat = splat(tilt);
        let [sphere, flattened] = [covariance(&splat)?, covariance(&splat.flattened(1.0))?];
        Ok(norm(sphere - flattened) / norm(sphere))
    })?;
    outcome.find(
        Finding::new(
            "Fig. 5",
            "no-flatness",
            "distance of the kernel with s = 1 from the sphere, share of it",
            round,
            Expectation::AtMost(1e-6),
        )
        .published(Published::Claim("s = 1: a spherical 3D kernel".to_owned())),
    );
    let texture = worst(&|tilt| {
        let splat = splat(tilt);
        let t = plane_derivative(&splat);
        let filter = t * t.transpose();
        Ok(norm(filter - covariance(&splat.flattened(f64::INFINITY))?) / norm(filter))
    })?;
    outcome.find(
        Finding::new(
            "Fig. 6",
            "texture-filter",
            "distance of the flat kernel from Heckbert's texture filter, by numerical derivatives of the plane's picture",
            texture,
            Expectation::AtMost(1e-4),
        )
        .published(Published::Claim("equivalent to Heckbert's EWA filter".to_owned())),
    );
    let enough = (0..=60)
        .map(|i| 2f64.powf(0.25 * f64::from(i)))
        .try_fold(f64::NAN, |found, s| {
            match found.is_nan() && worst(&|tilt| distance(tilt, s))? <= 0.01 {
                true => Ok::<_, LabError>(s),
                false => Ok(found),
            }
        })?;
    outcome.find(
        Finding::new(
            "Section 5",
            "flat-enough",
            "least s from which on covariances are within 1 % of the limit, up to 85 degrees",
            enough,
            Expectation::AtMost(16.0),
        )
        .detail("quarter octaves"),
    );
    Ok(())
}

/// The derivative of the picture of the plane through the kernel with respect to the plane's coordinates, by central
/// differences of the exact perspective.
fn plane_derivative(splat: &Splat) -> DMat2 {
    let project = |u: DVec3| DVec2::new(u.x, u.y) * (FOCAL / u.z);
    let along = |axis: DVec3| {
        const STEP: f64 = 1e-5;
        (project(splat.centre + axis * STEP) - project(splat.centre - axis * STEP)) / (2.0 * STEP)
    };
    let w = splat.camera_from_object;
    DMat2::from_cols(along(w.x_axis), along(w.y_axis))
}

/// Fig. 5 as a plot: footprints of a kernel that gets flatter.
fn outlines(tilt: f64) -> Result<Plot, LabError> {
    let splat = splat(tilt);
    let mut plot = Plot::curves(
        "outlines",
        "Fig. 5",
        &format!(
            "Footprints of a kernel that gets flatter, one standard deviation; normal tilted {tilt} degrees"
        ),
        Axis::new("x (pixels)").range(-40.0, 40.0),
        Axis::new("y (pixels)").range(-24.0, 24.0),
    );
    for flatness in [1.0, 2.0, 4.0] {
        let covariance = covariance(&splat.flattened(flatness))?;
        plot = plot.curve(Curve::new(&format!("s = {flatness}"), outline(covariance)));
    }
    let limit = outline(splat.covariance(f64::INFINITY));
    Ok(plot.curve(Curve::new("surface kernel (eq. 24)", limit).dashed()))
}
