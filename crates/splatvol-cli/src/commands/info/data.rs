//! Descriptions of points, Gaussians, meshes and scenes.

use std::fmt::Write;
use std::path::Path;

use serde::Serialize;
use splatvol::{Bounds, Gaussians, Mesh, Points, Topology};
use splatvol_document::format::{is_scene, read_scene};
use splatvol_document::keys::ItemKeys;
use splatvol_document::upright::Up;
use splatvol_document::{ReadRules, Reading, Silent, items, meaning};
use splatvol_io::{Data, DataKind, LoadedData, read_data};

use super::tidy;
use crate::args::{InfoArgs, of_input};
use crate::failure::{During, Failure, Step};
use crate::terminal::Terminal;

/// All that is known about data other than a volume.
#[derive(Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
struct Report {
    kind: &'static str,
    input: String,
    format: String,
    stored_type: String,
    orientation: String,
    /// Of points.
    #[serde(skip_serializing_if = "Option::is_none")]
    up: Option<Up>,
    files: Vec<std::path::PathBuf>,
    count: usize,
    min: [f64; 3],
    max: [f64; 3],
    #[serde(flatten)]
    details: Details,
    arrays: Vec<String>,
    warnings: Vec<String>,
}

/// Properties of some kinds.
#[derive(Debug, Serialize)]
#[serde(rename_all = "kebab-case", rename_all_fields = "kebab-case", untagged)]
enum Details {
    Points {
        has_colors: bool,
        has_normals: bool,
        /// Smallest and largest, world lengths of the file.
        radii: Option<[f32; 2]>,
        /// Where the scanner stood.
        viewpoint: Option<[f64; 3]>,
    },
    Gaussians {
        degree: u32,
        antialiased: bool,
        tags: Vec<String>,
    },
    Mesh {
        cells: usize,
        /// Points along i, j, k of every block of a structured mesh.
        blocks: Vec<[usize; 3]>,
        array: String,
        association: &'static str,
        range: [f32; 2],
    },
}

/// Description of a scene.
#[derive(Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
struct SceneReport {
    kind: &'static str,
    input: String,
    items: Vec<ItemReport>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
struct ItemReport {
    kind: &'static str,
    #[serde(flatten)]
    item: ItemKeys,
}

/// Files are read from the paths given.
const AS_TYPED: Reading<'static> = Reading {
    rules: ReadRules {
        strict: false,
        allow_outside: false,
        max_bytes: None,
        chunks: None,
    },
    folder: None,
    listener: &Silent,
};

/// Text or JSON about the input; `None` if it is a volume.
pub(super) fn text(name: &str, args: &InfoArgs, terminal: &Terminal) -> Result<Option<String>, Failure> {
    let path = Path::new(name);
    if is_scene(path) {
        return scene(path, args.json).map(Some);
    }
    let mut item = of_input(&args.read, name);
    item.kind = args.kind.map(|kind| kind.name().to_owned());
    // If the file cannot be read, the reader of volumes reports the error in its own words.
    let Ok((kind, path)) = items::kind(&item, AS_TYPED) else {
        return Ok(None);
    };
    meaning::check(&item, kind)?;
    if kind == DataKind::Volume {
        return Ok(None);
    }
    let loaded = {
        let _spinner = terminal.spinner(format!("Reading {name}"));
        read_data(&path, &items::options(&item, args.read.rules())?).during(Step::Input)?
    };
    let report = Report::new(name, loaded);
    Ok(Some(if args.json { json(&report)? } else { report.text() }))
}

fn json(report: &impl Serialize) -> Result<String, Failure> {
    Ok(serde_json::to_string_pretty(report).during(Step::Output)? + "\n")
}

fn scene(path: &Path, as_json: bool) -> Result<String, Failure> {
    let scene = read_scene(path)?;
    let items = scene.items.into_iter().map(|item| {
        let (kind, _) = items::kind(&item, AS_TYPED)?;
        Ok(ItemReport {
            kind: kind.name(),
            item,
        })
    });
    let report = SceneReport {
        kind: "scene",
        input: path.display().to_string(),
        items: items.collect::<Result<_, Failure>>()?,
    };
    if as_json {
        return json(&report);
    }
    let mut rows = Rows::default();
    rows.add("input", &report.input);
    rows.add("items", report.items.len());
    for ItemReport { kind, item } in &report.items {
        let hidden = if item.visible == Some(false) {
            ", not visible"
        } else {
            ""
        };
        rows.add("item", format!("{} ({kind}{hidden})", item.file));
    }
    Ok(rows.0)
}

/// Labelled lines.
#[derive(Default)]
struct Rows(String);

impl Rows {
    fn add(&mut self, label: &str, value: impl std::fmt::Display) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{label:<18} {value}");
    }
}

impl Report {
    fn new(name: &str, loaded: LoadedData) -> Self {
        let viewpoint = loaded.viewpoint.map(|place| place.to_array());
        let up = match &loaded.data {
            Data::Points(points) if loaded.kind == DataKind::Points => {
                Some(Up::of_points(points, &loaded.description))
            }
            _ => None,
        };
        let (count, bounds, details) = match &loaded.data {
            Data::Points(points) => (points.len(), points.bounds(), of_points(points, viewpoint)),
            Data::Gaussians(gaussians) => (
                gaussians.len(),
                gaussians.bounds(),
                of_gaussians(gaussians, loaded.tags),
            ),
            Data::Mesh(mesh) => (mesh.positions().len(), mesh.bounds(), of_mesh(mesh)),
            // Volumes have their own report.
            Data::Volume(volume) => {
                let dims = volume.grid().dims();
                let [low, high] = volume.value_range().map(|value| value as f32);
                let details = Details::Mesh {
                    cells: volume.samples().len(),
                    blocks: vec![dims],
                    array: String::new(),
                    association: "point",
                    range: [low, high],
                };
                (volume.samples().len(), volume.grid().bounds(), details)
            }
        };
        let Bounds { min, max } = bounds;
        Self {
            kind: loaded.kind.name(),
            input: name.to_owned(),
            format: loaded.description.format,
            stored_type: loaded.description.stored_type,
            orientation: loaded.description.orientation,
            up,
            files: loaded.description.files,
            count,
            min: min.to_array(),
            max: max.to_array(),
            details,
            arrays: loaded.arrays,
            warnings: loaded.description.warnings,
        }
    }

    fn text(&self) -> String {
        let list = |values: &[f64]| values.iter().map(|v| tidy(*v)).collect::<Vec<_>>().join(", ");
        let yes = |value: bool| if value { "yes" } else { "none" };
        let mut rows = Rows::default();
        rows.add("input", &self.input);
        rows.add("kind", self.kind);
        rows.add("format", &self.format);
        rows.add("stored type", &self.stored_type);
        rows.add("orientation", &self.orientation);
        if let Some(up) = &self.up {
            rows.add("up", format!("{} ({})", up.axis.name(), up.reason));
        }
        rows.add(
            match self.details {
                Details::Gaussians { .. } => "Gaussians",
                _ => "points",
            },
            self.count,
        );
        rows.add(
            "bounds",
            format!("({}) to ({})", list(&self.min), list(&self.max)),
        );
        match &self.details {
            Details::Points {
                has_colors,
                has_normals,
                radii,
                viewpoint,
            } => {
                rows.add("colours", yes(*has_colors));
                rows.add("normals", yes(*has_normals));
                let radii = radii.map(|[low, high]| format!("{} to {}", tidy(low.into()), tidy(high.into())));
                rows.add("radii", radii.as_deref().unwrap_or("none"));
                if let Some(viewpoint) = viewpoint {
                    rows.add("viewpoint", list(viewpoint));
                }
            }
            Details::Gaussians {
                degree,
                antialiased,
                tags,
            } => {
                rows.add("degree", degree);
                rows.add("antialiased", if *antialiased { "yes" } else { "no" });
                if !tags.is_empty() {
                    rows.add("tags", tags.join(", "));
                }
            }
            Details::Mesh {
                cells,
                blocks,
                array,
                association,
                range: [low, high],
            } => {
                rows.add("cells", cells);
                for dims in blocks {
                    rows.add("block", dims.map(|n| n.to_string()).join(" x "));
                }
                rows.add("array", format!("{array} (of {association}s)"));
                rows.add(
                    "range",
                    format!("{} to {}", tidy((*low).into()), tidy((*high).into())),
                );
            }
        }
        for array in &self.arrays {
            rows.add("has array", array);
        }
        for warning in &self.warnings {
            rows.add("warning", warning);
        }
        rows.0
    }
}

fn of_points(points: &Points, viewpoint: Option<[f64; 3]>) -> Details {
    let attributes = points.attributes();
    let range = attributes
        .radii
        .iter()
        .fold(None, |range: Option<[f32; 2]>, &radius| match range {
            None => Some([radius; 2]),
            Some([low, high]) => Some([radius.min(low), radius.max(high)]),
        });
    Details::Points {
        has_colors: !attributes.colors.is_empty(),
        has_normals: !attributes.normals.is_empty(),
        radii: range,
        viewpoint,
    }
}

fn of_gaussians(gaussians: &Gaussians, tags: Vec<String>) -> Details {
    Details::Gaussians {
        degree: gaussians.degree(),
        antialiased: gaussians.antialiased(),
        tags,
    }
}

fn of_mesh(mesh: &Mesh) -> Details {
    let field = mesh.field();
    Details::Mesh {
        cells: mesh.cell_count(),
        blocks: match mesh.topology() {
            Topology::Structured(blocks) => blocks.clone(),
            Topology::Unstructured(_) => Vec::new(),
        },
        array: field.name.clone(),
        association: match field.association {
            splatvol::Association::Point => "point",
            splatvol::Association::Cell => "cell",
        },
        range: mesh.value_range(),
    }
}
