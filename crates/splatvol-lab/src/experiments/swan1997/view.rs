//! Common parts of the pictures of Fig. 7: a view, the filters compared on it, the distance k, and pictures sampled at
//! more than one sample per pixel.

use splatvol::{
    Camera, Filter, FlatSettings, Frame, Image, ImageSize, Lighting, Projection, RenderSettings, Renderer,
    Scene, SceneError,
};

use super::window::Window;
use crate::LabError;
use crate::measure::{Spectrum, luminance};

/// A filter with its key in findings and its name in tables.
pub(super) struct Method {
    pub(super) key: &'static str,
    pub(super) name: &'static str,
    pub(super) filter: Filter,
}

/// Standard splatting; the paper's method with the energy of a splat taken as its extinction, and as its opacity, as
/// section 5 has it; and the filter of zwicker2001.
pub(super) const METHODS: [Method; 4] = [
    Method {
        key: "plain",
        name: "plain",
        filter: Filter::None,
    },
    Method {
        key: "swan",
        name: "swan",
        filter: Filter::Swan,
    },
    Method {
        key: "swan-alpha",
        name: "swan, by alpha",
        filter: Filter::SwanAlpha,
    },
    Method {
        key: "ewa",
        name: "ewa",
        filter: Filter::Ewa { pixel_sigma: 0.55 },
    },
];

/// Scene, camera and picture size.
pub(super) struct View {
    pub(super) scene: Scene,
    pub(super) camera: Camera,
    pub(super) size: ImageSize,
    pub(super) lighting: Option<Lighting>,
}

impl View {
    /// The paper's splats (section 5) with a filter.
    fn settings(&self, filter: Filter, size: ImageSize) -> Result<RenderSettings, SceneError> {
        RenderSettings::try_from(FlatSettings {
            size,
            filter,
            lighting: self.lighting,
            ..RenderSettings::swan1997().into()
        })
    }

    /// `k = s D / p` (eq. 3), camera depth: D / p are the pixels per unit of slope.
    pub(super) fn k(&self) -> Result<f64, LabError> {
        let spacing = self.scene.single_volume()?.volume.grid().mean_spacing();
        Ok(spacing * self.camera.screen_from_camera(self.size).scale)
    }

    /// The picture, as the paper has it.
    pub(super) fn frame(&self, renderer: &mut Renderer, filter: Filter) -> Result<Frame, LabError> {
        Ok(renderer.render(&self.scene, &self.camera, &self.settings(filter, self.size)?)?)
    }

    /// This view from another camera.
    pub(super) fn seen_from(&self, camera: Camera) -> Self {
        Self {
            scene: self.scene.clone(),
            camera,
            ..*self
        }
    }

    /// This view made so faint that splats only add up: a thousandth of the extinction.
    pub(super) fn faint(&self) -> Result<Self, LabError> {
        let mut scene = self.scene.clone();
        let distance = 1000.0 * self.scene.single_volume()?.unit_distance();
        scene.transfer_function_mut()?.unit_distance = Some(distance);
        Ok(Self { scene, ..*self })
    }

    /// The function of place that the picture samples, sampled at half pixels: in pictures larger by one pixel the
    /// axis, and with it all samples, is shifted by half a pixel. Splats are exactly the same; only the samples differ.
    pub(super) fn at_half_pixels(&self, renderer: &mut Renderer, filter: Filter) -> Result<Fine, LabError> {
        let [width, height] = <[u32; 2]>::from(self.size);
        let (columns, rows) = (2 * width as usize, 2 * height as usize);
        let mut values = vec![0.0; columns * rows];
        for phase in 0..4_usize {
            let [x, y] = [phase % 2, phase / 2];
            // The sample half a pixel before the first is that of the larger picture.
            let size = ImageSize::new(width + 1 - x as u32, height + 1 - y as u32)?;
            let camera = self.as_wide_per_pixel(size)?;
            let frame = renderer.render(&self.scene, &camera, &self.settings(filter, size)?)?;
            let light = luminance(&frame.image);
            for row in 0..height as usize {
                for column in 0..width as usize {
                    values[(2 * row + y) * columns + 2 * column + x] =
                        light[row * size.width() as usize + column];
                }
            }
        }
        Ok(Fine {
            per_pixel: 2,
            width: columns,
            luminance: values,
        })
    }

    /// The camera for another size that shows as much per pixel.
    fn as_wide_per_pixel(&self, size: ImageSize) -> Result<Camera, LabError> {
        let scale = self.camera.screen_from_camera(self.size).scale;
        let projection = match self.camera.projection() {
            Projection::Perspective { .. } => Projection::Perspective {
                fov_degrees: 2.0 * (0.5 * f64::from(size.height()) / scale).atan().to_degrees(),
            },
            Projection::Orthographic { .. } => Projection::Orthographic {
                height: f64::from(size.height()) / scale,
            },
        };
        let camera = &self.camera;
        Ok(Camera::new(
            camera.position(),
            camera.target(),
            camera.up(),
            projection,
        )?)
    }

    /// The picture with `per_pixel` squared samples in every pixel. Filters in pixels keep their width in the
    /// picture's pixels, except swan's, which would stretch to these samples instead: see [`View::at_half_pixels`].
    pub(super) fn sampled(
        &self,
        renderer: &mut Renderer,
        filter: Filter,
        per_pixel: u32,
    ) -> Result<Image, LabError> {
        let filter = match filter {
            Filter::Ewa { pixel_sigma } => Filter::Ewa {
                pixel_sigma: pixel_sigma * f64::from(per_pixel),
            },
            Filter::None => Filter::None,
            other => {
                return Err(LabError::Measurement(format!(
                    "{other:?} is as wide as a sample, whatever the pixels"
                )));
            }
        };
        let [width, height] = <[u32; 2]>::from(self.size);
        let size = ImageSize::new(per_pixel * width, per_pixel * height)?;
        Ok(renderer
            .render(&self.scene, &self.camera, &self.settings(filter, size)?)?
            .image)
    }
}

/// A picture's luminance, sampled finer than by pixels.
pub(super) struct Fine {
    per_pixel: usize,
    width: usize,
    luminance: Vec<f64>,
}

impl Fine {
    /// Luminance of a picture of `per_pixel` squared samples per pixel.
    pub(super) fn of(image: &Image, per_pixel: u32) -> Self {
        Self {
            per_pixel: per_pixel as usize,
            width: image.size().width() as usize,
            luminance: luminance(image),
        }
    }

    /// Samples per pixel and axis.
    pub(super) fn per_pixel(&self) -> usize {
        self.per_pixel
    }

    /// Means of the samples in each pixel of a window, taken `down` samples farther down.
    pub(super) fn means(&self, window: &Window, down: isize) -> Vec<f64> {
        let n = self.per_pixel;
        let height = self.luminance.len() / self.width;
        let row_mean = |row: usize, column: usize| {
            let row = row.saturating_add_signed(down).min(height - 1);
            let samples = &self.luminance[row * self.width + column * n..][..n];
            samples.iter().sum::<f64>() / n as f64
        };
        let rows = window.rows.clone();
        rows.flat_map(|row| window.columns.clone().map(move |column| (row, column)))
            .map(|(row, column)| (0..n).map(|y| row_mean(row * n + y, column)).sum::<f64>() / n as f64)
            .collect()
    }

    /// Its power spectrum inside a window, frequencies in cycles per pixel.
    pub(super) fn spectrum(&self, window: &Window) -> PixelSpectrum {
        let n = self.per_pixel;
        let columns = window.columns.start * n..window.columns.end * n;
        let rows = window.rows.start * n..window.rows.end * n;
        let values: Vec<f64> = rows
            .flat_map(|row| &self.luminance[row * self.width..][columns.clone()])
            .copied()
            .collect();
        PixelSpectrum {
            per_pixel: n as f64,
            spectrum: Spectrum::of(&values, columns.len()),
        }
    }
}

/// A power spectrum whose frequencies count per pixel.
pub(super) struct PixelSpectrum {
    per_pixel: f64,
    spectrum: Spectrum,
}

impl PixelSpectrum {
    /// The larger component of a frequency along rows and columns, cycles per pixel: above a half, the raster cannot
    /// represent it.
    fn along_axes(&self, [x, y]: [f64; 2]) -> f64 {
        x.abs().max(y.abs()) * self.per_pixel
    }

    /// Power above a frequency in cycles per pixel, without that of the mean. Half a cycle is the pixels' Nyquist
    /// limit: higher frequencies alias.
    pub(super) fn power_above(&self, limit: f64) -> f64 {
        self.spectrum
            .power(|frequency| self.along_axes(frequency) > limit)
    }

    /// Power in bands of a width, up to a frequency: middle and power of each.
    pub(super) fn bands(&self, width: f64, end: f64) -> Vec<[f64; 2]> {
        let mut bands: Vec<[f64; 2]> = (0..(end / width).round() as usize)
            .map(|band| [(band as f64 + 0.5) * width, 0.0])
            .collect();
        for (frequency, power) in self.spectrum.iter() {
            let band = (self.along_axes(frequency) / width) as usize;
            if let Some(band) = bands.get_mut(band) {
                band[1] += power;
            }
        }
        bands
    }
}
