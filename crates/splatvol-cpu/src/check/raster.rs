//! Checks whether a rasteriser can draw the footprints of a grid in a view.

use glam::DMat3;
use splatvol_scene::{Alignment, Camera, Projection, Rasterizer, SceneError, SingleVolume, SplatSettings};

/// Relative difference of squared widths below which they count as equal: half of it in the radius.
const SAME: f64 = 2e-3;

/// Rejects a rasteriser for a view whose footprints it cannot draw.
///
/// # Errors
/// The rasteriser by name, with the reason and what to use.
pub(super) fn check(
    single: &SingleVolume<'_>,
    camera: &Camera,
    splats: &SplatSettings,
) -> Result<(), SceneError> {
    let refuse = |expected| {
        Err(SceneError::InvalidField {
            field: "rasterizer",
            value: splats.rasterizer.name().to_owned(),
            expected,
        })
    };
    let perspective = matches!(camera.projection(), Projection::Perspective { .. });
    if splats.rasterizer.has_table() && perspective && splats.alignment == Alignment::Exact {
        return refuse(
            "auto: alignment exact integrates along every pixel's own ray, which leaves no conic to look up; \
             or alignment affine or grid",
        );
    }
    if !splats.rasterizer.draws_circles() {
        return Ok(());
    }
    if perspective && splats.alignment != Alignment::Grid {
        return refuse(
            "ellipse-1d, linear-1d or auto: perspective makes ellipses of all directions, and this rasterizer draws \
             circles; or alignment grid",
        );
    }
    let linear = camera.camera_from_world().matrix3
        * single.item.world_from_item.matrix3
        * single.volume.grid().world_from_voxel().matrix3;
    let covariance = linear * linear.transpose();
    let rlut = matches!(splats.rasterizer, Rasterizer::Rlut { .. });
    if is_sphere(covariance) || (rlut && is_upright(covariance)) {
        return Ok(());
    }
    refuse(if rlut {
        "ellipse-1d, linear-1d or auto: voxels are not cubes and not seen along the picture's axes, so footprints are \
         turned ellipses, and this rasterizer draws circles and upright ellipses"
    } else {
        "ellipse-1d, linear-1d or auto: voxels are not cubes, so footprints are ellipses, and this rasterizer draws circles"
    })
}

fn is_sphere(m: DMat3) -> bool {
    let mean = (m.x_axis.x + m.y_axis.y + m.z_axis.z) / 3.0;
    (m - DMat3::from_diagonal(glam::DVec3::splat(mean)))
        .to_cols_array()
        .iter()
        .all(|difference| difference.abs() <= SAME * mean)
}

/// Whether the outline on the picture is an ellipse along its axes.
fn is_upright(m: DMat3) -> bool {
    m.x_axis.y.abs() <= SAME * m.x_axis.x.min(m.y_axis.y)
}
