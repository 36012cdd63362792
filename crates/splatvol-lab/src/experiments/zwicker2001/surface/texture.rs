//! The texture: as a volume, as discs, and itself, in 64 bits.

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};
use rayon::prelude::*;
use splatvol::transfer_function::linear_from_srgb;
use splatvol::{
    Camera, Grid, ImageSize, Item, PointAttributes, PointLook, Points, Projection, Scene, TransferFunction,
    Volume,
};
use splatvol_samples::{Sample, SampleSize};

use super::{CUT, ELEVATION, FOV, Plane, SAMPLES};
use crate::LabError;

/// The texture and the picture of it.
pub(super) struct Case {
    /// Texels per side.
    side: usize,
    /// Picture size, pixels.
    pub(super) size: [u32; 2],
    /// Three slices of it.
    pub(super) volume: Arc<Volume>,
    /// Its colours.
    pub(super) look: TransferFunction,
}

impl Case {
    /// The texture of a side, for a picture.
    pub(super) fn new(side: usize, size: [u32; 2]) -> Result<Self, LabError> {
        let dims = [side, side, 3];
        let stripes = Sample::Zebra.generate(Some(SampleSize::Dims(dims)))?;
        let grid = Grid::centred(dims, DVec3::ONE)?;
        let volume = Volume::new(grid, stripes.samples().clone(), stripes.rescale(), stripes.unit())?;
        Ok(Self {
            side,
            size,
            volume: Arc::new(volume),
            look: Sample::Zebra.default_transfer_function()?,
        })
    }

    /// The camera, above the near side.
    pub(super) fn camera(&self) -> Result<Camera, LabError> {
        let side = self.side as f64;
        let height = 0.35 * side;
        let eye = DVec3::new(0.0, -0.7 * side, height);
        let target = DVec3::new(0.0, eye.y + height / ELEVATION.to_radians().tan(), 0.0);
        let projection = Projection::Perspective { fov_degrees: FOV };
        Ok(Camera::new(eye, target, DVec3::Z, projection)?)
    }

    /// sRGB of the texels of the middle slice, in eight bits.
    fn texels(&self) -> Vec<[u8; 3]> {
        let slice = self.side * self.side;
        (slice..2 * slice)
            .map(|index| self.look.color(self.volume.value(index)))
            .map(|rgb| rgb.map(|level| (255.0 * level).round() as u8))
            .collect()
    }

    /// Discs in the plane, whose standard deviation, .6 of the radius, is one voxel.
    pub(super) fn surface(&self) -> Result<Scene, LabError> {
        let grid = self.volume.grid();
        let slice = self.side * self.side;
        let place = |i: usize| {
            let voxel = DVec3::new((i % self.side) as f64, (i / self.side) as f64, 1.0);
            grid.world_from_voxel()
                .transform_point3(voxel)
                .as_vec3()
                .to_array()
        };
        let attributes = PointAttributes {
            colors: self
                .texels()
                .into_iter()
                .map(|[r, g, b]| [r, g, b, 255])
                .collect(),
            normals: vec![[0.0, 0.0, 1.0]; slice],
            radii: vec![1.0 / 0.6; slice],
        };
        let points = Points::new((0..slice).map(place).collect(), attributes, DAffine3::IDENTITY)?;
        Ok(Scene::of_items(vec![Item::points(points, PointLook::default())])?)
    }

    /// The texture's green in linear light and its coverage, 16 samples per pixel.
    pub(super) fn truth(&self) -> Result<[Plane; 2], LabError> {
        let [width, height] = self.size.map(|side| side as usize * SAMPLES);
        let camera = self.camera()?;
        let screen = camera.screen_from_camera(ImageSize::new(width as u32, height as u32)?);
        let world_from_camera = camera.camera_from_world().inverse();
        let voxel_from_world = self.volume.grid().world_from_voxel().inverse();
        let green: Vec<f64> = self
            .texels()
            .iter()
            .map(|[_, g, _]| linear_from_srgb(f64::from(*g) / 255.0))
            .collect();
        let value = |index: usize| {
            let pixel = DVec2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
            let (origin, direction) = screen.ray(pixel);
            let origin = voxel_from_world.transform_point3(world_from_camera.transform_point3(origin));
            let direction =
                voxel_from_world.transform_vector3(world_from_camera.transform_vector3(direction));
            // The middle slice.
            let along = (1.0 - origin.z) / direction.z;
            match along > 0.0 {
                true => self.reconstructed(&green, (origin + direction * along).truncate()),
                false => [0.0; 2],
            }
        };
        let values: Vec<[f64; 2]> = (0..width * height).into_par_iter().map(value).collect();
        Ok([0, 1].map(|channel| Plane {
            width,
            values: values.iter().map(|value| value[channel]).collect(),
        }))
    }

    /// `sum c g / sum g` at a place of the plane, voxels, and 1; nothing outside the texture.
    fn reconstructed(&self, colors: &[f64], at: DVec2) -> [f64; 2] {
        let last = self.side as f64 - 0.5;
        if !(at.min_element() >= -0.5 && at.max_element() <= last) {
            return [0.0; 2];
        }
        let first = |at: f64| (at - CUT).ceil().max(0.0) as usize;
        let end = |at: f64| ((at + CUT).floor() as usize + 1).min(self.side);
        let (mut sum, mut total) = (0.0, 0.0);
        for y in first(at.y)..end(at.y) {
            for x in first(at.x)..end(at.x) {
                let weight = (-0.5 * at.distance_squared(DVec2::new(x as f64, y as f64))).exp();
                sum += weight * colors[y * self.side + x];
                total += weight;
            }
        }
        [sum / total, 1.0]
    }
}
