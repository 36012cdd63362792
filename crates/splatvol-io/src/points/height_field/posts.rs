//! Heights interpolated to another number of posts.
//!
//! Every post stands in the middle of its cell, and the cells of all posts cover the same ground before and after, as
//! do the pixels of a picture draped over it. Heights are bilinear; beyond the outermost posts they are those of the
//! border. A post is a gap if any of the surrounding posts that count is one.

use glam::DVec2;

use super::HeightField;
use crate::IoError;
use crate::error::Context;

/// The two posts around a place along one axis, and the share of the second.
struct Between {
    posts: [usize; 2],
    share: f64,
}

impl Between {
    /// Interpolation at new post `post` of `new`, among `old`.
    fn new(post: usize, new: usize, old: usize) -> Self {
        let place = (post as f64 + 0.5) * old as f64 / new as f64 - 0.5;
        let place = place.clamp(0.0, (old - 1) as f64);
        let first = place as usize;
        Self {
            posts: [first, (first + 1).min(old - 1)],
            share: place - first as f64,
        }
    }

    /// The mean of the heights at the two posts that count.
    fn mix(&self, height: impl Fn(usize) -> f64) -> f64 {
        let [first, second] = self.posts;
        match self.share {
            0.0 => height(first),
            share => (1.0 - share) * height(first) + share * height(second),
        }
    }
}

impl HeightField {
    /// This terrain with `dims` posts to the east and to the north.
    pub(super) fn interpolated(
        &self,
        dims: [usize; 2],
        max_bytes: u64,
        context: &Context<'_>,
    ) -> Result<Self, IoError> {
        let [columns, rows] = dims;
        if columns < 2 || rows < 2 {
            let found = format!("{columns} x {rows}");
            return Err(context.field("posts", found, None, "at least 2 x 2"));
        }
        let bytes = (columns as u64)
            .saturating_mul(rows as u64)
            .saturating_mul(size_of::<f64>() as u64);
        if bytes > max_bytes {
            return Err(context.limit(bytes, max_bytes));
        }
        let [width, height] = self.dims;
        let across: Vec<Between> = (0..columns)
            .map(|post| Between::new(post, columns, width))
            .collect();
        let mut heights = Vec::with_capacity(columns * rows);
        for row in 0..rows {
            let along = Between::new(row, rows, height);
            heights.extend(
                across
                    .iter()
                    .map(|across| along.mix(|row| across.mix(|column| self.heights[row * width + column]))),
            );
        }
        let ratio = DVec2::new(width as f64 / columns as f64, height as f64 / rows as f64);
        Ok(Self {
            dims,
            heights,
            origin: self.origin + self.spacing * (0.5 * ratio - 0.5),
            spacing: self.spacing * ratio,
            ..*self
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn field(dims: [usize; 2], height: impl Fn(DVec2) -> f64) -> HeightField {
        let [width, rows] = dims;
        let (origin, spacing) = (DVec2::new(100.0, -20.0), DVec2::new(3.0, 2.0));
        let place = |post: usize| origin + spacing * DVec2::new((post % width) as f64, (post / width) as f64);
        HeightField {
            dims,
            heights: (0..width * rows).map(|post| height(place(post))).collect(),
            origin,
            spacing,
            height_scale: 1.0,
            measured: true,
        }
    }

    fn interpolated(field: &HeightField, dims: [usize; 2]) -> Result<HeightField, IoError> {
        field.interpolated(dims, 1 << 20, &Context::new("test", Path::new("a")))
    }

    #[test]
    fn a_plane_stays_where_it_is() {
        let plane = |p: DVec2| 0.5 * p.x - 0.25 * p.y + 7.0;
        let coarse = field([9, 7], plane);
        for dims in [[18, 21], [9, 7], [5, 4]] {
            let fine = interpolated(&coarse, dims).unwrap();
            let [columns, rows] = fine.dims;
            for post in 0..columns * rows {
                let at = DVec2::new((post % columns) as f64, (post / columns) as f64);
                let place = fine.origin + fine.spacing * at;
                // The border is level beyond the outermost posts.
                let last = coarse.origin + coarse.spacing * DVec2::new(8.0, 6.0);
                let expected = plane(place.clamp(coarse.origin, last));
                assert!(
                    (fine.heights[post] - expected).abs() < 1e-12,
                    "{place} of {dims:?}"
                );
            }
            let side =
                |field: &HeightField| field.spacing * DVec2::new(field.dims[0] as f64, field.dims[1] as f64);
            assert!(
                (side(&fine) - side(&coarse)).abs().max_element() < 1e-12,
                "{dims:?}"
            );
        }
    }

    #[test]
    fn gaps_stay_gaps_and_sizes_have_limits() {
        let mut coarse = field([4, 4], |_| 1.0);
        coarse.heights[5] = f64::NAN;
        let fine = interpolated(&coarse, [8, 8]).unwrap();
        let gaps = fine.heights.iter().filter(|height| height.is_nan()).count();
        // Post (1, 1) counts for the places less than a post away: new posts 1 to 4 along each axis.
        assert_eq!(gaps, 16);
        assert_eq!(
            interpolated(&coarse, [4, 4])
                .unwrap()
                .heights
                .iter()
                .filter(|h| h.is_nan())
                .count(),
            1
        );
        let text = interpolated(&coarse, [1, 8]).unwrap_err().to_string();
        assert!(text.contains("posts") && text.contains("1 x 8"), "{text}");
        assert!(interpolated(&coarse, [1 << 20, 1 << 20]).is_err());
        assert!(interpolated(&coarse, [usize::MAX, 2]).is_err());
    }
}
