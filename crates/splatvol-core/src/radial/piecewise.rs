//! Kernels that are cubic polynomials of the distance, piece by piece.
//!
//! With `r = sqrt(rho^2 + z^2)` and `L = asinh(z / rho)` the integrals along a line are elementary:
//!
//! `int dz = z`, `int r dz = (z r + rho^2 L) / 2`, `int r^2 dz = rho^2 z + z^3 / 3`,
//! `int r^3 dz = z r^3 / 4 + 3 rho^2 (z r + rho^2 L) / 8`.

/// A polynomial `a_0 + a_1 r + a_2 r^2 + a_3 r^3` up to a distance.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    end: f64,
    coefficients: [f64; 4],
}

/// Two pieces, and zero beyond.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PiecewiseCubic {
    pieces: [Piece; 2],
}

impl PiecewiseCubic {
    /// Crawfis and Max 1993 (Texture splats for 3D scalar and vector field visualization): optimised for the
    /// least ripple of the sum over the lattice. The second piece is written in powers of the distance from the edge.
    pub(super) fn crawfis_max() -> Self {
        const EDGE: f64 = 1.556_228;
        // p (t - r)^2 + q (t - r)^3 in powers of r.
        let (p, q) = (0.067_599, 0.282_474);
        let outer = [
            p * EDGE * EDGE + q * EDGE.powi(3),
            -2.0 * p * EDGE - 3.0 * q * EDGE * EDGE,
            p + 3.0 * q * EDGE,
            -q,
        ];
        Self::new([
            (0.893_998, [0.557_526, 0.0, -1.157_743, 0.671_033]),
            (EDGE, outer),
        ])
    }

    /// The cubic B-spline's profile `2/3 - r^2 + r^3 / 2` and `(2 - r)^3 / 6` as a function of the distance.
    pub(super) fn cubic_bspline() -> Self {
        Self::new([
            (1.0, [2.0 / 3.0, 0.0, -1.0, 0.5]),
            (2.0, [4.0 / 3.0, -2.0, 1.0, -1.0 / 6.0]),
        ])
    }

    fn new(pieces: [(f64, [f64; 4]); 2]) -> Self {
        Self {
            pieces: pieces.map(|(end, coefficients)| Piece { end, coefficients }),
        }
    }

    pub(super) fn support(&self) -> f64 {
        self.pieces[1].end
    }

    /// Radius at which the pieces meet.
    pub(super) fn knot(&self) -> f64 {
        self.pieces[0].end
    }

    pub(super) fn value(&self, r: f64) -> f64 {
        let piece = self.pieces[usize::from(r > self.knot())];
        let [a0, a1, a2, a3] = piece.coefficients;
        a0 + r * (a1 + r * (a2 + r * a3))
    }

    /// `int_0^z h dz` at the squared distance from the axis, z within the support.
    pub(super) fn half_line(&self, rho2: f64, z: f64) -> f64 {
        let mut from = 0.0;
        let mut sum = 0.0;
        for piece in &self.pieces {
            let to = z.min((piece.end * piece.end - rho2).max(0.0).sqrt());
            if to > from {
                sum += piece.antiderivative(rho2, to) - piece.antiderivative(rho2, from);
                from = to;
            }
        }
        sum
    }
}

impl Piece {
    fn antiderivative(&self, rho2: f64, z: f64) -> f64 {
        let [a0, a1, a2, a3] = self.coefficients;
        let r2 = rho2 + z * z;
        let r = r2.sqrt();
        // rho^2 asinh(z / rho) vanishes on the axis.
        let logarithm = if rho2 > 0.0 {
            rho2 * libm::asinh(z / rho2.sqrt())
        } else {
            0.0
        };
        let linear = 0.5 * (z * r + logarithm);
        a0 * z + a1 * linear + a2 * z * (rho2 + z * z / 3.0) + a3 * (0.25 * z * r * r2 + 0.75 * rho2 * linear)
    }
}
