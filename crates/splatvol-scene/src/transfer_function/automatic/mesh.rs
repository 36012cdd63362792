//! Automatic looks of meshes.
//!
//! A mesh is what it covers: beyond its border there is nothing. Where it is a shell or a plate
//! ([`Mesh::shell_thickness`]), nothing lies behind its surface that an opaque one would hide. So the whole body is
//! shown, as opaque through its thickness as a solid, whatever its values. Otherwise a can would be wisps where its
//! values are high. Solids show their insides by the values alone, as volumes do.

use super::shapes::PALETTE;
use super::survey::quantile;
use super::{AutomaticChoice, ValueKind, short};
use crate::{
    ColorMap, ColorPoint, Grid, LengthUnit, Mesh, OpacityPoint, Rescale, Samples, SceneError,
    TransferFunction, Volume,
};

/// Values in a row of the grid that a mesh is surveyed on.
const ROW: usize = 32_768;
/// Opacity through a shell at a right angle.
const SHELL_OPACITY: f64 = 0.95;
/// Share of values at either end that the colours do not tell apart.
const TAIL: f64 = 0.01;

impl TransferFunction {
    /// [`TransferFunction::automatic`] for the values of a mesh. Shells and plates show all of their body, with
    /// opacities that refer to their thickness.
    ///
    /// # Errors
    /// More values than a [`Grid`] can have rows for: some two thousand million.
    pub fn automatic_mesh(mesh: &Mesh, map: Option<ColorMap>) -> Result<(Self, AutomaticChoice), SceneError> {
        let (chosen, choice) = Self::automatic(&rows_of(&mesh.field().values)?, map);
        match mesh.shell_thickness() {
            Some(thickness) => body(mesh, thickness, map, (chosen, choice)),
            None => Ok((chosen, choice)),
        }
    }
}

/// A whole body. Labels and signed values keep the colours that were chosen for them.
fn body(
    mesh: &Mesh,
    thickness: f64,
    map: Option<ColorMap>,
    (chosen, choice): (TransferFunction, AutomaticChoice),
) -> Result<(TransferFunction, AutomaticChoice), SceneError> {
    let [low, high] = mesh.value_range().map(f64::from);
    let range = bulk(mesh);
    let (colors, shown) = match (choice.kind, map) {
        (ValueKind::Labels | ValueKind::Signed | ValueKind::Constant, _) => {
            (chosen.colors().to_vec(), choice.range)
        }
        (_, Some(map)) => (map.points(range, ColorMap::DEFAULT_POINTS), range),
        (_, None) => (ramp(range), range),
    };
    let mut opacities = vec![OpacityPoint::new(low, SHELL_OPACITY)];
    if high > low {
        opacities.push(OpacityPoint::new(high, SHELL_OPACITY));
    }
    let choice = AutomaticChoice {
        reason: format!(
            "a shell or plate {} thick: all of its body, coloured by value",
            short(thickness)
        ),
        range: shown,
        ..choice
    };
    Ok((TransferFunction::new(colors, opacities, Some(thickness))?, choice))
}

/// The palette over a range.
fn ramp([low, high]: [f64; 2]) -> Vec<ColorPoint> {
    let last = (PALETTE.len() - 1) as f64;
    let at = |i: usize| low + (high - low) * i as f64 / last;
    let points = PALETTE.into_iter().enumerate();
    points.map(|(i, rgb)| ColorPoint::new(at(i), rgb)).collect()
}

/// Range of the values without the tails.
fn bulk(mesh: &Mesh) -> [f64; 2] {
    let mut sorted: Vec<f64> = mesh
        .field()
        .values
        .iter()
        .filter(|value| value.is_finite())
        .map(|&value| f64::from(value))
        .collect();
    sorted.sort_unstable_by(f64::total_cmp);
    match [quantile(&sorted, TAIL), quantile(&sorted, 1.0 - TAIL)] {
        [low, high] if low < high => [low, high],
        _ => mesh.value_range().map(f64::from),
    }
}

/// Values as the rows of a flat volume; what is missing in the last row does not count.
fn rows_of(values: &[f32]) -> Result<Volume, SceneError> {
    let width = values.len().clamp(1, ROW);
    let rows = values.len().div_ceil(width);
    let mut samples = values.to_vec();
    samples.resize(rows * width, f32::NAN);
    Volume::new(
        Grid::centred([width, rows, 1], [1.0; 3])?,
        Samples::F32(samples.into()),
        Rescale::default(),
        LengthUnit::Unknown,
    )
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::{Association, MeshField, Topology};

    /// A block of 20 x 20 x 3 points; most of the values are zero, as those of a plate that yields at a notch.
    fn plate(thickness: f32, value: impl Fn(usize) -> f32) -> Mesh {
        let places = (0..1200).map(|i| [i % 20, i / 20 % 20, i / 400].map(|at| at as f32));
        let field = MeshField {
            name: "strain".to_owned(),
            association: Association::Point,
            values: (0..1200).map(value).collect(),
        };
        Mesh::new(
            places.map(|[x, y, z]| [x, y, 0.5 * thickness * z]).collect(),
            Topology::Structured(vec![[20, 20, 3]]),
            Vec::new(),
            field,
            DAffine3::IDENTITY,
        )
        .unwrap()
    }

    fn yielding(i: usize) -> f32 {
        if i % 20 > 15 {
            0.013 * (i % 397) as f32
        } else {
            0.0
        }
    }

    #[test]
    fn a_shell_shows_its_body_whatever_its_values() {
        let (look, choice) = TransferFunction::automatic_mesh(&plate(0.2, yielding), None).unwrap();
        assert!(choice.reason.starts_with("a shell or plate"), "{}", choice.reason);
        assert_eq!([look.opacity(0.0), look.opacity(5.0)], [SHELL_OPACITY; 2]);
        assert!(
            look.unit_distance
                .is_some_and(|unit| (0.15..0.21).contains(&unit))
        );
        assert_ne!(look.color(0.0), look.color(5.0));
        let map = ColorMap::from_name("viridis").unwrap();
        let (mapped, _) = TransferFunction::automatic_mesh(&plate(0.2, yielding), Some(map)).unwrap();
        assert_eq!(mapped.color(0.0), map.rgb(0.0));
    }

    #[test]
    fn a_solid_shows_what_its_values_say() {
        let solid = plate(19.0, |i| 0.37 * i as f32);
        let (look, choice) = TransferFunction::automatic_mesh(&solid, None).unwrap();
        let (rows, _) = TransferFunction::automatic(&rows_of(&solid.field().values).unwrap(), None);
        assert_eq!(look, rows, "{}", choice.reason);
        assert_eq!(look.opacity(0.0), 0.0);
    }

    #[test]
    fn one_value_is_a_body_too() {
        let (look, _) = TransferFunction::automatic_mesh(&plate(0.2, |_| 3.0), None).unwrap();
        assert_eq!(look.opacity(3.0), SHELL_OPACITY);
    }
}
