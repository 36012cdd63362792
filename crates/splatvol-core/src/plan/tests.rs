use glam::{DAffine3, DVec3};
use splatvol_scene::{Camera, Grid, ImageSize, Projection, RenderSettings, SheetSettings};

use super::{Bricks, FramePlan, GridView, Sampling};
use crate::brick::BRICK;
use crate::sheets::Planes;

/// Some of the bricks of a grid.
#[derive(Debug)]
struct Chosen(Vec<[u32; 3]>);

impl Chosen {
    fn of(dims: [usize; 3], keep: impl Fn(usize) -> bool) -> Self {
        let bricks = dims.map(|n| (n + 2).div_ceil(BRICK));
        let firsts = (0..bricks.iter().product::<usize>())
            .filter(|&index| keep(index))
            .map(|index| {
                let at = [
                    index % bricks[0],
                    index / bricks[0] % bricks[1],
                    index / (bricks[0] * bricks[1]),
                ];
                at.map(|a| (a * BRICK) as u32)
            });
        Self(firsts.collect())
    }
}

impl Bricks for Chosen {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn first(&self, index: usize) -> [u32; 3] {
        self.0[index]
    }
}

const DIMS: [usize; 3] = [40, 33, 27];

fn view(settings: &RenderSettings<SheetSettings>, distance: f64, fov_degrees: f64) -> GridView {
    let grid = Grid::centred(DIMS, DVec3::new(1.0, 1.2, 0.9)).expect("a grid");
    let projection = Projection::Perspective { fov_degrees };
    let from = DVec3::new(0.6, 0.5, -0.7).normalize() * distance;
    let camera = Camera::new(from, DVec3::ZERO, DVec3::Y, projection).expect("a camera");
    GridView::new(&grid, (&camera, settings), Sampling::Field, None)
}

fn settings() -> RenderSettings<SheetSettings> {
    RenderSettings {
        size: ImageSize::new(200, 150).expect("a size"),
        ..RenderSettings::default().with(SheetSettings::default())
    }
}

fn plan(view: &GridView, bricks: &Chosen) -> FramePlan {
    let mut plan = FramePlan::default();
    plan.of_grid(view, bricks, &settings(), 64);
    plan
}

/// A plan holds no reference to its inputs.
#[test]
fn plans_are_plain_data() {
    fn is_plain<T: Send + Sync + 'static>(_: &T) {}
    let bricks = Chosen::of(DIMS, |_| true);
    is_plain(&plan(&view(&settings(), 120.0, 30.0), &bricks));
}

#[test]
fn every_brick_is_in_the_lists_of_the_tiles_that_its_voxels_reach() {
    for (distance, fov_degrees) in [(120.0, 30.0), (25.0, 90.0)] {
        let settings = settings();
        let view = view(&settings, distance, fov_degrees);
        let bricks = Chosen::of(DIMS, |index| index % 2 == 0);
        let plan = plan(&view, &bricks);
        assert!(!plan.zones().is_empty());
        let camera_from_lattice: DAffine3 = view.camera_from_lattice();
        let rays = view.rays();
        for (index, first) in bricks.0.iter().enumerate() {
            let corner = camera_from_lattice.transform_point3(DVec3::from_array(first.map(f64::from)));
            let found = DVec3::from_array(plan.corners[index].map(f64::from));
            assert!(
                (corner - found).length() < 1e-5 * corner.length(),
                "{corner} {found}"
            );
            // Where a voxel lies on its own plane, in front of the camera.
            for voxel in 0..BRICK.pow(3) {
                let within = [voxel % BRICK, voxel / BRICK % BRICK, voxel / (BRICK * BRICK)];
                let point =
                    DVec3::from_array(std::array::from_fn(|a| f64::from(first[a]) + within[a] as f64));
                let at = camera_from_lattice.transform_point3(point);
                let Some(zone) = plan.zones().iter().find(|own| {
                    let Planes { spacing, .. } = own.zone.planes;
                    let shown = &own.zone.shown;
                    let depth = |sheet: usize| own.zone.planes.plane(sheet);
                    at.z > depth(shown.start) && at.z <= depth(shown.end) && at.z > spacing
                }) else {
                    continue;
                };
                let pixel = [at.x, at.y].map(|x| x / at.z / f64::from(rays.per_pixel));
                let pixel = [0, 1].map(|a| pixel[a] + f64::from(rays.principal[a]));
                if !(0.0..200.0).contains(&pixel[0]) || !(0.0..150.0).contains(&pixel[1]) {
                    continue;
                }
                let tile = pixel[1] as usize / 64 * plan.tiles.columns + pixel[0] as usize / 64;
                let listed = zone
                    .lists
                    .of(tile)
                    .any(|brick| brick.active.brick as usize == index);
                assert!(listed, "brick {index} in tile {tile}");
            }
        }
    }
}

#[test]
fn planes_and_footprints_do_not_depend_on_the_bricks_that_are_needed() {
    let view = view(&settings(), 60.0, 60.0);
    let [all, few] = [1, 3].map(|n| plan(&view, &Chosen::of(DIMS, |index| index % n == 0)));
    assert_eq!(all.zones().len(), few.zones().len());
    for (all, few) in all.zones().iter().zip(few.zones()) {
        assert_eq!(all.zone.planes, few.zone.planes);
        assert_eq!(all.sheets, few.sheets);
    }
}
