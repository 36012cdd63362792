//! A landscape under a satellite photograph (swan1997 and mueller1998, figure 6: 512 x 512 x 103, every column of
//! splats has the colour of its pixel in the photograph).
//!
//! The papers' elevations and photograph are not published; both are drawn from noise here. A sample is an entry of a
//! palette: 1 + kind of ground x [`SHADES`] + shade, 0 is air. Columns are filled from their own height down to below
//! their neighbours', so that steep places have no holes, but no deeper, so that the splats cost no more than the
//! surface.

use glam::{Vec2, Vec3};

use crate::fill::voxels;
use crate::noise;

/// Shades of each kind of ground, dark to light.
pub(crate) const SHADES: usize = 17;

/// Kinds of ground with their colour in full sun, sRGB: 15 x 17 shades are the 255 values above air.
pub(crate) const GROUND: [[f64; 3]; 15] = [
    [0.07, 0.16, 0.30], // deep water
    [0.17, 0.36, 0.46], // shallow water
    [0.80, 0.73, 0.55], // sand
    [0.52, 0.60, 0.28], // meadow
    [0.84, 0.75, 0.38], // ripe field
    [0.58, 0.42, 0.28], // ploughed field
    [0.38, 0.58, 0.22], // green field
    [0.72, 0.64, 0.48], // fallow field
    [0.20, 0.33, 0.16], // wood
    [0.29, 0.42, 0.20], // light wood
    [0.55, 0.52, 0.34], // scrub
    [0.56, 0.53, 0.49], // grey rock
    [0.62, 0.50, 0.40], // brown rock
    [1.00, 1.00, 1.00], // snow, roads and roofs
    [0.78, 0.42, 0.32], // tiled roofs
];

const DEEP: usize = 0;
const SHALLOW: usize = 1;
const SAND: usize = 2;
const MEADOW: usize = 3;
const FIELDS: usize = 4;
const WOOD: usize = 8;
const SCRUB: usize = 10;
const ROCK: usize = 11;
const SNOW: usize = 13;
const TILES: usize = 14;

/// Height of lakes, share of the volume's.
const WATER: f32 = 0.12;

/// The palette's colours in order of values, from value 1.
pub(crate) fn palette() -> impl Iterator<Item = [f64; 3]> {
    GROUND.into_iter().flat_map(|color| {
        (0..SHADES).map(move |shade| {
            let light = 0.3 + 0.7 * shade as f64 / (SHADES - 1) as f64;
            color.map(|c| c * light)
        })
    })
}

/// Columns along x and y with their contents.
struct Columns {
    dims: [usize; 2],
    /// Height of the ground, that of the bed where there is water, 0..1.
    heights: Vec<f32>,
}

impl Columns {
    fn new([nx, ny, _]: [usize; 3]) -> Self {
        let scale = 512.0 / nx.max(ny) as f32;
        // Rows as slices, so that threads share them.
        let heights = voxels([nx, 1, ny], |[x, _, y]| {
            height(Vec2::new(x as f32, y as f32) * scale)
        });
        Self {
            dims: [nx, ny],
            heights,
        }
    }

    /// Height of the visible surface of a column; outside, that of the nearest one.
    fn surface(&self, x: isize, y: isize) -> f32 {
        let [nx, ny] = self.dims;
        let x = x.clamp(0, nx as isize - 1) as usize;
        let y = y.clamp(0, ny as isize - 1) as usize;
        self.heights[y * nx + x].max(WATER)
    }

    /// Rise along x and y, volume heights per column.
    fn rise(&self, x: usize, y: usize) -> Vec2 {
        let (x, y) = (x as isize, y as isize);
        0.5 * Vec2::new(
            self.surface(x + 1, y) - self.surface(x - 1, y),
            self.surface(x, y + 1) - self.surface(x, y - 1),
        )
    }

    /// First and last voxel of a column.
    fn filled(&self, [x, y]: [usize; 2], nz: usize) -> [usize; 2] {
        let voxel = |height: f32| (height * (nz as f32 - 1.0)).round() as usize;
        let top = voxel(self.surface(x as isize, y as isize));
        let mut lowest = top;
        for dy in -1..=1 {
            for dx in -1..=1 {
                lowest = lowest.min(voxel(self.surface(x as isize + dx, y as isize + dy)));
            }
        }
        [lowest.saturating_sub(1), top]
    }
}

/// A landscape.
pub(crate) fn terrain(dims: [usize; 3]) -> Vec<u8> {
    let [nx, ny, nz] = dims;
    let columns = Columns::new(dims);
    let scale = 512.0 / nx.max(ny) as f32;
    // Slopes are those of the landscape of 512 x 512 x 103 columns.
    let steepness = 102.0 / scale;
    let colors: Vec<u8> = voxels([nx, 1, ny], |[x, _, y]| {
        let rise = columns.rise(x, y) * steepness;
        let bed = columns.heights[y * nx + x];
        color(Vec2::new(x as f32, y as f32) * scale, [x, y], bed, rise)
    });
    let filled: Vec<[usize; 2]> = (0..nx * ny)
        .map(|column| columns.filled([column % nx, column / nx], nz))
        .collect();
    voxels(dims, |[x, y, z]| {
        let column = y * nx + x;
        let [bottom, top] = filled[column];
        if (bottom..=top).contains(&z) {
            colors[column]
        } else {
            0
        }
    })
}

/// Noise over the plane, in [-1, 1], features `size` apart.
fn plane_noise(p: Vec2, size: f32, seed: u32) -> f32 {
    noise::smooth((p / size).extend(0.5), seed)
}

/// Sum of octaves of noise, halved in size and strength each.
fn octaves(p: Vec2, size: f32, count: u32, seed: u32) -> f32 {
    (0..count)
        .map(|octave| plane_noise(p, size / (1 << octave) as f32, seed + octave) / (1 << octave) as f32)
        .sum()
}

fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Height at a point of 512 x 512: hills, and ridges where the land is mountainous.
fn height(p: Vec2) -> f32 {
    let warp = Vec2::new(octaves(p, 90.0, 3, 101), octaves(p, 90.0, 3, 111));
    let q = p + 18.0 * warp;
    let country = octaves(q + Vec2::new(0.35, -0.6) * 100.0, 230.0, 2, 121);
    // Mountains in the far corner, lowland in the near one.
    let slant = (p.y + 0.4 * p.x) / 700.0;
    let mountains = smoothstep(0.25, 0.95, slant + 0.45 * country);
    let mut ridges = 0.0;
    let mut strength = 0.5;
    for octave in 0..6 {
        let crest = 1.0 - plane_noise(q, 110.0 / (1 << octave) as f32, 131 + octave).abs();
        // Detail lies on the crests; valleys are smooth.
        let detail = if octave == 0 {
            1.0
        } else {
            (ridges * 1.6f32).min(1.0)
        };
        ridges += strength * crest * crest * detail;
        strength *= 0.5;
    }
    let hills = 0.17 + 0.09 * octaves(q, 120.0, 5, 141);
    (hills + mountains * 0.85 * ridges).clamp(0.0, 1.0)
}

/// The value of a column at `p` of 512 x 512, given the height of its bed and how the ground rises, columns per column.
fn color(p: Vec2, column: [usize; 2], bed: f32, rise: Vec2) -> u8 {
    let grain = noise::white(column[0] as i32, column[1] as i32, 0, 151);
    let (kind, texture) = ground(p, bed, rise.length(), grain);
    // Sun from the upper left; water lies flat.
    let normal = (-rise).extend(1.0).normalize();
    let sun = normal.dot(Vec3::new(-0.5, 0.5, 0.7).normalize()).max(0.0);
    let light = 0.1 + 0.85 * sun + texture;
    let shade = (light.clamp(0.0, 1.0) * (SHADES - 1) as f32).round() as usize;
    (1 + kind * SHADES + shade) as u8
}

/// Kind of ground, and how much lighter this column is than usual.
fn ground(p: Vec2, bed: f32, slope: f32, grain: f32) -> (usize, f32) {
    let fine = octaves(p, 9.0, 3, 161);
    let depth = WATER - bed;
    if depth > 0.0 {
        let kind = if depth > 0.03 + 0.01 * fine { DEEP } else { SHALLOW };
        return (kind, 0.04 * grain);
    }
    if depth > -0.006 {
        return (SAND, 0.12 * grain);
    }
    let moisture = octaves(p, 70.0, 4, 171);
    if bed > 0.62 + 0.05 * fine && slope < 2.2 {
        return (SNOW, 0.08 * grain);
    }
    if slope > 1.05 + 0.25 * fine || bed > 0.52 + 0.05 * moisture {
        let layer = libm::sinf(bed * 90.0 + 2.0 * fine);
        return (ROCK + usize::from(layer > 0.2), 0.12 * grain + 0.08 * layer);
    }
    if moisture > 0.12 + 0.25 * fine {
        // Crowns are bright beside their shadows.
        return (WOOD + usize::from(grain > 0.1), 0.22 * grain);
    }
    if slope > 0.5 || bed > 0.34 {
        let kind = if moisture > -0.25 { MEADOW } else { SCRUB };
        return (kind, 0.1 * grain + 0.1 * fine);
    }
    if octaves(p, 60.0, 2, 181) > 0.62 {
        return town(p, grain);
    }
    fields(p, grain)
}

/// Streets around blocks of houses, six columns apart.
fn town(p: Vec2, grain: f32) -> (usize, f32) {
    let street = |along: f32| along.rem_euclid(6.0) < 1.4;
    let turned = Vec2::new(p.x + 0.3 * p.y, p.y - 0.3 * p.x);
    if street(turned.x) || street(turned.y) {
        return (ROCK, 0.1);
    }
    let house = (turned / 2.0).floor();
    match noise::hash(house.x as i32, house.y as i32, 0, 191) % 4 {
        0 => (SNOW, -0.15 + 0.1 * grain),
        1 => (MEADOW, 0.1 * grain),
        _ => (TILES, 0.15 * grain),
    }
}

/// Fields of some ten columns with furrows, hedges between them and roads now and then.
fn fields(p: Vec2, grain: f32) -> (usize, f32) {
    let bend = 6.0 * Vec2::new(plane_noise(p, 60.0, 201), plane_noise(p, 60.0, 202));
    let turned = Vec2::new(p.x + 0.45 * p.y, p.y - 0.45 * p.x) + bend;
    let road = |along: f32| along.rem_euclid(58.0) < 1.3;
    if road(turned.x) || road(turned.y + 17.0) {
        return (SNOW, -0.1);
    }
    let row = (turned.y / 11.0).floor();
    let width = 9.0 + (noise::hash(row as i32, 0, 0, 203) % 9) as f32;
    let across = [turned.x / width, turned.y / 11.0];
    let field = noise::hash(across[0].floor() as i32, row as i32, 1, 204);
    let edge = |t: f32, size: f32| t.rem_euclid(1.0) * size < 0.9;
    if !field.is_multiple_of(3) && (edge(across[0], width) || edge(across[1], 11.0)) {
        return (WOOD, 0.1 * grain);
    }
    let direction = if field & 64 == 0 { turned.x } else { turned.y };
    let furrow = if (direction / 1.5).rem_euclid(2.0) < 1.0 {
        0.06
    } else {
        -0.06
    };
    let tone = ((field >> 8) % 16) as f32 / 16.0 - 0.5;
    (
        FIELDS + (field >> 16) as usize % 4,
        furrow + 0.15 * tone + 0.05 * grain,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// First and last filled voxel and the value of each column.
    fn columns(dims: [usize; 3]) -> Vec<([usize; 2], u8)> {
        let values = terrain(dims);
        let [nx, ny, nz] = dims;
        (0..nx * ny)
            .map(|column| {
                let at = |z: usize| values[z * nx * ny + column];
                let filled: Vec<usize> = (0..nz).filter(|&z| at(z) > 0).collect();
                let (first, last) = (filled[0], filled[filled.len() - 1]);
                assert_eq!(last + 1 - first, filled.len(), "one piece");
                assert!(filled.iter().all(|&z| at(z) == at(first)), "one colour");
                ([first, last], at(first))
            })
            .collect()
    }

    #[test]
    fn columns_are_of_one_colour_and_leave_no_holes() {
        let (nx, ny) = (96, 96);
        let columns = columns([nx, ny, 40]);
        let heights: Vec<usize> = columns.iter().map(|([_, top], _)| *top).collect();
        assert!(heights.iter().max() > Some(&25) && heights.iter().min() < Some(&8));
        for y in 0..ny - 1 {
            for x in 0..nx - 1 {
                let ([bottom, top], _) = columns[y * nx + x];
                for beside in [y * nx + x + 1, (y + 1) * nx + x, (y + 1) * nx + x + 1] {
                    let ([other_bottom, other_top], _) = columns[beside];
                    assert!(bottom <= other_top && other_bottom <= top, "{x} {y}");
                }
            }
        }
    }

    #[test]
    fn the_photograph_has_many_colours_that_change_from_column_to_column() {
        let n = 256;
        let columns = columns([n, n, 52]);
        let mut count = [0usize; 256];
        columns.iter().for_each(|(_, value)| count[*value as usize] += 1);
        assert!(count.iter().filter(|&&count| count > 0).count() > 120);
        let kinds = |from: usize| {
            (0..SHADES)
                .map(|shade| count[1 + from * SHADES + shade])
                .sum::<usize>()
        };
        for kind in [DEEP, MEADOW, FIELDS, WOOD, ROCK, SNOW] {
            assert!(kinds(kind) > 100, "{kind}: {}", kinds(kind));
        }
        let changes = columns.windows(2).filter(|pair| pair[0].1 != pair[1].1).count();
        assert!(changes * 2 > columns.len(), "{changes}");
    }

    #[test]
    fn the_palette_fills_the_bytes() {
        assert_eq!(palette().count(), 255);
        assert!(palette().flatten().all(|c| (0.0..=1.0).contains(&c)));
    }
}
