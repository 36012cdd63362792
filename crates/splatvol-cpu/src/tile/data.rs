//! Post-classification and pictures of one value per ray: data is sampled on planes.

use glam::Vec3;
use splatvol_core::bin::TileRect;
use splatvol_core::footprint::{PlaneSlicer, Slice};
use splatvol_scene::Compositing;

use super::{Canvas, Fate, Mode};
use crate::phong::Phong;
use crate::plan::FramePlan;
use crate::sheets::extremum::{Largest, Smallest};
use crate::stage::activate::OpenVoxel;
use crate::stage::shade::{End, Interval, NO_COVERAGE, Shader};
use crate::stage::sheet_buffer::{SheetBuffer, Touched};
use crate::stage::splat::DataPayload;

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

    /// Ray of the image pixel x, y.
    #[inline(always)]
    fn ray(&self, x: usize, y: usize) -> PixelRay {
        let screen = &self.plan.projector.screen;
        let per_pixel = 1.0 / screen.scale as f32;
        let [cx, cy] = screen.centre.as_vec2().to_array();
        let plane = [
            (x as f32 + 0.5 - cx) * per_pixel,
            (y as f32 + 0.5 - cy) * per_pixel,
        ];
        if screen.perspective {
            PixelRay {
                origin: [0.0; 2],
                slope: plane,
            }
        } else {
            PixelRay {
                origin: plane,
                slope: [0.0; 2],
            }
        }
    }

    /// Whether all pixels of a tile's rectangle see the plane well inside the volume's box.
    fn is_inside(&self, plane: &Plane, rect: &TileRect, touched: &Touched) -> bool {
        let (x0, x1) = (rect.x0 + touched.x0, rect.x0 + touched.x1);
        let (y0, y1) = (rect.y0 + touched.y0, rect.y0 + touched.y1);
        let corners = [(x0, y0), (x1, y0), (x0, y1), (x1, y1)];
        let depth = plane.slicer.depth();
        !self.plan.coefficients.any_missing
            && corners
                .iter()
                .all(|&(x, y)| self.plan.cover.is_inside(self.ray(x, y).at(depth), plane.sigma))
    }

    /// The end of an interval: channels of a plane's pixel to sums and gradient.
    #[inline(always)]
    fn end(
        &self,
        (plane, inside): (&Plane, bool),
        [sum, weight, dx, dy, dz]: [f32; 5],
        ray: &PixelRay,
    ) -> End {
        let slicer = &plane.slicer;
        let scale = slicer.scale();
        let slope = slicer.lateral_slope();
        let (x, y) = (scale * dx, scale * dy);
        // The depth derivative was taken along the footprint's drift.
        let z = dz - slope[0] * x - slope[1] * y;
        let own_weight = if inside {
            1.0
        } else {
            self.plan.cover.at(ray.at(slicer.depth()), plane.sigma, weight)
        };
        End {
            sum,
            weight,
            own_weight,
            gradient: [x, y, z],
        }
    }
}

/// A plane with the kernel's standard deviations along the voxel axes there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane {
    slicer: PlaneSlicer,
    sigma: Vec3,
}

/// A pixel's ray, camera space: (x, y) at depth 0 and per depth.
#[derive(Debug, Clone, Copy)]
struct PixelRay {
    origin: [f32; 2],
    slope: [f32; 2],
}

impl PixelRay {
    /// Its point at a depth.
    #[inline(always)]
    fn at(&self, depth: f32) -> [f32; 3] {
        [
            self.origin[0] + self.slope[0] * depth,
            self.origin[1] + self.slope[1] * depth,
            depth,
        ]
    }
}

impl Mode for DataMode<'_> {
    type Payload = f32;
    type Splat = DataPayload;
    type Sheet = Plane;

    fn sheet(&self, index: usize) -> Plane {
        let projector = &self.plan.projector;
        let depth = projector.sheets.plane(index);
        let slicer = PlaneSlicer::new(projector.shape, &projector.screen, projector.pixel_sigma, depth);
        let low_pass = projector.pixel_sigma / projector.screen.scale_at(depth);
        Plane {
            slicer,
            sigma: self.plan.cover.on_plane(low_pass as f32),
        }
    }

    #[inline(always)]
    fn payload(&self, index: usize, _position: [usize; 3]) -> Option<f32> {
        let coefficient = self.plan.coefficients.values[index];
        (!coefficient.is_nan()).then_some(coefficient)
    }

    #[inline(always)]
    fn meets(&self, Plane { slicer, .. }: &Plane, voxel: &OpenVoxel<f32>, rect: &TileRect) -> Fate {
        let [x, y, z] = voxel.centre;
        let offset = slicer.offset(z);
        Fate {
            met: slicer.reaches(offset) & slicer.touches([x, y], offset, rect),
            past: slicer.is_past(offset),
        }
    }

    #[inline(always)]
    fn slice(&self, Plane { slicer, .. }: &Plane, voxel: &OpenVoxel<f32>) -> Option<(Slice, DataPayload)> {
        let [x, y, z] = voxel.centre;
        let offset = slicer.offset(z);
        let slice = slicer.slice([x, y], offset);
        let payload = DataPayload {
            coefficient: voxel.payload,
            conic: slice.conic,
            depth_derivative: slicer.depth_derivative(offset),
        };
        Some((slice, payload))
    }

    fn composite(
        &self,
        near: Option<(&Plane, &SheetBuffer)>,
        (far_plane, far): (&Plane, &SheetBuffer),
        canvas: &mut Canvas<'_>,
    ) {
        let Some((near_plane, near)) = near else { return };
        let touched = near.touched.join(far.touched);
        if touched.is_empty() {
            return;
        }
        let ends =
            [near_plane, far_plane].map(|plane| (plane, self.is_inside(plane, &canvas.rect, &touched)));
        let depth = near_plane.slicer.depth();
        for y in touched.y0..touched.y1 {
            for x in touched.x0..touched.x1 {
                let (a, b) = (near.pixel(x, y), far.pixel(x, y));
                let index = canvas.index(x, y);
                if a[1].max(b[1]) < NO_COVERAGE || canvas.pixels[index].finished {
                    continue;
                }
                let ray = self.ray(canvas.rect.x0 + x, canvas.rect.y0 + y);
                let (a, b) = (self.end(ends[0], a, &ray), self.end(ends[1], b, &ray));
                if a.own_weight.max(b.own_weight) < NO_COVERAGE {
                    continue;
                }
                let interval = Interval {
                    depth,
                    ray: ray.slope,
                };
                let pixel = &mut canvas.pixels[index];
                match self.plan.settings.compositing {
                    Compositing::Mip => self.shader.extreme::<Largest>(pixel, &a, &b, interval),
                    Compositing::MinimumIntensity => {
                        self.shader.extreme::<Smallest>(pixel, &a, &b, interval);
                    }
                    Compositing::Mean => self.shader.mean(pixel, &a, &b, interval),
                    _ => {
                        self.shader.shade(pixel, &a, &b, interval);
                        canvas.close_if_opaque(x, y);
                    }
                }
            }
        }
    }
}
