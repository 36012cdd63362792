//! A single splat: its size on screen, and its mass.

use glam::{DVec2, DVec3};
use splatvol::{
    Camera, ColorPoint, Compositing, Filter, FlatSettings, Grid, ImageSize, LengthUnit, OpacityPoint,
    Projection, RenderSettings, Renderer, Rescale, Samples, Scene, TransferFunction, Volume,
};

use crate::LabError;

/// Rows of the pictures.
const ROWS: u32 = 33;

/// A voxel by itself, a unit from its neighbours, at the world's origin.
pub(super) struct Single {
    scene: Scene,
    /// D / p, pixels.
    pub(super) scale: f64,
    /// Shifts of the pixels per axis.
    pub(super) shifts: u32,
}

/// Measurements on the X-ray of a splat.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moments {
    /// Optical depth integrated over the picture, pixels squared.
    pub(super) mass: f64,
    /// Standard deviation along rows, which point away from the axis, and along columns, pixels.
    pub(super) deviation: DVec2,
    /// Largest optical depth.
    pub(super) peak: f64,
}

impl Single {
    /// A voxel seen with `scale` pixels per unit of slope.
    pub(super) fn new(scale: f64, shifts: u32) -> Result<Self, LabError> {
        let mut values = vec![0_u8; 27];
        values[13] = 1;
        let volume = Volume::new(
            Grid::centred([3; 3], DVec3::ONE)?,
            Samples::U8(values.into()),
            Rescale::default(),
            LengthUnit::Unknown,
        )?;
        let look = TransferFunction::new(
            vec![ColorPoint::new(0.0, [1.0; 3])],
            vec![OpacityPoint::new(0.0, 0.0), OpacityPoint::new(1.0, 0.5)],
            Some(1.0),
        )?;
        Ok(Self {
            scene: Scene::new(volume, look),
            scale,
            shifts,
        })
    }

    /// Moments of its X-ray at a camera depth, `angle` radians beside the axis.
    pub(super) fn moments(
        &self,
        renderer: &mut Renderer,
        filter: Filter,
        (depth, angle): (f64, f64),
    ) -> Result<Moments, LabError> {
        let aside = self.scale * angle.tan();
        let columns = 2 * aside.ceil() as u32 + ROWS;
        let size = ImageSize::new(columns, ROWS)?;
        let settings = RenderSettings::try_from(FlatSettings {
            size,
            filter,
            compositing: Compositing::Xray,
            lighting: None,
            ..RenderSettings::swan1997().into()
        })?;
        let fov_degrees = 2.0 * (0.5 * f64::from(ROWS) / self.scale).atan().to_degrees();
        let projection = Projection::Perspective { fov_degrees };
        let (mut mass, mut first, mut second) = (0.0, DVec2::ZERO, DVec2::ZERO);
        let mut peak = 0.0_f64;
        let shifts = self.shifts;
        for shift in 0..shifts * shifts {
            // With an even number of shifts one of them is zero, and the splat is in the middle of a pixel.
            let shift =
                DVec2::new(f64::from(shift % shifts), f64::from(shift / shifts)) / f64::from(shifts) - 0.5;
            // Where it is seen: x to the right, y down, from the middle of the picture.
            let centre = DVec2::new(aside, 0.0) + shift;
            let seen = depth * centre / self.scale;
            let position = DVec3::new(-seen.x, seen.y, depth);
            let camera = Camera::new(position, position - DVec3::Z, DVec3::Y, projection)?;
            let frame = renderer.render(&self.scene, &camera, &settings)?;
            for (index, &tau) in frame
                .optical_depth
                .iter()
                .enumerate()
                .filter(|(_, tau)| **tau > 0.0)
            {
                let pixel = DVec2::new((index as u32 % columns).into(), (index as u32 / columns).into());
                let at = pixel + 0.5 - 0.5 * DVec2::new(columns.into(), ROWS.into()) - centre;
                let tau = f64::from(tau);
                mass += tau;
                first += tau * at;
                second += tau * at * at;
                peak = peak.max(tau);
            }
        }
        if mass <= 0.0 {
            return Err(LabError::Measurement(format!("nothing is seen at depth {depth}")));
        }
        let mean = first / mass;
        let variance = second / mass - mean * mean;
        Ok(Moments {
            mass: mass / f64::from(shifts * shifts),
            deviation: DVec2::new(variance.x.sqrt(), variance.y.sqrt()),
            peak,
        })
    }
}
