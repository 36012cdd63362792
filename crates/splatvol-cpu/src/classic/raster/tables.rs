//! FastSplats: footprints looked up in tables (huang2000 section 3).
//!
//! Shared by the rasterisers: the table of the kernel's sections, the part of it that a sheet cuts from a splat,
//! and the splat's position after its centre is snapped. Each rasteriser has a module of its own for looking up a
//! pixel's entry. All fill the weights of a splat's rectangle, one call per splat and sheet, in scalar code like
//! the paper's.
//!
//! A pixel's weight is `weight (C_far[i] - C_near[i]) / C_all[0]`, i the entry nearest to its distance. The paper
//! instead keeps a sum over separate sections. With the difference, neighbouring sheets' shares add up exactly.

use splatvol_core::bin::TileRect;
use splatvol_core::radial::{self, AnySection, Entry, Precision, Spacing, TableSettings};
use splatvol_core::splats::{Footprint, Sample, Warp};
use splatvol_scene::{Kernel, Rasterizer, SceneError, TableLayout, TablePrecision};

use super::blit::Blits;
use super::rlut::RadiusTables;
use super::{Section, UPRIGHT, circle, ellipse, linear};

/// A table and the way its entries are found.
#[derive(Debug)]
pub(crate) struct Tables {
    method: Method,
    table: radial::FootprintTable,
    /// One over the table's value at the centre.
    per_peak: f32,
    /// The support, standard deviations.
    cut: f32,
}

#[derive(Debug)]
enum Method {
    Linear,
    Square,
    Ellipse,
    Rlut(RadiusTables),
    Blit(Blits),
    /// Circles of this radius, pixels, at most are copied.
    Hybrid(Blits, f32),
}

/// Rectangle of pixels to fill: its first pixel in the picture, and its size.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block {
    pub first: [usize; 2],
    pub size: [usize; 2],
}

impl Block {
    /// From the splat's centre to the first pixel's.
    #[inline(always)]
    pub(super) fn offset(&self, centre: [f32; 2]) -> [f32; 2] {
        [0, 1].map(|axis| self.first[axis] as f32 + 0.5 - centre[axis])
    }
}

/// Rows of a table, and the factor on their difference.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lookup<'a, E> {
    near: &'a [E],
    far: &'a [E],
    scale: f32,
}

impl<E: Entry> Lookup<'_, E> {
    /// Index of the last entry, at the support.
    #[inline(always)]
    pub(super) fn last(&self) -> usize {
        self.far.len() - 1
    }

    /// The weight of an entry; an index beyond the last entry gets the last one's, which is zero.
    #[inline(always)]
    pub(super) fn entry(&self, index: usize) -> f32 {
        self.number(index) * self.scale
    }

    /// An entry, in units of the table's.
    #[inline(always)]
    pub(super) fn number(&self, index: usize) -> f32 {
        let index = index.min(self.last());
        match (self.far.get(index), self.near.get(index)) {
            (Some(far), Some(near)) => far.less(*near),
            _ => 0.0,
        }
    }

    /// The weight of a unit of the table's entries.
    #[inline(always)]
    pub(super) fn scale(&self) -> f32 {
        self.scale
    }

    /// The weight of the entry nearest to a position, counted in entries from the centre.
    #[inline(always)]
    pub(super) fn nearest(&self, position: f32) -> f32 {
        /// Added, it leaves the nearest integer in the lowest bits.
        const ROUND: f32 = 8_388_608.0;
        let last = self.last() as f32;
        let position = if position < last { position.max(0.0) } else { last };
        self.entry(((position + ROUND).to_bits() & 0x7f_ffff) as usize)
    }
}

impl Tables {
    /// The table of a rasteriser; `None` for the one without.
    ///
    /// # Errors
    /// Kernel or table outside their domain.
    pub(crate) fn new(
        (rasterizer, layout): (Rasterizer, TableLayout),
        kernel: Kernel,
    ) -> Result<Option<Self>, SceneError> {
        let method = match rasterizer {
            Rasterizer::Auto => return Ok(None),
            Rasterizer::Linear1d => Method::Linear,
            Rasterizer::Square1d => Method::Square,
            Rasterizer::Ellipse1d => Method::Ellipse,
            Rasterizer::Rlut { subpixels } => Method::Rlut(RadiusTables::new(subpixels as usize)),
            Rasterizer::Blit2d { subpixels } => {
                let [entries, sections] = [layout.entries, layout.sections].map(|count| count as usize);
                Method::Blit(Blits::new(subpixels as usize, entries, sections))
            }
            Rasterizer::Hybrid { subpixels, radius } => {
                let [entries, sections] = [layout.entries, layout.sections].map(|count| count as usize);
                Method::Hybrid(Blits::new(subpixels as usize, entries, sections), radius as f32)
            }
        };
        let settings = TableSettings {
            entries: layout.entries as usize,
            precision: match layout.precision {
                TablePrecision::U8 => Precision::U8,
                TablePrecision::U16 => Precision::U16,
                TablePrecision::F32 => Precision::F32,
            },
            spacing: match rasterizer {
                Rasterizer::Linear1d => Spacing::Linear,
                _ => Spacing::Squared,
            },
            sections: layout.sections as usize,
        };
        let table = radial::FootprintTable::new(kernel, settings)?;
        let kernel = radial::RadialKernel::new(kernel);
        Ok(Some(Self {
            method,
            per_peak: 1.0 / kernel.line_integral(0.0) as f32,
            cut: (kernel.support() / kernel.sigma()) as f32,
            table,
        }))
    }

    /// Largest displacement of a footprint's edge by snapping, pixels.
    pub(crate) fn margin(&self) -> f32 {
        match self.method {
            Method::Linear | Method::Square | Method::Ellipse => 0.0,
            Method::Rlut(_) => 0.5,
            Method::Blit(_) | Method::Hybrid(..) => 1.5,
        }
    }

    /// The footprint as this rasteriser draws it: its centre and size may be rounded.
    #[inline]
    pub(crate) fn snap(&self, footprint: Footprint) -> Footprint {
        match &self.method {
            Method::Linear | Method::Square | Method::Ellipse => footprint,
            Method::Rlut(tables) => tables.snap(footprint),
            Method::Blit(blits) => blits.snap(footprint, self.cut),
            Method::Hybrid(blits, most) if self.is_small(&footprint, *most) => {
                blits.snap(footprint, self.cut)
            }
            Method::Hybrid(..) => footprint,
        }
    }

    /// Whether a circle's radius in whole pixels is `most` at most.
    #[inline(always)]
    fn is_small(&self, footprint: &Footprint, most: f32) -> bool {
        match footprint.warp {
            Warp::Affine { conic, .. } => self.cut / conic[0].sqrt() < most + 0.5,
            _ => false,
        }
    }

    /// Weights of the pixels of an area of a tile, row after row.
    pub(crate) fn fill(
        &self,
        footprint: &Footprint,
        section: Option<Section>,
        (rect, [x0, y0, x1, y1]): (&TileRect, [usize; 4]),
        weights: &mut Vec<f32>,
    ) {
        let block = Block {
            first: [rect.x0 + x0, rect.y0 + y0],
            size: [x1 - x0, y1 - y0],
        };
        weights.clear();
        weights.resize(block.size[0] * block.size[1], 0.0);
        let Warp::Affine { conic, slope } = footprint.warp else {
            return self.each(footprint, section, &block, weights);
        };
        let [near, far] = match section {
            None => [-self.cut, self.cut],
            Some(depths) => {
                let [x0, y0, x1, y1] = footprint.bounds;
                let lean = slope[0].abs() * (x1 - x0) + slope[1].abs() * (y1 - y0);
                if lean > UPRIGHT * footprint.depth_sigma {
                    return self.each(footprint, section, &block, weights);
                }
                depths.map(|depth| (depth - footprint.depth) / footprint.depth_sigma)
            }
        };
        let part = self.table.section(near / self.cut, far / self.cut);
        match part {
            AnySection::U8(part) => self.lookup(footprint, conic, &block, (&part, weights)),
            AnySection::U16(part) => self.lookup(footprint, conic, &block, (&part, weights)),
            AnySection::F32(part) => self.lookup(footprint, conic, &block, (&part, weights)),
        }
    }

    fn lookup<E: Entry>(
        &self,
        footprint: &Footprint,
        conic: [f32; 3],
        block: &Block,
        (part, weights): (&radial::Section<'_, E>, &mut [f32]),
    ) {
        if part.is_empty() {
            return;
        }
        let [near, far] = part.rows();
        let lookup = Lookup {
            near,
            far,
            scale: footprint.weight * self.per_peak * part.unit(),
        };
        // Squared standard deviations to support radii, and to entries.
        let entries = lookup.last() as f32 / (self.cut * self.cut);
        let to_entries = conic.map(|q| q * entries);
        match &self.method {
            Method::Linear => {
                let to_last = conic.map(|q| q / (self.cut * self.cut));
                linear::fill(&lookup, to_last, footprint.centre, block, weights);
            }
            Method::Square => circle::fill(&lookup, to_entries[0], footprint.centre, block, weights),
            Method::Ellipse => ellipse::fill(&lookup, to_entries, footprint.centre, block, weights),
            Method::Rlut(tables) => tables.fill(&lookup, to_entries, footprint.centre, block, weights),
            Method::Blit(blits) => {
                let radius = self.cut / conic[0].sqrt();
                blits.fill((&lookup, part.depths()), radius, footprint.centre, block, weights);
            }
            Method::Hybrid(blits, most) if self.is_small(footprint, *most) => {
                let radius = self.cut / conic[0].sqrt();
                blits.fill((&lookup, part.depths()), radius, footprint.centre, block, weights);
            }
            Method::Hybrid(..) => circle::fill(&lookup, to_entries[0], footprint.centre, block, weights),
        }
    }

    /// Kernels that lean over their footprints: each pixel's ray meets a sheet at another height of the kernel.
    fn each(&self, footprint: &Footprint, section: Option<Section>, block: &Block, weights: &mut [f32]) {
        let to_support = 1.0 / (self.cut * self.cut);
        for (y, row) in weights.chunks_exact_mut(block.size[0]).enumerate() {
            let py = (block.first[1] + y) as f32 + 0.5;
            for (x, weight) in row.iter_mut().enumerate() {
                let sample: Sample = footprint.at([(block.first[0] + x) as f32 + 0.5, py]);
                let [near, far] = section.map_or([-1.0, 1.0], |depths| {
                    depths.map(|depth| (depth - sample.depth) / (sample.depth_sigma.max(1e-20) * self.cut))
                });
                let value = self.table.between(sample.squared * to_support, near, far);
                *weight = footprint.weight * sample.gain * value * self.per_peak;
            }
        }
    }

    /// Memory of the footprint table, and of the rasteriser's own tables so far.
    #[cfg(test)]
    pub(super) fn bytes(&self) -> [usize; 2] {
        let own = match &self.method {
            Method::Linear | Method::Square | Method::Ellipse => 0,
            Method::Rlut(tables) => tables.bytes(),
            Method::Blit(blits) | Method::Hybrid(blits, _) => blits.bytes(),
        };
        [self.table.bytes(), own]
    }
}
