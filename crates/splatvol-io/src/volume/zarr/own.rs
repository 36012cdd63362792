//! Attributes of our own, under the key `splatvol`: what OME-Zarr has no place for. Other programs pass over them.

use glam::{DAffine3, DMat3, DVec3};
use serde_json::{Map, Value, json};
use splatvol_scene::Rescale;

use crate::IoError;
use crate::error::Context;

/// Key of the attributes.
const KEY: &str = "splatvol";
/// Folder of the index of a level's bounds, below the image: behind it comes the number of the level.
pub(super) const BOUNDS: &str = "splatvol/bounds";
/// Folder of samples that stand for a level, likewise.
pub(super) const SPREAD: &str = "splatvol/spread";

/// Attributes of an image.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Own {
    /// Conversion of stored samples to real values.
    pub(super) rescale: Rescale,
    /// Map of the finest level, where it is not a scale and a translation.
    pub(super) world_from_voxel: Option<DAffine3>,
    /// True where the map leads to the patient's axes, or another named space.
    pub(super) oriented: bool,
}

/// Whether the attributes of an array say that all its chunks were written.
pub(super) fn is_complete(attributes: Option<&Value>) -> bool {
    let complete = attributes.and_then(|attributes| attributes.get(KEY)?.get("complete"));
    complete == Some(&Value::Bool(true))
}

/// The attributes of an array, all of whose chunks are written.
pub(super) fn complete() -> Value {
    json!({ KEY: { "complete": true } })
}

/// The attributes of an index of bounds of blocks with these edges, the slowest first.
pub(super) fn bounds_of(block: [usize; 3]) -> Value {
    json!({ KEY: { "complete": true, "block": block } })
}

/// The edges of the blocks that an index of bounds is about; earlier versions wrote those of chunks.
pub(super) fn block_of_bounds(attributes: Option<&Value>) -> Option<[usize; 3]> {
    let own = attributes?.get(KEY)?;
    let block = own.get("block").or_else(|| own.get("chunk"))?.as_array()?;
    let edge = |edge: &Value| usize::try_from(edge.as_u64()?).ok().filter(|edge| *edge > 0);
    let block: Option<Vec<usize>> = block.iter().map(edge).collect();
    block?.try_into().ok()
}

impl Own {
    /// From the attributes of a group.
    pub(super) fn new(attributes: Option<&Value>, context: &Context<'_>) -> Result<Self, IoError> {
        let Some(own) = attributes.and_then(|attributes| attributes.get(KEY)) else {
            return Ok(Self::default());
        };
        let number = |value: &Value| value.as_f64().filter(|number| number.is_finite());
        let bad = |field: &str, expected: &str| {
            let shown = own.get(field).map(Value::to_string).unwrap_or_default();
            context.field(format!("{KEY}.{field}"), shown, None, expected)
        };
        let rescale = match own.get("rescale") {
            None => Rescale::default(),
            Some(rescale) => {
                let part = |key: &str| rescale.get(key).and_then(number);
                let (Some(slope), Some(intercept)) = (part("slope"), part("intercept")) else {
                    return Err(bad("rescale", "a slope and an intercept"));
                };
                Rescale { slope, intercept }
            }
        };
        let world_from_voxel = match own.get("world-from-voxel") {
            None => None,
            Some(rows) => {
                let row = |row: &Value| row.as_array()?.iter().map(number).collect::<Option<Vec<f64>>>();
                let rows: Option<Vec<Vec<f64>>> =
                    rows.as_array().and_then(|rows| rows.iter().map(row).collect());
                let rows = rows.filter(|rows| rows.len() == 3 && rows.iter().all(|row| row.len() == 4));
                Some(affine(&rows.ok_or_else(|| {
                    bad("world-from-voxel", "3 rows of 4 finite numbers")
                })?))
            }
        };
        Ok(Self {
            rescale,
            world_from_voxel,
            oriented: own.get("oriented") == Some(&Value::Bool(true)),
        })
    }

    /// Adds itself to the attributes of a group.
    pub(super) fn add_to(&self, attributes: &mut Map<String, Value>) {
        let mut own = Map::new();
        if self.rescale != Rescale::default() {
            let Rescale { slope, intercept } = self.rescale;
            own.insert(
                "rescale".to_owned(),
                json!({ "slope": slope, "intercept": intercept }),
            );
        }
        if let Some(map) = self.world_from_voxel {
            let row = |i: usize| [0, 1, 2, 3].map(|column| map.to_cols_array()[3 * column + i]);
            own.insert("world-from-voxel".to_owned(), json!([row(0), row(1), row(2)]));
        }
        if self.oriented {
            own.insert("oriented".to_owned(), json!(true));
        }
        if !own.is_empty() {
            attributes.insert(KEY.to_owned(), own.into());
        }
    }
}

fn affine(rows: &[Vec<f64>]) -> DAffine3 {
    let column = |i: usize| DVec3::new(rows[0][i], rows[1][i], rows[2][i]);
    DAffine3::from_mat3_translation(DMat3::from_cols(column(0), column(1), column(2)), column(3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn attributes_come_back_and_wrong_ones_are_refused() {
        let context = &Context::new("OME-Zarr", Path::new("a"));
        let own = Own {
            rescale: Rescale {
                slope: 0.1,
                intercept: -1024.0,
            },
            world_from_voxel: Some(DAffine3::from_cols_array(&std::array::from_fn(|i| {
                i as f64 / 3.0
            }))),
            oriented: true,
        };
        let mut attributes = Map::new();
        own.add_to(&mut attributes);
        let text = Value::from(attributes).to_string();
        let read = |text: &str| Own::new(serde_json::from_str(text).ok().as_ref(), context);
        assert_eq!(read(&text).unwrap(), own);
        assert_eq!(read("{}").unwrap(), Own::default());
        for wrong in ["{\"rescale\": 3}", "{\"world-from-voxel\": [[1, 2, 3, 4]]}"] {
            let error = read(&format!("{{\"splatvol\": {wrong}}}"))
                .unwrap_err()
                .to_string();
            assert!(error.contains("field \"splatvol."), "{error}");
        }
        let mut none = Map::new();
        Own::default().add_to(&mut none);
        assert!(none.is_empty());
    }

    #[test]
    fn arrays_say_what_they_hold() {
        assert!(is_complete(Some(&complete())) && !is_complete(None));
        assert_eq!(block_of_bounds(Some(&bounds_of([1, 2, 3]))), Some([1, 2, 3]));
        assert_eq!(block_of_bounds(Some(&complete())), None);
    }
}
