//! The texture, one voxel of it, and the camera.

use glam::{DMat3, DVec2, DVec3};
use splatvol::{
    Camera, ColorPoint, Filter, FlatSettings, Grid, ImageSize, Kernel, LengthUnit, OpacityPoint, Projection,
    RenderSettings, Rescale, Samples, Scene, TransferFunction, Volume,
};
use splatvol_samples::{Sample, SampleSize};

use crate::{LabError, Workbench};

/// A texture of one ratio, and the picture of it.
pub(super) struct Case {
    /// Length of a voxel over its width.
    pub(super) ratio: usize,
    /// Side of the square, widths of a voxel.
    pub(super) side: usize,
    /// Picture size, pixels.
    pub(super) size: [u32; 2],
}

/// The settings of the paper, without light, with kernels cut at this many standard deviations.
pub(super) fn settings(
    [width, height]: [u32; 2],
    filter: Filter,
    cut: f64,
) -> Result<RenderSettings, LabError> {
    Ok(RenderSettings::try_from(FlatSettings {
        size: ImageSize::new(width, height)?,
        filter,
        kernel: Kernel::Gaussian {
            sigma: 1.0,
            radius: cut,
        },
        lighting: None,
        termination: 0.0,
        ..RenderSettings::ewa2001().into()
    })?)
}

impl Case {
    /// The case of this ratio, in the bench's size.
    pub(super) fn of(bench: &Workbench<'_>, ratio: usize) -> Self {
        let (side, size) = bench.choose((1024, [400, 150]), (256, [100, 38]));
        Self { ratio, side, size }
    }

    /// The camera, 60 degrees above the square.
    pub(super) fn camera(&self) -> Result<Camera, LabError> {
        let side = self.side as f64;
        let height = 0.55 * side;
        let ahead = height / 60f64.to_radians().tan();
        let eye = DVec3::new(0.0, -0.37 * side, height);
        let target = DVec3::new(0.0, eye.y + ahead, 0.0);
        let projection = Projection::Perspective { fov_degrees: 40.0 };
        Ok(Camera::new(eye, target, DVec3::Y, projection)?)
    }

    fn dims(&self) -> [usize; 3] {
        [self.side, self.side / self.ratio, 3]
    }

    fn spacing(&self) -> DVec3 {
        DVec3::new(1.0, self.ratio as f64, 1.0)
    }

    /// The texture, square in the world.
    pub(super) fn texture(&self) -> Result<Scene, LabError> {
        let sample = Sample::Zebra;
        let stripes = sample.generate(Some(SampleSize::Dims(self.dims())))?;
        let grid = Grid::centred(self.dims(), self.spacing())?;
        let volume = Volume::new(grid, stripes.samples().clone(), stripes.rescale(), stripes.unit())?;
        Ok(Scene::new(volume, sample.default_transfer_function()?))
    }

    /// One voxel in the middle of the picture, moved by a part of a pixel's width.
    pub(super) fn voxel(&self, shift: DVec2) -> Result<Scene, LabError> {
        let camera = self.camera()?;
        let pixel = (camera.target() - camera.position()).length() / self.pixels_per_radian();
        let origin = camera.target() + (shift * pixel).extend(0.0) - self.spacing();
        let grid = Grid::new([3; 3], origin, self.spacing(), DMat3::IDENTITY)?;
        let mut values = vec![0; 27];
        values[13] = 1;
        let volume = Volume::new(
            grid,
            Samples::U8(values.into()),
            Rescale::default(),
            LengthUnit::Unknown,
        )?;
        let look = TransferFunction::new(
            vec![ColorPoint::new(0.0, [1.0; 3])],
            vec![OpacityPoint::new(0.0, 0.0), OpacityPoint::new(1.0, 0.5)],
            None,
        )?;
        Ok(Scene::new(volume, look))
    }

    fn pixels_per_radian(&self) -> f64 {
        0.5 * f64::from(self.size[1]) / 20f64.to_radians().tan()
    }

    /// The dims in words.
    pub(super) fn name(&self) -> String {
        let [x, y, z] = self.dims();
        format!("{x} x {y} x {z}")
    }
}
