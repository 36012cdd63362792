//! Open: brings a chunk's splats into camera space, and queues them for the first plane that they reach.

use glam::{Affine3A, DMat3, DVec2, DVec3, Vec3};
use splatvol_core::cloud_planes::{CUT, DEPTH_CUT, DEPTH_INTEGRAL, LEAST_WIDTH, widened};
use splatvol_core::splats::{KernelShape, SplatCloud};
use splatvol_scene::{Clip, ScreenFromCamera};

use crate::sheets::cut::Cut;
use crate::splat_light::SplatLight;

/// Share of the cut in depth within which planes are searched for: beyond it a splat has less than a thousandth of its
/// peak.
const NEARLY: f64 = 0.985;
/// A splat in camera space, ready for the planes.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct OpenSplat {
    /// Centre, camera space.
    pub centre: [f32; 3],
    /// Drift of its centre on planes per depth.
    pub slope: [f32; 2],
    /// Negative exponents to base 2, per world length squared: xx, xy (twice), yy.
    pub exponent: [f32; 3],
    /// Negative exponent to base 2 in depth, per world length squared.
    pub depth_exponent: f32,
    /// Half widths of the box around its section, world length.
    pub half_extent: [f32; 2],
    /// Reach in depth, world length.
    pub reach: f32,
    /// Extinction and emission at its centre, before `cloud_planes::DEPTH_EDGE` is subtracted.
    pub payload: [f32; 4],
}

/// A cloud in a camera's view, with everything needed to open its splats.
#[derive(Debug, Clone)]
pub(crate) struct CloudView<'a> {
    pub cloud: &'a SplatCloud,
    pub screen: ScreenFromCamera,
    pub camera_from_local: Affine3A,
    linear: DMat3,
    /// Covariance shared by all splats that have none of their own, camera space.
    shared: DMat3,
    light: Option<SplatLight>,
    /// Low-pass variance, pixels squared; with `matched`, footprints are widened only up to it.
    low_pass: f64,
    matched: bool,
    /// Variance by which planes widen splats in depth.
    widening: f64,
    /// Dropped splats; local space.
    cut: Cut,
    /// Depth of the nearest plane, for the low-pass of splats in front of it.
    nearest: f64,
}

impl<'a> CloudView<'a> {
    pub(crate) fn new(
        (cloud, light): (&'a SplatCloud, Option<SplatLight>),
        camera_from_local: glam::DAffine3,
        screen: ScreenFromCamera,
        (low_pass, matched): (f64, bool),
        (nearest, spacing): (f64, f64),
    ) -> Self {
        let linear = camera_from_local.matrix3;
        let shared = match cloud.shape {
            KernelShape::Sphere { sigma } => linear * linear.transpose() * sigma.powi(2),
            _ => DMat3::ZERO,
        };
        Self {
            cloud,
            screen,
            camera_from_local: Affine3A::from_mat3_translation(
                linear.as_mat3(),
                camera_from_local.translation.as_vec3(),
            ),
            linear,
            shared,
            light,
            low_pass,
            matched,
            widening: widened(0.0, spacing),
            cut: Cut::default(),
            nearest,
        }
    }

    /// Drops the splats whose centres are cut away by clips, which are given in world space.
    pub(crate) fn cut(self, clips: &[Clip]) -> Self {
        let cut = Cut::new(clips, self.cloud.world_from_local);
        Self { cut, ..self }
    }

    /// Opens a splat; `None` if it is empty.
    #[inline(always)]
    pub(crate) fn open(&self, index: usize) -> Option<OpenSplat> {
        let cloud = self.cloud;
        let local = Vec3::from_array(cloud.positions[index]);
        if !self.cut.keeps(local) {
            return None;
        }
        let centre = self.camera_from_local.transform_point3(local);
        let own = cloud.covariances.get(index);
        let covariance = own.map_or(self.shared, |own| {
            let [xx, xy, xz, yy, yz, zz] = own.map(f64::from);
            let own = DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
            self.linear * own * self.linear.transpose()
        });
        let variance = covariance.z_axis.z + self.widening;
        let slope = covariance.z_axis.truncate() / variance;
        let section = [
            covariance.x_axis.x - slope.x * slope.x * variance,
            covariance.x_axis.y - slope.x * slope.y * variance,
            covariance.y_axis.y - slope.y * slope.y * variance,
        ];
        let [xx, xy, yy] = self.filtered(section, f64::from(centre.z));
        let determinant = xx * yy - xy * xy;
        let per_area = 1.0 / (std::f64::consts::TAU * determinant.sqrt());
        let per_depth = 1.0 / (variance.sqrt() * DEPTH_INTEGRAL);
        let mass = if index >= cloud.peaks_from {
            self.mass_of_peak(centre.as_dvec3(), covariance)
        } else {
            cloud.mass
        };
        let payload = match &self.light {
            Some(light) => light.on(cloud.payloads[index], cloud.gradients[index]),
            None => cloud.payloads[index],
        };
        let density = (mass * per_area * per_depth) as f32;
        let payload = payload.map(|value| value * density);
        let half = 0.5 * std::f64::consts::LOG2_E / determinant;
        // False where anything is not a number.
        (payload[0] > 0.0 && determinant > 0.0).then(|| OpenSplat {
            centre: centre.to_array(),
            slope: slope.as_vec2().to_array(),
            exponent: [-yy * half, 2.0 * xy * half, -xx * half].map(|e| e as f32),
            depth_exponent: (-0.5 * std::f64::consts::LOG2_E / variance) as f32,
            half_extent: [xx, yy].map(|variance| (CUT * variance.sqrt()) as f32),
            reach: (NEARLY * DEPTH_CUT * variance.sqrt()) as f32,
            payload,
        })
    }

    /// A section's covariance with the low-pass, world length squared.
    #[inline(always)]
    fn filtered(&self, [xx, xy, yy]: [f64; 3], depth: f64) -> [f64; 3] {
        let per_pixel = 1.0 / self.screen.scale_at(depth.max(self.nearest));
        let wanted = self.low_pass * per_pixel * per_pixel;
        let least = 0.5 * (xx + yy) - (0.25 * (xx - yy).powi(2) + xy * xy).sqrt();
        let added = if self.matched {
            (wanted - least).max(0.0)
        } else {
            wanted
        };
        let least_width = (LEAST_WIDTH * per_pixel).powi(2);
        [xx + added + least_width, xy, yy + added + least_width]
    }

    /// The integral of a kernel whose line integral through its centre is one.
    #[inline(always)]
    fn mass_of_peak(&self, centre: DVec3, covariance: DMat3) -> f64 {
        let along = if self.screen.perspective {
            centre.truncate() / centre.z.max(self.nearest)
        } else {
            DVec2::ZERO
        };
        let [x, y, z] = [covariance.x_axis, covariance.y_axis, covariance.z_axis];
        let xx = x.x - 2.0 * along.x * z.x + along.x * along.x * z.z;
        let xy = x.y - along.x * z.y - along.y * z.x + along.x * along.y * z.z;
        let yy = y.y - 2.0 * along.y * z.y + along.y * along.y * z.z;
        let area = (xx * yy - xy * xy).max(0.0).sqrt();
        std::f64::consts::TAU * area / (1.0 + along.length_squared()).sqrt()
    }
}

/// Queues of a tile's splats, one per plane, as linked lists in one memory.
#[derive(Debug, Default)]
pub(crate) struct Waiting {
    splats: Vec<OpenSplat>,
    /// For each splat the next in its list, plus one.
    next: Vec<u32>,
    /// First splat of each plane's list, plus one.
    heads: Vec<u32>,
    /// Places that are free again.
    free: Vec<u32>,
    /// Splats in chains.
    pub count: usize,
}

impl Waiting {
    /// Memory held, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let numbers = self.next.capacity() + self.heads.capacity() + self.free.capacity();
        self.splats.capacity() * size_of::<OpenSplat>() + numbers * size_of::<u32>()
    }

    /// Empty lists for so many planes.
    pub(crate) fn reset(&mut self, planes: usize) {
        self.splats.clear();
        self.next.clear();
        self.free.clear();
        self.heads.clear();
        self.heads.resize(planes, 0);
        self.count = 0;
    }

    /// Queues a splat for a plane; drops it where that lies behind the last one.
    pub(crate) fn add(&mut self, splat: &OpenSplat, plane: usize) {
        if plane >= self.heads.len() {
            return;
        }
        let place = match self.free.pop() {
            Some(place) => {
                self.splats[place as usize] = *splat;
                place
            }
            None => {
                self.splats.push(*splat);
                self.next.push(0);
                self.splats.len() as u32 - 1
            }
        };
        self.link(place, plane);
    }

    fn link(&mut self, place: u32, plane: usize) {
        self.next[place as usize] = self.heads[plane];
        self.heads[plane] = place + 1;
        self.count += 1;
    }

    /// Takes a plane's list, and returns its first splat.
    pub(crate) fn take(&mut self, plane: usize) -> Option<u32> {
        let head = self.heads.get_mut(plane).map_or(0, std::mem::take);
        head.checked_sub(1)
    }

    /// A taken splat, and the next one of its list.
    pub(crate) fn splat(&mut self, place: u32) -> (&OpenSplat, Option<u32>) {
        self.count -= 1;
        let next = self.next[place as usize].checked_sub(1);
        (&self.splats[place as usize], next)
    }

    /// Queues a taken splat again, for another plane.
    pub(crate) fn again(&mut self, place: u32, plane: usize) {
        if plane < self.heads.len() {
            self.link(place, plane);
        } else {
            self.free.push(place);
        }
    }

    /// Drops a taken splat.
    pub(crate) fn drop(&mut self, place: u32) {
        self.free.push(place);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lists return all their splats, whatever was dropped before.
    #[test]
    fn splats_wait_for_their_planes() {
        let mut waiting = Waiting::default();
        waiting.reset(4);
        let splat = |depth: f32| OpenSplat {
            centre: [0.0, 0.0, depth],
            ..OpenSplat::default()
        };
        for (depth, plane) in [(1.0, 0), (2.0, 2), (3.0, 0), (4.0, 9)] {
            waiting.add(&splat(depth), plane);
        }
        assert_eq!(waiting.count, 3);
        let first = waiting.take(0).unwrap();
        let (found, next) = waiting.splat(first);
        assert_eq!(found.centre[2], 3.0);
        waiting.again(first, 2);
        let (found, last) = waiting.splat(next.unwrap());
        assert_eq!((found.centre[2], last), (1.0, None));
        waiting.drop(next.unwrap());
        waiting.add(&splat(5.0), 2);
        let mut depths = Vec::new();
        let mut next = waiting.take(2);
        while let Some(place) = next {
            let (found, following) = waiting.splat(place);
            depths.push(found.centre[2]);
            next = following;
        }
        assert_eq!((depths, waiting.count), (vec![5.0, 3.0, 2.0], 0));
        assert!(waiting.take(2).is_none());
    }
}
