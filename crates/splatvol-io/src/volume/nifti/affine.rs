//! `world_from_voxel` of NIfTI: the sform where its code is positive, else the qform, else the bare pixdim.
//!
//! World is RAS+ by definition of the format. The qform is `R diag(dx, dy, qfac dz)` with R of the unit quaternion
//! `(a, b, c, d)`, `a = sqrt(1 - b^2 - c^2 - d^2)`, and qfac = -1 where `pixdim[0] < 0`.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::header::Header;
use crate::IoError;
use crate::error::Context;

/// Rounding may make a quaternion longer than 1, by at most this.
const QUATERNION_SLACK: f64 = 1e-3;
/// Below this, the remainder for `a^2` is the rounding error of a half turn (the limit of the reference
/// implementation).
const HALF_TURN: f64 = 1e-7;
/// sform and qform count as different if they move a corner by more than this share of a voxel.
const NOTABLE: f64 = 0.1;

/// The map and its warnings.
#[derive(Debug)]
pub(super) struct Orientation {
    pub(super) world_from_voxel: DAffine3,
    /// `sform (aligned)`.
    pub(super) source: String,
    /// Whether the file has one of the two orientations.
    pub(super) oriented: bool,
    pub(super) warnings: Vec<String>,
}

/// Chooses between the three maps.
pub(super) fn orientation(
    header: &Header,
    dims: [usize; 3],
    context: &Context<'_>,
) -> Result<Orientation, IoError> {
    let mut warnings = Vec::new();
    for (code, name) in [
        (header.qform_code, "qform_code"),
        (header.sform_code, "sform_code"),
    ] {
        if !(0..=5).contains(&code) {
            warnings.push(format!("{name} {code} is not defined"));
        }
    }
    if header.sform_code > 0 {
        let sform = sform(header, context)?;
        if header.qform_code > 0 {
            match qform(header, &mut Vec::new(), context) {
                Ok(qform) => warnings.extend(compare(sform, qform, dims)),
                Err(_) => warnings.push("the qform is invalid; the sform is used".to_owned()),
            }
        }
        return Ok(Orientation {
            world_from_voxel: sform,
            source: format!("sform ({})", code_name(header.sform_code)),
            oriented: true,
            warnings,
        });
    }
    if header.qform_code > 0 {
        return Ok(Orientation {
            world_from_voxel: qform(header, &mut warnings, context)?,
            source: format!("qform ({})", code_name(header.qform_code)),
            oriented: true,
            warnings,
        });
    }
    warnings.push("neither sform nor qform: which side is left is not known".to_owned());
    let spacing = spacing(header, &mut warnings, context)?;
    Ok(Orientation {
        world_from_voxel: DAffine3::from_mat3(DMat3::from_diagonal(spacing)),
        source: "pixdim only".to_owned(),
        oriented: false,
        warnings,
    })
}

fn code_name(code: i32) -> &'static str {
    match code {
        1 => "scanner",
        2 => "aligned",
        3 => "Talairach",
        4 => "MNI 152",
        5 => "template",
        _ => "unknown code",
    }
}

fn sform(header: &Header, context: &Context<'_>) -> Result<DAffine3, IoError> {
    if let Some(index) = header.srow.iter().position(|value| !value.is_finite()) {
        let name = ["srow_x", "srow_y", "srow_z"][index / 4];
        let place = header.float_place(header.places.srow, index);
        return Err(context.field(name, header.srow[index], place, "finite numbers"));
    }
    let column = |i: usize| DVec3::new(header.srow[i], header.srow[4 + i], header.srow[8 + i]);
    Ok(DAffine3::from_cols(column(0), column(1), column(2), column(3)))
}

fn qform(header: &Header, warnings: &mut Vec<String>, context: &Context<'_>) -> Result<DAffine3, IoError> {
    let [b, c, d] = header.quatern;
    let rest = 1.0 - (b * b + c * c + d * d);
    if rest.is_nan() || rest < -QUATERNION_SLACK {
        let place = header.places.quatern as u64;
        let shown = format!("{b} {c} {d}");
        return Err(context.field("quatern_b, _c, _d", shown, place, "a vector of length 1 or less"));
    }
    let offset = DVec3::from_array(header.qoffset);
    if !offset.is_finite() {
        let place = header.places.qoffset as u64;
        return Err(context.field("qoffset_x, _y, _z", offset, place, "finite numbers"));
    }
    let a = if rest < HALF_TURN { 0.0 } else { rest.sqrt() };
    let rotation = DMat3::from_quat(DQuat::from_xyzw(b, c, d, a).normalize());
    let handedness = if header.pixdim[0] < 0.0 { -1.0 } else { 1.0 };
    let spacing = spacing(header, warnings, context)? * DVec3::new(1.0, 1.0, handedness);
    Ok(DAffine3::from_mat3_translation(
        rotation * DMat3::from_diagonal(spacing),
        offset,
    ))
}

/// `pixdim[1..4]`, repaired (with a warning) where it is zero or negative.
fn spacing(header: &Header, warnings: &mut Vec<String>, context: &Context<'_>) -> Result<DVec3, IoError> {
    let mut spacing = DVec3::ONE;
    for axis in 0..3 {
        let name = format!("pixdim[{}]", axis + 1);
        let value = header.pixdim[axis + 1];
        if !value.is_finite() {
            let place = header.float_place(header.places.pixdim, axis + 1);
            return Err(context.field(name, value, place, "a positive number"));
        }
        spacing[axis] = if value == 0.0 { 1.0 } else { value.abs() };
        // The spacing of an axis of one sample does not matter.
        if value <= 0.0 && header.dim[axis + 1] > 1 && axis < header.dim[0] as usize {
            warnings.push(format!("{name} is {value}: {} is used", spacing[axis]));
        }
    }
    Ok(spacing)
}

/// A warning if the two maps put a corner of the volume at notably different places.
fn compare(sform: DAffine3, qform: DAffine3, dims: [usize; 3]) -> Option<String> {
    let mut distance: f64 = 0.0;
    for corner in 0..8 {
        let at = |axis: usize| {
            if corner >> axis & 1 == 1 {
                dims[axis] as f64 - 1.0
            } else {
                0.0
            }
        };
        let voxel = DVec3::new(at(0), at(1), at(2));
        distance = distance.max(
            sform
                .transform_point3(voxel)
                .distance(qform.transform_point3(voxel)),
        );
    }
    let voxel = sform.matrix3.determinant().abs().cbrt();
    (distance > NOTABLE * voxel)
        .then(|| format!("sform and qform differ by up to {distance:.3} (world length); the sform is used"))
}
