//! Small symmetric matrices. In 64 bits: flat kernels differ from singular ones by less than the precision of 32
//! bits.

use glam::{DMat3, DVec2, DVec3};

/// Symmetric 3 x 3: xx, xy, xz, yy, yz, zz.
pub(super) type Covariance = [f64; 6];

/// Symmetric 2 x 2: xx, xy, yy.
pub(super) type Planar = [f64; 3];

/// Inverse of a covariance's lower Cholesky factor: 00, 10, 11, 20, 21, 22.
#[derive(Debug, Clone, Copy)]
pub(super) struct Whitening(pub [f64; 6]);

pub(super) fn symmetric(m: DMat3) -> Covariance {
    [
        m.x_axis.x, m.y_axis.x, m.z_axis.x, m.y_axis.y, m.z_axis.y, m.z_axis.z,
    ]
}

/// `A C A^T`.
#[inline(always)]
pub(super) fn transformed([xx, xy, xz, yy, yz, zz]: Covariance, a: DMat3) -> Covariance {
    let c = DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
    symmetric(a * c * a.transpose())
}

/// `v^T C v`.
#[inline(always)]
pub(super) fn along([xx, xy, xz, yy, yz, zz]: Covariance, v: DVec3) -> f64 {
    xx * v.x * v.x
        + yy * v.y * v.y
        + zz * v.z * v.z
        + 2.0 * (xy * v.x * v.y + xz * v.x * v.z + yz * v.y * v.z)
}

/// `C + s v v^T`.
#[inline(always)]
pub(super) fn add_square([xx, xy, xz, yy, yz, zz]: Covariance, v: DVec3, s: f64) -> Covariance {
    let DVec3 { x, y, z } = v;
    [
        xx + s * x * x,
        xy + s * x * y,
        xz + s * x * z,
        yy + s * y * y,
        yz + s * y * z,
        zz + s * z * z,
    ]
}

/// Covariance projected along `(along, 1)`: `A C A^T`, `A = [I, -along]`.
#[inline(always)]
pub(super) fn seen_along([xx, xy, xz, yy, yz, zz]: Covariance, along: DVec2) -> Planar {
    [
        xx - 2.0 * along.x * xz + along.x * along.x * zz,
        xy - along.x * yz - along.y * xz + along.x * along.y * zz,
        yy - 2.0 * along.y * yz + along.y * along.y * zz,
    ]
}

#[inline(always)]
pub(super) fn determinant([xx, xy, yy]: Planar) -> f64 {
    xx * yy - xy * xy
}

/// `v^T C v`.
#[inline(always)]
pub(super) fn quadratic([xx, xy, yy]: Planar, v: DVec2) -> f64 {
    xx * v.x * v.x + 2.0 * xy * v.x * v.y + yy * v.y * v.y
}

/// The smaller eigenvalue.
#[inline(always)]
pub(super) fn least_variance([xx, xy, yy]: Planar) -> f64 {
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    (mean - (half * half + xy * xy).sqrt()).max(0.0)
}

impl Whitening {
    /// Whitening of a covariance; a flat kernel keeps a thousandth of its width.
    #[inline(always)]
    pub(super) fn new([xx, xy, xz, yy, yz, zz]: Covariance) -> Self {
        let least = 1e-6 * (xx + yy + zz);
        let l00 = xx.max(least).sqrt();
        let (l10, l20) = (xy / l00, xz / l00);
        let l11 = (yy - l10 * l10).max(least).sqrt();
        let l21 = (yz - l20 * l10) / l11;
        let l22 = (zz - l20 * l20 - l21 * l21).max(least).sqrt();
        let (i00, i11, i22) = (1.0 / l00, 1.0 / l11, 1.0 / l22);
        let i10 = -l10 * i00 * i11;
        let i21 = -l21 * i11 * i22;
        let i20 = -(l20 * i00 + l21 * i10) * i22;
        Self([i00, i10, i11, i20, i21, i22])
    }

    #[inline(always)]
    pub(super) fn apply(&self, v: DVec3) -> DVec3 {
        let [a, b, c, d, e, f] = self.0;
        DVec3::new(a * v.x, b * v.x + c * v.y, d * v.x + e * v.y + f * v.z)
    }

    /// The transpose times a vector: `W^T W v` is `C^-1 v`.
    #[inline(always)]
    pub(super) fn apply_transposed(&self, v: DVec3) -> DVec3 {
        let [a, b, c, d, e, f] = self.0;
        DVec3::new(a * v.x + b * v.y + d * v.z, c * v.y + e * v.z, f * v.z)
    }

    pub(super) fn determinant(&self) -> f64 {
        self.0[0] * self.0[2] * self.0[5]
    }
}

/// Least and greatest singular value.
pub(super) fn singular_values(m: DMat3) -> [f64; 2] {
    // Eigenvalues of the symmetric 3 x 3 matrix M M^T, by the trigonometric form of Cardano's formula.
    let a = m * m.transpose();
    let mean = (a.x_axis.x + a.y_axis.y + a.z_axis.z) / 3.0;
    let b = a - DMat3::from_diagonal(DVec3::splat(mean));
    let norm = (b.x_axis.length_squared() + b.y_axis.length_squared() + b.z_axis.length_squared()) / 6.0;
    if norm <= 1e-24 * mean * mean {
        return [mean.sqrt(); 2];
    }
    let p = norm.sqrt();
    let angle = libm::acos((b.determinant() / (2.0 * p * p * p)).clamp(-1.0, 1.0)) / 3.0;
    let most = mean + 2.0 * p * libm::cos(angle);
    let least = mean + 2.0 * p * libm::cos(angle + 2.0 * std::f64::consts::FRAC_PI_3);
    [least.max(1e-12 * most).sqrt(), most.sqrt()]
}
