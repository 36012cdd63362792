//! Classified voxels: extinction and lit emission of a brick's samples, made when the brick is opened.
//!
//! Nothing is cached between frames: reading, classifying and lighting a voxel costs a tenth of splatting it, and
//! lighting changes with the camera. After an edit of the transfer function only the bricks' ranges are looked at.

use fearless_simd::{f32x4, f32x8, f32x16, prelude::*};
use glam::DMat3;
use splatvol_core::brick::BRICK;
use splatvol_core::classification::ClassificationTable;
use splatvol_core::field::{FieldStore, Neighbourhood};
use splatvol_core::level::{Classes, ClassifiedMeans, Level, Surfaces};
use splatvol_core::plan::Bricks;
use splatvol_core::visibility::BRICK_VOXELS;

use super::cut::Cut;
use super::sheet::Lanes16;
use crate::phong::Phong;

/// Extinction and emission of the voxels of open bricks.
#[derive(Debug, Default)]
pub(crate) struct ClassifiedVoxels {
    /// By slot and voxel: extinction, and emission (extinction times colour) red, green and blue.
    voxels: Vec<Classes>,
    around: Neighbourhood,
    /// Two rows of the brick being opened.
    pairs: [Pair; BRICK_VOXELS / 16],
    /// Its mean classes, not lit.
    means: MeanClasses,
}

/// Mean classes of a brick, not lit, and of labels their surfaces.
#[derive(Debug)]
struct MeanClasses {
    classes: Classes,
    surfaces: Surfaces,
}

impl Default for MeanClasses {
    fn default() -> Self {
        Self {
            classes: [[0.0; 4]; BRICK_VOXELS],
            surfaces: [[0.0; 4]; BRICK_VOXELS],
        }
    }
}

/// Two rows of voxels: which may be visible, their values, and their diffuse and specular factors.
#[derive(Debug, Clone, Copy, Default)]
struct Pair {
    visible: u32,
    value: Lanes16,
    light: [Lanes16; 2],
}

/// Bit set in every handle, so that its bits are those of a normal float.
const HANDLE: u32 = 1 << 30;

impl ClassifiedVoxels {
    /// The voxel of a handle.
    #[inline(always)]
    pub(crate) fn voxel(&self, handle: f32) -> &[f32; 4] {
        let handle = handle.to_bits() & !HANDLE;
        let (slot, voxel) = (handle as usize / BRICK_VOXELS, handle as usize % BRICK_VOXELS);
        self.voxels.get(slot).map_or(&[0.0; 4], |voxels| &voxels[voxel])
    }
}

/// Light on voxels.
#[derive(Debug, Clone, Copy)]
struct VoxelLight {
    phong: Phong,
    /// Rows of the matrix from differences per voxel to gradients in camera space.
    camera_from_voxel: [[f32; 3]; 3],
    /// Values are labels; the gradients are those of the labels' own shares.
    labels: bool,
}

/// Bricks whose voxels are classified, and how.
#[derive(Debug, Clone)]
pub(crate) struct ClassifiedBricks<'a> {
    field: &'a FieldStore,
    bricks: &'a [u32],
    /// Classes of these bricks' voxels, where they are not those of the field's samples.
    means: Option<&'a ClassifiedMeans>,
    table: &'a ClassificationTable,
    /// Values outside are invisible.
    hull: [f32; 2],
    light: Option<VoxelLight>,
    /// Dropped voxels; lattice space.
    cut: Option<&'a Cut>,
}

impl Bricks for ClassifiedBricks<'_> {
    fn len(&self) -> usize {
        self.bricks.len()
    }

    fn first(&self, index: usize) -> [u32; 3] {
        self.field.brick_first(self.bricks[index])
    }
}

impl<'a> ClassifiedBricks<'a> {
    /// Visible bricks of a level, not lit.
    pub(crate) fn new(level: &'a Level) -> Self {
        Self {
            field: &level.field,
            bricks: &level.visible,
            means: level.means.as_ref(),
            table: &level.classification,
            hull: level.hull,
            light: None,
            cut: None,
        }
    }

    /// Adds a cut, which drops voxels.
    pub(crate) fn cut(self, cut: &'a Cut) -> Self {
        Self {
            cut: (!cut.is_empty()).then_some(cut),
            ..self
        }
    }

    /// Adds lighting; `labels`: values are labels.
    pub(crate) fn lit(self, phong: Option<Phong>, camera_from_voxel: DMat3, labels: bool) -> Self {
        let gradient = camera_from_voxel.inverse().as_mat3();
        let light = phong.map(|phong| VoxelLight {
            phong,
            // The inverse's transpose, row by row.
            camera_from_voxel: gradient.to_cols_array_2d(),
            labels,
        });
        Self { light, ..self }
    }

    /// Classifies and lights a brick's voxels; `values` become their handles, NaN where nothing is visible. Compiled once,
    /// whatever the mode.
    pub(crate) fn open<S: Simd>(
        &self,
        simd: S,
        brick: (usize, u32),
        values: &mut [f32; BRICK_VOXELS],
        classified: &mut ClassifiedVoxels,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.classify(simd, brick, values, classified),
        );
    }

    #[inline(always)]
    fn classify<S: Simd>(
        &self,
        simd: S,
        (brick, slot): (usize, u32),
        values: &mut [f32; BRICK_VOXELS],
        classified: &mut ClassifiedVoxels,
    ) {
        let ClassifiedVoxels {
            voxels,
            around,
            pairs,
            means,
        } = classified;
        let index = slot as usize;
        if voxels.len() <= index {
            voxels.resize(index + 1, [[0.0; 4]; BRICK_VOXELS]);
        }
        let light = self.light.as_ref();
        let have_surfaces = light.is_some()
            && self
                .means
                .is_some_and(|of| of.decode_surfaces(brick, &mut means.surfaces));
        if self.means.is_none() || (light.is_some() && !have_surfaces) {
            self.field.read(self.bricks[brick], around);
        }
        match self.means {
            Some(of) => {
                of.decode(brick, &mut means.classes);
                find_means(&means.classes, pairs);
            }
            None => self.find(simd, around, pairs),
        }
        if let Some(light) = light {
            for (i, pair) in pairs.iter_mut().enumerate() {
                if pair.visible != 0 {
                    let (diffuse, specular) = match have_surfaces {
                        true => light.on_share(simd, &means.surfaces.as_chunks::<16>().0[i]),
                        false => light.on(simd, light.difference(simd, around, place_of(i))),
                    };
                    diffuse.store_slice(&mut pair.light[0].0);
                    specular.store_slice(&mut pair.light[1].0);
                }
            }
        }
        let handle = HANDLE | (slot * BRICK_VOXELS as u32);
        let voxels = &mut voxels[index];
        match self.means {
            Some(_) => light_voxels(simd, (pairs, handle), values, voxels, |voxel, _| {
                f32x4::from_slice(simd, &means.classes[voxel])
            }),
            None => light_voxels(simd, (pairs, handle), values, voxels, |_, value| {
                let ([a, b], t) = self.table.around(value);
                let (a, b) = (f32x4::from_slice(simd, a), f32x4::from_slice(simd, b));
                (b - a) * t + a
            }),
        }
        if let Some(cut) = self.cut {
            cut.drop_voxels(self.field.brick_first(self.bricks[brick]), values);
        }
    }

    /// Finds the rows that hold values which may be visible. Their light is the colours' own.
    #[inline(always)]
    fn find<S: Simd>(&self, simd: S, around: &Neighbourhood, pairs: &mut [Pair; BRICK_VOXELS / 16]) {
        let [xs, ys, zs] = around.inside;
        let columns = ((1u32 << xs[1]) - 1) & !((1u32 << xs[0]) - 1);
        let [low, high] = self.hull;
        for (i, pair) in pairs.iter_mut().enumerate() {
            let [y, z] = place_of(i);
            let value = rows(simd, around, [1, 1 + y, 1 + z]);
            let visible = value.simd_ge(f32x16::splat(simd, low)) & value.simd_le(f32x16::splat(simd, high));
            let inside = if z >= zs[0] && z < zs[1] { columns } else { 0 };
            let upper = if y >= ys[0] && y < ys[1] { inside } else { 0 };
            let lower = if y + 1 >= ys[0] && y + 1 < ys[1] {
                inside
            } else {
                0
            };
            pair.visible = visible.to_bitmask() as u32 & (upper | (lower << BRICK));
            value.store_slice(&mut pair.value.0);
            f32x16::splat(simd, 1.0).store_slice(&mut pair.light[0].0);
            f32x16::splat(simd, 0.0).store_slice(&mut pair.light[1].0);
        }
    }
}

/// Finds the voxels that have extinction. Their light is the colours' own.
fn find_means(classes: &Classes, pairs: &mut [Pair; BRICK_VOXELS / 16]) {
    for (pair, classes) in pairs.iter_mut().zip(classes.as_chunks::<16>().0) {
        let bits = classes.iter().enumerate();
        pair.visible = bits.fold(0, |bits, (lane, class)| bits | u32::from(class[0] > 0.0) << lane);
        pair.light = [Lanes16([1.0; 16]), Lanes16([0.0; 16])];
    }
}

/// Extinction and lit emission of the visible voxels; `class` has those of a voxel with this value.
#[inline(always)]
fn light_voxels<S: Simd>(
    simd: S,
    (pairs, handle): (&[Pair; BRICK_VOXELS / 16], u32),
    values: &mut [f32; BRICK_VOXELS],
    voxels: &mut Classes,
    class: impl Fn(usize, f32) -> f32x4<S>,
) {
    values.fill(f32::NAN);
    for (i, pair) in pairs.iter().enumerate() {
        let mut left = pair.visible;
        while left != 0 {
            let lane = left.trailing_zeros() as usize & 15;
            left &= left - 1;
            let voxel = 16 * i + lane;
            let class = class(voxel, pair.value.0[lane]);
            let extinction = class[0];
            if extinction <= 0.0 {
                continue;
            }
            let [diffuse, specular] = [pair.light[0].0[lane], pair.light[1].0[lane]];
            let shine = f32x4::splat(simd, specular * extinction);
            let lit = &mut voxels[voxel];
            (class * diffuse + shine).store_slice(lit);
            lit[0] = extinction;
            values[voxel] = f32::from_bits(handle + voxel as u32);
        }
    }
}

/// First row and slice of a pair of rows.
#[inline(always)]
fn place_of(pair: usize) -> [usize; 2] {
    [2 * pair % BRICK, 2 * pair / BRICK]
}

/// Two rows of eight values from a place of the neighbourhood on.
#[inline(always)]
fn rows<S: Simd>(simd: S, around: &Neighbourhood, [x, y, z]: [usize; 3]) -> f32x16<S> {
    let slice = &around.values[z];
    f32x8::from_slice(simd, &slice[y][x..x + BRICK])
        .combine(f32x8::from_slice(simd, &slice[y + 1][x..x + BRICK]))
}

impl VoxelLight {
    /// Differences per voxel of two rows of a brick's voxels.
    #[inline(always)]
    fn difference<S: Simd>(&self, simd: S, around: &Neighbourhood, [y, z]: [usize; 2]) -> [f32x16<S>; 3] {
        let [per_x, per_y, per_z] = &around.per_difference;
        let per_x = f32x8::from_slice(simd, per_x);
        let per_y = f32x8::splat(simd, per_y[y]).combine(f32x8::splat(simd, per_y[y + 1]));
        let place = [1, y + 1, z + 1];
        let [px, py, pz] = place;
        let own = rows(simd, around, place);
        let value = |place| {
            let value = rows(simd, around, place);
            match (self.labels, around.any_missing) {
                // The share of the voxel's own kind: a whole voxel of it, or none.
                (true, _) => {
                    let one = f32x16::splat(simd, 1.0);
                    value.simd_eq(own).select(one, f32x16::splat(simd, 0.0))
                }
                // A missing neighbour counts as the voxel's own value.
                (_, true) => value.simd_eq(value).select(value, own),
                (_, false) => value,
            }
        };
        let dx = (value([px + 1, py, pz]) - value([px - 1, py, pz])) * per_x.combine(per_x);
        let dy = (value([px, py + 1, pz]) - value([px, py - 1, pz])) * per_y;
        let dz = (value([px, py, pz + 1]) - value([px, py, pz - 1])) * per_z[z];
        [dx, dy, dz]
    }

    /// Diffuse and specular factors of voxels that have surfaces in them, as [`ClassifiedMeans::decode_surfaces`] has them.
    #[inline(always)]
    fn on_share<S: Simd>(&self, simd: S, surfaces: &[[f32; 4]; 16]) -> (f32x16<S>, f32x16<S>) {
        let mut lanes = [[0.0; 16]; 4];
        for (lane, surface) in surfaces.iter().enumerate() {
            for c in 0..4 {
                lanes[c][lane] = surface[c];
            }
        }
        let mut columns = [f32x16::splat(simd, 0.0); 4];
        for c in 0..4 {
            columns[c] = f32x16::simd_from(simd, lanes[c]);
        }
        let [dx, dy, dz, share] = columns;
        let (diffuse, specular) = self.on(simd, [dx, dy, dz]);
        ((diffuse - 1.0) * share + 1.0, specular * share)
    }

    /// Diffuse and specular factors of two rows of a brick's voxels.
    #[inline(always)]
    fn on<S: Simd>(&self, simd: S, [dx, dy, dz]: [f32x16<S>; 3]) -> (f32x16<S>, f32x16<S>) {
        let [a, b, c] = self.camera_from_voxel;
        self.phong.lanes(
            simd,
            [
                dx * a[0] + dy * a[1] + dz * a[2],
                dx * b[0] + dy * b[1] + dz * b[2],
                dx * c[0] + dy * c[1] + dz * c[2],
            ],
        )
    }
}
