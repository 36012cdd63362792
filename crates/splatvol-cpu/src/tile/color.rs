//! Pre-classification and X-ray: classified, lit voxels are integrated over slabs.

use glam::{DMat3, DVec3};
use splatvol_core::bin::TileRect;
use splatvol_core::footprint::{SlabSlicer, Slice};
use splatvol_scene::Compositing;

use super::{Canvas, Fate, Mode};
use crate::phong::Phong;
use crate::plan::FramePlan;
use crate::stage::activate::OpenVoxel;
use crate::stage::sheet_buffer::SheetBuffer;
use crate::stage::splat::ColorPayload;

/// Splats extinction and emission; composites slab by slab.
#[derive(Debug)]
pub(crate) struct ColorMode<'a> {
    plan: &'a FramePlan<'a>,
    slicer: SlabSlicer,
    lights: Option<Phong>,
    /// Gradients per voxel to gradients in camera space.
    camera_from_voxel_gradient: DMat3,
}

impl<'a> ColorMode<'a> {
    /// Mode of a frame.
    pub(crate) fn new(plan: &'a FramePlan<'a>) -> Self {
        let projector = &plan.projector;
        let lighting = plan.settings.lighting.as_ref();
        let lighting = lighting.filter(|_| plan.settings.compositing != Compositing::Xray);
        Self {
            plan,
            slicer: SlabSlicer::new(projector.shape, &projector.screen, projector.pixel_sigma),
            lights: lighting.map(|l| Phong::new(l, plan.mean_spacing)),
            camera_from_voxel_gradient: projector.camera_from_voxel.matrix3.inverse().transpose(),
        }
    }

    /// Gradient at a voxel, camera space, per world length.
    fn gradient(&self, index: usize, position: [usize; 3]) -> [f32; 3] {
        let difference = DVec3::from_array(self.plan.coefficients.difference(index, position).map(f64::from));
        (self.camera_from_voxel_gradient * difference)
            .as_vec3()
            .to_array()
    }
}

/// A slab's first and last depth.
type Slab = [f32; 2];

impl Mode for ColorMode<'_> {
    type Payload = [f32; 4];
    type Splat = ColorPayload;
    type Sheet = Slab;

    fn sheet(&self, index: usize) -> Slab {
        self.plan.projector.sheets.slab(index).map(|depth| depth as f32)
    }

    #[inline(always)]
    fn payload(&self, index: usize, position: [usize; 3]) -> Option<[f32; 4]> {
        let value = self.plan.coefficients.values[index];
        if value.is_nan() {
            return None;
        }
        let [extinction, r, g, b] = self.plan.table.at(value);
        if extinction <= 0.0 {
            return None;
        }
        let Some(phong) = self.lights else {
            return Some([extinction, r, g, b]);
        };
        let lit = phong.at(self.gradient(index, position));
        let shine = extinction * lit.specular;
        Some([
            extinction,
            r * lit.diffuse + shine,
            g * lit.diffuse + shine,
            b * lit.diffuse + shine,
        ])
    }

    #[inline(always)]
    fn meets(&self, slab: &Slab, voxel: &OpenVoxel<[f32; 4]>, _rect: &TileRect) -> Fate {
        let [.., z] = voxel.centre;
        Fate {
            met: self.slicer.reaches(z, *slab),
            past: self.slicer.is_past(z, slab[1]),
        }
    }

    #[inline(always)]
    fn slice(&self, slab: &Slab, voxel: &OpenVoxel<[f32; 4]>) -> Option<(Slice, ColorPayload)> {
        let slice = self.slicer.slice(voxel.centre, *slab)?;
        let [extinction, r, g, b] = voxel.payload;
        Some((
            slice,
            ColorPayload([extinction, r, g, b, extinction * slice.depth]),
        ))
    }

    fn composite(
        &self,
        _near: Option<(&Slab, &SheetBuffer)>,
        (_, sheet): (&Slab, &SheetBuffer),
        canvas: &mut Canvas<'_>,
    ) {
        let screen = &self.plan.projector.screen;
        let per_pixel = if screen.perspective {
            1.0 / screen.scale as f32
        } else {
            0.0
        };
        let [cx, cy] = screen.centre.as_vec2().to_array();
        let touched = sheet.touched;
        for y in touched.y0..touched.y1 {
            let ray_y = ((canvas.rect.y0 + y) as f32 + 0.5 - cy) * per_pixel;
            for x in touched.x0..touched.x1 {
                let [extinction, r, g, b, depth] = sheet.pixel(x, y);
                let index = canvas.index(x, y);
                if extinction <= 0.0 || canvas.pixels[index].finished {
                    continue;
                }
                let ray_x = ((canvas.rect.x0 + x) as f32 + 0.5 - cx) * per_pixel;
                let ray_length = (1.0 + ray_x * ray_x + ray_y * ray_y).sqrt();
                let pixel = &mut canvas.pixels[index];
                if self.plan.settings.compositing == Compositing::Xray {
                    let along = [extinction, r, g, b, depth].map(|channel| channel * ray_length);
                    pixel.integrate(along[0], [along[1], along[2], along[3]], along[4]);
                } else {
                    let color = [r / extinction, g / extinction, b / extinction];
                    pixel.add(extinction * ray_length, color, depth / extinction);
                    canvas.close_if_opaque(x, y);
                }
            }
        }
    }
}
