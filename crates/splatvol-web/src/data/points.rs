//! Points as bytes.

use glam::{DAffine3, DMat3, DVec3};
use serde::{Deserialize, Serialize};
use splatvol::{PointAttributes, Points, SceneError};

use super::column::{Column, Packer, Precision};

/// The columns of points. Attributes that are unknown have none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct PointsData {
    /// Number of points.
    pub count: usize,
    /// World from local: images of the three axes, and of the origin.
    pub world_from_local: [[f64; 3]; 4],
    positions: [Column; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    colors: Option<[Column; 4]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    normals: Option<[Column; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    radii: Option<Column>,
}

impl PointsData {
    /// Packs points; returns their bytes, too.
    pub fn pack(points: &Points, precision: Precision) -> (Self, Vec<u8>) {
        let PointAttributes {
            colors,
            normals,
            radii,
        } = points.attributes();
        let mut packer = Packer::default();
        let data = Self {
            count: points.len(),
            world_from_local: columns(points.world_from_local()),
            positions: packer.vectors(points.positions(), |packer, values| {
                packer.even(values, precision.places)
            }),
            colors: (!colors.is_empty()).then(|| {
                let channel = |i: usize| colors.iter().map(move |color| u32::from(color[i]));
                std::array::from_fn(|i| packer.whole(channel(i)))
            }),
            normals: (!normals.is_empty())
                .then(|| packer.vectors(normals, |packer, values| packer.symmetric(values, precision.rest))),
            radii: (!radii.is_empty()).then(|| packer.logarithmic(radii.iter().copied(), precision.rest)),
        };
        (data, packer.bytes)
    }

    /// Takes points from the front of bytes.
    ///
    /// # Errors
    /// Too few bytes, and numbers that are no points.
    pub fn unpack(&self, bytes: &mut &[u8]) -> Result<Points, SceneError> {
        let count = counted(self.count, bytes)?;
        let positions = Column::vectors(&self.positions, count, bytes)?;
        let mut attributes = PointAttributes::default();
        if let Some(columns) = &self.colors {
            attributes.colors = vec![[0; 4]; count];
            for (channel, column) in columns.iter().enumerate() {
                let values = column.whole(count, bytes)?;
                for (color, value) in attributes.colors.iter_mut().zip(values) {
                    color[channel] =
                        u8::try_from(value).map_err(|_| SceneError::invalid("color", value, "0 to 255"))?;
                }
            }
        }
        if let Some(columns) = &self.normals {
            attributes.normals = Column::vectors(columns, count, bytes)?;
        }
        if let Some(column) = &self.radii {
            attributes.radii = column.numbers(count, bytes)?;
        }
        Points::new(positions, attributes, affine(self.world_from_local))
    }
}

/// The columns of a map.
pub(super) fn columns(map: &DAffine3) -> [[f64; 3]; 4] {
    let DMat3 {
        x_axis,
        y_axis,
        z_axis,
    } = map.matrix3;
    [x_axis, y_axis, z_axis, map.translation].map(|column| column.to_array())
}

/// The map of columns.
pub(super) fn affine(columns: [[f64; 3]; 4]) -> DAffine3 {
    let [x, y, z, translation] = columns.map(DVec3::from_array);
    DAffine3 {
        matrix3: DMat3::from_cols(x, y, z),
        translation,
    }
}

/// Elements that so many bytes may hold: whatever is the same everywhere takes none, so that a header could ask for any number of
/// elements.
pub(super) fn counted(count: usize, bytes: &[u8]) -> Result<usize, SceneError> {
    match count {
        0 => Err(SceneError::invalid("count", count, "at least one")),
        1..=SMALL => Ok(count),
        _ if count <= bytes.len() => Ok(count),
        _ => Err(SceneError::invalid("count", count, "no more than the bytes hold")),
    }
}

/// Elements that may be alike in everything.
const SMALL: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;

    const FINE: Precision = Precision { places: 24, rest: 16 };

    fn cloud(count: usize) -> Points {
        let wave = |i: usize, rate: f32| (i as f32 * rate).sin();
        let positions = (0..count)
            .map(|i| [wave(i, 0.3), 4.0 * wave(i, 0.7), 7.0])
            .collect();
        let attributes = PointAttributes {
            colors: (0..count).map(|i| [i as u8, 200, (i * 7) as u8, 255]).collect(),
            normals: (0..count)
                .map(|i| {
                    if i == 3 {
                        [0.0; 3]
                    } else {
                        [wave(i, 1.1), 0.3, 0.0]
                    }
                })
                .collect(),
            radii: (0..count).map(|i| 0.01 + i as f32 * 0.001).collect(),
        };
        let frame = DAffine3::from_translation(DVec3::new(6e6, 0.1, -3.0));
        Points::new(positions, attributes, frame).unwrap()
    }

    fn apart(a: &[[f32; 3]], b: &[[f32; 3]]) -> f32 {
        let each = a.iter().flatten().zip(b.iter().flatten());
        each.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    }

    #[test]
    fn points_come_back_as_near_as_their_bits_allow() {
        let points = cloud(300);
        let (data, bytes) = PointsData::pack(&points, FINE);
        let text = serde_json::to_string(&data).unwrap();
        let data: PointsData = serde_json::from_str(&text).unwrap();
        let mut rest = &bytes[..];
        let again = data.unpack(&mut rest).unwrap();
        assert!(rest.is_empty());
        assert_eq!(again.world_from_local(), points.world_from_local());
        assert_eq!(again.attributes().colors, points.attributes().colors);
        assert!(apart(again.positions(), points.positions()) < 1e-6);
        assert!(apart(&again.attributes().normals, &points.attributes().normals) < 5e-5);
        assert_eq!(again.attributes().normals[3], [0.0; 3]);
        let radii = again.attributes().radii.iter().zip(&points.attributes().radii);
        assert!(radii.clone().all(|(a, b)| (a / b - 1.0).abs() < 1e-4));
    }

    #[test]
    fn what_is_no_cloud_of_points_is_refused() {
        let (data, bytes) = PointsData::pack(&cloud(100), FINE);
        for short in 0..bytes.len() {
            assert!(data.unpack(&mut &bytes[..short]).is_err());
        }
        for count in [0, 101, usize::MAX] {
            let other = PointsData {
                count,
                ..data.clone()
            };
            assert!(other.unpack(&mut &bytes[..]).is_err(), "{count}");
        }
        let flat = PointsData {
            world_from_local: [[0.0; 3]; 4],
            ..data
        };
        assert!(flat.unpack(&mut &bytes[..]).is_err());
    }
}
