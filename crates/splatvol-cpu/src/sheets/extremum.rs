//! Extremum: the largest or the smallest value of a ray, as the largest of a *rank*.

use fearless_simd::{f32x16, prelude::*};

use super::cubic::Cubic;

/// Which value is kept. Ranks of normalised values that occur are above 0, so that a pixel begins with rank 0.
pub(crate) trait Extremum: Sync {
    /// Ranks of sixteen normalised values, or values of ranks: the map is its own inverse.
    fn rank_lanes<S: Simd>(value: f32x16<S>) -> f32x16<S>;

    /// Ranks along a ray whose values these are.
    fn rank_cubic<S: Simd>(values: Cubic<S>) -> Cubic<S>;

    /// Ranks up to this show nothing, where values outside `hull` are invisible.
    fn least_rank(hull: [f32; 2]) -> f32;
}

/// The largest value.
#[derive(Debug)]
pub(crate) struct Largest;

/// The smallest value; its rank is its distance from 2, which is above what an interpolation of values up to 1 reaches.
#[derive(Debug)]
pub(crate) struct Smallest;

impl Extremum for Largest {
    #[inline(always)]
    fn rank_lanes<S: Simd>(value: f32x16<S>) -> f32x16<S> {
        value
    }

    #[inline(always)]
    fn rank_cubic<S: Simd>(values: Cubic<S>) -> Cubic<S> {
        values
    }

    #[inline(always)]
    fn least_rank([low, _]: [f32; 2]) -> f32 {
        low.max(0.0)
    }
}

impl Extremum for Smallest {
    #[inline(always)]
    fn rank_lanes<S: Simd>(value: f32x16<S>) -> f32x16<S> {
        2.0 - value
    }

    #[inline(always)]
    fn rank_cubic<S: Simd>(values: Cubic<S>) -> Cubic<S> {
        values.less_than(2.0)
    }

    #[inline(always)]
    fn least_rank([_, high]: [f32; 2]) -> f32 {
        (2.0 - high).max(0.0)
    }
}
