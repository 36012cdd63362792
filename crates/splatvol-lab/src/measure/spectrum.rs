//! The power spectrum of a picture: `|DFT|^2 / n^2`, whose sum is the mean square (Parseval).

use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;

/// Power by frequency.
#[derive(Debug, Clone)]
pub(crate) struct Spectrum {
    width: usize,
    height: usize,
    power: Vec<f64>,
}

impl Spectrum {
    /// Spectrum of values in rows of `width`. Their mean is subtracted first. A Hann window keeps the border, where the
    /// periodic repetition jumps, from spreading over all frequencies.
    pub(crate) fn of(values: &[f64], width: usize) -> Self {
        let height = values.len() / width.max(1);
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let mut grid: Vec<Complex64> = values
            .iter()
            .enumerate()
            .map(|(index, value)| (value - mean) * hann(index % width, width) * hann(index / width, height))
            .map(Complex64::from)
            .collect();
        transform_rows(&mut grid, width);
        let mut grid = transposed(&grid, width);
        transform_rows(&mut grid, height);
        let grid = transposed(&grid, height);
        let scale = 1.0 / (values.len().max(1) as f64).powi(2);
        Self {
            width,
            height,
            power: grid.iter().map(|value| value.norm_sqr() * scale).collect(),
        }
    }

    /// Power and frequency in cycles per pixel, each of x and y in -0.5..0.5.
    pub(crate) fn iter(&self) -> impl Iterator<Item = ([f64; 2], f64)> + '_ {
        let frequency = |index: usize, n: usize| match index * 2 < n {
            true => index as f64 / n as f64,
            false => index as f64 / n as f64 - 1.0,
        };
        self.power.iter().enumerate().map(move |(index, &power)| {
            let [x, y] = [index % self.width, index / self.width];
            ([frequency(x, self.width), frequency(y, self.height)], power)
        })
    }

    /// Power of all frequencies that a test accepts.
    pub(crate) fn power(&self, of: impl Fn([f64; 2]) -> bool) -> f64 {
        self.iter()
            .filter(|(frequency, _)| of(*frequency))
            .map(|(_, power)| power)
            .sum()
    }
}

fn hann(index: usize, n: usize) -> f64 {
    let phase = (index as f64 + 0.5) / n.max(1) as f64;
    0.5 - 0.5 * (std::f64::consts::TAU * phase).cos()
}

fn transform_rows(grid: &mut [Complex64], width: usize) {
    FftPlanner::new().plan_fft_forward(width).process(grid);
}

fn transposed(grid: &[Complex64], width: usize) -> Vec<Complex64> {
    let height = grid.len() / width;
    (0..grid.len())
        .map(|index| grid[index % height * width + index / height])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wave_stands_at_its_frequency() {
        let [width, height] = [64, 48];
        let wave = |index: usize| {
            let [x, y] = [index % width, index / width];
            (std::f64::consts::TAU * (x as f64 * 0.25 + y as f64 * 0.125)).sin()
        };
        let values: Vec<f64> = (0..width * height).map(wave).collect();
        let spectrum = Spectrum::of(&values, width);
        let near = |[x, y]: [f64; 2]| {
            let distance = |sign: f64| (x - 0.25 * sign).hypot(y - 0.125 * sign);
            distance(1.0).min(distance(-1.0)) < 0.05
        };
        let all = spectrum.power(|_| true);
        assert!(spectrum.power(near) > 0.999 * all);
        // The mean square of a sine, 1/2, under the window's own, (3/8)^2.
        assert!((all - 0.5 * 0.375 * 0.375).abs() < 1e-3, "{all}");
    }
}
