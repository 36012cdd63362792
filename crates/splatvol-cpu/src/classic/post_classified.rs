//! Post-classification: sheets of values, classified and lit pixel by pixel (huang2000 section 4, "post-rendering
//! classification").
//!
//! A sheet holds, per pixel, the sums `S = sum v_k w_k` and `W = sum w_k` of its sections, w being line integrals:
//! W is the length of the ray's path through the volume within the sheet. As a *mean* a pixel's value is `S / W` and its
//! optical depth `kappa(S / W) W`; as a *sum*, the paper's, they are `S / l` and `kappa(S / l) l`, with l the length of the
//! ray's path through the whole sheet, so that voxels without splats have the least value, which is zero here. The gradient comes from central differences between neighbouring pixels and
//! between the sheets before and behind.

use std::sync::atomic::AtomicBool;

use splatvol_core::splats::Profile;
use splatvol_scene::SheetValues;

use super::levels::Levels;
use super::order::Order;
use super::raster::Target;
use super::sheet::Sheet;
use super::tile::{Tile, TileScratch};

/// Three neighbouring sheets: before, here, behind.
#[derive(Debug, Default)]
pub(crate) struct ValueSheets {
    sheets: [Sheet<2>; 3],
    /// Turn of the sheet behind.
    newest: Option<usize>,
}

impl ValueSheets {
    /// Resets to empty sheets; `None` if the picture is cancelled meanwhile.
    pub(crate) fn reset(
        &mut self,
        size: [usize; 2],
        levels: Option<Levels>,
        stop: &AtomicBool,
    ) -> Option<()> {
        self.newest = None;
        // Lengths are no numbers of the paper's: its sheets hold the values alone.
        let levels = levels.map(|levels| (levels, 1));
        self.sheets
            .iter_mut()
            .try_for_each(|sheet| sheet.reset(size, levels, stop))
    }

    /// True where all three are empty.
    pub(crate) fn is_idle(&self) -> bool {
        self.sheets.iter().all(Sheet::is_empty)
    }

    fn advance(&mut self) {
        self.sheets.rotate_left(1);
        self.sheets[2].clear();
    }
}

/// Share of a sheet's thickness; shorter paths hold no value.
const FADED: f32 = 0.02;

struct Sum<'a> {
    sheet: &'a mut Sheet<2>,
    value: f32,
}

impl Target for Sum<'_> {
    #[inline(always)]
    fn row(&mut self, place: (usize, usize), weights: &[f32]) {
        self.sheet.add_row(place, weights, &[self.value, 1.0]);
    }
}

impl<P: Profile> Tile<'_, P> {
    /// Splats a sheet's sections of the open splats, behind the sheets so far.
    pub(crate) fn splat_values(&mut self, turn: usize, section: [f32; 2]) {
        let TileScratch {
            open, values, row, ..
        } = &mut *self.scratch;
        values.advance();
        values.newest = Some(turn);
        let (brush, work) = (&self.brush, &mut self.work);
        open.retain(|splat| {
            work.slices += 1;
            let mut target = Sum {
                sheet: &mut values.sheets[2],
                value: splat.payload[0],
            };
            target.sheet.touch(splat.area);
            brush.draw(&splat.footprint, Some(section), splat.area, row, &mut target);
            section[1] < splat.end
        });
    }

    /// Shades the sheet before the newest one, now that both its neighbours are complete.
    pub(crate) fn shade_values(&mut self, turn: usize) {
        if let (Some(middle), Order::Sheets { sheets, .. }) = (turn.checked_sub(1), self.plan.order) {
            let [near, far] = sheets.slab(middle).map(|depth| depth as f32);
            self.shade_between(0.5 * (near + far), far - near);
        }
    }

    /// Shades the last sheets, which no other follows.
    pub(crate) fn finish_values(&mut self) {
        if let Some(newest) = self.scratch.values.newest {
            self.scratch.values.advance();
            self.shade_values(newest + 1);
        }
    }

    fn shade_between(&mut self, depth: f32, thickness: f32) {
        let plan = self.plan;
        let Some((table, phong)) = &plan.shading else {
            return;
        };
        let TileScratch {
            values,
            pixels,
            finished,
            ..
        } = &mut *self.scratch;
        if values.sheets[1].is_empty() {
            return;
        }
        let (own, splatted) = (self.rect, self.brush.rect);
        let width = own.x1 - own.x0;
        let [x0, y0, x1, y1] = values.sheets[1].touched();
        let stencil = Stencil {
            sheets: &values.sheets,
            size: [splatted.x1 - splatted.x0, splatted.y1 - splatted.y0],
            least: FADED * thickness,
            thickness,
            values: plan.settings.method.sheet_values,
            per_pixel: 1.0 / plan.view.screen.scale_at(f64::from(depth)) as f32,
        };
        let levels = plan.picture_levels();
        let (first, end) = (x0 + splatted.x0, x1 + splatted.x0);
        for py in (y0 + splatted.y0).max(own.y0)..(y1 + splatted.y0).min(own.y1) {
            for px in first.max(own.x0)..end.min(own.x1) {
                let (x, y) = (px - own.x0, py - own.y0);
                let at = [px - splatted.x0, py - splatted.y0];
                if finished.is(x, y) {
                    continue;
                }
                let ray = plan.ray([px, py]);
                let whole = thickness * plan.projection.path_per_depth(ray, depth);
                let Some([value, path]) = stencil.value_and_path(1, at, whole) else {
                    continue;
                };
                let [extinction, emission @ ..] = table.at(value);
                if extinction <= 0.0 {
                    continue;
                }
                let mut color = emission.map(|e| e / extinction);
                if let Some(phong) = phong {
                    let lit = phong.at(stencil.gradient(at, value, ray, whole));
                    color = color.map(|c| c * lit.diffuse + lit.specular);
                }
                let pixel = &mut pixels[y * width + x];
                let optical_depth = extinction * path;
                pixel.composite(
                    (optical_depth, plan.settings.method.absorption),
                    color,
                    depth,
                    levels,
                );
                if pixel.transmittance <= plan.settings.termination as f32 {
                    finished.finish(x, y);
                }
            }
        }
    }
}

/// Differences between pixels of three sheets.
struct Stencil<'a> {
    sheets: &'a [Sheet<2>; 3],
    size: [usize; 2],
    /// Least path length at which a pixel has a value.
    least: f32,
    thickness: f32,
    values: SheetValues,
    /// World length between pixels.
    per_pixel: f32,
}

impl Stencil<'_> {
    /// The value of a pixel and the length of the path that it stands for; `None` where no splat is. `whole`: the length of
    /// the ray's path through the sheet.
    #[inline(always)]
    fn value_and_path(&self, sheet: usize, [x, y]: [usize; 2], whole: f32) -> Option<[f32; 2]> {
        let &[sum, path] = self.sheets[sheet].pixel(x, y);
        (path > self.least).then(|| {
            let path = match self.values {
                SheetValues::Mean => path,
                SheetValues::Sum => whole,
            };
            [sum / path, path]
        })
    }

    /// The value of a neighbour; `None` where it is missing. Neighbouring rays' paths are taken to be as long as this one's.
    #[inline(always)]
    fn neighbour(&self, sheet: usize, at: [usize; 2], whole: f32) -> Option<f32> {
        let found = self.value_and_path(sheet, at, whole).map(|[value, _]| value);
        match self.values {
            SheetValues::Mean => found,
            SheetValues::Sum => Some(found.unwrap_or(0.0)),
        }
    }

    /// Gradient in camera space, per world length. A missing neighbour is replaced by the pixel itself.
    #[inline(always)]
    fn gradient(&self, [x, y]: [usize; 2], here: f32, ray: [f32; 2], whole: f32) -> [f32; 3] {
        let rise = |before: Option<f32>, after: Option<f32>, step: f32| {
            let steps = f32::from(u8::from(before.is_some()) + u8::from(after.is_some())).max(1.0);
            (after.unwrap_or(here) - before.unwrap_or(here)) / (steps * step)
        };
        let beside = |inside: bool, at: [usize; 2]| {
            if inside {
                self.neighbour(1, at, whole)
            } else {
                None
            }
        };
        let across = rise(
            beside(x > 0, [x.wrapping_sub(1), y]),
            beside(x + 1 < self.size[0], [x + 1, y]),
            self.per_pixel,
        );
        let down = rise(
            beside(y > 0, [x, y.wrapping_sub(1)]),
            beside(y + 1 < self.size[1], [x, y + 1]),
            self.per_pixel,
        );
        let along = rise(
            self.neighbour(0, [x, y], whole),
            self.neighbour(2, [x, y], whole),
            self.thickness,
        );
        [across, down, along - ray[0] * across - ray[1] * down]
    }
}
