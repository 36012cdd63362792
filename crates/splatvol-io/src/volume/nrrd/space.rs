//! The space around an array: its name, directions, origin and unit, and the way from there to RAS+.
//!
//! | `space` | world |
//! |---|---|
//! | `right-anterior-superior` | as it is |
//! | `left-anterior-superior` | x negated |
//! | `left-posterior-superior` | x and y negated |
//! | `scanner-xyz`, `3D-right-handed`, `space dimension`, none | as it is; not known to be RAS+ |
//! | `3D-left-handed` | z negated, since world space is right-handed and the object would be mirrored otherwise |

use glam::{DAffine3, DMat3, DVec3};
use splatvol_scene::LengthUnit;

use super::axes::Axes;
use crate::IoError;
use crate::error::Context;
use crate::volume::fields::{Field, Fields};
use crate::volume::{complete_axes, length_unit};

/// A space and its map to world.
#[derive(Debug)]
pub(super) struct Space {
    /// Name of the space in the file; empty if it has none.
    name: String,
    /// Numbers per vector.
    dimension: usize,
    /// Signs of x y z that lead to world.
    world_from_space: DVec3,
    /// True where the last number of a vector is time.
    time: bool,
}

/// An entry of `space directions`, for one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Direction {
    None,
    Space(DVec3),
    Time,
}

/// Geometry of a volume.
pub(super) struct Placement {
    pub(super) world_from_voxel: DAffine3,
    pub(super) unit: LengthUnit,
    pub(super) orientation: String,
    /// Whether the space is a patient's.
    pub(super) oriented: bool,
    pub(super) warnings: Vec<String>,
}

impl Space {
    pub(super) fn new(fields: &Fields, context: &Context<'_>) -> Result<Self, IoError> {
        match (fields.get("space"), fields.get("spacedimension")) {
            (Some(field), None) => named(field, context),
            (None, Some(field)) => {
                let expected = "a space of 1 to 4 dimensions";
                let dimension: usize = field.number(expected, context)?;
                if !(1..=4).contains(&dimension) {
                    return Err(field.error(expected, context));
                }
                Ok(Self::unnamed(dimension))
            }
            (Some(field), Some(_)) => {
                Err(field.error("either \"space\" or \"space dimension\", not both", context))
            }
            (None, None) => Ok(Self::unnamed(3)),
        }
    }

    fn unnamed(dimension: usize) -> Self {
        Self {
            name: String::new(),
            dimension,
            world_from_space: DVec3::ONE,
            time: dimension == 4,
        }
    }

    /// One entry per axis: `none` or a vector in parentheses.
    pub(super) fn directions(
        &self,
        field: &Field,
        count: usize,
        context: &Context<'_>,
    ) -> Result<Vec<Direction>, IoError> {
        let expected = format!(
            "{count} entries, each \"none\" or a vector of {} finite numbers",
            self.dimension
        );
        let bad = || field.error(&*expected, context);
        let mut directions = Vec::new();
        let mut rest = field.value.trim();
        while !rest.is_empty() {
            if directions.len() == count {
                return Err(bad());
            }
            let (direction, length) = match rest.strip_prefix("none") {
                Some(_) => (Direction::None, "none".len()),
                None => {
                    let end = rest.find(')').ok_or_else(bad)? + 1;
                    let (space, time) = self.vector(&rest[..end]).ok_or_else(bad)?;
                    let is_time = self.time && time != 0.0 && space == DVec3::ZERO;
                    (
                        if is_time {
                            Direction::Time
                        } else {
                            Direction::Space(space)
                        },
                        end,
                    )
                }
            };
            directions.push(direction);
            rest = rest[length..].trim_start();
        }
        if directions.len() == count {
            Ok(directions)
        } else {
            Err(bad())
        }
    }

    /// `(a,b,c)` as spatial part and time.
    fn vector(&self, text: &str) -> Option<(DVec3, f64)> {
        let inner = text.strip_prefix('(')?.strip_suffix(')')?;
        let numbers: Vec<f64> = inner
            .split(',')
            .map(|number| number.trim().parse().ok())
            .collect::<Option<_>>()?;
        if numbers.len() != self.dimension || !numbers.iter().all(|number| number.is_finite()) {
            return None;
        }
        let at = |i: usize| numbers.get(i).copied().unwrap_or(0.0);
        Some((DVec3::new(at(0), at(1), at(2)), at(3)))
    }

    fn origin(&self, fields: &Fields, context: &Context<'_>) -> Result<DVec3, IoError> {
        let Some(field) = fields.get("spaceorigin") else {
            return Ok(DVec3::ZERO);
        };
        let expected = || format!("a vector of {} finite numbers", self.dimension);
        match self.vector(&field.value) {
            Some((origin, _)) => Ok(origin),
            None => Err(field.error(expected(), context)),
        }
    }

    /// Placement of the selected axes in world space.
    pub(super) fn place(
        &self,
        fields: &Fields,
        axes: &Axes,
        context: &Context<'_>,
    ) -> Result<Placement, IoError> {
        let mut warnings = Vec::new();
        let oriented = fields.get("spacedirections").is_some();
        if oriented && fields.get("spacings").is_some() {
            warnings.push("\"spacings\" are not used beside \"space directions\"".to_owned());
        }
        if !oriented && !self.name.is_empty() {
            warnings.push(format!(
                "space \"{}\" without \"space directions\": axes are taken to lie along the space's",
                self.name
            ));
        }
        if axes.steps.iter().any(Option::is_none) {
            warnings.push("no spacing: 1 is used".to_owned());
        }
        let matrix = complete_axes(&axes.steps);
        let origin = self.origin(fields, context)?;
        let to_world = DAffine3::from_mat3(DMat3::from_diagonal(self.world_from_space));
        let (unit, warning) = unit(fields, axes);
        warnings.extend(warning);
        Ok(Placement {
            world_from_voxel: to_world * DAffine3::from_mat3_translation(matrix, origin),
            unit,
            orientation: self.orientation(oriented),
            oriented: self.is_patient(),
            warnings,
        })
    }

    fn is_patient(&self) -> bool {
        self.name.contains("superior")
    }

    fn orientation(&self, oriented: bool) -> String {
        let aligned = if oriented {
            "space directions"
        } else {
            "no space directions, axes along the space's"
        };
        let negated: Vec<&str> = ["x", "y", "z"]
            .into_iter()
            .zip(self.world_from_space.to_array())
            .filter_map(|(axis, sign)| (sign < 0.0).then_some(axis))
            .collect();
        let result = match (negated.is_empty(), self.is_patient()) {
            (true, true) => "RAS+ as stored".to_owned(),
            (true, false) => "world as stored, not known to be RAS+".to_owned(),
            (false, true) => format!("{} negated to make RAS+", negated.join(" and ")),
            (false, false) => format!("{} negated to make world right-handed", negated.join(" and ")),
        };
        let name = if self.name.is_empty() {
            "no named space"
        } else {
            &self.name
        };
        format!("{name} ({aligned}); {result}")
    }
}

fn named(field: &Field, context: &Context<'_>) -> Result<Space, IoError> {
    let lower = field.value.to_ascii_lowercase();
    let (base, time) = match lower.strip_suffix("-time") {
        Some(base) => (base, true),
        None => match lower.as_str() {
            "rast" | "last" | "lpst" => (&lower[..3], true),
            other => (other, false),
        },
    };
    let (name, signs) = match base {
        "right-anterior-superior" | "ras" => ("right-anterior-superior", [1.0, 1.0, 1.0]),
        "left-anterior-superior" | "las" => ("left-anterior-superior", [-1.0, 1.0, 1.0]),
        "left-posterior-superior" | "lps" => ("left-posterior-superior", [-1.0, -1.0, 1.0]),
        "scanner-xyz" => ("scanner-xyz", [1.0, 1.0, 1.0]),
        "3d-right-handed" => ("3D-right-handed", [1.0, 1.0, 1.0]),
        "3d-left-handed" => ("3D-left-handed", [1.0, 1.0, -1.0]),
        _ => {
            return Err(field.error(
                "a space such as left-posterior-superior or 3D-right-handed",
                context,
            ));
        }
    };
    Ok(Space {
        name: name.to_owned(),
        dimension: 3 + usize::from(time),
        world_from_space: DVec3::from_array(signs),
        time,
    })
}

/// The unit of lengths, where all spatial axes have the same.
fn unit(fields: &Fields, axes: &Axes) -> (LengthUnit, Option<String>) {
    let names: Vec<&str> = match (fields.get("spaceunits"), fields.get("units")) {
        (Some(field), _) => quoted(&field.value),
        (None, Some(field)) => {
            let all = quoted(&field.value);
            axes.spatial
                .iter()
                .filter_map(|&axis| all.get(axis).copied())
                .collect()
        }
        (None, None) => return (LengthUnit::Unknown, None),
    };
    let Some(&first) = names.first() else {
        return (LengthUnit::Unknown, None);
    };
    let unit = length_unit(first);
    if unit == Some(LengthUnit::Unknown) {
        return (LengthUnit::Unknown, None);
    }
    let same = names.iter().take(axes.spatial.len()).all(|&name| name == first);
    match unit {
        Some(unit) if same => (unit, None),
        _ => {
            let names = crate::error::excerpt(&names.join(", "));
            (
                LengthUnit::Unknown,
                Some(format!("length units are not kept: {names}")),
            )
        }
    }
}

/// `"mm" "mm"`, or words without quotes.
fn quoted(value: &str) -> Vec<&str> {
    if value.contains('"') {
        value.split('"').skip(1).step_by(2).collect()
    } else {
        value.split_whitespace().collect()
    }
}
