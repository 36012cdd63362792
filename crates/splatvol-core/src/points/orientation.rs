//! Orientation: signs of normals.
//!
//! A plane has two sides. As in Hoppe et al. (1992, section 3.3), the choice of a side spreads over a spanning tree
//! of the graph of neighbours, first over pairs that surely agree, last over pairs that do not. The product of two
//! normals alone does not tell whether they agree: it fails where a surface turns by more than a right angle.
//! Agreement is instead
//!
//! `c = n_i . n_j - 2 (n_i . e)(n_j . e)`, with e the direction from one to the other:
//!
//! the product with the second normal mirrored as by a circle through both points (the simplest curve between them,
//! as König and Gumhold 2009 argue). It is 1 for the outward normals of a circle at any angle, and for the two
//! sides of a thin sheet. Edges have the weight `1 - |c|`, and the tree is that of least weight ([`spanning`]).
//!
//! Then each connected part is turned as a whole. A part that encloses a volume faces outward: there the sum of
//! `(p - centre) . n` over its area is above zero (the divergence theorem: three times the volume).

use glam::DVec3;
use rayon::prelude::*;

use super::{Neighborhoods, Orientation, spanning};

/// A part bulges where the mean of `(p - centre) . n` is at least this share of the mean of `|p - centre|`.
const BULGING: f64 = 0.1;
/// Length of the mean normal below which a part is closed; over a closed surface normals add up to zero.
const CLOSED: f64 = 0.3;
/// Bits that hold the number of an edge: 2^32 places of up to 64 neighbours.
const EDGE_BITS: u32 = 38;

impl Neighborhoods {
    /// Unit normals of all positions; see [`estimate_normals`](super::estimate_normals).
    pub fn normals(&self, orientation: Orientation) -> Vec<[f32; 3]> {
        let mut normals = self.plane_normals();
        match orientation {
            Orientation::Outward => self.turn_outward(&mut normals),
            Orientation::Along(direction) => turn(&mut normals, |_| direction),
            Orientation::Towards(viewpoint) => {
                let viewpoint = (viewpoint - self.center) / self.scale;
                turn(&mut normals, |place| viewpoint - self.place(place));
            }
        }
        let normals: Vec<[f32; 3]> = normals.par_iter().map(|n| n.as_vec3().to_array()).collect();
        self.spread(&normals)
    }

    fn turn_outward(&self, normals: &mut [DVec3]) {
        let signs: &[DVec3] = normals;
        let edge = |key: u64| (key & ((1 << EDGE_BITS) - 1)) as usize;
        let ends = |key| [edge(key) / self.k, self.neighbors_at(edge(key))];
        let differs = |key| {
            let [i, j] = ends(key);
            self.agreement(signs, i, j) < 0.0
        };
        let roots = spanning::spread(signs.len(), self.edges(signs), ends, differs);
        normals
            .par_iter_mut()
            .zip(&roots)
            .for_each(|(normal, &(_, flipped))| {
                if flipped {
                    *normal = -*normal;
                }
            });
        let inward = self.is_inward(normals, &roots);
        let turned = normals.par_iter_mut().zip(inward).filter(|(_, inward)| *inward);
        turned.for_each(|(normal, _)| *normal = -*normal);
    }

    /// Keys of edges; sides spread over light ones first. The upper bits hold the doubt, the lower the edge's
    /// number.
    fn edges(&self, normals: &[DVec3]) -> Vec<u64> {
        (0..self.flat().len())
            .into_par_iter()
            .filter_map(|edge| {
                let (i, j) = (edge / self.k, self.neighbors_at(edge));
                // An edge that both ends know is taken once.
                if j < i && self.of(j).contains(&(i as u32)) {
                    return None;
                }
                let doubt = 1.0 - self.agreement(normals, i, j).abs();
                let steps = (1u64 << (u64::BITS - EDGE_BITS)) - 1;
                Some(((doubt.clamp(0.0, 1.0) * steps as f64) as u64) << EDGE_BITS | edge as u64)
            })
            .collect()
    }

    fn neighbors_at(&self, edge: usize) -> usize {
        self.flat()[edge] as usize
    }

    /// Agreement of two normals: 1 where they surely show the same side, -1 where they surely do not.
    fn agreement(&self, normals: &[DVec3], i: usize, j: usize) -> f64 {
        let along = (self.place(j) - self.place(i)).normalize_or_zero();
        let (a, b) = (normals[i], normals[j]);
        a.dot(b) - 2.0 * a.dot(along) * b.dot(along)
    }

    /// For each place, whether the normals of its part point into it.
    fn is_inward(&self, normals: &[DVec3], roots: &[(u32, bool)]) -> Vec<bool> {
        let area: Vec<f64> = self.place_radii().into_par_iter().map(|r| r * r).collect();
        let (part_of, count) = numbered(roots);
        let mut parts = vec![Part::default(); count];
        for (place, &part) in part_of.iter().enumerate() {
            let part = &mut parts[part as usize];
            part.area += area[place];
            part.moment += area[place] * self.place(place);
        }
        for (place, &part) in part_of.iter().enumerate() {
            let part = &mut parts[part as usize];
            let from_center = self.place(place) - part.moment / part.area;
            part.outward += area[place] * from_center.dot(normals[place]);
            part.extent += area[place] * from_center.length();
            part.normal += area[place] * normals[place];
        }
        let inward: Vec<bool> = parts.iter().map(Part::is_inward).collect();
        part_of
            .into_par_iter()
            .map(|part| inward[part as usize])
            .collect()
    }
}

/// Index of each place's part, in the order of the parts' first places, and the number of parts.
fn numbered(roots: &[(u32, bool)]) -> (Vec<u32>, usize) {
    const NONE: u32 = u32::MAX;
    let mut number_of = vec![NONE; roots.len()];
    let mut count = 0;
    let number = |&(root, _): &(u32, bool)| {
        let number = &mut number_of[root as usize];
        if *number == NONE {
            *number = count;
            count += 1;
        }
        *number
    };
    let numbers = roots.iter().map(number).collect();
    (numbers, count as usize)
}

/// Sums over a connected part.
#[derive(Debug, Clone, Copy, Default)]
struct Part {
    area: f64,
    moment: DVec3,
    outward: f64,
    extent: f64,
    normal: DVec3,
}

impl Part {
    fn is_inward(&self) -> bool {
        let bulges = self.outward.abs() > BULGING * self.extent;
        if bulges || self.normal.length() < CLOSED * self.area {
            return self.outward < 0.0;
        }
        let [x, y, z] = self.normal.to_array();
        // Ties go to z, the usual up.
        [z, y, x]
            .into_iter()
            .reduce(|a, b| if b.abs() > a.abs() * (1.0 + 1e-9) { b } else { a })
            .is_some_and(|most| most < 0.0)
    }
}

/// Turns every normal to the side of its own direction.
fn turn(normals: &mut [DVec3], side: impl Fn(usize) -> DVec3 + Sync) {
    normals.par_iter_mut().enumerate().for_each(|(place, normal)| {
        if normal.dot(side(place)) < 0.0 {
            *normal = -*normal;
        }
    });
}
