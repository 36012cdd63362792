//! A volcano and its surroundings: 256 x 256 measured heights and a photograph of 2048 x 2048 pixels from a satellite,
//! as Kitware's vtk-js keeps them (`Data/elevation/dem.csv`, `dem.jpg`, BSD-3-Clause). Heights are interpolated to the
//! number of columns and stretched to that of layers, as their unit is not stated; the photograph's colours become a
//! palette of 255. It is seen from the north, where the plain lies, so that mountains are behind.

use color_quant::NeuQuant;
use glam::DVec3;
use splatvol::{ColorPoint, Grid, OpacityPoint, Points, Scene, TransferFunction};
use splatvol_io::{HeightFieldOptions, read_height_field};

use super::Columns;
use crate::{LabError, Workbench};

/// Posts of the file along each axis.
const POSTS: f64 = 256.0;

/// Colours of the palette: values 1 to 255, 0 is air.
const COLORS: usize = 255;

pub(super) fn scene(bench: &Workbench<'_>, dims: [usize; 3]) -> Result<Scene, LabError> {
    let [nx, ny, nz] = dims;
    let heights = bench.data("terrain/dem.csv")?;
    let options = HeightFieldOptions {
        // Columns are 1 apart once they are interpolated, and so flat that none needs points on its faces.
        spacing: Some([nx, ny].map(|n| n as f64 / POSTS)),
        height_scale: Some(1e-3),
        posts: Some([nx, ny]),
        color_image: Some(bench.data("terrain/dem.jpg")?),
        ..HeightFieldOptions::default()
    };
    let points = read_height_field(heights, &options)?.points;
    let columns = Photographed::of(&points, [nx, ny])?;
    let tops = columns.tops(nz);
    let (values, palette) = palette(&columns.colors);
    let grid = Grid::centred(dims, DVec3::ONE)?;
    let volume = Columns::new([nx, ny], tops, values).volume(&grid, 1)?;
    Ok(Scene::new(volume, palette?))
}

/// Heights and colours of columns, along x to the west, then along y to the south.
struct Photographed {
    heights: Vec<f64>,
    colors: Vec<[u8; 4]>,
}

impl Photographed {
    /// Heights and colours of the points that are posts: their positions are whole numbers.
    fn of(points: &Points, [nx, ny]: [usize; 2]) -> Result<Self, LabError> {
        let mut columns = Self {
            heights: vec![f64::NAN; nx * ny],
            colors: vec![[0; 4]; nx * ny],
        };
        for (&[x, y, z], &color) in points.positions().iter().zip(&points.attributes().colors) {
            if x.fract() == 0.0 && y.fract() == 0.0 {
                let column = nx * ny - 1 - (y as usize * nx + x as usize);
                columns.heights[column] = f64::from(z);
                columns.colors[column] = color;
            }
        }
        match columns.heights.iter().all(|height| height.is_finite()) {
            true => Ok(columns),
            false => Err(LabError::Measurement(
                "the terrain's heights have gaps".to_owned(),
            )),
        }
    }

    /// Heights as layers of `nz`.
    fn tops(&self, nz: usize) -> Vec<usize> {
        let least = self.heights.iter().copied().fold(f64::INFINITY, f64::min);
        let most = self.heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let scale = (nz - 1) as f64 / (most - least).max(f64::MIN_POSITIVE);
        let top = |height: &f64| ((height - least) * scale).round() as usize;
        self.heights.iter().map(top).collect()
    }
}

/// The value of each colour, and what values look like: nearly opaque, as the built-in terrain.
fn palette(colors: &[[u8; 4]]) -> (Vec<u8>, Result<TransferFunction, LabError>) {
    let quantiser = NeuQuant::new(1, COLORS, colors.as_flattened());
    let values = colors
        .iter()
        .map(|color| quantiser.index_of(color) as u8 + 1)
        .collect();
    let entries = quantiser.color_map_rgb();
    let points = (1..)
        .zip(entries.as_chunks::<3>().0)
        .map(|(value, rgb)| ColorPoint::new(f64::from(value), rgb.map(|code| f64::from(code) / 255.0)));
    let opacities =
        [(0.0, 0.0), (0.5, 0.95), (255.0, 0.95)].map(|(value, alpha)| OpacityPoint::new(value, alpha));
    let look = TransferFunction::new(points.collect(), opacities.to_vec(), None);
    (values, look.map_err(LabError::from))
}
