//! Columns of splats under a surface.

use splatvol::{Grid, LengthUnit, Rescale, Samples, Volume};

use crate::LabError;

/// The ground as seen from above: the top of every column, and its value.
pub(in crate::experiments) struct Columns {
    /// Columns along x and along y.
    dims: [usize; 2],
    /// Uppermost splat of each column.
    tops: Vec<usize>,
    /// Value of each column.
    values: Vec<u8>,
}

impl Columns {
    /// Columns along x, then along y.
    pub(super) fn new(dims: [usize; 2], tops: Vec<usize>, values: Vec<u8>) -> Self {
        Self { dims, tops, values }
    }

    /// Columns of a volume of bytes in which 0 is air.
    pub(in crate::experiments) fn of(volume: &Volume) -> Result<Self, LabError> {
        let Samples::U8(samples) = volume.samples() else {
            return Err(LabError::Measurement(
                "the ground's samples are no bytes".to_owned(),
            ));
        };
        let [nx, ny, nz] = volume.grid().dims();
        let layer = nx * ny;
        let top = |column: usize| (0..nz).rfind(|z| samples[z * layer + column] > 0).unwrap_or(0);
        let tops: Vec<usize> = (0..layer).map(top).collect();
        let values = (0..layer)
            .map(|column| samples[tops[column] * layer + column])
            .collect();
        Ok(Self::new([nx, ny], tops, values))
    }

    /// Mean of the uppermost splats' indices along z.
    pub(in crate::experiments) fn mean_top(&self) -> f64 {
        self.tops.iter().sum::<usize>() as f64 / self.tops.len() as f64
    }

    /// Index along z of the highest column of the near edge, y = 0.
    pub(in crate::experiments) fn highest_near(&self) -> usize {
        self.tops[..self.dims[0]].iter().copied().fold(0, usize::max)
    }

    /// The splats on `grid`: each column from its top down to `below` the lowest of its eight neighbours', so that
    /// steep ground has no holes.
    pub(in crate::experiments) fn volume(&self, grid: &Grid, below: usize) -> Result<Volume, LabError> {
        let layer = self.tops.len();
        let mut samples = vec![0; grid.sample_count()];
        for (column, (&top, &value)) in self.tops.iter().zip(&self.values).enumerate() {
            let bottom = self.lowest_beside(column).saturating_sub(below);
            for z in bottom..=top {
                samples[z * layer + column] = value;
            }
        }
        Ok(Volume::new(
            grid.clone(),
            Samples::U8(samples.into()),
            Rescale::default(),
            LengthUnit::default(),
        )?)
    }

    /// Least top of a column and its eight neighbours.
    fn lowest_beside(&self, column: usize) -> usize {
        let [nx, ny] = self.dims;
        let [x, y] = [column % nx, column / nx];
        let rows = y.saturating_sub(1)..=(y + 1).min(ny - 1);
        rows.flat_map(|y| {
            let columns = x.saturating_sub(1)..=(x + 1).min(nx - 1);
            columns.map(move |x| self.tops[y * nx + x])
        })
        .fold(self.tops[column], usize::min)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn a_step_is_filled_down_to_the_lower_side() {
        let columns = Columns::new([4, 1], vec![1, 1, 5, 5], vec![7, 7, 8, 9]);
        let grid = Grid::centred([4, 1, 6], DVec3::ONE).unwrap();
        let volume = columns.volume(&grid, 0).unwrap();
        let filled: Vec<(usize, f64)> = (0..24)
            .map(|i| (i, volume.value(i)))
            .filter(|(_, v)| *v > 0.0)
            .collect();
        let expected = [
            (4, 7.0),
            (5, 7.0),
            (6, 8.0),
            (10, 8.0),
            (14, 8.0),
            (18, 8.0),
            (22, 8.0),
            (23, 9.0),
        ];
        assert_eq!(filled, expected);
        let again = Columns::of(&columns.volume(&grid, 1).unwrap()).unwrap();
        assert_eq!((again.tops, again.values), (columns.tops, columns.values));
    }
}
