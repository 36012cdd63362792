//! The signal of Fig. 5: waves along a row of voxels, and spectra line by line.

use std::f64::consts::TAU;

use glam::DVec3;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;
use splatvol::{
    ColorPoint, Grid, LengthUnit, OpacityPoint, Rescale, Samples, Scene, TransferFunction, Volume,
};
use splatvol_testing::Random;

use crate::LabError;

/// Voxels of a period.
pub(super) const PERIOD: usize = 128;
/// Waves of the signal: up to `w = WAVES / PERIOD` cycles per voxel.
pub(super) const WAVES: usize = 51;
/// Opacity of the value 1: small, so that extinction is in proportion to the values.
pub(super) const OPACITY: f64 = 1e-3;

/// Amplitude of each wave, that of the mean being 1: falling, as in the drawing.
pub(super) fn amplitudes() -> Vec<f64> {
    let shape = |wave: usize| match wave {
        0 => 0.0,
        _ if wave > WAVES => 0.0,
        _ => 1.0 - 0.6 * wave as f64 / WAVES as f64,
    };
    let sum: f64 = (0..PERIOD / 2).map(shape).sum();
    // If all waves met, they would just reach 0.
    (0..PERIOD / 2).map(|wave| shape(wave) / sum).collect()
}

/// Three periods of the signal, the same along y.
pub(super) fn scene(amplitudes: &[f64]) -> Result<Scene, LabError> {
    const ROWS: usize = 25;
    let mut random = Random::new(5);
    let phases: Vec<f64> = amplitudes.iter().map(|_| random.range(0.0, TAU)).collect();
    let value = |x: usize| {
        let waves = amplitudes.iter().zip(&phases).enumerate();
        let sum: f64 = waves
            .map(|(wave, (amplitude, phase))| {
                amplitude * (TAU * (wave * x) as f64 / PERIOD as f64 + phase).cos()
            })
            .sum();
        (0.5 + 0.5 * sum) as f32
    };
    let dims = [3 * PERIOD, ROWS, 1];
    let mut values: Vec<f32> = (0..dims[0] * dims[1])
        .map(|index| value(index % dims[0]))
        .collect();
    // The corners, which no picture reaches, hold 0 and 1, so that stored values are those above.
    values[0] = 0.0;
    values[1] = 1.0;
    let volume = Volume::new(
        Grid::centred(dims, DVec3::ONE)?,
        Samples::F32(values.into()),
        Rescale::default(),
        LengthUnit::Unknown,
    )?;
    let look = TransferFunction::new(
        vec![ColorPoint::new(0.0, [1.0; 3])],
        vec![OpacityPoint::new(0.0, 0.0), OpacityPoint::new(1.0, OPACITY)],
        Some(1.0),
    )?;
    Ok(Scene::new(volume, look))
}

/// Amplitudes of the lines of one period, over the mean.
pub(super) fn spectrum(values: &[f64]) -> Vec<f64> {
    let mut line: Vec<Complex64> = values.iter().map(|&value| value.into()).collect();
    FftPlanner::new().plan_fft_forward(line.len()).process(&mut line);
    let mean = line[0].norm();
    line[..values.len() / 2]
        .iter()
        .enumerate()
        .map(|(wave, value)| value.norm() / mean * if wave == 0 { 1.0 } else { 2.0 })
        .collect()
}

/// Amplitude of the samples' spectrum at a line: the signal's and its repetitions, or those of the mean.
pub(super) fn repeated(amplitudes: &[f64], line: usize) -> f64 {
    let within = line % PERIOD;
    if within == 0 && line > 0 {
        // It has two sides, the mean itself only one.
        return 2.0;
    }
    amplitudes
        .get(within.min(PERIOD - within))
        .copied()
        .unwrap_or(0.0)
}
