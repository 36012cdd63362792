//! Compatibility table: every kind of item with every feature.
//!
//! The table of `docs/scenes.md` is made here, by asking [`splatvol::check`]; `UPDATE_SNAPSHOTS=1` rewrites it. Each
//! *yes* is rendered and checked, each *no* is the error that rendering also gives.

use std::path::{Path, PathBuf};

use glam::{DAffine3, DVec3};
use splatvol::mesh::{Association, MeshField, Topology};
use splatvol::{
    Bounds, Camera, Classification, Clip, Compositing, Coverage, EngineConfig, FlatSettings, Frame,
    GaussianMode, Grid, Isosurface, Item, Keep, Mesh, Motion, MotionBlur, PointLook, RenderSettings,
    Renderer, Scene, SolidTexture, Stuff, check,
};
use splatvol_testing::fields::{Ball, Field};
use splatvol_testing::transfer::linear_extinction;
use splatvol_testing::{checked, sample};

use super::support::{cloud, item, sphere, unlit};
use crate::common::perspective;

const BALL: Ball = Ball {
    centre: DVec3::ZERO,
    radius: 0.9,
};

/// Contents of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Volume,
    Mesh,
    Points,
    Volumetric,
    Published,
    Several,
}

/// Feature requested of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Feature {
    Animation,
    Depth,
    ClipBox,
    ClipPlane,
    Operator,
    Isosurface,
    Coverage,
    SubFrames,
    ExactBlur,
    PerSplat,
    Xray,
    Maximum,
    Mean,
}

/// A requested picture.
struct Asked {
    scene: Scene,
    settings: RenderSettings,
}

/// The answer.
#[derive(Debug, Clone, PartialEq)]
enum Answer {
    Yes,
    /// The combination cannot be expressed.
    Nothing(&'static str),
    /// Why not.
    No(String),
}

const KINDS: [(Kind, &str); 6] = [
    (Kind::Volume, "a volume"),
    (Kind::Mesh, "a mesh"),
    (Kind::Points, "points"),
    (Kind::Volumetric, "Gaussians, volumetric"),
    (Kind::Published, "Gaussians, 3dgs"),
    (Kind::Several, "several things"),
];

const FEATURES: [(Feature, &str); 13] = [
    (Feature::Animation, "animation"),
    (Feature::Depth, "depth"),
    (Feature::ClipBox, "clip box"),
    (Feature::ClipPlane, "clip plane"),
    (Feature::Operator, "operator"),
    (Feature::Isosurface, "exact isosurface"),
    (Feature::Coverage, "coverage"),
    (Feature::SubFrames, "motion blur by sub-frames"),
    (Feature::ExactBlur, "motion blur in closed form"),
    (Feature::PerSplat, "splat by splat"),
    (Feature::Xray, "X-ray"),
    (Feature::Maximum, "maximum (MIP)"),
    (Feature::Mean, "mean"),
];

impl Kind {
    fn items(self) -> Vec<Item> {
        match self {
            Self::Volume => {
                let grid = Grid::centred([12; 3], DVec3::splat(2.0 / 12.0)).unwrap();
                vec![Item::volume(sample(&BALL, &grid), look())]
            }
            Self::Mesh => vec![Item::mesh(mesh(), look())],
            Self::Points => vec![item(sphere(400), PointLook::default(), 0.8)],
            Self::Volumetric | Self::Published => vec![Item::gaussians(cloud(60, [0.05, 0.2], 3))],
            Self::Several => [Self::Volume, Self::Points]
                .into_iter()
                .flat_map(Self::items)
                .collect(),
        }
    }

    fn plain(self) -> Asked {
        let gaussians = match self {
            Self::Volumetric => GaussianMode::Volumetric,
            _ => GaussianMode::Auto,
        };
        Asked {
            scene: Scene::of_items(self.items()).unwrap(),
            settings: RenderSettings {
                gaussians,
                ..unlit(32, 28)
            },
        }
    }
}

fn look() -> splatvol::TransferFunction {
    linear_extinction([0.0, 1.0], 4.0, [0.9, 0.5, 0.2])
}

/// The ball on a structured grid.
fn mesh() -> Mesh {
    let points: Vec<DVec3> = (0..1000)
        .map(|i| DVec3::new(f64::from(i % 10), f64::from(i / 10 % 10), f64::from(i / 100)) / 4.5 - 1.0)
        .collect();
    let field = MeshField {
        name: "value".to_owned(),
        association: Association::Point,
        values: points.iter().map(|p| BALL.value(*p) as f32).collect(),
    };
    let positions = points.iter().map(|p| p.as_vec3().to_array()).collect();
    let topology = Topology::Structured(vec![[10; 3]]);
    Mesh::new(positions, topology, Vec::new(), field, DAffine3::IDENTITY).unwrap()
}

impl Feature {
    /// The requested picture, or the reason why it cannot be expressed.
    fn of(self, kind: Kind) -> Result<Asked, &'static str> {
        let Asked { scene, settings } = kind.plain();
        let bounds = Bounds {
            min: DVec3::splat(-2.0),
            max: DVec3::new(2.0, 0.3, 0.2),
        };
        let surface = Isosurface {
            value: 0.5,
            rgb: [0.2, 0.8, 0.3],
            opacity: 1.0,
        };
        let motion = Motion::Linear(DVec3::new(0.5, 0.1, 0.0));
        Ok(match self {
            Self::Animation | Self::Depth => Asked { scene, settings },
            Self::ClipBox => Asked {
                scene: scene.with_clip(Clip::of_box(&bounds, Keep::Inside).unwrap()),
                settings,
            },
            Self::ClipPlane => Asked {
                scene: scene.with_clip(Clip::plane(DVec3::ZERO, DVec3::new(1.0, 0.2, 0.1)).unwrap()),
                settings,
            },
            Self::Operator => Asked {
                scene: scene.with_operator(SolidTexture::new(Stuff::Marble, &bounds, 0.1).unwrap()),
                settings,
            },
            Self::Isosurface => Asked {
                scene: with_isosurface(scene, surface)?,
                settings,
            },
            Self::Coverage => Asked {
                scene,
                settings: RenderSettings {
                    coverage: Coverage::ADAPTIVE,
                    ..settings
                },
            },
            Self::SubFrames => Asked {
                scene: scene.with_motion(&motion),
                settings: checked(FlatSettings {
                    motion_blur: MotionBlur::Subframes { count: 3 },
                    ..settings.into()
                }),
            },
            Self::ExactBlur => Asked {
                scene: scene.with_motion(&motion),
                settings: checked(FlatSettings {
                    motion_blur: MotionBlur::Exact,
                    classification: Classification::Pre,
                    ..settings.into()
                }),
            },
            Self::PerSplat => Asked {
                scene,
                settings: checked(FlatSettings {
                    compositing: Compositing::PerSplat,
                    classification: Classification::Pre,
                    ..settings.into()
                }),
            },
            Self::Xray => Asked {
                scene,
                settings: checked(FlatSettings {
                    compositing: Compositing::Xray,
                    ..settings.into()
                }),
            },
            Self::Maximum => Asked {
                scene,
                settings: checked(FlatSettings {
                    compositing: Compositing::Mip,
                    ..settings.into()
                }),
            },
            Self::Mean => Asked {
                scene,
                settings: checked(FlatSettings {
                    compositing: Compositing::Mean,
                    ..settings.into()
                }),
            },
        })
    }
}

/// Every value of the scene as a surface.
fn with_isosurface(mut scene: Scene, surface: Isosurface) -> Result<Scene, &'static str> {
    let mut found = false;
    for item in &mut scene.items {
        if let splatvol::Content::Volume { isosurfaces, .. } | splatvol::Content::Mesh { isosurfaces, .. } =
            &mut item.content
        {
            isosurfaces.push(surface);
            found = true;
        }
    }
    if found {
        Ok(scene)
    } else {
        Err("points and Gaussians have no values")
    }
}

fn camera(step: f64) -> Camera {
    perspective(DVec3::ZERO, DVec3::new(0.4 + 0.1 * step, 1.0, 0.3), 7.0, 24.0)
}

fn answer(feature: Feature, kind: Kind) -> Answer {
    match feature.of(kind) {
        Err(why) => Answer::Nothing(why),
        Ok(asked) => match check(&asked.scene, &camera(0.0), &asked.settings) {
            Ok(()) => Answer::Yes,
            Err(error) => Answer::No(error.to_string()),
        },
    }
}

fn renderer() -> Renderer {
    Renderer::new(EngineConfig::default()).unwrap()
}

fn bytes(frame: &Frame) -> Vec<u32> {
    let pixels = frame.image.pixels.iter().flatten();
    pixels.chain(&frame.depth).map(|value| value.to_bits()).collect()
}

/// Looks at a picture that was promised.
fn look_at(feature: Feature, kind: Kind) {
    let what = format!("{feature:?} of {kind:?}");
    let Asked { scene, settings } = feature.of(kind).unwrap();
    let mut kept = renderer();
    let frame = kept.render(&scene, &camera(0.0), &settings).expect(&what);
    let seen = frame.image.pixels.iter().filter(|pixel| pixel[3] > 0.05).count();
    assert!(
        seen > 60 && seen < frame.image.pixels.len(),
        "{what}: {seen} pixels"
    );
    assert!(
        frame.image.pixels.iter().flatten().all(|value| value.is_finite()),
        "{what}"
    );
    match feature {
        Feature::Animation => {
            for step in [1.0, 2.0] {
                let next = kept.render(&scene, &camera(step), &settings).expect(&what);
                let alone = renderer().render(&scene, &camera(step), &settings).expect(&what);
                assert!(bytes(&next) == bytes(&alone), "{what}");
                assert!(bytes(&next) != bytes(&frame), "{what}");
            }
        }
        Feature::Depth => {
            for (pixel, depth) in frame.image.pixels.iter().zip(&frame.depth) {
                let inside = (4.0..10.0).contains(depth);
                assert!(
                    if pixel[3] > 0.05 {
                        inside
                    } else {
                        pixel[3] > 0.0 || depth.is_infinite()
                    },
                    "{what}: {depth}"
                );
            }
        }
        _ => {
            let plain = kind.plain();
            let plain = renderer()
                .render(&plain.scene, &camera(0.0), &plain.settings)
                .unwrap();
            assert!(bytes(&frame) != bytes(&plain), "{what} changes nothing");
        }
    }
    if let Feature::ClipBox | Feature::ClipPlane = feature {
        let plain = kind.plain();
        let plain = renderer()
            .render(&plain.scene, &camera(0.0), &plain.settings)
            .unwrap();
        let opacity = |frame: &Frame| frame.image.pixels.iter().map(|pixel| pixel[3]).sum::<f32>();
        assert!(opacity(&frame) < 0.9 * opacity(&plain), "{what}");
    }
}

#[test]
fn what_is_promised_is_rendered_and_what_is_refused_says_why() {
    for (feature, _) in FEATURES {
        for (kind, _) in KINDS {
            match answer(feature, kind) {
                Answer::Yes => look_at(feature, kind),
                Answer::Nothing(_) => {}
                Answer::No(why) => {
                    let Asked { scene, settings } = feature.of(kind).unwrap();
                    let error = renderer().render(&scene, &camera(0.0), &settings).unwrap_err();
                    assert_eq!(error.to_string(), why, "{feature:?} of {kind:?}");
                }
            }
        }
    }
}

/// The table, and below it each reason once.
fn table() -> String {
    let names = KINDS.map(|(_, name)| name).join(" | ");
    let mut text = format!("| | {names} |\n|---|{}\n", "---|".repeat(KINDS.len()));
    let mut reasons: Vec<String> = Vec::new();
    let mut note = |why: String| {
        let known = reasons.iter().position(|reason| *reason == why);
        let number = known.unwrap_or_else(|| {
            reasons.push(why);
            reasons.len() - 1
        });
        format!("no ({})", number + 1)
    };
    for (feature, name) in FEATURES {
        let cells = KINDS.map(|(kind, _)| match answer(feature, kind) {
            Answer::Yes => "yes".to_owned(),
            Answer::Nothing(why) => note(why.to_owned()),
            Answer::No(why) => note(why),
        });
        text += &format!("| {name} | {} |\n", cells.join(" | "));
    }
    text += "\n";
    for (index, reason) in reasons.iter().enumerate() {
        text += &format!("{}. {reason}\n", index + 1);
    }
    text
}

#[test]
fn the_documented_table_is_what_the_engines_answer() {
    const BEGIN: &str = "<!-- made by crates/splatvol/tests/it/scenes/table.rs -->\n";
    const END: &str = "<!-- end -->\n";
    let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/scenes.md");
    let docs = std::fs::read_to_string(&path).unwrap();
    let (before, rest) = docs.split_once(BEGIN).expect("the table begins");
    let (found, after) = rest.split_once(END).expect("the table ends");
    let expected = table();
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        std::fs::write(&path, format!("{before}{BEGIN}{expected}{END}{after}")).unwrap();
        return;
    }
    assert!(
        found == expected,
        "docs/scenes.md has another table; UPDATE_SNAPSHOTS=1 writes this:\n{expected}"
    );
}
