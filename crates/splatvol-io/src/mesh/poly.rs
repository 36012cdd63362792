//! Polygonal data of VTK: points, polygons and strips of triangles, and the attributes that say how they look. Unstructured grids
//! of flat cells are the same in another file.

pub(crate) mod flat;
mod scalars;

use splatvol_scene::Samples;

use crate::IoError;
use crate::SampleType;
use crate::error::Context;
use crate::volume::vtk_array::{ArrayHead, Association};
pub(crate) use scalars::{Choice, Scalars, choose};

/// Polygonal data as stored.
#[derive(Debug, Default)]
pub(crate) struct PolyData {
    /// Three coordinates for each point.
    pub(crate) points: Vec<f64>,
    /// Corners of each polygon.
    pub(crate) polygons: Lists,
    /// Corners of each strip of triangles.
    pub(crate) strips: Lists,
    /// Cells of a point or a line, which are left out.
    pub(crate) thin: u64,
    /// Three numbers for each point, or none.
    pub(crate) normals: Vec<f64>,
    /// Red, green and blue of each point, 0 to 255, or none.
    pub(crate) colors: Vec<[u8; 3]>,
    /// Values that colour the surface, where no colours do.
    pub(crate) scalars: Option<Scalars>,
    /// Format and version.
    pub(crate) format: String,
    /// Names of the arrays that were used.
    pub(crate) used: Vec<String>,
}

/// Lists of indices of points.
#[derive(Debug, Default)]
pub(crate) struct Lists {
    ends: Vec<usize>,
    indices: Vec<u32>,
}

impl Lists {
    /// Adds the lists of a piece whose `points` begin at `first`; each ends where `ends` says.
    pub(crate) fn add(
        &mut self,
        (ends, connectivity): (&[u64], &[u64]),
        (first, points): (usize, usize),
        context: &Context<'_>,
    ) -> Result<(), IoError> {
        let mut begin = 0;
        for (cell, &end) in ends.iter().enumerate() {
            let list = usize::try_from(end)
                .ok()
                .and_then(|end| connectivity.get(begin..end));
            let list = list.ok_or_else(|| {
                let expected = format!("{begin} to {}", connectivity.len());
                context.field(format!("offset of cell {cell}"), end, None, expected)
            })?;
            begin = end as usize;
            for &index in list {
                let place = usize::try_from(index).ok().filter(|&index| index < points);
                let place = place.and_then(|index| u32::try_from(first + index).ok());
                self.indices.push(place.ok_or_else(|| {
                    context.field(
                        format!("point of cell {cell}"),
                        index,
                        None,
                        format!("below {points}"),
                    )
                })?);
            }
            self.ends.push(self.indices.len());
        }
        Ok(())
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let begins = std::iter::once(0).chain(self.ends.iter().copied());
        begins
            .zip(&self.ends)
            .map(|(begin, &end)| &self.indices[begin..end])
    }

    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }
}

/// An attribute that says how points look.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Look {
    Normals,
    Colors,
}

impl Look {
    /// What an array of points is, by its name, type and components; VTK shows bytes by threes and fours as colours.
    pub(crate) fn of(head: &ArrayHead) -> Option<Self> {
        if head.association != Association::Point {
            return None;
        }
        let named = head.name.to_ascii_lowercase().contains("normal");
        match (head.components, head.sample_type?) {
            (3, SampleType::F32 | SampleType::F64) if named => Some(Self::Normals),
            (3 | 4, SampleType::U8) => Some(Self::Colors),
            _ => None,
        }
    }
}

impl PolyData {
    /// Adds the numbers of an array of points; one of each kind per piece is used.
    pub(crate) fn add_look(&mut self, look: Look, head: &ArrayHead, samples: &Samples) {
        let numbers = super::assemble::to_f64(samples);
        match look {
            Look::Normals => self.normals.extend(numbers),
            Look::Colors => {
                let tuples = numbers.chunks_exact(head.components);
                self.colors
                    .extend(tuples.map(|t| [t[0] as u8, t[1] as u8, t[2] as u8]));
            }
        }
        if !self.used.contains(&head.name) {
            self.used.push(head.name.clone());
        }
    }

    /// Normals and colours that some pieces lack are left out.
    pub(crate) fn complete(mut self) -> Self {
        if self.normals.len() != self.points.len() {
            self.normals.clear();
        }
        if self.colors.len() * 3 != self.points.len() {
            self.colors.clear();
        }
        let counts = [self.points.len() / 3, self.polygons.len(), self.strips.len()];
        self.scalars = self.scalars.filter(|scalars| scalars.fits(counts));
        self
    }
}
