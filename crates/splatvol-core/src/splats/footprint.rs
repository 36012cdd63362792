//! The footprint: from a pixel to the radius at which its ray passes the kernel.
//!
//! A pixel gets `weight gain profile(r^2)`, world length: the line integral along the pixel's ray of a kernel whose
//! integral over space is its cell. What the methods of alignment differ in is the map from pixels to `r^2`, the [`Warp`].

/// A splat as the picture sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footprint {
    /// Projected centre, pixels.
    pub centre: [f32; 2],
    /// Box that holds all pixels of the footprint: x0, y0, x1, y1, pixels.
    pub bounds: [f32; 4],
    /// Line integral through the centre, world length, where the warp's gain is 1.
    pub weight: f32,
    /// What a splat's opacity is multiplied by (`swan-alpha`); 1 otherwise.
    pub opacity: f32,
    /// Camera depth of the centre.
    pub depth: f32,
    /// Standard deviation in depth along a ray.
    pub depth_sigma: f32,
    /// From pixels to radii.
    pub warp: Warp,
}

/// How a pixel's ray meets a kernel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Squared distance of the ray from the centre, standard deviations of the kernel.
    pub squared: f32,
    /// What the weight is multiplied by.
    pub gain: f32,
    /// Camera depth of the point of the ray that is nearest to the centre.
    pub depth: f32,
    /// Standard deviation in depth along the ray.
    pub depth_sigma: f32,
}

/// Maps from pixels to radii.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Warp {
    /// `r^2 = d^T Q d`, d the pixel's offset from the centre.
    Affine {
        /// Conic Q: xx, xy, yy, per pixel squared.
        conic: [f32; 3],
        /// Depth of the ray's nearest point per pixel of offset.
        slope: [f32; 2],
    },
    /// The true distance of the pixel's ray from the centre.
    Ray(Ray),
}

/// A kernel in perspective: whitened camera space, where it is a unit sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Inverse of the covariance's Cholesky factor, rows of the lower triangle: 00, 10, 11, 20, 21, 22.
    pub whitening: [f32; 6],
    /// The centre, whitened.
    pub centre: [f32; 3],
    /// Principal point, pixels.
    pub principal: [f32; 2],
    /// Rays' x and y per pixel at depth 1.
    pub per_pixel: f32,
}

impl Ray {
    /// With `w = L^-1 (x, y, 1)` the pixel's whitened direction and `c = L^-1 u` the centre: `r = |c x w| / |w|`; a piece of
    /// the ray of length `|(x, y, 1)|` is `|w|` standard deviations long, which is the gain.
    #[inline(always)]
    pub fn at(&self, [px, py]: [f32; 2]) -> Sample {
        let x = (px - self.principal[0]) * self.per_pixel;
        let y = (py - self.principal[1]) * self.per_pixel;
        let [a, b, c, d, e, f] = self.whitening;
        let w = [a * x, b * x + c * y, d * x + e * y + f];
        let u = self.centre;
        let length_squared = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
        let cross = [
            u[1] * w[2] - u[2] * w[1],
            u[2] * w[0] - u[0] * w[2],
            u[0] * w[1] - u[1] * w[0],
        ];
        let distance = cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2];
        let inverse = 1.0 / length_squared;
        let along = u[0] * w[0] + u[1] * w[1] + u[2] * w[2];
        let depth_sigma = inverse.sqrt();
        Sample {
            squared: distance * inverse,
            gain: (1.0 + x * x + y * y).sqrt() * depth_sigma,
            depth: along * inverse,
            depth_sigma,
        }
    }
}

impl Footprint {
    /// How the ray through a point of the picture (pixels) meets the kernel.
    #[inline(always)]
    pub fn at(&self, [px, py]: [f32; 2]) -> Sample {
        match self.warp {
            Warp::Affine { conic, slope } => {
                let (dx, dy) = (px - self.centre[0], py - self.centre[1]);
                let [xx, xy, yy] = conic;
                Sample {
                    squared: xx * dx * dx + 2.0 * xy * dx * dy + yy * dy * dy,
                    gain: 1.0,
                    depth: self.depth + slope[0] * dx + slope[1] * dy,
                    depth_sigma: self.depth_sigma,
                }
            }
            Warp::Ray(ray) => ray.at([px, py]),
        }
    }
}
