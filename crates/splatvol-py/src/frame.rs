//! The picture that was rendered: floats, codes, files. Every way out has one buffer.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyBytes, PyDict};
use splatvol::transfer_function::linear_from_srgb;
use splatvol::{Image, ImageSize, RenderStatistics, SceneError};
use splatvol_document::{Document, Record};
use splatvol_io::image::png::srgb8;
use splatvol_io::{DepthFormat, ImageFormat, encode_depth, encode_image, read_image};

use crate::error::{Raise, refused};
use crate::{array, picture, work};

/// A rendered picture.
#[pyclass(frozen)]
#[derive(Debug)]
pub(crate) struct Frame {
    frame: splatvol::Frame,
    /// sRGB and straight alpha; `None` where the picture keeps its alpha.
    background: Option<[f64; 4]>,
    /// Whether the floats hold the background: published Gaussians are blended with it in display space.
    is_blended: bool,
    statistics: RenderStatistics,
}

impl Frame {
    pub(crate) fn new(frame: splatvol::Frame, background: Option<[f64; 4]>) -> Self {
        Self {
            frame,
            background,
            is_blended: false,
            statistics: RenderStatistics::default(),
        }
    }

    pub(crate) fn of_render(self, is_blended: bool, statistics: RenderStatistics) -> Self {
        Self {
            is_blended,
            statistics,
            ..self
        }
    }

    /// Size of the picture.
    pub(crate) fn image_size(&self) -> ImageSize {
        self.frame.image.size()
    }

    /// Whether the picture lets through what is behind it.
    pub(crate) fn has_alpha(&self) -> bool {
        self.background.is_none_or(|[.., alpha]| alpha < 1.0)
    }

    /// The picture over its background.
    pub(crate) fn shown(&self) -> Image {
        match self.background {
            None => self.frame.image.clone(),
            Some([r, g, b, a]) => {
                let [r, g, b] = [r, g, b].map(|c| linear_from_srgb(c) as f32);
                self.frame.image.over([r, g, b, a as f32])
            }
        }
    }
}

/// Size, linear pixels, depth, optical depth, background.
type Planes<'py> = (
    (u32, u32),
    Bound<'py, PyByteArray>,
    Bound<'py, PyByteArray>,
    Bound<'py, PyByteArray>,
    Option<[f64; 4]>,
);

/// A picture of the means of `step` x `step` pixels.
fn reduced(image: &Image, step: usize) -> Result<Image, SceneError> {
    let [width, height] = [image.size().width(), image.size().height()].map(|n| n as usize);
    let size = ImageSize::new((width.div_ceil(step)) as u32, (height.div_ceil(step)) as u32)?;
    let mut pixels = Vec::with_capacity(size.pixel_count());
    for y in (0..height).step_by(step) {
        for x in (0..width).step_by(step) {
            let mut sum = [0.0f32; 4];
            let mut count = 0.0;
            for (x, y) in
                (y..height.min(y + step)).flat_map(|y| (x..width.min(x + step)).map(move |x| (x, y)))
            {
                let pixel = image.pixel(x, y);
                sum = std::array::from_fn(|c| sum[c] + pixel[c]);
                count += 1.0;
            }
            pixels.push(sum.map(|channel| channel / count));
        }
    }
    Image::from_pixels(size, pixels)
}

/// Bytes of numbers, as this processor orders them.
fn bytes_of<'py, const N: usize>(
    py: Python<'py>,
    numbers: impl ExactSizeIterator<Item = [f32; N]>,
) -> PyResult<Bound<'py, PyByteArray>> {
    PyByteArray::new_with(py, numbers.len() * N * size_of::<f32>(), |bytes| {
        for (to, numbers) in bytes.chunks_exact_mut(N * size_of::<f32>()).zip(numbers) {
            for (to, number) in to.chunks_exact_mut(size_of::<f32>()).zip(numbers) {
                to.copy_from_slice(&number.to_ne_bytes());
            }
        }
        Ok(())
    })
}

#[pymethods]
impl Frame {
    /// Width and height, pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        let size = self.frame.image.size();
        (size.width(), size.height())
    }

    /// uint8, height x width x 4: sRGB, straight alpha, over the background; the codes of an 8-bit PNG.
    fn codes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyByteArray>> {
        let codes = py.detach(|| srgb8(&self.shown()));
        PyByteArray::new_with(py, codes.len() * 4, |bytes| {
            bytes.copy_from_slice(codes.as_flattened());
            Ok(())
        })
    }

    /// float32, height x width x 4: linear, premultiplied, without background.
    fn linear<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyByteArray>> {
        bytes_of(py, self.frame.image.pixels.iter().copied())
    }

    /// float32, height x width: depth along the view, world lengths; infinite where there is nothing.
    fn depth<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyByteArray>> {
        bytes_of(py, self.frame.depth.iter().map(|&depth| [depth]))
    }

    /// float32, height x width: optical depth, `-ln` of the transmittance.
    fn optical_depth<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyByteArray>> {
        bytes_of(py, self.frame.optical_depth.iter().map(|&depth| [depth]))
    }

    /// Times and counts, as a dictionary.
    fn statistics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        picture::statistics(py, &self.statistics)
    }

    /// The bytes of a file, by its extension: `.png` (over the background) or `.exr` (floats, alpha and depth). It carries the
    /// document, JSON, and says what made it.
    fn encode<'py>(
        &self,
        py: Python<'py>,
        extension: &str,
        bits: u8,
        record: Option<(&str, String)>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let format = match (ImageFormat::from_path(Path::new(&format!("x.{extension}"))), bits) {
            (Some(ImageFormat::Png8), 16) => ImageFormat::Png16,
            (Some(format), 8 | 16) => format,
            (Some(_), _) => return Err(refused("bits", format!("bits: {bits} is not allowed (8 or 16)"))),
            (None, _) => {
                let message =
                    format!("no picture format has the extension {extension:?} (png and exr have one)");
                return Err(refused("path", message));
            }
        };
        if self.is_blended && format == ImageFormat::Exr {
            let why = "3-D Gaussians are blended with their background, as published: background=\"none\" keeps alpha for .exr";
            return Err(refused("background", why));
        }
        let metadata = match record {
            Some((document, command)) => {
                let document = Document::from_json(document, "document".as_ref()).map_err(Raise::raised)?;
                Record { document, command }
                    .shortened(Path::new(""))
                    .metadata()
                    .map_err(Raise::raised)?
            }
            None => Vec::new(),
        };
        let bytes = work::run(py, (None, None), |_| {
            let encoded = match format {
                ImageFormat::Exr => {
                    encode_image(&self.frame.image, Some(&self.frame.depth), format, &metadata)
                }
                _ => encode_image(&self.shown(), None, format, &metadata),
            };
            encoded.map_err(Raise::raised)
        })?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// A PNG of every `step`th pixel across and down, each the mean of those around it.
    fn reduced_png<'py>(&self, py: Python<'py>, step: usize) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = work::run(py, (None, None), |_| {
            let reduced = reduced(&self.shown(), step.max(1)).map_err(Raise::raised)?;
            encode_image(&reduced, None, ImageFormat::Png8, &[]).map_err(Raise::raised)
        })?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// All that the frame holds: size, floats, depth, optical depth, background.
    fn planes<'py>(&self, py: Python<'py>) -> PyResult<Planes<'py>> {
        Ok((
            self.size(),
            self.linear(py)?,
            self.depth(py)?,
            self.optical_depth(py)?,
            self.background,
        ))
    }

    /// A frame of what [`Frame::planes`] gave.
    #[staticmethod]
    fn from_planes(
        size: (u32, u32),
        linear: &Bound<'_, PyAny>,
        depth: &Bound<'_, PyAny>,
        optical_depth: &Bound<'_, PyAny>,
        background: Option<[f64; 4]>,
    ) -> PyResult<Self> {
        let size = ImageSize::new(size.0, size.1).map_err(Raise::raised)?;
        let floats = |plane: &Bound<'_, PyAny>| -> PyResult<Vec<f32>> {
            let bytes = array::numbers::<u8>(plane)?;
            let (floats, _) = bytes.as_chunks::<4>();
            Ok(floats.iter().map(|&bytes| f32::from_ne_bytes(bytes)).collect())
        };
        let linear = floats(linear)?;
        let pixels = linear.as_chunks::<4>().0.to_vec();
        let frame = splatvol::Frame {
            image: Image::from_pixels(size, pixels).map_err(Raise::raised)?,
            depth: floats(depth)?,
            optical_depth: floats(optical_depth)?,
        };
        match frame.fits(size) {
            true => Ok(Self::new(frame, background)),
            false => Err(refused("planes", "the planes have different sizes")),
        }
    }

    /// The bytes of a file with the depths, by its extension.
    fn encode_depth<'py>(&self, py: Python<'py>, path: PathBuf) -> PyResult<Bound<'py, PyBytes>> {
        let format = DepthFormat::from_path(&path).ok_or_else(|| {
            refused(
                "path",
                format!("{}: no format of depths has this extension", path.display()),
            )
        })?;
        let size = self.frame.image.size();
        let bytes = encode_depth(&self.frame.depth, size, format, &[]).map_err(Raise::raised)?;
        Ok(PyBytes::new(py, &bytes))
    }
}

/// The pixels of a picture's file: width, height, and uint8 codes, height x width x 4.
#[pyfunction]
pub(crate) fn read_picture<'py>(
    py: Python<'py>,
    path: PathBuf,
) -> PyResult<(u32, u32, Bound<'py, PyByteArray>)> {
    let image = read_image(&path).map_err(Raise::raised)?.image;
    let codes = srgb8(&image);
    let bytes = PyByteArray::new(py, codes.as_flattened());
    Ok((image.size().width(), image.size().height(), bytes))
}
