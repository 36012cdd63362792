//! A pixel between two planes: value, coverage, gradient and place along its ray.
//!
//! A scalar version of `shade`: the value is the cubic through both planes, and the gradient consists of the
//! planes' central differences across the ray and a difference of four planes along it.

use glam::{Affine3A, Vec3};
use splatvol_scene::SheetSample;

use super::crossing::Cubic;
use super::cut::{Cut, RaySegment, Side};
use super::holes::beside_of;
use super::plane::{HALO, Plane};
use super::shade::{Interval, PlaneShader, depth_slope_of};

/// From camera space and normalised values to the world and data units.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Units {
    pub world_from_camera: Affine3A,
    /// Data value at 0, and the difference from there to 1.
    pub lowest: f32,
    pub range: f32,
}

/// Shader, interval and place from which a frame's pixels are made.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pixels<'a> {
    pub shader: &'a PlaneShader<'a>,
    pub interval: &'a Interval<'a>,
    /// Image coordinates of the tile's first pixel.
    pub origin: [usize; 2],
}

/// A pixel between two planes.
#[derive(Debug, Clone)]
pub(crate) struct Pixel {
    pub cubic: Cubic,
    /// Values at both ends.
    ends: [f32; 2],
    /// Sums of the four planes, for the slope that lighting uses: the values, except beside holes.
    whole: [f32; 4],
    coverage: [f32; 2],
    /// Differences across the ray on both planes, per world length.
    across: [[f32; 2]; 2],
    sharpness: f32,
    spacing: f32,
    /// Motion of the ray in camera x and y per depth.
    ray: [f32; 2],
    /// Camera space.
    pub segment: RaySegment,
    /// World length of the ray's part.
    pub length: f32,
    /// It begins at the eye.
    pub from_eye: bool,
}

impl Pixels<'_> {
    /// Motion of a pixel's ray in camera x and y per depth, and its points on both planes, camera space.
    fn ends(&self, [x, y]: [usize; 2]) -> ([f32; 2], [Vec3; 2]) {
        let shader = self.shader;
        let in_picture = [self.origin[0] + x, self.origin[1] + y];
        let from_middle = [0, 1].map(|a| in_picture[a] as f32 + 0.5 - shader.principal[a]);
        let ray = from_middle.map(|d| d * shader.per_pixel);
        let ends = self.interval.depths.map(|depth| {
            if shader.per_pixel > 0.0 {
                Vec3::new(ray[0] * depth, ray[1] * depth, depth)
            } else {
                let [x, y] = from_middle.map(|d| d * shader.plane_per_pixel);
                Vec3::new(x, y, depth)
            }
        });
        (ray, ends)
    }

    /// Side of all points of the interval in a rectangle of pixels of the tile, its ends included.
    pub(crate) fn side(&self, cut: &Cut, [x0, y0, x1, y1]: [usize; 4]) -> Side {
        let corners = [[x0, y0], [x1, y0], [x0, y1], [x1, y1]].map(|corner| self.ends(corner).1);
        cut.side(corners.as_flattened(), 2.0)
    }

    /// Side of the interval of one pixel.
    pub(crate) fn side_of(&self, cut: &Cut, pixel: [usize; 2]) -> Side {
        cut.side(&self.ends(pixel).1, 1.0)
    }

    /// The pixel at x, y of the tile; `None` where it is invisible.
    pub(crate) fn get(&self, [x, y]: [usize; 2]) -> Option<Pixel> {
        let Self { shader, interval, .. } = self;
        let [before, near, far, after] = interval.planes;
        let at = (y + HALO) * near.pitch + x + HALO;
        let sums = [before, near, far, after].map(|plane| plane.values[at]);
        let of = interval
            .weights
            .map_or([near, far], |[_, near, far, _]| [near, far]);
        let untouched = of.iter().all(|plane| plane.values[at] == 0.0);
        if untouched && !shader.table.shows_background {
            return None;
        }
        let in_picture = [self.origin[0] + x, self.origin[1] + y];
        let (mut coverage, mut weights) = ([1.0; 2], [1.0; 2]);
        if interval.is_near_border {
            for end in 0..2 {
                [coverage[end], weights[end]] = shader.border.at_pixel(&interval.borders[end], in_picture);
            }
        }
        if coverage == [0.0; 2] {
            return None;
        }
        let weights = [weights[0], weights[0], weights[1], weights[1]];
        let sums: [f32; 4] = std::array::from_fn(|i| sums[i] * weights[i]);
        let mut values = sums.map(|sum| sum + shader.background);
        let mut whole = values;
        if let Some(holes) = interval.holes {
            let missing: [f32; 4] = std::array::from_fn(|i| holes[i].values[at] * weights[i]);
            let (beside, left) = beside_of((sums, false), missing, coverage);
            (values, coverage) = (beside.map(|sum| sum + shader.background), left);
            whole = std::array::from_fn(|i| whole[i] - missing[i] * shader.background);
        }
        if let Some(shares) = interval.weights {
            let missing: [f32; 4] = std::array::from_fn(|i| (1.0 - shares[i].values[at]).max(0.0));
            (values, coverage) = beside_of((sums, true), missing, coverage);
            whole = values;
        }
        let cubic = Cubic::through(values);
        let [low, high] = cubic.bounds();
        let [first, last] = shader.table.hull;
        if high < first || low > last {
            return None;
        }
        let mut across = [0, 1].map(|end| {
            let scale = 0.5 * interval.scales[end];
            let difference =
                |plane: &Plane, step: usize| (plane.values[at + step] - plane.values[at - step]) * scale;
            let plane = [near, far][end];
            let along = [difference(plane, 1), difference(plane, plane.pitch)];
            match interval.holes {
                None => along,
                Some(holes) => {
                    let missing = [
                        difference(holes[1 + end], 1),
                        difference(holes[1 + end], plane.pitch),
                    ];
                    [0, 1].map(|axis| along[axis] - missing[axis] * shader.background)
                }
            }
        });
        if let Some([x, y, _]) = interval.at_eye {
            across[0] = [x, y];
        }
        let (ray, [start, end]) = self.ends([x, y]);
        Some(Pixel {
            cubic,
            ends: [values[1], values[2]],
            whole,
            coverage,
            across,
            sharpness: interval.sharpness(shader.spacing),
            spacing: shader.spacing,
            ray,
            segment: RaySegment {
                from: start,
                step: end - start,
            },
            from_eye: interval.at_eye.is_some(),
            length: (ray[0] * ray[0] + (1.0 + ray[1] * ray[1])).sqrt() * shader.spacing,
        })
    }
}

impl Pixel {
    /// Values at both ends.
    pub(crate) fn ends(&self) -> [f32; 2] {
        self.ends
    }

    /// Value at a place, 0 to 1; the planes' own at both ends.
    pub(crate) fn value(&self, u: f32) -> f32 {
        if u >= 1.0 { self.ends[1] } else { self.cubic.at(u) }
    }

    pub(crate) fn coverage(&self, u: f32) -> f32 {
        self.coverage[0] + (self.coverage[1] - self.coverage[0]) * u
    }

    /// Gradient of the normalised value, camera space, per world length.
    fn gradient(&self, u: f32) -> Vec3 {
        let [near, far] = self.across;
        let gx = (far[0] - near[0]) * u + near[0];
        let gy = (far[1] - near[1]) * u + near[1];
        let slope = depth_slope_of(self.whole, u, self.sharpness);
        let gz = slope * (1.0 / self.spacing) - self.ray[0] * gx - gy * self.ray[1];
        Vec3::new(gx, gy, gz)
    }

    /// The sample passed to operators, of a value at a place, and the length of the normalised gradient.
    pub(crate) fn sample(&self, (u, value): (f32, f32), units: &Units) -> (SheetSample, f32) {
        let gradient = self.gradient(u);
        let place = self.segment.from + self.segment.step * u;
        let to_world = |v: Vec3| units.world_from_camera.transform_vector3(v);
        let view = -Vec3::new(self.ray[0], self.ray[1], 1.0).normalize();
        let sample = SheetSample {
            value: units.lowest + value * units.range,
            gradient: to_world(gradient * units.range),
            position: units.world_from_camera.transform_point3(place),
            view: to_world(view),
            depth: place.z,
        };
        (sample, gradient.length())
    }
}
