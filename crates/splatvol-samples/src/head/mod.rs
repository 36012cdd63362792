//! A CT-like head phantom: Hounsfield units, 1 mm at 256^3, RAS+, mirror-symmetric except for texture and noise.
//!
//! Implicit solids (skin, skull, jaw, teeth, cavities) give signed distances; each tissue fills its solid with a
//! soft edge about one voxel wide, which stands for the scanner's point spread and keeps the data band-limited.
//! Not an atlas: shapes and proportions are plausible, not measured.

mod inside;
mod jaw;
mod skin;
mod skull;
mod solid;

use glam::Vec3;
use rayon::prelude::*;

use crate::noise;
use solid::{Brick, COUNT, FAR, Field, SIDE, Solid, smooth_min};

/// Side of the cube that contains the phantom, mm.
pub(crate) const EXTENT: f64 = 256.0;
/// Centre of that cube in the phantom's own coordinates (see [`skin`]), mm.
const CENTRE: Vec3 = Vec3::new(0.0, 11.0, 4.0);

/// Hounsfield unit of air.
const AIR: f32 = -1000.0;
/// Least thickness of the soft tissue over bone, mm.
const COVER: f32 = 2.2;
/// Least thickness of the bone around the brain, mm.
const CASE: f32 = 3.0;
/// Half the scanner noise, HU.
const NOISE: f32 = 9.0;

/// Samples of the phantom, x fastest.
pub(crate) fn head(dims: [usize; 3]) -> Vec<i16> {
    let phantom = Phantom::new(dims);
    let mut samples = vec![0i16; dims.iter().product()];
    let slice = dims[0] * dims[1];
    samples
        .par_chunks_mut(slice * SIDE)
        .enumerate()
        .for_each(|(slab, chunk)| {
            for y in (0..dims[1]).step_by(SIDE) {
                for x in (0..dims[0]).step_by(SIDE) {
                    phantom.fill([x, y, slab * SIDE], chunk);
                }
            }
        });
    samples
}

/// World position (RAS+, mm) of voxel 0's centre, and the spacing.
pub(crate) fn placement(dims: [usize; 3]) -> (glam::DVec3, glam::DVec3) {
    let spacing = glam::DVec3::from_array(dims.map(|n| EXTENT / n as f64));
    (CENTRE.as_dvec3() + 0.5 * (spacing - EXTENT), spacing)
}

struct Phantom {
    dims: [usize; 3],
    first: Vec3,
    spacing: Vec3,
    /// Half width of a tissue's edge, mm.
    edge: f32,
    skin: Solid,
    skull: Solid,
    cavity: Solid,
    jaw: Solid,
    teeth: Solid,
    airways: Solid,
    globes: Solid,
    ventricles: Solid,
}

/// Signed distances at a brick's voxels, [`FAR`] where there is nothing near.
struct Distances {
    skin: Field,
    bone: Field,
    cavity: Field,
    teeth: Field,
    air: Field,
    globes: Field,
    ventricles: Field,
}

impl Phantom {
    fn new(dims: [usize; 3]) -> Self {
        let (first, spacing) = placement(dims);
        let spacing = spacing.as_vec3();
        Self {
            dims,
            first: first.as_vec3(),
            spacing,
            edge: 1.5 * spacing.max_element(),
            skin: skin::skin(),
            skull: skull::skull(),
            cavity: skull::cranial_cavity(),
            jaw: jaw::mandible(),
            teeth: jaw::teeth(),
            airways: inside::airways(),
            globes: inside::globes(),
            ventricles: inside::ventricles(),
        }
    }

    /// Fills the brick at voxel `start`; `chunk` holds the slices from `start[2]` on.
    fn fill(&self, start: [usize; 3], chunk: &mut [i16]) {
        let offset = Vec3::from_array(start.map(|i| i as f32));
        let brick = Brick::new(self.first + self.spacing * offset, self.spacing);
        let distances = self.distances(&brick);
        let slices = chunk.len() / (self.dims[0] * self.dims[1]);
        for i in 0..COUNT {
            let local = [i % SIDE, i / SIDE % SIDE, i / (SIDE * SIDE)];
            let (x, y) = (start[0] + local[0], start[1] + local[1]);
            if x >= self.dims[0] || y >= self.dims[1] || local[2] >= slices {
                continue;
            }
            let value = distances
                .as_ref()
                .map_or(AIR, |distances| self.tissue(brick.position(i), distances, i));
            let grain = noise::triangular(x as i32, y as i32, (start[2] + local[2]) as i32, 31);
            let value = (value + NOISE * grain).round().clamp(-1024.0, 3071.0);
            chunk[(local[2] * self.dims[1] + y) * self.dims[0] + x] = value as i16;
        }
    }

    /// All distances, or `None` where the whole brick is air.
    fn distances(&self, brick: &Brick) -> Option<Distances> {
        let near = 3.0f32.max(2.0 * self.edge);
        let mut skin = self.skin.evaluate(brick, near.max(9.0))?;
        if skin.iter().all(|&d| d > self.edge + COVER) {
            return None;
        }
        let of = |solid: &Solid, reach: f32| solid.evaluate(brick, reach).unwrap_or([FAR; COUNT]);
        let cavity = of(&self.cavity, near.max(14.0));
        let skull = of(&self.skull, near + COVER);
        let jaw = of(&self.jaw, near + COVER);
        let mut bone = std::array::from_fn(|i| {
            // The bone around the brain has no gap, even where orbits and fossae come near it.
            let case = if brick.z[i] > -6.0 { cavity[i] - CASE } else { FAR };
            smooth_min(skull[i], case, 3.0).max(-cavity[i]).min(jaw[i])
        });
        for (skin, bone) in skin.iter_mut().zip(&bone) {
            *skin = smooth_min(*skin, bone - COVER, 3.0);
        }
        self.groove(brick, &cavity, &mut bone);
        Some(Distances {
            skin,
            bone,
            cavity,
            teeth: of(&self.teeth, near),
            air: of(&self.airways, near),
            globes: of(&self.globes, near),
            ventricles: of(&self.ventricles, near),
        })
    }

    /// Cuts the sutures into the vault's outer table.
    fn groove(&self, brick: &Brick, cavity: &Field, bone: &mut Field) {
        for i in 0..COUNT {
            let outer = brick.z[i] > 10.0 && cavity[i] > 3.0 && cavity[i] < 15.0;
            if outer && bone[i].abs() < self.edge + 1.5 {
                bone[i] += inside::suture(brick.position(i));
            }
        }
    }

    /// Hounsfield unit at voxel `i` of a brick, without noise.
    fn tissue(&self, p: Vec3, distances: &Distances, i: usize) -> f32 {
        let filled = |distance: f32| self.filled(distance);
        let skin = filled(distances.skin[i]);
        if skin <= 0.0 {
            return AIR;
        }
        let mut value = AIR + skin * (inside::soft_tissue(p, distances.skin[i]) - AIR);
        let mut cover = |amount: f32, tissue: &dyn Fn() -> f32| {
            if amount > 0.0 {
                value += amount * (tissue() - value);
            }
        };
        cover(filled(distances.globes[i]), &|| inside::globe(p));
        cover(filled(distances.cavity[i]), &|| {
            inside::brain(p, distances.cavity[i], filled(distances.ventricles[i]))
        });
        cover(filled(distances.air[i]), &|| AIR);
        cover(filled(distances.bone[i]), &|| inside::bone(p, distances.bone[i]));
        cover(filled(distances.teeth[i]), &|| inside::tooth(p));
        value
    }

    /// Share of a voxel that lies inside a surface at signed distance `distance`.
    fn filled(&self, distance: f32) -> f32 {
        let t = (0.5 - 0.5 * distance / self.edge).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }
}
