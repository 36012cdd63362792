//! Extremum: the largest or the smallest value of a ray, as the largest of a *rank*.

use fearless_simd::{f32x16, prelude::*};

use super::cubic::Cubic;
use super::intensity::Extreme;
use super::picture::{Picture, Values};

/// Extremum along a ray: the largest or smallest value. Ranks of normalised values are above 0, so that a pixel
/// starts at rank 0.
pub(crate) trait Extremum: Sync + Sized {
    /// The picture of these values.
    fn picture<'a>(values: Values<'a, Extreme<Self>>) -> Picture<'a>;

    /// Ranks of sixteen normalised values, or values from ranks: the map is its own inverse.
    fn rank_lanes<S: Simd>(value: f32x16<S>) -> f32x16<S>;

    /// Ranks along a ray, from the values along it.
    fn rank_cubic<S: Simd>(values: Cubic<S>) -> Cubic<S>;

    /// Largest rank that is not shown; values outside `hull` are invisible.
    fn least_rank(hull: [f32; 2]) -> f32;
}

/// The largest value.
#[derive(Debug)]
pub(crate) struct Largest;

/// The smallest value. Its rank is its distance from 2, since interpolated values up to 1 stay below 2.
#[derive(Debug)]
pub(crate) struct Smallest;

impl Extremum for Largest {
    fn picture<'a>(values: Values<'a, Extreme<Self>>) -> Picture<'a> {
        Picture::Largest(values)
    }

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
    fn picture<'a>(values: Values<'a, Extreme<Self>>) -> Picture<'a> {
        Picture::Smallest(values)
    }

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
