//! Picking: what a ray meets, and where a person would say that it meets it.
//!
//! Opacity is accumulated along the ray; the place is in the interval in which it grows most, where half of that
//! growth is reached (Wiebel et al. 2012, "WYSIWYP: What You See Is What You Pick", section 4). Departures: an interval ends where
//! the growth per length has a minimum, and samples are trilinear, not the picture's reconstruction: the value is
//! that of the data, or of the overview of a volume that is read in chunks.

use splatvol::glam::{DAffine3, DVec2, DVec3};
use splatvol::{Camera, ImageSize, Item, Scene, TransferFunction, Volume};

/// Steps of a ray at most.
const MOST_STEPS: usize = 4000;
/// Steps per spacing of the samples.
const STEPS_PER_SPACING: f64 = 4.0;
/// Growth of the opacity below which nothing is met.
const LEAST: f64 = 0.02;

/// A sample of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Depth along the camera's axis, world length.
    pub depth: f64,
    /// Value of the data; NaN outside.
    pub value: f64,
    /// Opacity of all that lies in front of it and in its step.
    pub opacity: f64,
}

/// What a ray meets.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// The place, world.
    pub place: DVec3,
    /// The value there.
    pub value: f64,
    /// Number of the item, among the visible ones.
    pub item: usize,
    /// The samples of that item along the ray.
    pub profile: Vec<Sample>,
    /// Index of the place among them.
    pub at: usize,
}

/// A volume, ready to be sampled.
struct Field<'a> {
    item: &'a Item,
    volume: &'a Volume,
    function: &'a TransferFunction,
    voxel_from_world: DAffine3,
    item_from_world: DAffine3,
    /// World length between samples.
    spacing: f64,
    /// World length to which opacities refer.
    unit_distance: f64,
}

impl<'a> Field<'a> {
    fn of(item: &'a Item) -> Option<Self> {
        let shown = item.as_volume()?;
        let grid = shown.volume.grid();
        let world_from_voxel = item.world_from_item * grid.world_from_voxel();
        let spacing = grid.mean_spacing() * item.scale();
        Some(Self {
            item,
            volume: shown.volume,
            function: shown.transfer_function,
            voxel_from_world: world_from_voxel.inverse(),
            item_from_world: item.world_from_item.inverse(),
            spacing,
            unit_distance: shown.unit_distance(),
        })
    }

    /// Value and extinction at a point, world; `None` outside and where it is cut away.
    fn at(&self, world: DVec3) -> Option<(f64, f64)> {
        let value = value(self.volume, self.voxel_from_world.transform_point3(world))?;
        let own = self.item_from_world.transform_point3(world);
        let kept = self.item.clips.iter().all(|clip| clip.keeps(own));
        kept.then(|| (value, self.function.extinction(value, self.unit_distance)))
    }

    /// Depths at which the ray `origin + depth * direction` enters and leaves the cells, world.
    fn crossed(&self, origin: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        let from = self.voxel_from_world.transform_point3(origin);
        let along = self.voxel_from_world.transform_vector3(direction);
        let dims = self.volume.grid().dims().map(|side| side as f64 - 0.5);
        let mut depths = [0.0, f64::INFINITY];
        for axis in 0..3 {
            let ends = [-0.5, dims[axis]].map(|end| (end - from[axis]) / along[axis]);
            if along[axis] == 0.0 {
                if !(-0.5..=dims[axis]).contains(&from[axis]) {
                    return None;
                }
                continue;
            }
            depths[0] = f64::max(depths[0], ends[0].min(ends[1]));
            depths[1] = f64::min(depths[1], ends[0].max(ends[1]));
        }
        (depths[1] > depths[0] && depths[1].is_finite()).then_some(depths)
    }
}

/// Trilinear value at a place in voxels; beyond the outermost samples theirs. `None` outside the cells and where samples are
/// missing.
pub fn value(volume: &Volume, voxel: DVec3) -> Option<f64> {
    let dims = volume.grid().dims();
    let mut low = [0; 3];
    let mut share = [0.0; 3];
    for axis in 0..3 {
        let at = voxel[axis];
        let last = dims[axis] - 1;
        if !(-0.5..=last as f64 + 0.5).contains(&at) {
            return None;
        }
        let at = at.clamp(0.0, last as f64);
        low[axis] = (at as usize).min(last.saturating_sub(1));
        share[axis] = at - low[axis] as f64;
    }
    let mut sum = 0.0;
    for corner in 0..8 {
        let bit = |axis: usize| corner >> axis & 1;
        let weight: f64 = (0..3)
            .map(|axis| {
                if bit(axis) == 1 {
                    share[axis]
                } else {
                    1.0 - share[axis]
                }
            })
            .product();
        if weight > 0.0 {
            let [x, y, z] = [0, 1, 2].map(|axis| low[axis] + bit(axis));
            sum += weight * volume.value((z * dims[1] + y) * dims[0] + x);
        }
    }
    sum.is_finite().then_some(sum)
}

/// Origin and direction of the ray of a pixel, world; the direction is as long as a length 1 of depth.
pub(super) fn world_ray(camera: &Camera, size: ImageSize, pixel: DVec2) -> (DVec3, DVec3) {
    let (origin, direction) = camera.screen_from_camera(size).ray(pixel);
    let world_from_camera = camera.camera_from_world().inverse();
    (
        world_from_camera.transform_point3(origin),
        world_from_camera.transform_vector3(direction),
    )
}

/// What the ray of a pixel meets: `pixel` from the upper left corner of a picture of this size.
pub fn probe(scene: &Scene, camera: &Camera, size: ImageSize, pixel: DVec2) -> Option<Probe> {
    let (origin, direction) = world_ray(camera, size, pixel);
    let fields: Vec<(usize, Field<'_>)> = scene
        .items
        .iter()
        .enumerate()
        .filter_map(|(index, item)| Some((index, Field::of(item)?)))
        .collect();
    let crossed: Vec<[f64; 2]> = fields
        .iter()
        .filter_map(|(_, field)| field.crossed(origin, direction))
        .collect();
    let near = crossed.iter().map(|ends| ends[0]).fold(f64::INFINITY, f64::min);
    let far = crossed
        .iter()
        .map(|ends| ends[1])
        .fold(f64::NEG_INFINITY, f64::max);
    if far <= near {
        return None;
    }
    let spacing = fields
        .iter()
        .map(|(_, field)| field.spacing)
        .fold(f64::INFINITY, f64::min);
    let length = (far - near) * direction.length();
    let steps = ((length / spacing * STEPS_PER_SPACING).ceil() as usize).clamp(2, MOST_STEPS);
    let step = (far - near) / steps as f64;
    let mut profiles = vec![Vec::with_capacity(steps); fields.len()];
    let mut transmittance = 1.0;
    let mut growth = Vec::with_capacity(steps);
    for index in 0..steps {
        let depth = near + (index as f64 + 0.5) * step;
        let world = origin + depth * direction;
        let met: Vec<Option<(f64, f64)>> = fields.iter().map(|(_, field)| field.at(world)).collect();
        let extinction: f64 = met.iter().flatten().map(|(_, extinction)| extinction).sum();
        let next = transmittance * libm::exp(-extinction * step * direction.length());
        growth.push(transmittance - next);
        transmittance = next;
        for (profile, met) in profiles.iter_mut().zip(&met) {
            profile.push(Sample {
                depth,
                value: met.map_or(f64::NAN, |(value, _)| value),
                opacity: 1.0 - transmittance,
            });
        }
    }
    let at = place_of(&growth)?;
    let world = origin + (near + (at as f64 + 0.5) * step) * direction;
    let extinction = |field: &Field<'_>| field.at(world).map_or(-1.0, |(_, extinction)| extinction);
    let (position, (item, field)) = fields
        .iter()
        .enumerate()
        .max_by(|(_, (_, a)), (_, (_, b))| extinction(a).total_cmp(&extinction(b)))?;
    let (value, _) = field.at(world)?;
    Some(Probe {
        place: world,
        value,
        item: *item,
        profile: profiles.swap_remove(position),
        at,
    })
}

/// The step at which half of the largest rise of opacity is reached: rises end where the growth per step has a minimum.
fn place_of(growth: &[f64]) -> Option<usize> {
    let mut best: Option<(f64, [usize; 2])> = None;
    let mut start = 0;
    for end in 1..=growth.len() {
        let ends = end == growth.len()
            || (growth[end] > growth[end - 1] && (end < 2 || growth[end - 1] <= growth[end - 2]));
        if ends {
            let rise: f64 = growth[start..end].iter().sum();
            if best.is_none_or(|(most, _)| rise > most) {
                best = Some((rise, [start, end]));
            }
            start = end;
        }
    }
    let (rise, [start, end]) = best.filter(|(rise, _)| *rise >= LEAST)?;
    let mut sum = 0.0;
    (start..end).find(|&index| {
        sum += growth[index];
        sum >= 0.5 * rise
    })
}

#[cfg(test)]
mod tests {
    use splatvol::{ColorPoint, Grid, LengthUnit, OpacityPoint, Projection, Rescale, Samples, Scene, View};

    use super::*;

    /// Two shells at x = 8 and x = 24 of 32, the second one several times as dense.
    fn shells() -> Scene {
        let value = |x: usize| match x {
            8 => 100,
            24 => 200,
            _ => 0,
        };
        let samples: Vec<u8> = (0..32 * 32 * 32).map(|i| value(i % 32)).collect();
        let grid = Grid::centred([32; 3], [1.0; 3]).unwrap();
        let samples = Samples::U8(samples.into());
        let volume = Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown).unwrap();
        let opacities = [
            (0.0, 0.0),
            (50.0, 0.0),
            (100.0, 0.1),
            (120.0, 0.1),
            (150.0, 0.6),
            (200.0, 0.9),
        ];
        let opacities = opacities.map(|(value, opacity)| OpacityPoint::new(value, opacity));
        let colors = vec![ColorPoint::new(0.0, [1.0; 3])];
        let function = TransferFunction::new(colors, opacities.to_vec(), Some(1.0)).unwrap();
        Scene::new(volume, function)
    }

    #[test]
    fn the_densest_shell_is_picked_and_no_empty_space_between() {
        let scene = shells();
        let size = ImageSize::new(64, 64).unwrap();
        let projection = Projection::Orthographic { height: 32.0 };
        let camera = Camera::framing(&scene.bounds().unwrap(), View::Left, projection, 1.0).unwrap();
        let probe = probe(&scene, &camera, size, DVec2::splat(32.0)).unwrap();
        // Seen from -x; the world's origin is the middle of the grid.
        assert!((probe.place.x - (24.0 - 15.5)).abs() < 0.8, "{}", probe.place);
        assert!(probe.value > 100.0, "{}", probe.value);
        assert!(probe.profile.len() >= 64, "{}", probe.profile.len());
        let opacity = probe.profile[probe.at].opacity;
        assert!(opacity > 0.3, "{opacity}");
        let beside = super::probe(&scene, &camera, size, DVec2::new(-9.0, 32.0));
        assert_eq!(beside, None);
    }

    #[test]
    fn values_are_trilinear_and_end_with_the_cells() {
        let samples = Samples::F32(vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0].into());
        let grid = Grid::centred([2; 3], [1.0; 3]).unwrap();
        let volume = Volume::new(grid, samples, Rescale::default(), LengthUnit::Unknown).unwrap();
        let at = |x, y, z| value(&volume, DVec3::new(x, y, z));
        assert_eq!(at(0.5, 0.5, 0.5), Some(3.5));
        assert_eq!(at(1.4, 0.0, 0.0), Some(1.0));
        assert_eq!(at(1.6, 0.0, 0.0), None);
        assert_eq!(at(f64::NAN, 0.0, 0.0), None);
    }
}
