//! Volumes of bent and branching tubes, as microscopes see them: microtubules (mueller1998 and huang2000 render 420 x
//! 468 x 62) and a nerve cell (512 x 512 x 76, voxels 1:1:5). The papers' data are not published; these grow from
//! seeded random walks.
//!
//! A tube is a chain of tapered pieces; a voxel's value depends on its distance from the axis and surface of the piece
//! that is brightest there.

use glam::Vec3;

use crate::fill::slices;
use crate::noise;
use crate::rotation::direction;

/// Voxel spacing of the nerve cell.
pub(crate) const NERVE_SPACING: [f64; 3] = [1.0, 1.0, 5.0];

/// Largest value of a tube.
const BRIGHT: f32 = 235.0;

/// A piece of a tube.
#[derive(Debug, Clone, Copy)]
struct Piece {
    ends: [Vec3; 2],
    radii: [f32; 2],
}

impl Piece {
    /// Distances from the axis and from the surface, below 0 inside. `metric` scales lengths along x, y, z.
    fn distances(&self, p: Vec3, metric: Vec3) -> [f32; 2] {
        let axis = (self.ends[1] - self.ends[0]) * metric;
        let from = (p - self.ends[0]) * metric;
        let along = (from.dot(axis) / axis.length_squared().max(1e-12)).clamp(0.0, 1.0);
        let radius = self.radii[0] + along * (self.radii[1] - self.radii[0]);
        let distance = (from - along * axis).length();
        [distance, distance - radius]
    }

    /// Bounding box of the points at most `beyond` its surface: low and high.
    fn bounds(&self, metric: Vec3, beyond: f32) -> [Vec3; 2] {
        let reach = Vec3::splat(self.radii[0].max(self.radii[1]) + beyond) / metric;
        let [a, b] = self.ends;
        [a.min(b) - reach, a.max(b) + reach]
    }
}

/// Region and resolution at which pieces are sampled.
struct Raster {
    dims: [usize; 3],
    /// Length between samples, in the pieces' units.
    spacing: Vec3,
    /// Scale of lengths in distances.
    metric: Vec3,
    /// Distance from their surface where pieces have faded.
    beyond: f32,
}

impl Raster {
    /// Samples of the brightest piece at each voxel, `profile` of [`Piece::distances`], over grain.
    fn fill(&self, pieces: &[Piece], profile: impl Fn([f32; 2]) -> f32 + Sync, seed: u32) -> Vec<u8> {
        let [nx, ny, _] = self.dims;
        slices(self.dims, |z, slice: &mut [u8]| {
            let depth = z as f32 * self.spacing.z;
            let mut values = vec![0.0f32; nx * ny];
            for piece in pieces {
                let [low, high] = piece.bounds(self.metric, self.beyond);
                if depth < low.z || depth > high.z {
                    continue;
                }
                let first = |low: f32, step: f32| (low / step).ceil().max(0.0) as usize;
                let last = |high: f32, step: f32, n: usize| {
                    ((high / step).floor() + 1.0).clamp(0.0, n as f32) as usize
                };
                for y in first(low.y, self.spacing.y)..last(high.y, self.spacing.y, ny) {
                    for x in first(low.x, self.spacing.x)..last(high.x, self.spacing.x, nx) {
                        let p = Vec3::new(x as f32, y as f32, 0.0) * self.spacing + Vec3::Z * depth;
                        let value = &mut values[y * nx + x];
                        *value = value.max(profile(piece.distances(p, self.metric)));
                    }
                }
            }
            for (i, (sample, value)) in slice.iter_mut().zip(values).enumerate() {
                let grain = noise::triangular((i % nx) as i32, (i / nx) as i32, z as i32, seed);
                *sample = (BRIGHT * value * (1.0 + 0.08 * grain) + 6.0 + 6.0 * grain).clamp(0.0, 255.0) as u8;
            }
        })
    }
}

fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Random numbers of one stream, one after the other.
struct Stream {
    id: i32,
    next: i32,
    seed: u32,
}

impl Stream {
    fn new(id: usize, seed: u32) -> Self {
        Self {
            id: id as i32,
            next: 0,
            seed,
        }
    }

    /// Uniform in [-1, 1).
    fn signed(&mut self) -> f32 {
        self.next += 1;
        noise::white(self.id, self.next, 0, self.seed)
    }

    /// Uniform in [0, 1).
    fn unit(&mut self) -> f32 {
        0.5 * (self.signed() + 1.0)
    }
}

/// Bent tubes through a flat cell, most of them from one organising centre.
pub(crate) fn microtubules(dims: [usize; 3]) -> Vec<u8> {
    const TUBES: usize = 130;
    let full = Vec3::new(420.0, 468.0, 62.0);
    let scale = Vec3::from_array(dims.map(|n| n as f32)) / full;
    let spacing = scale.recip();
    // If thinner than a voxel and a half, they would break up.
    let radius = (2.3f32).max(1.2 * spacing.x.max(spacing.y));
    let pieces: Vec<Piece> = (0..TUBES)
        .flat_map(|tube| microtubule(tube, full, radius))
        .collect();
    let raster = Raster {
        dims,
        spacing,
        metric: Vec3::ONE,
        beyond: 0.4 * radius,
    };
    // A wall around a darker bore.
    let wall = |[distance, _]: [f32; 2]| {
        let d = distance / radius;
        (1.0 - smoothstep(0.7, 1.4, d)) * (0.7 + 0.3 * smoothstep(0.1, 0.7, d))
    };
    raster.fill(&pieces, wall, 301)
}

/// The pieces of one tube.
fn microtubule(tube: usize, full: Vec3, radius: f32) -> Vec<Piece> {
    const STEP: f32 = 6.0;
    let mut random = Stream::new(tube, 302);
    let centre = Vec3::new(0.42, 0.46, 0.5) * full;
    let (mut at, mut angle) = if tube.is_multiple_of(4) {
        let start = Vec3::new(random.unit(), random.unit(), 0.1 + 0.8 * random.unit()) * full;
        (start, std::f32::consts::PI * random.signed())
    } else {
        let angle = std::f32::consts::PI * random.signed();
        let away = 8.0 + 26.0 * random.unit();
        let start = centre + away * direction(angle).extend(0.4 * random.signed());
        (start, angle)
    };
    let mut climb = 0.12 * random.signed();
    let (mut bend, drift) = (0.0f32, 0.012 * random.signed());
    let steps = 30 + (70.0 * random.unit()) as usize;
    let mut pieces = Vec::with_capacity(steps);
    for _ in 0..steps {
        bend = 0.9 * bend + 0.035 * random.signed();
        angle += bend + drift;
        // Turned back before floor and ceiling.
        let level = at.z / full.z - 0.5;
        climb = (climb + 0.04 * random.signed() - 0.06 * level).clamp(-0.3, 0.3);
        let next = at + STEP * direction(angle).extend(climb);
        let inside = next.cmpgt(Vec3::ZERO).all() && next.cmplt(full).all();
        pieces.push(Piece {
            ends: [at, next],
            radii: [radius; 2],
        });
        if !inside {
            break;
        }
        at = next;
    }
    pieces
}

/// A cell body with branching arms and one long fibre.
pub(crate) fn nerve(dims: [usize; 3]) -> Vec<u8> {
    let full = Vec3::new(512.0, 512.0, 380.0);
    let voxels = Vec3::from_array(dims.map(|n| n as f32));
    let spacing = full / voxels;
    let centre = Vec3::new(0.47, 0.52, 0.5) * full;
    let mut arms = Arms {
        pieces: Vec::new(),
        full,
        thinnest: 2.2f32.max(1.1 * spacing.x.max(spacing.y)),
        grown: 0,
    };
    arms.body(centre);
    for arm in 0..8 {
        let mut random = Stream::new(arm, 311);
        let angle = (arm as f32 + 0.5 * random.signed()) * std::f32::consts::TAU / 8.0;
        let heading = direction(angle).extend(0.55 * random.signed()).normalize();
        // One of them is the axon: thin, long, without branches.
        let (radius, branches) = if arm == 5 {
            (6.0, 0)
        } else {
            (11.0 + 5.0 * random.unit(), 5)
        };
        arms.grow(centre + 26.0 * heading, heading, radius, branches);
    }
    // Half the width of an edge.
    let edge = 2.5f32.max(0.8 * spacing.x.max(spacing.y));
    let raster = Raster {
        dims,
        spacing,
        // Microscopes blur along their axis.
        metric: Vec3::new(1.0, 1.0, 0.5),
        beyond: edge,
    };
    raster.fill(
        &arms.pieces,
        |[_, depth]| 1.0 - smoothstep(-edge, edge, depth),
        312,
    )
}

/// Arms as they grow.
struct Arms {
    pieces: Vec<Piece>,
    full: Vec3,
    /// Radius at which they end.
    thinnest: f32,
    /// Arms so far, each with random numbers of its own.
    grown: usize,
}

impl Arms {
    fn body(&mut self, centre: Vec3) {
        let mut random = Stream::new(0, 321);
        for _ in 0..7 {
            let end = |random: &mut Stream| {
                centre
                    + Vec3::new(
                        24.0 * random.signed(),
                        24.0 * random.signed(),
                        16.0 * random.signed(),
                    )
            };
            self.pieces.push(Piece {
                ends: [end(&mut random), end(&mut random)],
                radii: [24.0 + 8.0 * random.unit(), 20.0],
            });
        }
    }

    /// Grows an arm that thins out; where it forks both parts share its cross-section.
    fn grow(&mut self, from: Vec3, heading: Vec3, radius: f32, branches: u32) {
        const STEP: f32 = 7.0;
        self.grown += 1;
        let mut random = Stream::new(self.grown, 322);
        let (mut at, mut heading, mut radius) = (from, heading, radius);
        let length = if branches == 0 {
            60
        } else {
            8 + (9.0 * random.unit()) as usize
        };
        for _ in 0..length {
            let turn = Vec3::new(random.signed(), random.signed(), 0.6 * random.signed());
            heading = (heading + 0.22 * turn).normalize();
            let next = at + STEP * heading;
            let outside = next.cmplt(Vec3::ZERO).any() || next.cmpgt(self.full).any();
            let thinner = (radius * 0.972).max(self.thinnest);
            self.pieces.push(Piece {
                ends: [at, next],
                radii: [radius, thinner],
            });
            // Spines.
            if radius < 9.0 && random.unit() < 0.3 {
                let side = heading.cross(turn).normalize_or_zero() * (radius + 5.0);
                self.pieces.push(Piece {
                    ends: [next, next + side],
                    radii: [self.thinnest, self.thinnest],
                });
            }
            if outside {
                return;
            }
            (at, radius) = (next, thinner);
        }
        if branches == 0 || radius <= self.thinnest {
            return;
        }
        let turn = Vec3::new(random.signed(), random.signed(), 0.5 * random.signed()).normalize_or_zero();
        let side = (turn - turn.dot(heading) * heading).normalize_or_zero();
        for (sign, share) in [(1.0, 0.55 + 0.25 * random.unit()), (-1.0, 0.72)] {
            let turned = (heading + sign * 0.65 * side).normalize();
            self.grow(at, turned, radius * share, branches - 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Share of voxels at `threshold` and above, and the share of those in the largest connected piece.
    fn connected(values: &[u8], [nx, ny, nz]: [usize; 3], threshold: u8) -> [f64; 2] {
        let mut seen: Vec<bool> = values.iter().map(|&v| v < threshold).collect();
        let (mut count, mut largest) = (0usize, 0usize);
        for start in 0..values.len() {
            if seen[start] {
                continue;
            }
            seen[start] = true;
            let (mut open, mut size) = (vec![start], 0);
            while let Some(i) = open.pop() {
                size += 1;
                let [x, y, z] = [i % nx, i / nx % ny, i / (nx * ny)];
                let beside = [
                    (x > 0, i.wrapping_sub(1)),
                    (x + 1 < nx, i + 1),
                    (y > 0, i.wrapping_sub(nx)),
                    (y + 1 < ny, i + nx),
                    (z > 0, i.wrapping_sub(nx * ny)),
                    (z + 1 < nz, i + nx * ny),
                ];
                for (_, next) in beside.into_iter().filter(|(inside, _)| *inside) {
                    if !std::mem::replace(&mut seen[next], true) {
                        open.push(next);
                    }
                }
            }
            count += size;
            largest = largest.max(size);
        }
        [count as f64 / values.len() as f64, largest as f64 / count as f64]
    }

    #[test]
    fn microtubules_are_thin_and_many() {
        let dims = [210, 234, 31];
        let values = microtubules(dims);
        let [filled, _] = connected(&values, dims, 90);
        assert!((0.02..0.15).contains(&filled), "{filled}");
        // Only at the centre is a disc of 11 voxels filled.
        let slice = &values[15 * 210 * 234..16 * 210 * 234];
        let thick = (6..228)
            .flat_map(|y| (6..204).map(move |x| (x, y)))
            .filter(|&(x, y)| {
                let at = |dx: isize, dy: isize| {
                    slice[(y as isize + dy) as usize * 210 + (x as isize + dx) as usize] >= 90
                };
                at(0, 0) && at(5, 0) && at(-5, 0) && at(0, 5) && at(0, -5)
            })
            .count();
        assert!(thick < 210 * 234 / 100, "{thick}");
    }

    #[test]
    fn the_nerve_cell_is_one_piece_with_arms_to_all_sides() {
        let dims = [256, 256, 76];
        let values = nerve(dims);
        let [filled, largest] = connected(&values, dims, 90);
        assert!((0.01..0.12).contains(&filled), "{filled}");
        assert!(largest > 0.99, "{largest}");
        let bright = |x: usize, y: usize| (0..76).any(|z| values[(z * 256 + y) * 256 + x] > 120);
        for line in [25, 230] {
            assert!((0..256).any(|i| bright(i, line)), "row {line}");
            assert!((0..256).any(|i| bright(line, i)), "column {line}");
        }
    }

    #[test]
    fn distances_are_those_of_the_taper() {
        let piece = Piece {
            ends: [Vec3::ZERO, Vec3::new(10.0, 0.0, 0.0)],
            radii: [2.0, 4.0],
        };
        for (p, expected) in [
            (Vec3::new(0.0, 2.0, 0.0), [2.0, 0.0]),
            (Vec3::new(5.0, 0.0, 4.0), [4.0, 1.0]),
            (Vec3::new(14.0, 0.0, 0.0), [4.0, 0.0]),
            (Vec3::new(10.0, 1.0, 0.0), [1.0, -3.0]),
        ] {
            let found = piece.distances(p, Vec3::ONE);
            assert!(
                (0..2).all(|i| (found[i] - expected[i]).abs() < 1e-6),
                "{p}: {found:?}"
            );
        }
    }
}
