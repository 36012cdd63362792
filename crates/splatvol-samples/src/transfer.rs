//! A transfer function for each sample.

use splatvol_scene::{ColorPoint, OpacityPoint, SceneError, TransferFunction};

use crate::Sample;
use crate::terrain;
use crate::textures::{DARK, LIGHT};
use crate::tomato::{FLESH, GEL, SEED};

pub(crate) fn transfer_function(sample: Sample) -> Result<TransferFunction, SceneError> {
    let (dark, light) = (f64::from(DARK), f64::from(LIGHT));
    match sample {
        Sample::Head => head(),
        // Red and white, as in both papers.
        Sample::CheckerSheet => curves(
            &[(dark, [0.75, 0.1, 0.1]), (light, [1.0, 1.0, 1.0])],
            &[(0.0, 0.0), (0.5 * dark, 0.999), (light, 0.999)],
        ),
        Sample::Tunnel => curves(
            &[(dark, [0.75, 0.1, 0.1]), (light, [1.0, 1.0, 1.0])],
            &[(0.3 * dark, 0.0), (0.8 * dark, 0.95), (light, 0.95)],
        ),
        Sample::Zebra => curves(
            &[(dark, [0.05, 0.05, 0.05]), (light, [1.0, 1.0, 1.0])],
            &[(0.0, 0.0), (0.5 * dark, 0.999), (light, 0.999)],
        ),
        Sample::Shells => curves(
            &[
                (20.0, [0.30, 0.50, 0.95]),
                (110.0, [0.35, 0.60, 1.0]),
                (150.0, [1.0, 0.72, 0.30]),
                (250.0, [0.90, 0.20, 0.15]),
            ],
            &[
                (4.0, 0.0),
                (60.0, 0.004),
                (110.0, 0.012),
                (130.0, 0.02),
                (180.0, 0.12),
                (250.0, 0.8),
            ],
        ),
        Sample::Terrain => terrain(),
        Sample::Tomato => tomato(),
        Sample::Microtubules => curves(
            &[
                (60.0, [0.15, 0.35, 0.25]),
                (150.0, [0.35, 0.85, 0.45]),
                (235.0, [0.90, 1.0, 0.75]),
            ],
            &[(40.0, 0.0), (110.0, 0.15), (200.0, 0.6), (255.0, 0.8)],
        ),
        Sample::Nerve => curves(
            &[
                (60.0, [0.75, 0.35, 0.15]),
                (150.0, [0.95, 0.65, 0.25]),
                (235.0, [1.0, 0.92, 0.70]),
            ],
            &[(50.0, 0.0), (100.0, 0.08), (140.0, 0.5), (255.0, 0.8)],
        ),
        // The iso-surface 0.5 of Marschner and Lobb.
        Sample::MarschnerLobb => curves(
            &[(0.0, [0.85, 0.65, 0.45]), (1.0, [0.85, 0.65, 0.45])],
            &[(0.49, 0.0), (0.51, 0.95), (1.0, 0.95)],
        ),
        Sample::Ball => curves(
            &[
                (0.0, [0.25, 0.45, 0.85]),
                (0.5, [0.9, 0.9, 0.9]),
                (1.0, [0.85, 0.25, 0.2]),
            ],
            &[(0.0, 0.0), (0.5, 0.02), (1.0, 0.3)],
        ),
        Sample::Slab => curves(
            &[
                (0.0, [0.25, 0.45, 0.85]),
                (0.5, [0.9, 0.9, 0.9]),
                (1.0, [0.85, 0.25, 0.2]),
            ],
            &[(0.0, 0.0), (1.0, 0.3)],
        ),
    }
}

/// Translucent skin over opaque bone. Skin shows where air turns to tissue (-700 to -200 HU), so that the tissue
/// below stays clear.
fn head() -> Result<TransferFunction, SceneError> {
    let colors = [
        (-700.0, [0.86, 0.58, 0.46]),
        (-150.0, [0.93, 0.68, 0.55]),
        (120.0, [0.80, 0.36, 0.28]),
        (260.0, [0.93, 0.82, 0.66]),
        (700.0, [0.97, 0.92, 0.82]),
        (1350.0, [0.98, 0.95, 0.89]),
        (1700.0, [1.0, 1.0, 0.98]),
    ];
    let opacities = [
        (-720.0, 0.0),
        (-450.0, 0.22),
        (-180.0, 0.02),
        (-60.0, 0.002),
        (120.0, 0.006),
        (210.0, 0.02),
        (420.0, 0.75),
        (1000.0, 0.97),
    ];
    build(&colors, &opacities, Some(1.0))
}

/// A palette: every value has its colour, and is nearly opaque.
fn terrain() -> Result<TransferFunction, SceneError> {
    let colors: Vec<(f64, [f64; 3])> = (1..)
        .zip(terrain::palette())
        .map(|(value, rgb)| (f64::from(value), rgb))
        .collect();
    curves(&colors, &[(0.0, 0.0), (0.5, 0.95), (255.0, 0.95)])
}

/// Translucent red skin where air turns to flesh, clear gel and flesh, opaque seeds.
fn tomato() -> Result<TransferFunction, SceneError> {
    let [gel, flesh, seed] = [GEL, FLESH, SEED].map(f64::from);
    let colors = [
        (20.0, [0.90, 0.12, 0.06]),
        (55.0, [0.88, 0.14, 0.07]),
        (gel, [0.55, 0.68, 0.16]),
        (flesh - 25.0, [0.95, 0.38, 0.16]),
        (flesh + 30.0, [0.90, 0.22, 0.12]),
        (seed - 30.0, [0.98, 0.90, 0.58]),
        (255.0, [1.0, 0.96, 0.75]),
    ];
    let opacities = [
        (15.0, 0.0),
        (38.0, 0.10),
        (58.0, 0.012),
        (gel, 0.010),
        (flesh - 35.0, 0.016),
        (flesh, 0.028),
        (flesh + 35.0, 0.03),
        (seed - 30.0, 0.7),
        (255.0, 0.85),
    ];
    build(&colors, &opacities, None)
}

fn curves(colors: &[(f64, [f64; 3])], opacities: &[(f64, f64)]) -> Result<TransferFunction, SceneError> {
    build(colors, opacities, None)
}

fn build(
    colors: &[(f64, [f64; 3])],
    opacities: &[(f64, f64)],
    unit_distance: Option<f64>,
) -> Result<TransferFunction, SceneError> {
    TransferFunction::new(
        colors
            .iter()
            .map(|&(value, rgb)| ColorPoint::new(value, rgb))
            .collect(),
        opacities
            .iter()
            .map(|&(value, opacity)| OpacityPoint::new(value, opacity))
            .collect(),
        unit_distance,
    )
}
