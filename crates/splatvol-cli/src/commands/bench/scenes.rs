//! Measured cases: the fixed scenes or given volumes, in all requested combinations.

use std::num::NonZero;

use splatvol::Classification;

use splatvol_document::keys::names::ClassificationName;

use crate::args::{BenchArgs, LookName, ProjectionName};

/// A scene that is always the same, so that its pictures and times can be compared.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FixedScene {
    /// Name and size of the sample, after `sample:`.
    pub(crate) name: &'static str,
    /// Side of its picture, pixels.
    side: u32,
    /// Whether it is one of the small ones.
    quick: bool,
}

/// All fixed scenes.
pub(crate) const FIXED_SCENES: [FixedScene; 5] = [
    FixedScene::new("shells:256", 512, false),
    FixedScene::new("head:256", 512, false),
    FixedScene::new("head:512", 512, false),
    FixedScene::new("shells:64", 128, true),
    FixedScene::new("head:64", 128, true),
];

impl FixedScene {
    const fn new(name: &'static str, side: u32, quick: bool) -> Self {
        Self { name, side, quick }
    }
}

/// What is measured.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SceneChoice {
    /// In names of cases.
    pub(super) name: String,
    /// As `splatvol render` takes it; `None` if an earlier picture says it.
    pub(super) input: Option<String>,
    /// Side of its picture unless asked otherwise, pixels.
    pub(super) side: u32,
}

/// Variation between the cases of one volume. `None` leaves it to the other flags and the data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Variant {
    pub(super) look: LookName,
    pub(super) classification: Option<ClassificationName>,
    pub(super) projection: Option<ProjectionName>,
    pub(super) threads: usize,
}

/// The volumes that the flags ask for.
pub(super) fn scenes(args: &BenchArgs) -> Vec<SceneChoice> {
    let given = args.inputs.iter().map(|input| SceneChoice {
        name: input.clone(),
        input: Some(input.clone()),
        side: 512,
    });
    // Without an input, an earlier picture says what is shown.
    let earlier = args.picture.like.iter().filter(|_| args.inputs.is_empty());
    let earlier = earlier.map(|like| SceneChoice {
        name: like.display().to_string(),
        input: None,
        side: 512,
    });
    let selected = |scene: &&FixedScene| match (&args.scenes[..], &args.update_expected) {
        ([], Some(_)) => true,
        ([], None) => scene.quick == args.quick,
        (names, _) => names.iter().any(|name| name == scene.name),
    };
    let fixed = FIXED_SCENES.iter().filter(|_| args.is_fixed());
    let fixed = fixed.filter(selected).map(|scene| SceneChoice {
        name: scene.name.to_owned(),
        input: Some(format!("sample:{}", scene.name)),
        side: scene.side,
    });
    given.chain(earlier).chain(fixed).collect()
}

/// The cases of each volume; threads vary fastest.
pub(super) fn variants(args: &BenchArgs) -> Vec<Variant> {
    let fixed = args.is_fixed();
    let picture = &args.picture;
    let looks_given = !picture.look.is_empty() || picture.effects.tf2d.is_some();
    let looks = match &args.looks[..] {
        [] if fixed && !looks_given => vec![LookName::Opaque, LookName::Translucent],
        [] => vec![LookName::AsRender],
        looks => looks.to_vec(),
    };
    let classifications = match picture.method.classification {
        None if fixed => vec![Some(ClassificationName::Post), Some(ClassificationName::Pre)],
        one => vec![one],
    };
    let flags_project = picture.camera.camera_fov.is_some() || picture.camera.orthographic.is_some();
    let projections = match &args.projection[..] {
        [] if fixed && !flags_project => vec![
            Some(ProjectionName::Perspective),
            Some(ProjectionName::Orthographic),
        ],
        [] => vec![None],
        projections => projections.iter().copied().map(Some).collect(),
    };
    let threads = threads(args);
    let mut variants = Vec::new();
    for &look in &looks {
        for &classification in &classifications {
            for &projection in &projections {
                variants.extend(threads.iter().map(|&threads| Variant {
                    look,
                    classification,
                    projection,
                    threads,
                }));
            }
        }
    }
    variants
}

/// Name of a case, without its threads.
pub(super) fn case_name(
    scene: &str,
    look: LookName,
    classification: Classification,
    projection: ProjectionName,
) -> String {
    let look = match look {
        LookName::Opaque => "opaque",
        LookName::Translucent => "translucent",
        LookName::AsRender => "as-render",
    };
    let classification = match classification {
        Classification::Pre => "pre",
        Classification::Post => "post",
    };
    let projection = match projection {
        ProjectionName::Perspective => "perspective",
        ProjectionName::Orthographic => "orthographic",
    };
    format!("{scene}/{look}/{classification}/{projection}")
}

/// Names of all cases of the fixed scenes.
pub(super) fn fixed_names() -> Vec<String> {
    let mut names = Vec::new();
    for scene in FIXED_SCENES {
        for look in [LookName::Opaque, LookName::Translucent] {
            for classification in [Classification::Post, Classification::Pre] {
                for projection in [ProjectionName::Perspective, ProjectionName::Orthographic] {
                    names.push(case_name(scene.name, look, classification, projection));
                }
            }
        }
    }
    names
}

/// Logical processors.
pub(super) fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, NonZero::get)
}

fn threads(args: &BenchArgs) -> Vec<usize> {
    let asked = match &args.threads[..] {
        [] if args.update_expected.is_some() => &[0],
        [] => &[1, 0][..],
        asked => asked,
    };
    let mut threads = Vec::new();
    for &count in asked {
        let count = if count == 0 { processors() } else { count };
        if !threads.contains(&count) {
            threads.push(count);
        }
    }
    threads
}
