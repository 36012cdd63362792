//! Pictures that are stopped, watched while they are made, and made in parts.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::common::PROJECTIONS;
use glam::{DAffine3, DVec3};
use splatvol::{
    Bounds, Camera, Classification, Compositing, Control, Coverage, EngineConfig, FlatSettings, Frame,
    GaussianAttributes, Gaussians, Grid, ImageSize, Item, Motion, MotionBlur, PointAttributes, PointLook,
    Points, RenderSettings, Renderer, Scene, SceneError, Share, TileRect, View,
};
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::{Random, checked};

const WIDTH: u32 = 184;
const HEIGHT: u32 = 136;

struct Case {
    name: &'static str,
    scene: Scene,
    camera: Camera,
    settings: RenderSettings,
    /// Largest edge of a tile, whatever size is requested.
    edge: u32,
}

/// Every engine, and everything that combines several pictures into one.
fn cases() -> Vec<Case> {
    let volume = Sample::Shells.generate(Some(SampleSize::Longest(48))).unwrap();
    let grid = volume.grid().clone();
    let bounds = grid.bounds();
    let scene = Scene::new(volume, Sample::Shells.default_transfer_function().unwrap());
    let moving = scene.clone().with_motion(&Motion::Spin {
        axis: DVec3::Z,
        centre: bounds.centre(),
        angle: 0.3,
    });
    let camera = |zoom| Camera::framing(&bounds, View::Iso, PROJECTIONS[0], 1.35 / zoom).unwrap();
    let sized = |settings| RenderSettings {
        size: ImageSize::new(WIDTH, HEIGHT).unwrap(),
        ..settings
    };
    let default = sized(RenderSettings::default());
    let case = |name, settings| Case {
        name,
        scene: scene.clone(),
        camera: camera(1.0),
        settings,
        edge: 32,
    };
    let several = Scene::of_items(vec![
        scene.items[0].clone(),
        points(&bounds),
        Item::gaussians(gaussians(&bounds)),
    ])
    .unwrap();
    let cloud = Scene::of_items(vec![points(&bounds), Item::gaussians(gaussians(&bounds))]).unwrap();
    let composited = |compositing| {
        checked(FlatSettings {
            compositing,
            ..default.into()
        })
    };
    let pre = checked(FlatSettings {
        classification: Classification::Pre,
        ..default.into()
    });
    let one_by_one = checked(FlatSettings {
        compositing: Compositing::PerSplat,
        prefilter: false,
        ..pre.into()
    });
    vec![
        case("default", default),
        case("best", sized(RenderSettings::best())),
        case("pre", pre),
        Case {
            edge: 128,
            ..case("xray", composited(Compositing::Xray))
        },
        case("mip", composited(Compositing::Mip)),
        Case {
            edge: 64,
            ..case("per splat", one_by_one)
        },
        Case {
            scene: cloud,
            ..case("3dgs and points", default)
        },
        Case {
            scene: several.clone(),
            ..case("layers", default)
        },
        Case {
            scene: several.clone(),
            ..case("clouds per splat", one_by_one)
        },
        Case {
            scene: several,
            ..case("xray of clouds", composited(Compositing::Xray))
        },
        case(
            "coverage",
            RenderSettings {
                coverage: Coverage::ADAPTIVE,
                ..default
            },
        ),
        Case {
            scene: moving,
            ..case(
                "shutter",
                checked(FlatSettings {
                    motion_blur: MotionBlur::Subframes { count: 3 },
                    ..default.into()
                }),
            )
        },
        Case {
            camera: far(&grid, default.size),
            ..case("two levels", default)
        },
        Case {
            camera: camera(5.0),
            ..case(
                "levels by depth",
                checked(FlatSettings {
                    level_bias: 4.0,
                    ..default.into()
                }),
            )
        },
    ]
}

/// A place in a box, by numbers from 0 to 1.
fn place(bounds: &Bounds, at: DVec3) -> [f32; 3] {
    (bounds.min + at * (bounds.max - bounds.min)).as_vec3().to_array()
}

/// Points all over a box.
fn points(bounds: &Bounds) -> Item {
    let mut random = Random::new(5);
    let positions: Vec<_> = (0..2000)
        .map(|_| place(bounds, random.point(DVec3::ZERO, DVec3::ONE)))
        .collect();
    let attributes = PointAttributes {
        radii: vec![0.01 * bounds.diagonal() as f32; positions.len()],
        ..PointAttributes::default()
    };
    let points = Points::new(positions, attributes, DAffine3::IDENTITY).unwrap();
    Item::points(points, PointLook::default())
}

/// Gaussians all over a box.
fn gaussians(bounds: &Bounds) -> Gaussians {
    let mut random = Random::new(6);
    let mut made = GaussianAttributes::default();
    for _ in 0..2000 {
        made.means
            .push(place(bounds, random.point(DVec3::ZERO, DVec3::ONE)));
        made.scales
            .push([(); 3].map(|()| (bounds.diagonal() * random.range(0.002, 0.03)) as f32));
        made.rotations.push([0.0, 0.0, 0.0, 1.0]);
        made.opacities.push(random.range(0.1, 0.95) as f32);
        made.harmonics
            .push([(); 3].map(|()| random.range(-1.0, 1.0) as f32));
    }
    Gaussians::new(made, 0, DAffine3::IDENTITY).unwrap()
}

/// A camera for which two levels of detail are blended: voxels a little wider than .8 pixels.
fn far(grid: &Grid, size: ImageSize) -> Camera {
    let centre = grid.bounds().centre();
    let mut distance = grid.bounds().diagonal();
    loop {
        let position = centre + distance * DVec3::new(0.6, 0.7, 0.4).normalize();
        let camera = Camera::new(position, centre, DVec3::Z, PROJECTIONS[0]).unwrap();
        if camera.screen_from_camera(size).scale_at(distance) * grid.mean_spacing() < 0.85 {
            return camera;
        }
        distance *= 1.02;
    }
}

fn renderer() -> Renderer {
    let config = EngineConfig {
        threads: Some(2),
        tile_edge: Some(32),
        ..EngineConfig::default()
    };
    Renderer::new(config).unwrap()
}

impl Case {
    /// The least number of tiles.
    fn tiles(&self) -> usize {
        (WIDTH.div_ceil(self.edge) * HEIGHT.div_ceil(self.edge)) as usize
    }

    /// The largest share of the picture that is reported before all of it.
    fn shares(&self) -> f64 {
        1.0 - 1.0 / self.tiles() as f64
    }

    fn render(&self, renderer: &mut Renderer, control: &Control<'_>) -> Result<Frame, SceneError> {
        let mut frame = Frame::empty(self.settings.size);
        renderer.render_with(&self.scene, &self.camera, &self.settings, &mut frame, control)?;
        Ok(frame)
    }
}

#[test]
fn stopped_pictures_are_given_up_and_leave_no_trace() {
    for case in cases() {
        let expected = case.render(&mut renderer(), &Control::default()).unwrap();
        let mut renderer = renderer();
        for share in [0.0, 0.3, 0.8] {
            // The share of all tiles but one has to be larger.
            let share = f64::min(share, case.shares() - 0.1);
            let stop = AtomicBool::new(false);
            let heard = Mutex::new(0.0);
            let progress = |done: f64| {
                *heard.lock().unwrap() = done;
                stop.fetch_or(done >= share, Ordering::Relaxed);
            };
            let control = Control {
                stop: Some(&stop),
                progress: Some(&progress),
                ..Control::default()
            };
            let stopped = case.render(&mut renderer, &control);
            assert_eq!(stopped, Err(SceneError::Stopped), "{} at {share}", case.name);
            let heard = *heard.lock().unwrap();
            assert!(heard < 1.0, "{} at {share}: {heard} done", case.name);
        }
        let again = case.render(&mut renderer, &Control::default()).unwrap();
        assert!(again == expected, "{}: another picture after a stop", case.name);
    }
}

#[test]
fn progress_runs_once_from_nothing_to_all() {
    for case in cases() {
        let shares = Mutex::new(Vec::new());
        let progress = |share: f64| shares.lock().unwrap().push(share);
        let control = Control {
            progress: Some(&progress),
            ..Control::default()
        };
        case.render(&mut renderer(), &control).unwrap();
        let shares = shares.into_inner().unwrap();
        assert!(shares.is_sorted_by(|a, b| a < b), "{}: {shares:?}", case.name);
        assert_eq!((shares[0], shares[shares.len() - 1]), (0.0, 1.0), "{}", case.name);
        assert!(shares.len() > case.tiles() / 2, "{}: {shares:?}", case.name);
    }
}

#[test]
fn tiles_that_were_reported_are_the_picture() {
    let [width, height] = [WIDTH, HEIGHT].map(|side| side as usize);
    for case in cases() {
        let heard = Mutex::new((0, vec![[0.0f32; 4]; width * height]));
        let tile = |rect: &TileRect, colors: &[[f32; 4]]| {
            let (count, picture) = &mut *heard.lock().unwrap();
            *count += 1;
            for (y, row) in (rect.y0..rect.y1).zip(colors.chunks_exact(rect.x1 - rect.x0)) {
                picture[y * width + rect.x0..y * width + rect.x1].copy_from_slice(row);
            }
        };
        let control = Control {
            tile: Some(&tile),
            ..Control::default()
        };
        let frame = case.render(&mut renderer(), &control).unwrap();
        let (count, picture) = heard.into_inner().unwrap();
        assert!(picture == frame.image.pixels, "{}", case.name);
        if case.name != "shutter" {
            assert!(count >= case.tiles(), "{}: {count} reports", case.name);
        }
    }
}

#[test]
fn shares_that_are_put_together_are_the_whole_to_the_bit() {
    let width = WIDTH as usize;
    for case in cases() {
        let whole = case.render(&mut renderer(), &Control::default()).unwrap();
        let mut together = Frame::empty(case.settings.size);
        // Each by a worker of its own; blocks that do and do not divide the tiles.
        let (count, edge) = if case.name.len() % 2 == 0 {
            (2, 32)
        } else {
            (3, 20)
        };
        for index in 0..count {
            let share = Share::new(index, count, edge).unwrap();
            let control = Control {
                share: Some(share),
                ..Control::default()
            };
            let part = case.render(&mut renderer(), &control).unwrap();
            for rect in share.blocks(case.settings.size) {
                for i in (rect.y0..rect.y1).flat_map(|y| y * width + rect.x0..y * width + rect.x1) {
                    together.image.pixels[i] = part.image.pixels[i];
                    together.depth[i] = part.depth[i];
                    together.optical_depth[i] = part.optical_depth[i];
                }
            }
            // Nothing else is there: the rest of the pixels is empty.
            let mut kept = part.clone();
            share.keep(&mut kept, [0; 2]);
            assert!(kept == part, "{}: share {index} has pixels of others", case.name);
        }
        assert!(
            together == whole,
            "{}: {count} shares of {edge} pixels",
            case.name
        );
    }
}

#[test]
fn parts_that_are_put_together_are_the_whole_to_the_bit() {
    let [width, height] = [WIDTH, HEIGHT].map(|side| side as usize);
    for case in cases() {
        let whole = case.render(&mut renderer(), &Control::default()).unwrap();
        let mut together = Frame::empty(case.settings.size);
        // Parts that end at no tile's border, each by a worker of its own.
        for (columns, rows) in [(0..70, 0..height), (70..width, 0..50), (70..width, 50..height)] {
            let control = Control {
                part: Some(TileRect {
                    x0: columns.start,
                    y0: rows.start,
                    x1: columns.end,
                    y1: rows.end,
                }),
                ..Control::default()
            };
            let part = case.render(&mut renderer(), &control).unwrap();
            let seen = |i: usize| part.image.pixels[i] != [0.0; 4];
            let is_inside = |i: usize| columns.contains(&(i % width)) && rows.contains(&(i / width));
            assert!(
                (0..width * height).all(|i| is_inside(i) || !seen(i)),
                "{}: nothing outside",
                case.name
            );
            together.paste(&part, columns, rows).unwrap();
        }
        assert!(together == whole, "{}", case.name);
    }
}

#[test]
fn windows_have_the_whole_pictures_values_and_their_own_size() {
    let windows = [
        (0, 0, 184, 40),
        (0, 40, 184, 41),
        (37, 61, 131, 136),
        (183, 135, 184, 136),
    ];
    for case in &cases() {
        let mut renderer = renderer();
        let mut whole = Frame::empty(case.settings.size);
        let mut render = |frame: &mut Frame, control: Control<'_>| {
            renderer.render_with(&case.scene, &case.camera, &case.settings, frame, &control)
        };
        render(&mut whole, Control::default()).unwrap();
        for (x0, y0, x1, y1) in windows {
            let window = Some(TileRect { x0, y0, x1, y1 });
            let mut frame = Frame::empty(ImageSize::new(1, 1).unwrap());
            render(
                &mut frame,
                Control {
                    window,
                    ..Control::default()
                },
            )
            .unwrap();
            let expected = whole.cut(x0..x1, y0..y1).unwrap();
            assert_eq!(frame, expected, "{}, {window:?}", case.name);
        }
        let window = Some(TileRect {
            x0: 3,
            y0: 0,
            x1: 185,
            y1: 9,
        });
        let error = render(
            &mut whole,
            Control {
                window,
                ..Control::default()
            },
        )
        .unwrap_err();
        assert!(error.to_string().contains("[3, 0, 185, 9]"), "{error}");
    }
}

#[test]
fn the_memory_of_a_window_is_its_own() {
    let case = &cases()[0];
    let size = ImageSize::new(4 * WIDTH, 4 * HEIGHT).unwrap();
    let settings = &RenderSettings {
        size,
        ..case.settings
    };
    let held = |window| {
        let mut renderer = renderer();
        let mut frame = Frame::empty(size);
        let control = Control {
            window,
            ..Control::default()
        };
        renderer
            .render_with(&case.scene, &case.camera, settings, &mut frame, &control)
            .unwrap();
        renderer.statistics().memory.tiles
    };
    let row = TileRect {
        x0: 0,
        y0: 256,
        x1: 4 * WIDTH as usize,
        y1: 288,
    };
    let (all, own) = (held(None), held(Some(row)));
    assert!(own * 3 < all, "{own} of {all}");
}
