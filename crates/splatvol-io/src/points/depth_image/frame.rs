//! One frame: depths, colours, and the points they make in camera space.

use std::io::Cursor;
use std::path::Path;

use glam::DVec3;

use super::{Entry, Intrinsics};
use crate::error::Context;
use crate::points::height_field::picture;
use crate::source::read_file;
use crate::{IoError, ReadOptions, image, volume};

/// Deflate turns one byte into at most 1032.
const RATIO: u64 = 1032;

/// Depths of a camera's pixels, rows from the top.
pub(super) struct Frame {
    pub(super) size: [usize; 2],
    /// World lengths along the view direction; NaN where empty.
    pub(super) depths: Vec<f64>,
    /// Empty without a colour picture.
    pub(super) colors: Vec<[u8; 4]>,
    pub(super) stored_type: &'static str,
}

impl Frame {
    pub(super) fn read(entry: &Entry) -> Result<Self, IoError> {
        let mut frame = depths(&entry.depth)?;
        for depth in &mut frame.depths {
            *depth *= entry.depth_unit;
            if !(depth.is_finite() && *depth > 0.0) {
                *depth = f64::NAN;
            }
        }
        if let Some(path) = &entry.color {
            let picture = picture(path)?;
            let found = [picture.width, picture.height];
            if found != frame.size {
                let [width, height] = frame.size;
                let found = format!("{} x {}", found[0], found[1]);
                let expected = format!("{width} x {height}, as the depths");
                return Err(Context::new("picture", path).field("size", found, None, expected));
            }
            frame.colors = picture.pixels;
        }
        Ok(frame)
    }

    /// Place of a pixel's point, camera space; `None` where empty.
    pub(super) fn place(&self, pixel: usize, camera: &Intrinsics) -> Option<DVec3> {
        let depth = self.depths[pixel];
        let (u, v) = ((pixel % self.size[0]) as f64, (pixel / self.size[0]) as f64);
        let direction = DVec3::new((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
        (!depth.is_nan()).then(|| direction * depth)
    }

    /// Unit normal, camera space, on the camera's side. If a neighbour is missing, the difference to the other one
    /// serves; if both are, the surface is taken to face the camera.
    pub(super) fn normal(&self, pixel: usize, camera: &Intrinsics, jump: f64) -> DVec3 {
        let [width, height] = self.size;
        let Some(here) = self.place(pixel, camera) else {
            return DVec3::ZERO;
        };
        let neighbor = |there: bool, index: usize| {
            let place = there.then(|| self.place(index, camera)).flatten()?;
            ((place.z - here.z).abs() <= jump * place.z.min(here.z)).then_some(place)
        };
        let difference = |position: usize, size: usize, stride: usize| {
            let before = neighbor(position > 0, pixel.wrapping_sub(stride)).unwrap_or(here);
            let after = neighbor(position + 1 < size, pixel + stride).unwrap_or(here);
            after - before
        };
        let right = difference(pixel % width, width, 1);
        let down = difference(pixel / width, height, width);
        // x right, y down, z forward: right x down points away from the camera.
        let normal = down.cross(right).normalize_or((-here).normalize());
        if normal.dot(here) > 0.0 { -normal } else { normal }
    }
}

fn depths(path: &Path) -> Result<Frame, IoError> {
    let context = &Context::new("depth image", path);
    let bytes = read_file(path, context)?;
    let (size, depths, stored_type) = match bytes.as_slice() {
        [0x89, b'P', b'N', b'G', ..] => png(&bytes, path)?,
        [0x76, 0x2f, 0x31, 0x01, ..] => {
            let (size, depths) = image::exr::decode_depth(&bytes, path)?;
            (size, depths.into_iter().map(f64::from).collect(), "EXR")
        }
        [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => npy(path, context)?,
        _ => return Err(context.unsupported("depths are PNG, .npy or EXR files")),
    };
    Ok(Frame {
        size,
        depths,
        colors: Vec::new(),
        stored_type,
    })
}

type Depths = ([usize; 2], Vec<f64>, &'static str);

fn npy(path: &Path, context: &Context<'_>) -> Result<Depths, IoError> {
    let volume = volume::npy::read(path, &ReadOptions::default())?.volume;
    let [width, height, layers] = volume.grid().dims();
    if layers != 1 {
        return Err(context.field(
            "shape",
            format!("{layers} layers"),
            None,
            "an array of rows and columns",
        ));
    }
    let depths = (0..width * height).map(|index| volume.value(index)).collect();
    Ok(([width, height], depths, ".npy"))
}

/// Codes of a grey PNG as numbers, without gamma.
fn png(bytes: &[u8], path: &Path) -> Result<Depths, IoError> {
    let context = &Context::new("PNG", path);
    let malformed = |error: png::DecodingError| context.field("contents", error, None, "a valid PNG");
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::IDENTITY);
    let info = decoder.read_header_info().map_err(malformed)?;
    let (width, height) = info.size();
    let (color, depth) = (info.color_type, info.bit_depth);
    let stored_type = match (color, depth) {
        (png::ColorType::Grayscale, png::BitDepth::Sixteen) => "PNG of 16 bits",
        (png::ColorType::Grayscale, png::BitDepth::Eight) => "PNG of 8 bits",
        _ => {
            return Err(context.unsupported(format!(
                "{color:?} of {depth:?} bits; depths are grey, of 16 or 8 bits"
            )));
        }
    };
    let pixels = u64::from(width).saturating_mul(u64::from(height));
    let at_most = (bytes.len() as u64).saturating_mul(RATIO);
    if pixels > at_most {
        return Err(context.too_small("pixels", pixels, at_most));
    }
    let mut reader = decoder.read_info().map_err(malformed)?;
    let length = reader
        .output_buffer_size()
        .ok_or_else(|| context.limit(u64::MAX, usize::MAX as u64))?;
    let mut data = vec![0; length];
    reader.next_frame(&mut data).map_err(malformed)?;
    let depths = match depth {
        png::BitDepth::Sixteen => data
            .chunks_exact(2)
            .map(|pair| f64::from(u16::from_be_bytes([pair[0], pair[1]])))
            .collect(),
        _ => data.into_iter().map(f64::from).collect(),
    };
    Ok(([width as usize, height as usize], depths, stored_type))
}
