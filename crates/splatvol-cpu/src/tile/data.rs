//! Post-classification and maximum intensity: data is sampled on planes.

use fearless_simd::Simd;
use splatvol_core::bin::TileRect;
use splatvol_core::footprint::PlaneSlicer;
use splatvol_scene::Compositing;

use super::{Canvas, Fate, Mode};
use crate::plan::FramePlan;
use crate::stage::activate::OpenVoxel;
use crate::stage::shade::{End, Interval, NO_COVERAGE, Phong, Shader};
use crate::stage::sheet_buffer::SheetBuffer;
use crate::stage::splat::{DataPayload, splat};

/// Splats kernel coefficients; classifies pairs of planes.
#[derive(Debug)]
pub(crate) struct DataMode<'a> {
    plan: &'a FramePlan<'a>,
    shader: Shader<'a>,
}

impl<'a> DataMode<'a> {
    /// Mode of a frame.
    pub(crate) fn new(plan: &'a FramePlan<'a>) -> Self {
        let lights = plan
            .settings
            .lighting
            .as_ref()
            .map(|l| Phong::new(l, plan.mean_spacing));
        let spacing = plan.projector.sheets.spacing as f32;
        Self {
            plan,
            shader: Shader {
                table: plan.table,
                lights,
                spacing,
            },
        }
    }

    /// The end of an interval: channels of a plane's pixel to sums and gradient.
    #[inline(always)]
    fn end(slicer: &PlaneSlicer, [sum, weight, dx, dy, dz]: [f32; 5]) -> End {
        let scale = slicer.scale();
        let slope = slicer.lateral_slope();
        let (x, y) = (scale * dx, scale * dy);
        // The depth derivative was taken along the footprint's drift.
        let z = dz - slope[0] * x - slope[1] * y;
        End {
            sum,
            weight,
            gradient: [x, y, z],
        }
    }
}

impl Mode for DataMode<'_> {
    type Payload = f32;
    type Sheet = PlaneSlicer;

    fn sheet(&self, index: usize) -> PlaneSlicer {
        let projector = &self.plan.projector;
        PlaneSlicer::new(
            projector.shape,
            &projector.screen,
            projector.pixel_sigma,
            projector.sheets.plane(index),
        )
    }

    #[inline(always)]
    fn payload(&self, index: usize, _position: [usize; 3]) -> Option<f32> {
        let coefficient = self.plan.coefficients.values[index];
        (!coefficient.is_nan()).then_some(coefficient)
    }

    #[inline(always)]
    fn splat<S: Simd>(
        &self,
        simd: S,
        slicer: &PlaneSlicer,
        voxel: &OpenVoxel<f32>,
        (buffer, rect): (&mut SheetBuffer, &TileRect),
    ) -> Fate {
        let [x, y, z] = voxel.centre;
        let Some(offset) = slicer.offset(z) else {
            return Fate {
                touched: false,
                past: slicer.is_past(z),
            };
        };
        let slice = slicer.slice([x, y], offset);
        let payload = DataPayload {
            coefficient: voxel.payload,
            conic: slice.conic,
            depth_derivative: slicer.depth_derivative(offset),
        };
        Fate {
            touched: splat(simd, buffer, rect, &slice, payload),
            past: false,
        }
    }

    fn composite(
        &self,
        (near_slicer, near): (&PlaneSlicer, &SheetBuffer),
        (far_slicer, far): (&PlaneSlicer, &SheetBuffer),
        canvas: &mut Canvas<'_>,
    ) {
        let touched = near.touched.join(far.touched);
        if touched.is_empty() {
            return;
        }
        let screen = &self.plan.projector.screen;
        let per_pixel = if screen.perspective {
            1.0 / screen.scale as f32
        } else {
            0.0
        };
        let [cx, cy] = screen.centre.as_vec2().to_array();
        for y in touched.y0..touched.y1 {
            let ray_y = ((canvas.rect.y0 + y) as f32 + 0.5 - cy) * per_pixel;
            for x in touched.x0..touched.x1 {
                let (a, b) = (near.pixel(x, y), far.pixel(x, y));
                let index = canvas.index(x, y);
                if a[1].max(b[1]) < NO_COVERAGE || canvas.pixels[index].finished {
                    continue;
                }
                let ray = [((canvas.rect.x0 + x) as f32 + 0.5 - cx) * per_pixel, ray_y];
                let interval = Interval {
                    depth: near_slicer.depth(),
                    ray,
                };
                let (a, b) = (Self::end(near_slicer, a), Self::end(far_slicer, b));
                let pixel = &mut canvas.pixels[index];
                if self.plan.settings.compositing == Compositing::Mip {
                    self.shader.maximum(pixel, &a, &b, interval);
                } else {
                    self.shader.shade(pixel, &a, &b, interval);
                    canvas.close_if_opaque(x, y);
                }
            }
        }
    }
}
