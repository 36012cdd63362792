//! The value between two planes: the cubic of `shade`, through both planes with slopes from the planes beside them.
//!
//! The cubic lies within the range of its Bezier points, which for most intervals is below the pixel's value so
//! far. Otherwise its largest value is at an end, or at the root `b / (sqrt(c^2 - 3 b d) - c)` of its derivative.
//! Near the volume's border coverage is the parabola through its values at both ends and in the middle; only points
//! with a coverage of a half or more count there.

use fearless_simd::{f32x16, prelude::*};

/// The cubic between two planes, `a + u (b + u (c + u d))`, and its value at the far one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cubic<S: Simd> {
    a: f32x16<S>,
    b: f32x16<S>,
    c: f32x16<S>,
    d: f32x16<S>,
    end: f32x16<S>,
    /// No value exceeds it.
    pub bound: f32x16<S>,
}

impl<S: Simd> Cubic<S> {
    /// Through the middle two of four values with the slopes that the outer ones give.
    #[inline(always)]
    pub(crate) fn through([before, near, far, after]: [f32x16<S>; 4]) -> Self {
        Self::with_slopes([near, far], [(far - before) * 0.5, (after - near) * 0.5])
    }

    /// Through two values with these slopes.
    #[inline(always)]
    pub(crate) fn with_slopes([near, far]: [f32x16<S>; 2], [start, end]: [f32x16<S>; 2]) -> Self {
        let rise = far - near;
        Self {
            a: near,
            b: start,
            c: rise * 3.0 - start * 2.0 - end,
            d: start + end - rise * 2.0,
            end: far,
            bound: near
                .max(far)
                .max((near + start * (1.0 / 3.0)).max(far - end * (1.0 / 3.0))),
        }
    }

    /// The cubic `number - self`.
    #[inline(always)]
    pub(crate) fn less_than(&self, number: f32) -> Self {
        let slope = self.b + self.c * 2.0 + self.d * 3.0;
        Self::with_slopes(
            [number - self.a, number - self.end],
            [self.b * -1.0, slope * -1.0],
        )
    }

    #[inline(always)]
    pub(crate) fn at(&self, u: f32x16<S>) -> f32x16<S> {
        ((self.d * u + self.c) * u + self.b) * u + self.a
    }

    /// Place of its local maximum; outside of (0, 1), or NaN, where the interval has none.
    #[inline(always)]
    fn summit(&self, simd: S) -> f32x16<S> {
        let zero = f32x16::splat(simd, 0.0);
        let square = self.c * self.c - self.b * self.d * 3.0;
        let root = square.max(zero).sqrt();
        // Two forms of the same: neither takes a difference of alike numbers.
        let convex = self.c.simd_gt(zero);
        let u = convex.select(self.c + root, self.b) / convex.select(self.d * -3.0, root - self.c);
        square.simd_gt(zero).select(u, zero)
    }

    /// Its largest value, and where.
    #[inline(always)]
    pub(crate) fn largest(&self, simd: S) -> (f32x16<S>, f32x16<S>) {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let u = self.summit(simd);
        let ends = self.a.max(self.end);
        let place = self.a.simd_ge(self.end).select(zero, one);
        let value = self.at(u);
        let peak = u.simd_gt(zero) & u.simd_lt(one) & value.simd_gt(ends);
        (peak.select(value, ends), peak.select(u, place))
    }

    /// The largest value where coverage is a half or more: at an end, at the maximum, or where coverage is a half;
    /// -1 where coverage is less everywhere. Values must be above -1.
    #[inline(always)]
    pub(crate) fn largest_covered(&self, simd: S, coverage: &Parabola<S>) -> (f32x16<S>, f32x16<S>) {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let half = f32x16::splat(simd, 0.5);
        let [first, second] = coverage.crossings(simd);
        let mut best = (f32x16::splat(simd, -1.0), zero);
        for (u, is_crossing) in [
            (zero, false),
            (one, false),
            (self.summit(simd), false),
            (first, true),
            (second, true),
        ] {
            let value = self.at(u);
            let mut better = u.simd_ge(zero) & u.simd_le(one) & value.simd_gt(best.0);
            if !is_crossing {
                better &= coverage.at(u).simd_ge(half);
            }
            best = (better.select(value, best.0), better.select(u, best.1));
        }
        best
    }

    /// Integrals over the interval of the coverage, of the value times the coverage and of the position times the
    /// coverage.
    #[inline(always)]
    pub(crate) fn covered_integrals(&self, coverage: &Parabola<S>) -> [f32x16<S>; 3] {
        let Self { a, b, c, d, .. } = *self;
        let Parabola { bend, slope, from } = *coverage;
        let plain = self.mean();
        let once = a * (1.0 / 2.0) + b * (1.0 / 3.0) + c * (1.0 / 4.0) + d * (1.0 / 5.0);
        let twice = a * (1.0 / 3.0) + b * (1.0 / 4.0) + c * (1.0 / 5.0) + d * (1.0 / 6.0);
        [
            from + slope * (1.0 / 2.0) + bend * (1.0 / 3.0),
            from * plain + slope * once + bend * twice,
            from * (1.0 / 2.0) + slope * (1.0 / 3.0) + bend * (1.0 / 4.0),
        ]
    }

    /// Its mean.
    #[inline(always)]
    pub(crate) fn mean(&self) -> f32x16<S> {
        self.a + self.b * (1.0 / 2.0) + self.c * (1.0 / 3.0) + self.d * (1.0 / 4.0)
    }
}

/// Coverage along an interval, `from + u (slope + u bend)`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Parabola<S: Simd> {
    bend: f32x16<S>,
    slope: f32x16<S>,
    from: f32x16<S>,
}

impl<S: Simd> Parabola<S> {
    /// Through values at both ends and in the middle.
    #[inline(always)]
    pub(crate) fn through([from, middle, to]: [f32x16<S>; 3]) -> Self {
        let bend = (from + to) * 2.0 - middle * 4.0;
        Self {
            bend,
            slope: to - from - bend,
            from,
        }
    }

    #[inline(always)]
    fn at(&self, u: f32x16<S>) -> f32x16<S> {
        (self.bend * u + self.slope) * u + self.from
    }

    /// Places at which it is a half; outside of 0 to 1, or NaN, where the interval has none.
    #[inline(always)]
    fn crossings(&self, simd: S) -> [f32x16<S>; 2] {
        let zero = f32x16::splat(simd, 0.0);
        let above = self.from - 0.5;
        let square = self.slope * self.slope - self.bend * above * 4.0;
        let root = square.max(zero).sqrt();
        let falls = self.slope.simd_lt(zero);
        let sum = (self.slope + falls.select(zero - root, root)) * -0.5;
        let nowhere = f32x16::splat(simd, -1.0);
        let is_real = square.simd_ge(zero);
        [
            is_real.select(sum / self.bend, nowhere),
            is_real.select(above / sum, nowhere),
        ]
    }

    /// Its largest value.
    #[inline(always)]
    pub(crate) fn largest(&self, simd: S) -> f32x16<S> {
        let zero = f32x16::splat(simd, 0.0);
        let u = self.slope / (self.bend * -2.0);
        let ends = self.from.max(self.from + self.slope + self.bend);
        let inside = self.bend.simd_lt(zero) & u.simd_gt(zero) & u.simd_lt(f32x16::splat(simd, 1.0));
        inside.select(self.at(u), ends)
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::*;

    /// Largest value and where, by the closed form and by many samples, for sixteen quadruples of values.
    #[inline(always)]
    fn both<S: Simd>(simd: S, values: [[f32; 16]; 4]) -> [[f32; 16]; 3] {
        let cubic = Cubic::through(values.map(|v| f32x16::from_slice(simd, &v)));
        let (value, place) = cubic.largest(simd);
        let mut sampled = cubic.at(f32x16::splat(simd, 0.0));
        for i in 1..=4000 {
            sampled = sampled.max(cubic.at(f32x16::splat(simd, i as f32 / 4000.0)));
        }
        let at_place = (cubic.at(place) - value).abs();
        assert!(
            (cubic.bound + 1e-6).simd_ge(sampled).all_true(),
            "the bound holds"
        );
        [value, sampled, at_place].map(|v| v.as_slice().try_into().expect("sixteen lanes"))
    }

    /// Uniform in 0..1, independent for neighbouring seeds.
    fn unit(seed: usize) -> f32 {
        let mut z = (seed as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z >> 40) as f32 / 16_777_216.0
    }

    fn units<const N: usize>(from: usize) -> [[f32; 16]; N] {
        std::array::from_fn(|i| std::array::from_fn(|lane| unit(from + i * 16 + lane)))
    }

    /// Largest covered value, and the value at the place returned for it, for sixteen lanes.
    #[inline(always)]
    fn covered<S: Simd>(simd: S, values: [[f32; 16]; 4], coverage: [[f32; 16]; 3]) -> [[f32; 16]; 3] {
        let cubic = Cubic::through(values.map(|v| f32x16::from_slice(simd, &v)));
        let coverage = Parabola::through(coverage.map(|v| f32x16::from_slice(simd, &v)));
        let (value, place) = cubic.largest_covered(simd, &coverage);
        [value, cubic.at(place), coverage.largest(simd)]
            .map(|v| v.as_slice().try_into().expect("sixteen lanes"))
    }

    #[test]
    fn the_largest_covered_value_is_that_of_many_samples() {
        const COUNT: usize = 4000;
        let (mut none, mut some) = (0, 0);
        for round in 0..60 {
            let values: [[f32; 16]; 4] = units(round * 200);
            let coverage: [[f32; 16]; 3] = units(round * 200 + 100);
            let found = dispatch!(Level::new(), simd => covered(simd, values, coverage));
            for lane in 0..16 {
                let (mut largest, mut most) = (-1.0f64, 0.0f64);
                for i in 0..=COUNT {
                    let u = i as f64 / COUNT as f64;
                    let q = parabola(coverage.map(|q| f64::from(q[lane])), u);
                    most = most.max(q);
                    if q >= 0.5 {
                        largest = largest.max(hermite(values.map(|v| f64::from(v[lane])), u));
                    }
                }
                let [value, at_place, most_found] = found.map(|lanes| f64::from(lanes[lane]));
                assert!(
                    (most_found - most).abs() < 1e-5,
                    "{round} {lane}: {most_found} {most}"
                );
                if (most - 0.5).abs() < 1e-4 {
                    continue;
                }
                // Samples miss up to a step of a slope of 3 where coverage crosses a half.
                assert!(
                    (value - largest).abs() < 1e-3 && value > largest - 2e-6,
                    "{round} {lane}: {value}, sampled {largest}"
                );
                if largest >= 0.0 {
                    assert!((at_place - value).abs() < 1e-6);
                    some += 1;
                } else {
                    none += 1;
                }
            }
        }
        assert!(none > 50 && some > 500, "{none} {some}");
    }

    /// Hermite's form of the cubic.
    fn hermite([p, a, b, n]: [f64; 4], u: f64) -> f64 {
        (1.0 + 2.0 * u) * (1.0 - u).powi(2) * a
            + u * (1.0 - u).powi(2) * 0.5 * (b - p)
            + u * u * (3.0 - 2.0 * u) * b
            + u * u * (u - 1.0) * 0.5 * (n - a)
    }

    /// Lagrange's form of the parabola.
    fn parabola([from, middle, to]: [f64; 3], u: f64) -> f64 {
        from * (1.0 - u) * (1.0 - 2.0 * u) + middle * 4.0 * u * (1.0 - u) + to * u * (2.0 * u - 1.0)
    }

    #[test]
    fn the_largest_value_of_an_interval_is_that_of_many_samples() {
        for round in 0..50 {
            let mut values: [[f32; 16]; 4] = units(round * 64);
            if round == 0 {
                values = [[0.25; 16]; 4];
            }
            let [value, sampled, at_place] = dispatch!(Level::new(), simd => both(simd, values));
            for lane in 0..16 {
                assert!((value[lane] - sampled[lane]).abs() < 2e-6, "{round} {lane}");
                assert!(at_place[lane] < 1e-6, "{round} {lane}");
            }
        }
    }

    /// Sums of a cubic and `2 - cubic` at eleven places of sixteen lanes.
    #[inline(always)]
    fn with_its_complement<S: Simd>(simd: S, values: [[f32; 16]; 4]) -> Vec<f32> {
        let cubic = Cubic::through(values.map(|v| f32x16::from_slice(simd, &v)));
        let complement = cubic.less_than(2.0);
        let places = (0..=10).map(|i| f32x16::splat(simd, i as f32 / 10.0));
        places
            .flat_map(|u| (cubic.at(u) + complement.at(u)).as_slice().to_vec())
            .collect()
    }

    #[test]
    fn a_number_less_a_cubic_is_that_everywhere() {
        for round in 0..20 {
            for sum in dispatch!(Level::new(), simd => with_its_complement(simd, units(round * 64))) {
                assert!((sum - 2.0).abs() < 2e-6, "{round}: {sum}");
            }
        }
    }

    /// The three integrals and the mean, for values and coverages of sixteen lanes.
    #[inline(always)]
    fn integrals<S: Simd>(simd: S, values: [[f32; 16]; 4], coverage: [[f32; 16]; 3]) -> [[f32; 16]; 4] {
        let cubic = Cubic::through(values.map(|v| f32x16::from_slice(simd, &v)));
        let coverage = Parabola::through(coverage.map(|v| f32x16::from_slice(simd, &v)));
        let [a, b, c] = cubic.covered_integrals(&coverage);
        [a, b, c, cubic.mean()].map(|v| v.as_slice().try_into().expect("sixteen lanes"))
    }

    #[test]
    fn covered_integrals_are_those_of_many_samples() {
        let (values, coverage): ([[f32; 16]; 4], [[f32; 16]; 3]) = (units(0), units(999));
        let found = dispatch!(Level::new(), simd => integrals(simd, values, coverage));
        for lane in 0..16 {
            let mut sums = [0.0; 4];
            const COUNT: usize = 20_000;
            for i in 0..COUNT {
                let u = (i as f64 + 0.5) / COUNT as f64;
                let v = hermite(values.map(|v| f64::from(v[lane])), u);
                let q = parabola(coverage.map(|q| f64::from(q[lane])), u);
                for (sum, term) in sums.iter_mut().zip([q, q * v, q * u, v]) {
                    *sum += term / COUNT as f64;
                }
            }
            for (found, expected) in found.iter().zip(sums) {
                assert!(
                    (f64::from(found[lane]) - expected).abs() < 2e-6,
                    "{lane}: {found:?} {expected}"
                );
            }
        }
    }
}
