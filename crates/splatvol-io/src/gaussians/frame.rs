//! Frames of Gaussian files, and how they become world space: right-handed, z up.
//!
//! A frame is named by the directions of its x, y and z axes, as in the header of the reference implementation of SPZ:
//! right or left, up or down, forward or back. World has x right, y forward and z up.

use glam::{DAffine3, DMat3, DVec3};

/// Directions of the axes: `"RDF"`.
pub(crate) type Frame = &'static str;

/// Frame of training programs (COLMAP's cameras): y down, z forward.
pub(crate) const RDF: Frame = "RDF";
/// SPZ, and glTF as far as up and the handedness go: y up, z back.
pub(crate) const RUB: Frame = "RUB";

/// The world frame.
const WORLD: [(char, DVec3); 6] = [
    ('R', DVec3::X),
    ('L', DVec3::NEG_X),
    ('F', DVec3::Y),
    ('B', DVec3::NEG_Y),
    ('U', DVec3::Z),
    ('D', DVec3::NEG_Z),
];

/// World from the numbers in a file of that frame.
pub(crate) fn world_from_local(frame: Frame) -> DAffine3 {
    let axis = |letter: char| {
        let found = WORLD.iter().find(|(name, _)| *name == letter);
        found.map_or(DVec3::ZERO, |(_, axis)| *axis)
    };
    let mut axes = frame.chars().map(axis);
    let mut next = || axes.next().unwrap_or(DVec3::ZERO);
    DAffine3::from_mat3(DMat3::from_cols(next(), next(), next()))
}

/// Description of the file's axes, for people.
pub(crate) fn describe(frame: Frame) -> String {
    let word = |letter| match letter {
        'R' => "right",
        'L' => "left",
        'F' => "forward",
        'B' => "back",
        'U' => "up",
        _ => "down",
    };
    let axes: Vec<_> = ["x", "y", "z"]
        .iter()
        .zip(frame.chars().map(word))
        .map(|(axis, word)| format!("{axis} {word}"))
        .collect();
    format!("{frame}: {}; turned to z up", axes.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_is_z_whatever_the_file_calls_it() {
        let rdf = world_from_local(RDF);
        let rub = world_from_local(RUB);
        assert_eq!(
            rdf.transform_point3(DVec3::new(1.0, 2.0, 3.0)),
            DVec3::new(1.0, 3.0, -2.0)
        );
        assert_eq!(
            rub.transform_point3(DVec3::new(1.0, -2.0, -3.0)),
            DVec3::new(1.0, 3.0, -2.0)
        );
        assert_eq!(rdf.matrix3.determinant(), 1.0);
        assert_eq!(rub.matrix3.determinant(), 1.0);
        assert_eq!(world_from_local("RFU"), DAffine3::IDENTITY);
        assert_eq!(world_from_local("LUB").matrix3.determinant(), -1.0);
        assert_eq!(describe(RDF), "RDF: x right, y down, z forward; turned to z up");
    }
}
