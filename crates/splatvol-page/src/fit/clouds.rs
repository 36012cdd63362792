//! Clouds: fewer points, and harmonics of lower degree.

use std::sync::Arc;

use splatvol::gaussians::harmonics_count;
use splatvol::{GaussianAttributes, Gaussians, PointAttributes, Points, SceneError};
use splatvol_document::HeldContent;

/// A quarter of the points of a surface, of twice the radii: those of half the resolution along each of its axes.
///
/// Which points stay depends on nothing but their numbers, and looks random: every fourth would follow the scanner's lines.
pub(super) fn quarter(points: &Points) -> Result<Arc<Points>, SceneError> {
    // The first one does: zero is mixed to zero.
    let stays = |index: &usize| mixed(*index as u64).is_multiple_of(4);
    let kept: Vec<usize> = (0..points.len()).filter(stays).collect();
    let attributes = points.attributes();
    let attributes = PointAttributes {
        colors: picked(&attributes.colors, &kept),
        normals: picked(&attributes.normals, &kept),
        radii: picked(&attributes.radii, &kept)
            .into_iter()
            .map(|radius| 2.0 * radius)
            .collect(),
    };
    let positions = picked(points.positions(), &kept);
    Points::new(positions, attributes, *points.world_from_local()).map(Arc::new)
}

/// Elements of a list, in order; none of an empty one.
fn picked<T: Copy>(list: &[T], kept: &[usize]) -> Vec<T> {
    kept.iter()
        .filter_map(|&index| list.get(index).copied())
        .collect()
}

/// Mixes the bits of a number (the finalizer of splitmix64: Steele, Lea and Flood 2014).
fn mixed(number: u64) -> u64 {
    let number = (number ^ (number >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let number = (number ^ (number >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    number ^ (number >> 31)
}

/// Gaussians whose harmonics have one degree less; `None` where colours depend on no direction.
pub(super) fn of_lower_degree(gaussians: &Gaussians) -> Result<Option<Arc<Gaussians>>, SceneError> {
    let Some(degree) = gaussians.degree().checked_sub(1) else {
        return Ok(None);
    };
    let attributes = gaussians.attributes();
    let of_each = attributes
        .harmonics
        .chunks_exact(harmonics_count(gaussians.degree()));
    let harmonics = of_each
        .flat_map(|own| &own[..harmonics_count(degree)])
        .copied()
        .collect();
    let attributes = GaussianAttributes {
        harmonics,
        ..attributes.clone()
    };
    let lower = Gaussians::new(attributes, degree, *gaussians.world_from_local())?;
    Ok(Some(Arc::new(lower.with_antialiasing(gaussians.antialiased()))))
}

/// Whether clouds are the same.
pub(super) fn are_equal(a: &HeldContent, b: &HeldContent) -> bool {
    match (a, b) {
        (HeldContent::Points(a), HeldContent::Points(b)) => a == b,
        (HeldContent::Gaussians(a), HeldContent::Gaussians(b)) => a == b,
        (HeldContent::Mesh(a), HeldContent::Mesh(b)) => a == b,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;

    #[test]
    fn a_quarter_of_the_points_stays_and_radii_double() {
        let positions: Vec<[f32; 3]> = (0..4000).map(|i| [i as f32, 0.0, 1.0]).collect();
        let attributes = PointAttributes {
            radii: (0..4000).map(|i| 1.0 + i as f32).collect(),
            ..PointAttributes::default()
        };
        let points = Points::new(positions, attributes, DAffine3::IDENTITY).unwrap();
        let fewer = quarter(&points).unwrap();
        assert!((900..1100).contains(&fewer.len()), "{}", fewer.len());
        assert!(fewer.attributes().colors.is_empty());
        let pairs = fewer.positions().iter().zip(&fewer.attributes().radii);
        assert!(
            pairs
                .clone()
                .all(|(place, radius)| *radius == 2.0 * (1.0 + place[0]))
        );
        // Every part of the cloud loses as much.
        let first = pairs.filter(|(place, _)| place[0] < 1000.0).count();
        assert!((200..300).contains(&first), "{first}");
        let one = Points::new(vec![[1.0; 3]], PointAttributes::default(), DAffine3::IDENTITY).unwrap();
        assert_eq!(quarter(&one).unwrap().len(), 1);
    }

    #[test]
    fn lower_degrees_keep_the_first_coefficients() {
        let attributes = GaussianAttributes {
            means: vec![[0.0; 3], [1.0; 3]],
            scales: vec![[1.0; 3]; 2],
            rotations: vec![[0.0, 0.0, 0.0, 1.0]; 2],
            opacities: vec![0.5; 2],
            harmonics: (0..18).map(|i| [i as f32, 0.0, 0.0]).collect(),
        };
        let gaussians = Gaussians::new(attributes, 2, DAffine3::IDENTITY).unwrap();
        let lower = of_lower_degree(&gaussians.with_antialiasing(true))
            .unwrap()
            .unwrap();
        let firsts: Vec<f32> = lower.attributes().harmonics.iter().map(|own| own[0]).collect();
        assert_eq!(firsts, [0.0, 1.0, 2.0, 3.0, 9.0, 10.0, 11.0, 12.0]);
        assert!(lower.antialiased());
        let lowest = of_lower_degree(&lower).unwrap().unwrap();
        assert!(lowest.degree() == 0 && of_lower_degree(&lowest).unwrap().is_none());
    }
}
