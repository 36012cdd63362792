//! Gather: kernels of all kinds into one cloud of ellipsoids.
//!
//! A cloud of several items has the world, moved to their middle, as its local space. Its splats carry
//!
//! | item | covariance | payload |
//! |---|---|---|
//! | voxel | `sigma^2 L L^T`, L the grid's cell | extinction times the cell's volume |
//! | sample of an irregular grid | its own | extinction times its mass |
//! | surfel: radius r, normal n | `(a r)^2 (I - n n^T)`; `(a r)^2 I` without a normal | optical depth of the surface times `r^2`, the area that it stands for |
//! | Gaussian | `R S^2 R^T` | `-ln(1 - opacity)`, the optical depth through its centre, in every view |
//!
//! So surfels make a surface of one optical depth, however they overlap (zwicker2001 section 5). huang2000 section
//! 4.2 clips them to their sheets; the section of a flat kernel does so by itself.
//!
//! Splats are sorted along a space-filling curve (Morton 1966), those of a size together, so the boxes of chunks
//! are small.

use glam::{DAffine3, DMat3, DVec3, Mat3, Quat, Vec3};
use rayon::prelude::*;
use splatvol_scene::transfer_function::linear_from_srgb;
use splatvol_scene::{Gaussians, Points};

use super::cloud::{Chunk, KernelShape, SplatCloud};

/// Most splats of a chunk.
const CHUNK: usize = 256;
/// Standard deviation of a surfel, radii: sums of Gaussians this wide on a square lattice of the radius ripple by
/// 0.2 %.
const SURFEL_SIGMA: f64 = 0.6;
/// Optical depth of an opaque surface: a 255th shows through.
const OPAQUE: f64 = 5.55;
/// Least transmittance of a Gaussian, as in the published renderer.
const CLEAREST: f64 = 0.01;
/// Gradient of a surface, value ranges per spacing: steep enough for full surface lighting.
const SURFACE_GRADIENT: f64 = 1e3;

/// One kernel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Splat {
    /// Centre, world.
    pub centre: DVec3,
    /// Covariance, world.
    pub covariance: DMat3,
    /// Extinction and emission, integrated over space; for a Gaussian, along a ray through its centre.
    pub payload: [f32; 4],
    /// Gradient of the normalised value, per world length.
    pub gradient: DVec3,
}

/// Last cell along an axis of the Morton order: nine bits, so that size, place and index fit a key of 64.
const LAST_CELL: f32 = 511.0;
/// Octave of the widths in the first class of sizes, and the last class: five bits, from 2^-40 up.
const SMALLEST: f32 = -40.0;
const LAST_CLASS: f32 = 31.0;

/// Kernels on their way into a cloud.
#[derive(Debug, Clone)]
pub struct Gather {
    /// The cloud's origin, world.
    origin: DVec3,
    /// Distance of neighbours, world length.
    spacing: f64,
    positions: Vec<[f32; 3]>,
    covariances: Vec<[f32; 6]>,
    payloads: Vec<[f32; 4]>,
    gradients: Vec<[f32; 3]>,
    /// The first of the splats that carry optical depths.
    peaks_from: Option<usize>,
}

/// A cloud, and the origin of its splats.
#[derive(Debug, Clone)]
pub struct Gathered {
    /// The cloud.
    pub cloud: SplatCloud,
    /// For each splat, its index in the order of addition.
    pub sources: Vec<u32>,
}

impl Gather {
    /// An empty collection. Neighbours lie about `spacing` apart, the reference length of sheets and lighting; all
    /// kernels will lie around `origin`.
    pub fn around(origin: DVec3, spacing: f64) -> Self {
        Self {
            origin,
            spacing,
            positions: Vec::new(),
            covariances: Vec::new(),
            payloads: Vec::new(),
            gradients: Vec::new(),
            peaks_from: None,
        }
    }

    /// Number of splats so far.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Distance of neighbours, world length.
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Whether nothing has been added.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Adds so many splats.
    fn add(&mut self, count: usize, splat: impl Fn(usize) -> Splat + Sync) {
        let (origin, first) = (self.origin, self.len());
        let end = first + count;
        self.positions.resize(end, [0.0; 3]);
        self.covariances.resize(end, [0.0; 6]);
        self.payloads.resize(end, [0.0; 4]);
        self.gradients.resize(end, [0.0; 3]);
        let places = self.positions[first..]
            .par_iter_mut()
            .zip(&mut self.covariances[first..]);
        let rest = self.payloads[first..]
            .par_iter_mut()
            .zip(&mut self.gradients[first..]);
        let all = places.zip(rest).enumerate();
        all.for_each(|(index, ((position, covariance), (payload, gradient)))| {
            let splat = splat(index);
            *position = (splat.centre - origin).as_vec3().to_array();
            *covariance = upper(splat.covariance);
            *payload = splat.payload;
            *gradient = splat.gradient.as_vec3().to_array();
        });
    }

    /// Adds the voxels of a classified volume.
    pub fn add_voxels(&mut self, cloud: &SplatCloud) {
        let linear = cloud.world_from_local.matrix3;
        let covariance = linear * linear.transpose() * cloud.shape.sigma().powi(2);
        let world_from_gradient = linear.inverse().transpose();
        // Gradients are compared with the item's own spacing.
        let steepness = cloud.spacing / self.spacing;
        self.add(cloud.len(), |index| Splat {
            centre: place(&cloud.world_from_local, cloud.positions[index]),
            covariance,
            payload: cloud.payloads[index].map(|value| (f64::from(value) * cloud.mass) as f32),
            gradient: cloud.gradients.get(index).map_or(DVec3::ZERO, |gradient| {
                world_from_gradient * vector(*gradient) * steepness
            }),
        });
    }

    /// Adds splats made by the caller.
    pub fn add_splats(&mut self, count: usize, splat: impl Fn(usize) -> Splat + Sync) {
        self.add(count, splat);
    }

    /// Adds points as discs of their radii, or as balls where they have no normals. `color`: for points without
    /// one, sRGB; `opacity`: of a surface of the points, times their own.
    pub fn add_points(
        &mut self,
        points: &Points,
        world_from_item: &DAffine3,
        (color, opacity): ([f64; 3], f64),
    ) {
        let attributes = points.attributes();
        let frame = &(*world_from_item * *points.world_from_local());
        let linear = frame.matrix3;
        let scale = libm::cbrt(linear.determinant().abs());
        let gradient = SURFACE_GRADIENT / self.spacing;
        let world_from_normal = linear.inverse().transpose();
        let payloads = SurfacePayloads::new(color, opacity);
        self.add(points.len(), |index| {
            let radius = attributes.radii.get(index).map_or(0.0, |r| f64::from(*r));
            let normal = attributes.normals.get(index).map_or(DVec3::ZERO, |n| vector(*n));
            let disc = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
            let covariance = (DMat3::IDENTITY - disc) * (SURFEL_SIGMA * radius).powi(2);
            let normal = (world_from_normal * normal).normalize_or_zero();
            let area = (radius * scale).powi(2);
            Splat {
                centre: place(frame, points.positions()[index]),
                covariance: linear * covariance * linear.transpose(),
                payload: payloads.of(attributes.colors.get(index), area),
                gradient: normal * gradient,
            }
        });
    }

    /// Adds Gaussians, after everything else. `color`: of each in this view, sRGB.
    pub fn add_gaussians(
        &mut self,
        gaussians: &Gaussians,
        world_from_item: &DAffine3,
        color: impl Fn(usize) -> [f32; 3] + Sync,
    ) {
        self.peaks_from.get_or_insert(self.positions.len());
        let attributes = gaussians.attributes();
        let frame = &(*world_from_item * *gaussians.world_from_local());
        self.add(gaussians.len(), |index| {
            let rotation = Mat3::from_quat(Quat::from_array(attributes.rotations[index]));
            let axes = frame.matrix3
                * (rotation * Mat3::from_diagonal(Vec3::from_array(attributes.scales[index]))).as_dmat3();
            Splat {
                centre: place(frame, attributes.means[index]),
                covariance: axes * axes.transpose(),
                payload: gaussian_payload(attributes.opacities[index], color(index)),
                gradient: DVec3::ZERO,
            }
        });
    }

    /// The cloud: splats in the order of a space-filling curve.
    pub fn finish(self) -> Gathered {
        self.finish_while(|| true).expect("nobody gives it up")
    }

    /// As [`Self::finish`], cancelled when `go_on` returns false; it is called between steps of some milliseconds
    /// per million splats.
    pub fn finish_while(self, go_on: impl Fn() -> bool + Sync) -> Option<Gathered> {
        let peaks_from = self.peaks_from.unwrap_or(self.len());
        let order = self.order(peaks_from, &go_on)?;
        let sources: Vec<u32> = order.par_iter().map(|key| *key as u32).collect();
        // One after the other, so that only one field at a time is held twice.
        let positions = permuted(&sources, self.positions, &go_on)?;
        let covariances = permuted(&sources, self.covariances, &go_on)?;
        let payloads = permuted(&sources, self.payloads, &go_on)?;
        let gradients = permuted(&sources, self.gradients, &go_on)?;
        let chunks = chunks(&positions, &covariances, &order, peaks_from);
        let largest = chunks.iter().map(|chunk| chunk.sigma).fold(0.0, f32::max);
        let cloud = SplatCloud {
            world_from_local: DAffine3::from_translation(self.origin),
            positions,
            payloads,
            gradients,
            shape: KernelShape::Ellipsoids {
                largest: f64::from(largest),
            },
            covariances,
            peaks_from,
            mass: 1.0,
            spacing: self.spacing,
            chunks,
        };
        Some(Gathered { cloud, sources })
    }

    /// Sorted keys of the splats: size and place, then index. Splats with optical depths stay last.
    fn order(&self, peaks_from: usize, go_on: impl Fn() -> bool) -> Option<Vec<u64>> {
        let (low, high) = extent(&self.positions);
        let width = (high - low).max_element().max(f32::MIN_POSITIVE);
        let key = |index: usize| {
            let cell = (Vec3::from_array(self.positions[index]) - low) * (LAST_CELL / width);
            let size = (libm::log2f(largest_variance(&self.covariances[index]).max(1e-30)) * 0.5).floor();
            let class = (size - SMALLEST).clamp(0.0, LAST_CLASS) as u64;
            let place = spread(cell.x as u64) | spread(cell.y as u64) << 1 | spread(cell.z as u64) << 2;
            (class << 27 | place) << 32 | index as u64
        };
        let mut keys: Vec<u64> = (0..self.len()).into_par_iter().map(key).collect();
        let (masses, peaks) = keys.split_at_mut(peaks_from);
        for part in [masses, peaks] {
            if !go_on() {
                return None;
            }
            part.par_sort_unstable();
        }
        Some(keys)
    }
}

/// Values in the order of the cloud.
fn permuted<T: Copy + Send + Sync>(
    sources: &[u32],
    values: Vec<T>,
    go_on: impl Fn() -> bool,
) -> Option<Vec<T>> {
    go_on().then(|| {
        sources
            .par_iter()
            .map(|&source| values[source as usize])
            .collect()
    })
}

/// Payload of a Gaussian of this opacity and colour (sRGB).
pub fn gaussian_payload(opacity: f32, color: [f32; 3]) -> [f32; 4] {
    let clear = (1.0 - f64::from(opacity)).max(CLEAREST);
    payload(-libm::log(clear), color.map(f64::from))
}

/// Payloads of a surface's surfels, tabulated by the levels of their colours.
struct SurfacePayloads {
    /// Linear light of each level.
    light: [f64; 256],
    /// Optical depth of each level of opacity.
    depth: [f64; 256],
    /// Linear light of points without a colour.
    own: [f64; 3],
}

impl SurfacePayloads {
    fn new(color: [f64; 3], opacity: f64) -> Self {
        let level = |level: usize| level as f64 / 255.0;
        Self {
            light: std::array::from_fn(|l| linear_from_srgb(level(l))),
            depth: std::array::from_fn(|l| surface_depth(level(l) * opacity)),
            own: color.map(|level| linear_from_srgb(level.max(0.0))),
        }
    }

    /// Payload of a surfel of this area, world length squared.
    fn of(&self, color: Option<&[u8; 4]>, area: f64) -> [f32; 4] {
        let (light, depth) = match color {
            Some(&[r, g, b, a]) => (
                [r, g, b].map(|level| self.light[usize::from(level)]),
                self.depth[usize::from(a)],
            ),
            None => (self.own, self.depth[255]),
        };
        let depth = depth * area;
        let [r, g, b] = light.map(|light| (depth * light) as f32);
        [depth as f32, r, g, b]
    }
}

/// Optical depth of a surface.
fn surface_depth(opacity: f64) -> f64 {
    -libm::log(1.0 - opacity.min(1.0 - libm::exp(-OPAQUE)))
}

fn payload(depth: f64, color: [f64; 3]) -> [f32; 4] {
    let [r, g, b] = color.map(|level| (depth * linear_from_srgb(level.max(0.0))) as f32);
    [depth as f32, r, g, b]
}

fn vector(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

fn place(frame: &DAffine3, local: [f32; 3]) -> DVec3 {
    frame.transform_point3(vector(local))
}

fn upper(m: DMat3) -> [f32; 6] {
    [
        m.x_axis.x, m.y_axis.x, m.z_axis.x, m.y_axis.y, m.z_axis.y, m.z_axis.z,
    ]
    .map(|v| v as f32)
}

/// A bound of the variance in any direction, tight where axes differ: by rows (Gershgorin), or the trace.
fn largest_variance(&[xx, xy, xz, yy, yz, zz]: &[f32; 6]) -> f32 {
    let rows = [
        xx + xy.abs() + xz.abs(),
        yy + xy.abs() + yz.abs(),
        zz + xz.abs() + yz.abs(),
    ];
    rows.into_iter().fold(0.0, f32::max).min(xx + yy + zz)
}

fn extent(positions: &[[f32; 3]]) -> (Vec3, Vec3) {
    positions
        .par_iter()
        .map(|p| (Vec3::from_array(*p), Vec3::from_array(*p)))
        .reduce(
            || (Vec3::INFINITY, Vec3::NEG_INFINITY),
            |a, b| (a.0.min(b.0), a.1.max(b.1)),
        )
}

/// Nine bits with two zeros between each.
fn spread(bits: u64) -> u64 {
    (0..9).fold(0, |spread, bit| spread | (bits >> bit & 1) << (3 * bit))
}

/// Chunks of neighbours in the order of the keys, each of one size and kind.
fn chunks(positions: &[[f32; 3]], covariances: &[[f32; 6]], keys: &[u64], peaks_from: usize) -> Vec<Chunk> {
    let class = |index: usize| (keys[index] >> 59, index >= peaks_from);
    let mut chunks = Vec::with_capacity(positions.len() / CHUNK + 32);
    let mut first = 0;
    for end in 1..=positions.len() {
        if end < positions.len() && end - first < CHUNK && class(end) == class(first) {
            continue;
        }
        let variance = covariances[first..end]
            .iter()
            .map(largest_variance)
            .fold(0.0, f32::max);
        chunks.extend(Chunk::of(&positions[first..end], first as u32, variance.sqrt()));
        first = end;
    }
    chunks
}

#[cfg(test)]
mod tests {
    use splatvol_scene::{GaussianAttributes, PointAttributes};
    use splatvol_testing::Random;

    use super::*;

    fn gathered(count: usize) -> (Gathered, Vec<Splat>) {
        let mut random = Random::new(11);
        let splats: Vec<Splat> = (0..count)
            .map(|_| {
                let axes = DMat3::from_cols(
                    random.direction() * random.range(1e-3, 3.0),
                    random.direction() * random.range(1e-3, 0.3),
                    random.direction() * random.range(0.0, 0.1),
                );
                Splat {
                    centre: random.point(DVec3::splat(90.0), DVec3::new(100.0, 130.0, 91.0)),
                    covariance: axes * axes.transpose(),
                    payload: [1.0, 0.5, 0.25, random.unit() as f32],
                    gradient: random.direction(),
                }
            })
            .collect();
        let mut gather = Gather::around(DVec3::new(95.0, 110.0, 90.0), 1.0);
        gather.add_splats(count, |index| splats[index]);
        (gather.finish(), splats)
    }

    #[test]
    fn splats_are_sorted_and_none_is_lost() {
        let (Gathered { cloud, sources }, splats) = gathered(5000);
        let mut seen = sources.clone();
        seen.sort_unstable();
        assert!(seen.iter().enumerate().all(|(i, s)| i as u32 == *s));
        for (index, source) in sources.iter().enumerate() {
            let splat = &splats[*source as usize];
            let found = place(&cloud.world_from_local, cloud.positions[index]);
            assert!((found - splat.centre).length() < 1e-5);
            assert_eq!(cloud.covariances[index], upper(splat.covariance));
            assert_eq!(cloud.payloads[index], splat.payload);
        }
    }

    #[test]
    fn chunks_cover_all_and_hold_their_splats() {
        let (Gathered { cloud, .. }, _) = gathered(5000);
        let mut next = 0;
        for chunk in &cloud.chunks {
            assert_eq!(chunk.first, next);
            assert!(chunk.end > chunk.first && (chunk.end - chunk.first) as usize <= CHUNK);
            next = chunk.end;
            for splat in chunk.first as usize..chunk.end as usize {
                for axis in 0..3 {
                    let at = cloud.positions[splat][axis];
                    assert!((chunk.low[axis]..=chunk.high[axis]).contains(&at));
                }
                // Along random directions, no kernel is wider than the chunk's bound.
                let [xx, xy, xz, yy, yz, zz] = cloud.covariances[splat].map(f64::from);
                let c = DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
                let mut random = Random::new(splat as u64);
                for _ in 0..20 {
                    let d = random.direction();
                    assert!(d.dot(c * d).max(0.0).sqrt() <= f64::from(chunk.sigma) * (1.0 + 1e-6));
                }
            }
        }
        assert_eq!(next as usize, cloud.len());
    }

    #[test]
    fn surfels_are_flat_across_their_normals() {
        let attributes = PointAttributes {
            normals: vec![[0.0, 0.0, 2.0]],
            radii: vec![0.5],
            ..Default::default()
        };
        let frame = DAffine3::from_scale(DVec3::splat(3.0));
        let points = Points::new(vec![[1.0, 0.0, 0.0]], attributes, frame).unwrap();
        let mut gather = Gather::around(DVec3::ZERO, 1.0);
        gather.add_points(&points, &DAffine3::IDENTITY, ([1.0; 3], 0.5));
        let cloud = gather.finish().cloud;
        let sigma = (SURFEL_SIGMA * 1.5) as f32;
        let [xx, xy, xz, yy, yz, zz] = cloud.covariances[0];
        assert!((xx.sqrt() - sigma).abs() < 1e-6 && (yy.sqrt() - sigma).abs() < 1e-6);
        assert_eq!([xy, xz, yz, zz], [0.0; 4]);
        // Half opaque where one covers the area it stands for.
        let expected = 2.0_f32.ln() * 1.5 * 1.5;
        assert!((cloud.payloads[0][0] - expected).abs() < 1e-6);
        assert_eq!(cloud.positions[0], [3.0, 0.0, 0.0]);
    }

    #[test]
    fn gaussians_come_last_and_carry_their_peaks() {
        let attributes = GaussianAttributes {
            means: vec![[0.0; 3]],
            scales: vec![[1.0, 2.0, 3.0]],
            // A quarter turn about z.
            rotations: vec![[0.0, 0.0, 1.0, 1.0]],
            opacities: vec![0.75],
            harmonics: vec![[0.0; 3]],
        };
        let gaussians = Gaussians::new(attributes, 0, DAffine3::IDENTITY).unwrap();
        let mut gather = Gather::around(DVec3::ZERO, 1.0);
        gather.add_splats(1, |_| Splat {
            centre: DVec3::ONE,
            covariance: DMat3::IDENTITY * 100.0,
            payload: [1.0; 4],
            gradient: DVec3::ZERO,
        });
        gather.add_gaussians(&gaussians, &DAffine3::IDENTITY, |_| [1.0, 0.0, 0.5]);
        let Gathered { cloud, sources } = gather.finish();
        assert_eq!((cloud.peaks_from, sources), (1, vec![0, 1]));
        let found = cloud.covariances[1];
        for (found, expected) in found.into_iter().zip([4.0, 0.0, 0.0, 1.0, 0.0, 9.0]) {
            assert!((found - expected).abs() < 1e-5, "{found} {expected}");
        }
        assert!((cloud.payloads[1][0] - 4.0_f32.ln()).abs() < 1e-6);
        assert_eq!(cloud.payloads[1][2], 0.0);
    }
}
