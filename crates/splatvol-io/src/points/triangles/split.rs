//! Patches of a triangle that are small and compact enough for a disc.
//!
//! Triangles are halved until their edges are short; the tips of slender ones would stay slender for ever, and are cut into slices.

use glam::DVec3;

/// Longest edge of a patch: this part of the whole surface's diagonal.
const FINEST: f64 = 1.0 / 256.0;
/// Longest edge over the height on it, at most; 1.15 in an equilateral triangle, 2 in half a square.
const SLENDER: f64 = 3.0;
/// Shortest slice, and longest edge of slender triangles that are too small to matter: this part of the limit.
const TINY: f64 = 0.25;
/// Factor from one limit to the next.
const STEP: f64 = 1.25;

/// A triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece(pub(super) [DVec3; 3]);

impl Piece {
    pub(super) fn centroid(self) -> DVec3 {
        (self.0[0] + self.0[1] + self.0[2]) / 3.0
    }

    fn cross(self) -> DVec3 {
        let [a, b, c] = self.0;
        (b - a).cross(c - a)
    }

    pub(super) fn area(self) -> f64 {
        self.cross().length() / 2.0
    }

    /// Unit normal; zero where there is no area.
    pub(super) fn normal(self) -> DVec3 {
        self.cross().normalize_or_zero()
    }

    /// Weights of the corners at a place in the triangle's plane.
    pub(super) fn weights(self, place: DVec3) -> DVec3 {
        let [a, b, c] = self.0;
        let whole = self.cross();
        let share = |p: DVec3, q: DVec3| (p - place).cross(q - place).dot(whole) / whole.length_squared();
        let weights = DVec3::new(share(b, c), share(c, a), share(a, b));
        match weights.is_finite() {
            true => weights,
            false => DVec3::splat(1.0 / 3.0),
        }
    }

    /// Squared length and first corner of the longest edge.
    fn longest(self) -> (f64, usize) {
        let length = |corner: usize| self.0[corner].distance_squared(self.0[(corner + 1) % 3]);
        let lengths = [length(0), length(1), length(2)];
        let longest = (0..3).fold(0, |best, corner| {
            if lengths[corner] > lengths[best] {
                corner
            } else {
                best
            }
        });
        (lengths[longest], longest)
    }

    /// The halves on either side of the line from the middle of the edge after `corner`.
    fn halves(self, corner: usize) -> [Self; 2] {
        let [a, b, c] = [self.0[corner], self.0[(corner + 1) % 3], self.0[(corner + 2) % 3]];
        let middle = a / 2.0 + b / 2.0;
        [Self([a, middle, c]), Self([middle, b, c])]
    }
}

/// A part of a triangle that becomes one disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Patch {
    pub(super) centroid: DVec3,
    pub(super) area: f64,
}

/// The size above which triangles are divided: a length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Limit(f64);

/// What becomes of a triangle.
enum Division {
    Whole,
    Halves,
    /// So many slices across its longest edge.
    Slices(f64),
}

impl Limit {
    /// The finest for a surface of this diagonal.
    pub(super) fn of_surface(diagonal: f64) -> Self {
        Self(diagonal * FINEST)
    }

    pub(super) fn coarser(self) -> Self {
        Self(self.0 * STEP)
    }

    fn division(self, piece: Piece) -> Division {
        let (squared, _) = piece.longest();
        let longest = squared.sqrt();
        let height = 2.0 * piece.area() / longest;
        let slender = longest > SLENDER * height;
        // Written so that what has no extent, and what is not a number, stays whole.
        if slender && height <= self.0 && longest > TINY * self.0 {
            let step = (height / 2.0).clamp(TINY * self.0, self.0 / 2.0);
            Division::Slices((longest / step).ceil())
        } else if longest > self.0 {
            Division::Halves
        } else {
            Division::Whole
        }
    }

    /// An upper estimate of the number of patches.
    pub(super) fn patches(self, whole: Piece) -> f64 {
        match self.division(whole) {
            Division::Whole => 1.0,
            Division::Slices(count) => count,
            Division::Halves => {
                let longest = whole.longest().0.sqrt();
                let square = self.0 * self.0;
                // What is cut off at the tips is sliced.
                1.0 + 4.0 * whole.area() / square + 2.0 * longest / (TINY * self.0)
            }
        }
    }
}

/// Fills `patches` with those of `whole`.
pub(super) fn split(whole: Piece, limit: Limit, patches: &mut Vec<Patch>) {
    patches.clear();
    let mut open = vec![whole];
    while let Some(piece) = open.pop() {
        match limit.division(piece) {
            Division::Whole => patches.push(Patch {
                centroid: piece.centroid(),
                area: piece.area(),
            }),
            Division::Slices(count) => slice(piece, count, patches),
            Division::Halves => open.extend(piece.halves(piece.longest().1)),
        }
    }
}

/// Adds slices of equal lengths along the longest edge.
fn slice(piece: Piece, count: f64, patches: &mut Vec<Patch>) {
    let (squared, corner) = piece.longest();
    let [a, b, c] = [0, 1, 2].map(|next| piece.0[(corner + next) % 3]);
    let foot = ((c - a).dot(b - a) / squared).clamp(0.0, 1.0);
    // Width over the height, at a part of the edge, and its integral from the edge's start.
    let width = |t: f64| {
        if t < foot {
            t / foot
        } else {
            (1.0 - t) / (1.0 - foot)
        }
    };
    let until = |t: f64| match t < foot {
        true => t * t / foot / 2.0,
        false => 0.5 - (1.0 - t).powi(2) / (1.0 - foot).max(f64::MIN_POSITIVE) / 2.0,
    };
    let across = c - a.lerp(b, foot);
    for index in 0..count as u64 {
        let [from, to] = [index, index + 1].map(|end| end as f64 / count);
        let middle = (from + to) / 2.0;
        patches.push(Patch {
            centroid: a.lerp(b, middle) + across * (width(middle) / 2.0),
            area: piece.area() * 2.0 * (until(to) - until(from)),
        });
    }
}
