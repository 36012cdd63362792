//! Writers of Gaussians: the attributes are first transformed to the frame of the format.

use std::path::Path;

use splatvol_scene::{GaussianAttributes, Gaussians};

use super::frame::{self, Frame, RDF, RUB};
use super::harmonics::{DEGREE_0, harmonics_count};
use super::{detect, spz, transform};
use crate::IoError;
use crate::error::Context;

/// Opacities of 0 and 1 have no finite logit; this far from them, neither 8 bits nor floats differ.
const OPACITY_MARGIN: f64 = 1e-7;
/// Logarithm of the scale of flat Gaussians.
const FLAT: f64 = -30.0;

/// Writes to `path` in the format of its extension.
pub(super) fn write(path: &Path, gaussians: &Gaussians) -> Result<(), IoError> {
    let context = Context::new("Gaussians", path);
    let extension = detect::extension(path);
    let bytes = match extension.as_str() {
        "ply" => ply(&in_frame(RDF, gaussians, &context)?, gaussians),
        "splat" => splat(&in_frame(RDF, gaussians, &context)?, gaussians.degree()),
        "spz" => {
            let attributes = in_frame(RUB, gaussians, &context)?;
            spz::encode(&attributes, gaussians.degree(), gaussians.antialiased())?
        }
        other => {
            return Err(context.unsupported(format!(
                "no writer for the extension \"{other}\" (.ply, .splat and .spz have one)"
            )));
        }
    };
    std::fs::write(path, bytes).map_err(|source| IoError::Write {
        source,
        path: path.to_owned(),
    })
}

/// The attributes as numbers of a file with that frame.
fn in_frame(
    frame: Frame,
    gaussians: &Gaussians,
    context: &Context<'_>,
) -> Result<GaussianAttributes, IoError> {
    let file_from_local = frame::world_from_local(frame).inverse() * *gaussians.world_from_local();
    let mut attributes = gaussians.attributes().clone();
    if transform::transform(&mut attributes, gaussians.degree(), &file_from_local) {
        return Ok(attributes);
    }
    Err(context.unsupported("only rotations, mirrors, shifts and one scale for all axes can be written"))
}

fn ply(attributes: &GaussianAttributes, gaussians: &Gaussians) -> Vec<u8> {
    let rest = 3 * (harmonics_count(gaussians.degree()) - 1);
    let comment = if gaussians.antialiased() {
        "comment antialiased\n"
    } else {
        ""
    };
    let mut header = format!(
        "ply\nformat binary_little_endian 1.0\n{comment}element vertex {}\n",
        attributes.means.len()
    );
    let names = ["x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"];
    let names = names
        .map(str::to_owned)
        .into_iter()
        .chain((0..rest).map(|i| format!("f_rest_{i}")));
    let last = [
        "opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3",
    ];
    for name in names.chain(last.map(str::to_owned)) {
        header.push_str(&format!("property float {name}\n"));
    }
    header.push_str("end_header\n");
    let mut bytes = header.into_bytes();
    let each = attributes
        .harmonics
        .chunks_exact(harmonics_count(gaussians.degree()));
    for (index, harmonics) in each.enumerate() {
        let mut put = |value: f32| bytes.extend(value.to_le_bytes());
        attributes.means[index]
            .into_iter()
            .chain([0.0; 3])
            .for_each(&mut put);
        harmonics[0].into_iter().for_each(&mut put);
        (0..3)
            .flat_map(|color| harmonics[1..].iter().map(move |triple| triple[color]))
            .for_each(&mut put);
        let opacity = f64::from(attributes.opacities[index]).clamp(OPACITY_MARGIN, 1.0 - OPACITY_MARGIN);
        put((opacity / (1.0 - opacity)).ln() as f32);
        attributes.scales[index]
            .map(|s| f64::from(s).ln().max(FLAT) as f32)
            .into_iter()
            .for_each(&mut put);
        let [x, y, z, w] = attributes.rotations[index];
        [w, x, y, z].into_iter().for_each(&mut put);
    }
    bytes
}

fn splat(attributes: &GaussianAttributes, degree: u32) -> Vec<u8> {
    let byte = |value: f64| value.round().clamp(0.0, 255.0) as u8;
    let mut bytes = Vec::with_capacity(super::splat::SIZE * attributes.means.len());
    for (index, harmonics) in attributes
        .harmonics
        .chunks_exact(harmonics_count(degree))
        .enumerate()
    {
        for value in attributes.means[index]
            .into_iter()
            .chain(attributes.scales[index])
        {
            bytes.extend(value.to_le_bytes());
        }
        bytes.extend(harmonics[0].map(|c| byte((0.5 + DEGREE_0 * f64::from(c)) * 255.0)));
        bytes.push(byte(f64::from(attributes.opacities[index]) * 255.0));
        let [x, y, z, w] = attributes.rotations[index];
        bytes.extend([w, x, y, z].map(|c| byte(f64::from(c) * 128.0 + 128.0)));
    }
    bytes
}
