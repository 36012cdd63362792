//! Plan: planes that suit a cloud, and its chunks in tile lists.

use glam::{DAffine3, DVec2, DVec3};
use splatvol_core::bin::{ProjectedBrick, TileGrid};
use splatvol_core::brick::ActiveBrick;
use splatvol_core::plan::{FramePlan, SheetShape, Zone, low_pass};
use splatvol_core::sheets::Planes;
use splatvol_core::splats::{Chunk, KernelShape, SplatCloud};
use splatvol_scene::{Camera, ImageSize, RenderSettings, ScreenFromCamera, SheetSettings};

use super::open::{CUT, CloudView, DEPTH_CUT};
use crate::sheets::frame::ZonedFrame;
use crate::sheets::plane::HALO;
use crate::splat_light::SplatLight;

/// Pixels added to a footprint on either side: by rounding to whole blocks, and as the border that it reads.
const ROUNDING: f64 = 2.0 + HALO as f64;
/// Factor of a chunk's reach in depth, by which it stays an upper bound in 32 bits.
const ROUNDED_UP: f64 = 1.0 + 1e-6;

/// Planes and lists of a cloud; the next frame reuses their memory.
#[derive(Debug, Default)]
pub(crate) struct CloudPlan {
    plan: FramePlan,
}

/// Distance of planes that suits a cloud, world length.
pub(crate) fn own_spacing(
    cloud: &SplatCloud,
    (camera, settings): (&Camera, &RenderSettings<SheetSettings>),
) -> f64 {
    let screen = camera.screen_from_camera(settings.size);
    let camera_from_local = camera.camera_from_world() * cloud.world_from_local;
    ChunkBounds::new(camera_from_local, cloud, settings, screen)
        .planes(cloud, settings, None)
        .spacing
}

impl CloudPlan {
    /// Plans a cloud's frame, on planes of the given spacing or else of one that suits it, and returns the cloud in
    /// that view. There is one zone: splats are drawn on pixels, whatever their size, and sorted as they are
    /// opened.
    pub(crate) fn frame<'a>(
        &'a mut self,
        cloud: &'a SplatCloud,
        (camera, settings): (&Camera, &RenderSettings<SheetSettings>),
        tiles: TileGrid,
        spacing: Option<f64>,
    ) -> (ZonedFrame<'a>, CloudView<'a>) {
        let screen = camera.screen_from_camera(settings.size);
        let camera_from_local = camera.camera_from_world() * cloud.world_from_local;
        let bounds = ChunkBounds::new(camera_from_local, cloud, settings, screen);
        let stack = bounds.planes(cloud, settings, spacing);
        let view = CloudView::new(
            (
                cloud,
                settings
                    .lighting
                    .as_ref()
                    .filter(|_| !cloud.gradients.is_empty())
                    .map(|lighting| SplatLight::new(lighting, cloud, camera)),
            ),
            camera_from_local,
            screen,
            low_pass(settings.method.filter.into()),
            (stack.plane(usize::from(stack.first == 0)), stack.spacing),
        );
        let least = nearest(&stack, &screen);
        let sheets = (0..=stack.count).map(|i| {
            let depth = stack.plane(i).max(least);
            SheetShape {
                depth: depth as f32,
                scale: screen.scale_at(depth) as f32,
                ..SheetShape::default()
            }
        });
        let project = |index: usize| bounds.project(&cloud.chunks[index], index, &stack);
        self.plan.of_pixels(
            (&screen, settings),
            (Zone::of_pixels(stack), sheets),
            (cloud.chunks.len(), project),
            tiles,
        );
        let plan = &self.plan;
        (ZonedFrame { plan, eyes: &[] }, view)
    }
}

/// Least depth of planes: the plane at the eye, which has no scale, counts as a little in front of it.
fn nearest(stack: &Planes, screen: &ScreenFromCamera) -> f64 {
    if screen.perspective {
        stack.plane(0).max(AT_EYE * stack.spacing)
    } else {
        f64::NEG_INFINITY
    }
}

/// Depth of the plane at the eye, distances of planes.
const AT_EYE: f64 = 1e-3;

/// Chunks to screen rectangles and first planes.
struct ChunkBounds {
    camera_from_local: DAffine3,
    screen: ScreenFromCamera,
    size: ImageSize,
    /// Longest world length of a local unit.
    stretch: f64,
    /// Low-pass, pixels.
    pixel_sigma: f64,
    /// Standard deviation of kernels that have no covariance of their own, local.
    shared_sigma: f64,
}

impl ChunkBounds {
    fn new(
        camera_from_local: DAffine3,
        cloud: &SplatCloud,
        settings: &RenderSettings<SheetSettings>,
        screen: ScreenFromCamera,
    ) -> Self {
        let linear = camera_from_local.matrix3;
        // A bound on the largest singular value; exact for a rotation times a number.
        let square = linear.transpose() * linear;
        let rows = [square.row(0), square.row(1), square.row(2)];
        let stretch = rows
            .map(|row| row.abs().element_sum())
            .into_iter()
            .fold(0.0, f64::max)
            .sqrt();
        Self {
            camera_from_local,
            screen,
            size: settings.size,
            stretch,
            pixel_sigma: low_pass(settings.method.filter.into()).0.sqrt(),
            shared_sigma: match cloud.shape {
                KernelShape::Ellipsoids { .. } => 0.0,
                shape => shape.sigma(),
            },
        }
    }

    /// Least and greatest coordinates of a chunk's centres, camera space.
    fn centres(&self, chunk: &Chunk) -> [DVec3; 2] {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for corner in chunk.corners() {
            let point = self
                .camera_from_local
                .transform_point3(DVec3::from_array(corner.map(f64::from)));
            (low, high) = (low.min(point), high.max(point));
        }
        [low, high]
    }

    /// Largest standard deviation of a chunk's kernels, world length.
    fn sigma(&self, chunk: &Chunk) -> f64 {
        f64::from(chunk.sigma).max(self.shared_sigma) * self.stretch
    }

    /// Planes of the given spacing, or else of the settings', but at least that of the pixels in the middle of the
    /// cloud: closer planes cost more and show nothing new.
    fn planes(
        &self,
        cloud: &SplatCloud,
        settings: &RenderSettings<SheetSettings>,
        spacing: Option<f64>,
    ) -> Planes {
        let wanted = settings.method.thickness * cloud.spacing;
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for chunk in &cloud.chunks {
            let [near, far] = self.centres(chunk);
            let sigma = self.sigma(chunk);
            (low, high) = (
                low.min(near - DEPTH_CUT * sigma),
                high.max(far + DEPTH_CUT * sigma),
            );
        }
        if cloud.chunks.is_empty() {
            (low, high) = (DVec3::ZERO, DVec3::ZERO);
        }
        let middle = 0.5 * (low.z + high.z);
        let pixel = 1.0 / self.screen.scale_at(middle.max(wanted));
        let spacing = spacing.unwrap_or(wanted.max(pixel));
        // Two planes more on either side, which the widening in depth reaches.
        let mut planes = Planes::covering(&[low, high], 2.0 * spacing, spacing, &self.screen);
        if self.screen.perspective && planes.first == 1 && low.z < spacing {
            // Splats between the eye and the first plane are visible, too.
            (planes.first, planes.count) = (0, planes.count + 1);
        }
        planes
    }

    /// Bounds of a chunk's footprints; `None` behind the camera, and outside the picture.
    fn project(&self, chunk: &Chunk, index: usize, stack: &Planes) -> Option<ProjectedBrick> {
        let [low, high] = self.centres(chunk);
        let sigma = self.sigma(chunk);
        let reach = DEPTH_CUT * CloudView::widened(sigma * sigma, stack.spacing).sqrt() * ROUNDED_UP;
        let first = nearest(stack, &self.screen).max(stack.plane(0));
        let near = (low.z - reach).max(first);
        let far = high.z + reach;
        if far < first {
            return None;
        }
        // Sections drift with depth, and are as wide as the kernel at most: together no farther than this.
        let lateral = (DEPTH_CUT * DEPTH_CUT + CUT * CUT).sqrt() * sigma;
        let scales = [self.screen.scale_at(near), self.screen.scale_at(far)];
        // The low-pass is as wide as it is at a splat's own depth: nearer planes show it larger.
        let own = self.screen.scale_at(low.z.max(first));
        let margin = CUT * self.pixel_sigma * (scales[0] / own).max(1.0) + ROUNDING;
        let bound = |value: DVec2, pick: fn(f64, f64) -> f64| {
            let [a, b] = scales.map(|scale| value * scale);
            DVec2::new(pick(a.x, b.x), pick(a.y, b.y)) + self.screen.centre
        };
        let from = bound(low.truncate() - lateral, f64::min) - margin;
        let to = bound(high.truncate() + lateral, f64::max) + margin;
        let (width, height) = (f64::from(self.size.width()), f64::from(self.size.height()));
        if to.x < 0.0 || to.y < 0.0 || from.x > width || from.y > height {
            return None;
        }
        Some(ProjectedBrick {
            active: ActiveBrick {
                brick: index as u32,
                blocks: u8::MAX,
            },
            front_sheet: stack.first_touched(low.z - reach) as u32,
            rect: [from.x as f32, from.y as f32, to.x as f32, to.y as f32],
        })
    }
}
