//! Post-classification with operators, clips or isosurfaces: planes shaded pixel by pixel (huang2000 section 4.3).
//!
//! Clips cut an interval into pieces. Each remaining piece takes its mean extinction and the place of its material
//! from the integrals of the transfer function, as in `shade`; operators are evaluated at that place. An isosurface
//! is seen where the cubic between two planes takes its value.
//!
//! Where there are clips alone, pixels of which they neither cut the interval nor light a face are left to `shade`: each
//! pixel decides for itself, by the distances of its interval's ends from the planes. Clips that touch nothing change no bit.
//!
//! The field's gradient is not the normal of a cut. The normal is that of the cut's face, weighted by the opacity
//! of four voxels of the material at the face, until seven eighths of the light are gone or the material ends. So
//! faces of opaque material are lit flat, at the mean place of the light they send, and fog, which has no faces, is
//! lit as if uncut.

use std::sync::Arc;

use fearless_simd::prelude::*;
use glam::{Affine3A, Vec3};
use splatvol_scene::transfer_function::linear_from_srgb;
use splatvol_scene::{Appearance, Camera, PixelOperator, SheetSample};

use super::canvas::Canvas;
use super::cut::{Cut, Range, Side};
use super::pixel::{Pixel, Pixels, Units};
use super::plane::Span;
use super::shade::Interval;
use super::shade::{PlaneShader, ShadeTarget};
use crate::phong::Lit;
use crate::route::Effects;
use crate::simd::math::{LEAST_EXPONENT, exp2_of};
use splatvol_core::shade_table::PixelSegment;

/// Operators, clips and isosurfaces, applied pixel by pixel.
#[derive(Debug)]
pub(crate) struct Operated<'a> {
    operators: &'a [Arc<dyn PixelOperator>],
    pub cut: Cut,
    surfaces: Vec<Surface>,
    units: Units,
    pieces: usize,
    /// World length.
    mean_spacing: f32,
}

/// An isosurface; normalised value, linear colour, extinction over a voxel.
#[derive(Debug, Clone, Copy)]
struct Surface {
    value: f32,
    color: Vec3,
    extinction: f32,
}

/// State of the cut face that a pixel looks at.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Face {
    /// World axes.
    normal: Vec3,
    /// Share of the lit material that lies on the face, 0 to 1.
    share: f32,
    /// Transmittance from the face on.
    through: f32,
    /// The interval in which it was last seen.
    sheet: usize,
}

impl Face {
    const NONE: Self = Self {
        normal: Vec3::Z,
        share: 0.0,
        through: 1.0,
        sheet: 0,
    };

    /// Share of the normal that is the cut's.
    fn weight(&self) -> f32 {
        self.share * (8.0 * self.through).min(1.0)
    }
}

/// A tile's memory of cuts, and room for parts of intervals.
#[derive(Debug, Default)]
pub(crate) struct Faces {
    /// Of each pixel; none before the first cut.
    faces: Vec<Face>,
    divided: Divided,
    ranges: Vec<Range>,
    /// Places and surfaces.
    crossings: Vec<(f32, usize)>,
}

/// What clips do to sixteen pixels of a row in an interval: bits of those that they leave whole, and of those that they may
/// cut. The others are hidden.
#[derive(Debug, Clone, Copy, Default)]
struct Sixteen {
    whole: u16,
    cut: u16,
}

/// The same of all pixels of a tile that an interval fills.
#[derive(Debug, Default)]
pub(crate) struct Divided {
    sixteens: Vec<Sixteen>,
    /// Sixteens of a row.
    pitch: usize,
}

impl Divided {
    /// Of the pixels from a place on.
    fn at(&self, [x, y]: [usize; 2]) -> Sixteen {
        self.sixteens
            .get(y * self.pitch + x / 16)
            .copied()
            .unwrap_or_default()
    }

    /// Bits of the sixteen pixels from a place on that clips leave whole.
    pub(crate) fn whole(&self, place: [usize; 2]) -> u16 {
        self.at(place).whole
    }
}

impl Faces {
    /// Forgets all.
    pub(crate) fn clear(&mut self) {
        self.faces.clear();
    }

    /// Whether a pixel looks at a cut face, as of an interval.
    fn is_lit(&self, pixel: usize, sheet: usize) -> bool {
        let face = self.faces.get(pixel);
        face.is_some_and(|face| face.share > 0.0 && sheet <= face.sheet + 1)
    }

    /// Divides the pixels of an interval; without clips all of them are to be shaded one by one.
    fn divide(
        &mut self,
        (pixels, cut): (&Pixels<'_>, Option<&Cut>),
        (target, sheet): (&ShadeTarget<'_>, usize),
    ) {
        let Span { x0, y0, x1, y1 } = target.span;
        let pitch = x1.div_ceil(16);
        let mut sixteens = std::mem::take(&mut self.divided.sixteens);
        sixteens.clear();
        sixteens.resize(pitch * y1, Sixteen::default());
        for y in y0..y1 {
            for x in (x0 / 16 * 16..x1).step_by(16) {
                let open = target.mask.sixteen(x, y);
                if open == 0 {
                    continue;
                }
                let side = cut.map_or(Side::Between, |cut| pixels.side(cut, [x, y, x + 15, y]));
                let is_whole = |lane: usize| {
                    let side = match (side, cut) {
                        (Side::Between, Some(cut)) => pixels.side_of(cut, [x + lane, y]),
                        _ => side,
                    };
                    match side {
                        Side::Visible => Some(!self.is_lit(y * target.canvas.pitch + x + lane, sheet)),
                        Side::Hidden => None,
                        Side::Between => Some(false),
                    }
                };
                let own = &mut sixteens[y * pitch + x / 16];
                for lane in (0..16).filter(|lane| open >> lane & 1 != 0) {
                    match is_whole(lane) {
                        Some(true) => own.whole |= 1 << lane,
                        Some(false) => own.cut |= 1 << lane,
                        None => {}
                    }
                }
            }
        }
        self.divided = Divided { sixteens, pitch };
    }
}

/// State of a pixel during shading.
struct Ink {
    through: f32,
    color: Vec3,
    depth_sum: f32,
}

impl Ink {
    fn of(canvas: &Canvas, pixel: usize) -> Self {
        if canvas.gathers() {
            // Other layers share the interval: this holds only what this layer shows of it.
            return Self {
                through: 1.0,
                color: Vec3::ZERO,
                depth_sum: 0.0,
            };
        }
        Self {
            through: canvas.transmittance[pixel],
            color: Vec3::from_array(canvas.color.each_ref().map(|plane| plane[pixel])),
            depth_sum: canvas.depth_sum[pixel],
        }
    }

    fn store(&self, canvas: &mut Canvas, pixel: usize) {
        if canvas.gathers() {
            let opacity = 1.0 - self.through;
            if opacity > 0.0 {
                canvas.add_pixel(
                    pixel,
                    self.color.to_array(),
                    self.through,
                    self.depth_sum / opacity,
                );
            }
            return;
        }
        canvas.transmittance[pixel] = self.through;
        for (plane, value) in canvas.color.iter_mut().zip(self.color.to_array()) {
            plane[pixel] = value;
        }
        canvas.depth_sum[pixel] = self.depth_sum;
    }

    /// Composites a colour with a transmittance behind the pixel.
    fn add(&mut self, color: Vec3, through: f32, depth: f32) {
        let share = self.through * (1.0 - through);
        self.color += color * share;
        self.depth_sum += depth * share;
        self.through *= through;
    }
}

impl<'a> Operated<'a> {
    /// `None` without operators, clips and isosurfaces. `mean_spacing`: world length; values lie in the range.
    pub(crate) fn new(
        effects: &Effects<'a>,
        mean_spacing: f64,
        (camera, [low, high]): (&Camera, [f64; 2]),
    ) -> Option<Self> {
        if effects.operators.is_empty() && effects.clips.is_empty() && effects.isosurfaces.is_empty() {
            return None;
        }
        let world_from_camera = camera.camera_from_world().inverse();
        let range = if high > low { high - low } else { 1.0 };
        let units = Units {
            world_from_camera: Affine3A::from_mat3_translation(
                world_from_camera.matrix3.as_mat3(),
                world_from_camera.translation.as_vec3(),
            ),
            lowest: low as f32,
            range: range as f32,
        };
        let surfaces = effects.isosurfaces.iter().map(|surface| Surface {
            value: ((surface.value - low) / range) as f32,
            color: Vec3::from_array(surface.rgb.map(|c| linear_from_srgb(c) as f32)),
            extinction: (-libm::log1p(-surface.opacity) / mean_spacing) as f32,
        });
        Some(Self {
            operators: effects.operators,
            cut: Cut::new(&effects.clips, world_from_camera),
            surfaces: surfaces.collect(),
            units,
            pieces: effects
                .operators
                .iter()
                .fold(2, |most, o| most.max(o.pieces()))
                .min(64),
            mean_spacing: mean_spacing as f32,
        })
    }

    /// Shades an interval, and closes the pixels that it finishes. Pixels that clips neither touch nor have just left are shaded
    /// as without clips.
    pub(crate) fn shade<S: Simd>(
        &self,
        simd: S,
        (shader, interval, sheet): (&PlaneShader<'_>, &Interval<'_>, usize),
        target: &mut ShadeTarget<'_>,
        faces: &mut Faces,
    ) {
        let pixels = Pixels {
            shader,
            interval,
            origin: target.origin,
        };
        let Span { x0, y0, x1, y1 } = target.span;
        if target.span.is_empty() {
            return;
        }
        let only_cuts = self.operators.is_empty() && self.surfaces.is_empty();
        let side = match only_cuts {
            true => pixels.side(&self.cut, [x0, y0, x1 - 1, y1 - 1]),
            false => Side::Between,
        };
        match side {
            Side::Hidden => {}
            Side::Visible if faces.faces.is_empty() => shader.shade(simd, interval, target, None),
            _ => {
                faces.divide((&pixels, only_cuts.then_some(&self.cut)), (target, sheet));
                let divided = std::mem::take(&mut faces.divided);
                shader.shade(simd, interval, target, Some(&divided));
                self.shade_cut((&pixels, sheet), target, (faces, &divided));
                faces.divided = divided;
            }
        }
    }

    /// Shades the pixels that clips may touch, one by one.
    fn shade_cut(
        &self,
        (pixels, sheet): (&Pixels<'_>, usize),
        target: &mut ShadeTarget<'_>,
        (faces, divided): (&mut Faces, &Divided),
    ) {
        let shader = pixels.shader;
        faces.faces.resize(target.canvas.transmittance.len(), Face::NONE);
        let span = target.span;
        for y in span.y0..span.y1 {
            for x in span.x0..span.x1 {
                let is_cut = divided.at([x / 16 * 16, y]).cut >> (x % 16) & 1 != 0;
                if !is_cut || target.mask.sixteen(x, y) & 1 == 0 {
                    continue;
                }
                let Some(pixel) = pixels.get([x, y]) else { continue };
                let at = y * target.canvas.pitch + x;
                let mut ink = Ink::of(target.canvas, at);
                self.cut.ranges(&pixel.segment, &mut faces.ranges);
                if self.surfaces.is_empty() {
                    let face = &mut faces.faces[at];
                    for range in &faces.ranges {
                        self.material((shader, &pixel, sheet), range, face, &mut ink);
                    }
                } else {
                    self.cross((shader, &pixel), faces, &mut ink);
                }
                ink.store(target.canvas, at);
                if !target.canvas.gathers() && ink.through < shader.termination {
                    target.mask.finish(x, y, 1);
                }
            }
        }
    }

    /// Material of a part of an interval.
    fn material(
        &self,
        (shader, pixel, sheet): (&PlaneShader<'_>, &Pixel, usize),
        range: &Range,
        face: &mut Face,
        ink: &mut Ink,
    ) {
        let table = shader.table;
        let width = (range.to - range.from) / self.pieces as f32;
        let mut from = (range.from, pixel.value(range.from));
        let mut point = table.point(from.1);
        if let Some(normal) = range.face {
            let material = point.extinction * pixel.coverage(range.from);
            *face = Face {
                normal: self.units.world_from_camera.transform_vector3(normal),
                share: 1.0 - exp2_of(-4.0 * std::f32::consts::LOG2_E * material * self.mean_spacing),
                through: 1.0,
                sheet,
            };
        } else if sheet > face.sheet + 1 {
            face.share = 0.0;
        }
        face.sheet = sheet;
        for i in 1..=self.pieces {
            let to_u = range.from + width * i as f32;
            let to = (to_u, pixel.value(to_u));
            let next = table.point(to.1);
            let piece = PixelSegment::between([from.1, to.1], [&point, &next]);
            let extinction = piece.extinction * pixel.coverage(0.5 * (from.0 + to.0));
            let mut place = piece.place;
            if face.share > 0.0 || pixel.from_eye {
                // Material from the cut, or the eye, on fills the piece.
                place *= 2.0 * mean_place(extinction * pixel.length * width);
            }
            let u = from.0 + place * (to.0 - from.0);
            let value = from.1 + place * (to.1 - from.1);
            (from, point) = (to, next);
            if extinction <= 0.0 {
                face.share = 0.0;
                continue;
            }
            let (sample, slope) = pixel.sample((u, value), &self.units);
            let mut appearance = Appearance {
                color: Vec3::from_array(table.color_of(value)),
                extinction,
                ..Appearance::default()
            };
            orient(shader, (&sample, slope), face, &mut appearance);
            if !self.operate(&sample, &mut appearance) {
                continue;
            }
            let depth = appearance.extinction * pixel.length * width;
            let through = exp2_of((depth * -std::f32::consts::LOG2_E).max(LEAST_EXPONENT));
            ink.add(self.light(shader, &appearance), through, sample.depth);
            face.through *= through;
        }
    }

    /// The isosurfaces that a pixel's ray crosses.
    fn cross(&self, (shader, pixel): (&PlaneShader<'_>, &Pixel), faces: &mut Faces, ink: &mut Ink) {
        let Faces {
            ranges, crossings, ..
        } = faces;
        crossings.clear();
        for (i, surface) in self.surfaces.iter().enumerate() {
            pixel
                .cubic
                .crossings(surface.value, pixel.ends(), |u| crossings.push((u, i)));
        }
        crossings.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for &(u, surface) in crossings.iter() {
            let left = ranges.iter().any(|range| range.from <= u && u < range.to);
            if !left || pixel.coverage(u) < 0.5 || ink.through < shader.termination {
                continue;
            }
            let surface = &self.surfaces[surface];
            let (sample, slope) = pixel.sample((u, surface.value), &self.units);
            let mut appearance = Appearance {
                color: surface.color,
                extinction: surface.extinction,
                ..Appearance::default()
            };
            orient(shader, (&sample, slope), &Face::NONE, &mut appearance);
            if self.operate(&sample, &mut appearance) {
                let depth = appearance.extinction * self.mean_spacing;
                let through = if depth < 100.0 { libm::expf(-depth) } else { 0.0 };
                ink.add(self.light(shader, &appearance), through, sample.depth);
            }
        }
    }

    /// Applies the operators; false if the result is invisible.
    fn operate(&self, sample: &SheetSample, appearance: &mut Appearance) -> bool {
        for operator in self.operators {
            operator.apply(sample, appearance);
        }
        // NaN counts as nothing.
        appearance.extinction > 0.0
    }

    /// The lit colour.
    fn light(&self, shader: &PlaneShader<'_>, appearance: &Appearance) -> Vec3 {
        let Lit { diffuse, specular } = shader.phong.as_ref().map_or(Lit::PLAIN, |phong| {
            let normal = self.units.world_from_camera.matrix3.transpose() * appearance.normal;
            phong.on_surface(normal.to_array(), appearance.surfaceness)
        });
        let lit = appearance.color * diffuse + specular;
        lit + (appearance.reflection - lit) * appearance.reflectance
    }
}

/// Optical depth below which the difference of the exact form would lose its digits.
const THIN: f32 = 0.1;
/// Optical depth at which the back sends no light at all, and its exponential does not overflow.
const OPAQUE: f32 = 80.0;

/// Mean place, 0 to 1, of the light from homogeneous material of this optical depth: `1 / t - 1 / (e^t - 1)`.
fn mean_place(depth: f32) -> f32 {
    if depth < THIN {
        // To second order.
        0.5 - depth / 12.0
    } else {
        1.0 / depth - 1.0 / libm::expm1f(depth.min(OPAQUE))
    }
}

/// Normal and surfaceness, by the gradient and the face of a cut.
fn orient(
    shader: &PlaneShader<'_>,
    (sample, slope): (&SheetSample, f32),
    face: &Face,
    appearance: &mut Appearance,
) {
    let normal = (-sample.gradient).try_normalize().unwrap_or(sample.view);
    appearance.normal = normal;
    // Without lighting, it matters only to mirrors.
    appearance.surfaceness = shader
        .phong
        .as_ref()
        .map_or(1.0, |phong| phong.surfaceness(slope));
    let weight = face.weight();
    if weight > 0.0 {
        let turned = if normal.dot(face.normal) < 0.0 {
            -normal
        } else {
            normal
        };
        appearance.normal = turned
            .lerp(face.normal, weight)
            .try_normalize()
            .unwrap_or(face.normal);
        appearance.surfaceness += (1.0 - appearance.surfaceness) * weight;
    }
}
