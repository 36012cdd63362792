//! Canvas: accumulated state of a tile's pixels, and compositing of material behind it.
//!
//! A single layer's material is composited directly. With several layers the materials of one interval are gathered
//! first. They lie side by side along the interval, so that extinctions add up (`T = T_a T_b`), and each layer's
//! emission per length, `C tau / (1 - T)` of its colour alone, is attenuated by both. A pixel that only one layer
//! reaches has that layer's numbers unchanged.

use fearless_simd::{Level, dispatch, f32x16, mask32x16, prelude::*};

use super::sheet::Lanes16;
use crate::simd::math::{exp2, log2};

/// An interval's material as sixteen pixels see it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Material<S: Simd> {
    /// Transmittance.
    pub through: f32x16<S>,
    /// `1 - through`, kept by itself because thin material would lose digits in the difference.
    pub opacity: f32x16<S>,
    /// Lit colour times opacity.
    pub color: [f32x16<S>; 3],
    /// Camera depth.
    pub depth: f32x16<S>,
}

/// A [`Material`] in memory.
#[derive(Debug, Clone, Copy)]
struct Stored {
    through: Lanes16,
    opacity: Lanes16,
    color: [Lanes16; 3],
    depth: Lanes16,
}

impl Stored {
    const NONE: Self = Self {
        through: Lanes16([1.0; 16]),
        opacity: Lanes16([0.0; 16]),
        color: [Lanes16([0.0; 16]); 3],
        depth: Lanes16([0.0; 16]),
    };
}

/// Accumulated state of a tile's pixels, channel by channel.
#[derive(Debug, Default)]
pub(crate) struct Canvas {
    pub transmittance: Vec<f32>,
    pub color: [Vec<f32>; 3],
    pub depth_sum: Vec<f32>,
    /// Of X-rays, once they are finished: the transmittance of dense material is no number. Else empty.
    pub optical_depth: Vec<f32>,
    pub pitch: usize,
    /// Whether something in front was composited by an earlier pass.
    pub continues: bool,
    /// Share of their extinctions that gathered materials have.
    pub share: f32,
    /// The interval's material, vector by vector, where layers are gathered.
    gathered: Vec<Stored>,
    /// Marks the non-empty vectors of `gathered`.
    holds: Vec<bool>,
    /// Indices of the non-empty vectors.
    touched: Vec<u32>,
}

#[inline(always)]
fn load<S: Simd>(simd: S, plane: &[f32], at: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &plane[at..at + 16])
}

#[inline(always)]
fn splat<S: Simd>(simd: S, value: f32) -> f32x16<S> {
    f32x16::splat(simd, value)
}

impl Canvas {
    /// Memory held, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let planes = [&self.transmittance, &self.depth_sum, &self.optical_depth]
            .into_iter()
            .chain(&self.color);
        planes
            .map(|plane| plane.capacity() * size_of::<f32>())
            .sum::<usize>()
            + self.gathered.capacity() * size_of::<Stored>()
            + self.holds.capacity()
            + self.touched.capacity() * size_of::<u32>()
    }

    /// Resets to an empty tile, with direct compositing.
    pub(crate) fn reset(&mut self, [width, height]: [usize; 2]) {
        self.pitch = width.next_multiple_of(16);
        let length = self.pitch * height;
        let Self {
            transmittance,
            color: [r, g, b],
            depth_sum,
            ..
        } = self;
        for (plane, value) in [
            (transmittance, 1.0),
            (r, 0.0),
            (g, 0.0),
            (b, 0.0),
            (depth_sum, 0.0),
        ] {
            plane.clear();
            plane.resize(length, value);
        }
        self.optical_depth.clear();
        self.composite();
        self.touched.clear();
    }

    /// Composites material directly from now on.
    pub(crate) fn composite(&mut self) {
        self.gathered.clear();
        self.holds.clear();
    }

    /// Starts to gather material, until [`Canvas::settle`].
    pub(crate) fn gather(&mut self) {
        self.share = 1.0;
        let vectors = self.transmittance.len() / 16;
        self.gathered.resize(vectors, Stored::NONE);
        self.holds.resize(vectors, false);
    }

    /// Composites material behind sixteen pixels from this one on, or gathers it; returns the pixels that it
    /// finished. Pixels whose transmittance is below `termination` stay unchanged.
    #[inline(always)]
    pub(crate) fn put<S: Simd>(
        &mut self,
        simd: S,
        pixel: usize,
        material: &Material<S>,
        termination: f32,
    ) -> u16 {
        if self.gathered.is_empty() {
            return self.put_behind(simd, pixel, material, termination);
        }
        self.add(simd, pixel / 16, material);
        0
    }

    #[inline(always)]
    fn put_behind<S: Simd>(
        &mut self,
        simd: S,
        pixel: usize,
        material: &Material<S>,
        termination: f32,
    ) -> u16 {
        let transmittance = load(simd, &self.transmittance, pixel);
        let open: mask32x16<S> = transmittance.simd_ge(splat(simd, termination));
        let before = open.select(transmittance, splat(simd, 0.0));
        for c in 0..3 {
            let plane = &mut self.color[c][pixel..pixel + 16];
            (material.color[c] * before + load(simd, plane, 0)).store_slice(plane);
        }
        let share = before * material.opacity;
        let plane = &mut self.depth_sum[pixel..pixel + 16];
        (material.depth * share + load(simd, plane, 0)).store_slice(plane);
        let left = transmittance * material.through;
        open.select(left, transmittance)
            .store_slice(&mut self.transmittance[pixel..pixel + 16]);
        (open & left.simd_lt(splat(simd, termination))).to_bitmask() as u16
    }

    /// Adds a layer's material to the interval's.
    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, vector: usize, material: &Material<S>) {
        let material = &match self.share {
            1.0 => *material,
            share => material.thinned(simd, share),
        };
        let stored = &mut self.gathered[vector];
        if std::mem::replace(&mut self.holds[vector], true) {
            stored.load(simd).beside(simd, material).store(stored);
        } else {
            self.touched.push(vector as u32);
            material.store(stored);
        }
    }

    /// Whether material is gathered.
    pub(crate) fn gathers(&self) -> bool {
        !self.gathered.is_empty()
    }

    /// Adds a layer's interval at one pixel: premultiplied colour, transmittance, camera depth.
    pub(crate) fn add_pixel(&mut self, pixel: usize, color: [f32; 3], through: f32, depth: f32) {
        let mut one = Stored::NONE;
        let lane = pixel % 16;
        one.through.0[lane] = through;
        one.opacity.0[lane] = 1.0 - through;
        for (plane, value) in one.color.iter_mut().zip(color) {
            plane.0[lane] = value;
        }
        one.depth.0[lane] = depth;
        dispatch!(Level::baseline(), simd => self.add(simd, pixel / 16, &one.load(simd)));
    }

    /// Composites the gathered material behind the pixels; calls `finish` with the column and row of sixteen pixels
    /// and those of them that it finished.
    #[inline(always)]
    pub(crate) fn settle<S: Simd>(
        &mut self,
        simd: S,
        termination: f32,
        mut finish: impl FnMut(usize, usize, u16),
    ) {
        for at in 0..self.touched.len() {
            let vector = self.touched[at] as usize;
            self.holds[vector] = false;
            let material = self.gathered[vector].load(simd);
            let pixel = 16 * vector;
            let finished = self.put_behind(simd, pixel, &material, termination);
            if finished != 0 {
                finish(pixel % self.pitch, pixel / self.pitch, finished);
            }
        }
        self.touched.clear();
    }
}

impl Stored {
    #[inline(always)]
    fn load<S: Simd>(&self, simd: S) -> Material<S> {
        let of = |lanes: &Lanes16| f32x16::from_slice(simd, &lanes.0);
        let [r, g, b] = &self.color;
        Material {
            through: of(&self.through),
            opacity: of(&self.opacity),
            color: [of(r), of(g), of(b)],
            depth: of(&self.depth),
        }
    }
}

/// Opacity below which the logarithm's digits would be lost in its division; the series is exact to 1e-6 there.
const THIN: f32 = 0.02;

/// Optical depth per opacity.
#[inline(always)]
fn depth_per_opacity<S: Simd>(simd: S, through: f32x16<S>, opacity: f32x16<S>) -> f32x16<S> {
    let thin = opacity.simd_lt(splat(simd, THIN));
    let series = opacity * (opacity * (1.0 / 3.0) + 0.5) + 1.0;
    let least = through.max(splat(simd, f32::MIN_POSITIVE));
    let divisor = thin.select(splat(simd, 1.0), opacity);
    let exact = log2(simd, least) * -std::f32::consts::LN_2 / divisor;
    thin.select(series, exact)
}

impl<S: Simd> Material<S> {
    #[inline(always)]
    fn store(&self, stored: &mut Stored) {
        self.through.store_slice(&mut stored.through.0);
        self.opacity.store_slice(&mut stored.opacity.0);
        for (color, stored) in self.color.iter().zip(&mut stored.color) {
            color.store_slice(&mut stored.0);
        }
        self.depth.store_slice(&mut stored.depth.0);
    }

    /// The material with a share of its extinction: `T^s`, in the same colour.
    #[inline(always)]
    fn thinned(&self, simd: S, share: f32) -> Self {
        let least = self.through.max(splat(simd, f32::MIN_POSITIVE));
        let through = exp2(simd, log2(simd, least) * share);
        let thin = self.opacity.simd_lt(splat(simd, THIN));
        // 1 - (1 - a)^s = s a (1 + (1 - s) a / 2 + (1 - s)(2 - s) a^2 / 6 + ...)
        let series = self.opacity * ((1.0 - share) * (2.0 - share) / 6.0) + 0.5 * (1.0 - share);
        let series = (series * self.opacity + 1.0) * self.opacity * share;
        let opacity = thin.select(series, 1.0 - through);
        let per_opacity = opacity / self.opacity.max(splat(simd, f32::MIN_POSITIVE));
        Self {
            through,
            opacity,
            color: self.color.map(|channel| channel * per_opacity),
            depth: self.depth,
        }
    }

    /// Two layers' material in one interval.
    #[inline(always)]
    fn beside(&self, simd: S, other: &Self) -> Self {
        let zero = splat(simd, 0.0);
        let (own, others) = (self.opacity.simd_gt(zero), other.opacity.simd_gt(zero));
        let through = self.through * other.through;
        // 1 - T_a T_b, without losing digits where both are thin.
        let opacity = self.opacity + other.opacity * self.through;
        let per_own = depth_per_opacity(simd, self.through, self.opacity);
        let per_other = depth_per_opacity(simd, other.through, other.opacity);
        let total = self.opacity * per_own + other.opacity * per_other;
        let seen = opacity / total.max(splat(simd, f32::MIN_POSITIVE));
        let (own_seen, other_seen) = (per_own * seen, per_other * seen);
        let opacities = (self.opacity + other.opacity).max(splat(simd, f32::MIN_POSITIVE));
        let depth = (self.depth * self.opacity + other.depth * other.opacity) / opacities;
        let pick = |both: f32x16<S>, own_value: f32x16<S>, other_value: f32x16<S>| {
            others.select(own.select(both, other_value), own_value)
        };
        let mut color = self.color;
        for c in 0..3 {
            let both = self.color[c] * own_seen + other.color[c] * other_seen;
            color[c] = pick(both, self.color[c], other.color[c]);
        }
        Self {
            through: pick(through, self.through, other.through),
            opacity: pick(opacity, self.opacity, other.opacity),
            color,
            depth: pick(depth, self.depth, other.depth),
        }
    }
}

#[cfg(test)]
mod tests {
    use splatvol_testing::Random;

    use super::*;

    /// Two media in one interval, in thin slices, f64: transmittance and colour.
    fn side_by_side(layers: [(f64, f64); 2]) -> (f64, f64) {
        const SLICES: usize = 20_000;
        let (mut through, mut color) = (1.0, 0.0);
        for _ in 0..SLICES {
            let depth: f64 = layers.iter().map(|(tau, _)| tau / SLICES as f64).sum();
            let emission: f64 = layers.iter().map(|(tau, c)| tau * c / SLICES as f64).sum();
            let opacity = -(-depth).exp_m1();
            color += through * emission / depth * opacity;
            through *= 1.0 - opacity;
        }
        (through, color)
    }

    #[inline(always)]
    fn gathered<S: Simd>(simd: S, layers: &[[(f32, f32); 16]]) -> ([f32; 16], [f32; 16]) {
        let mut canvas = Canvas::default();
        canvas.reset([16, 1]);
        canvas.gather();
        for layer in layers {
            let lanes = |value: &dyn Fn((f32, f32)) -> f32| {
                f32x16::from_slice(simd, &std::array::from_fn::<_, 16, _>(|lane| value(layer[lane])))
            };
            let material = Material {
                through: lanes(&|(tau, _)| (-tau).exp()),
                opacity: lanes(&|(tau, _)| -(-tau).exp_m1()),
                color: [lanes(&|(tau, c)| -(-tau).exp_m1() * c); 3],
                depth: f32x16::splat(simd, 1.0),
            };
            assert_eq!(canvas.put(simd, 0, &material, 0.0), 0);
        }
        canvas.settle(simd, 0.0, |_, _, _| {});
        let of = |plane: &[f32]| std::array::from_fn(|lane| plane[lane]);
        (of(&canvas.transmittance), of(&canvas.color[0]))
    }

    #[test]
    fn media_side_by_side_look_like_thin_slices_of_both() {
        let mut random = Random::new(5);
        let mut layers = [[(0.0f32, 0.0f32); 16]; 2];
        for lane in 0..16 {
            for layer in &mut layers {
                layer[lane] = (10f64.powf(random.range(-4.0, 1.0)) as f32, random.unit() as f32);
            }
        }
        let (through, color) = dispatch!(Level::new(), simd => gathered(simd, &layers));
        for lane in 0..16 {
            let both = layers.map(|layer| (f64::from(layer[lane].0), f64::from(layer[lane].1)));
            let (wanted_through, wanted_color) = side_by_side(both);
            assert!(
                (f64::from(through[lane]) - wanted_through).abs() < 1e-5,
                "{both:?}"
            );
            assert!((f64::from(color[lane]) - wanted_color).abs() < 2e-5, "{both:?}");
        }
    }

    #[inline(always)]
    fn thinned<S: Simd>(simd: S, tau: f32, share: f32) -> [f32; 3] {
        let material = Material {
            through: splat(simd, (-tau).exp()),
            opacity: splat(simd, -(-tau).exp_m1()),
            color: [splat(simd, -(-tau).exp_m1() * 0.25); 3],
            depth: splat(simd, 1.0),
        };
        let thinned = material.thinned(simd, share);
        [thinned.through, thinned.opacity, thinned.color[0]].map(|lanes| lanes.as_slice()[0])
    }

    #[test]
    fn a_share_of_a_material_has_that_share_of_its_optical_depth() {
        let mut random = Random::new(6);
        for _ in 0..2000 {
            let (tau, share) = (10f64.powf(random.range(-5.0, 1.5)) as f32, random.unit() as f32);
            let [through, opacity, color] = dispatch!(Level::new(), simd => thinned(simd, tau, share));
            let wanted = (-f64::from(tau) * f64::from(share)).exp();
            let opaque = -(-f64::from(tau) * f64::from(share)).exp_m1();
            assert!((f64::from(through) - wanted).abs() < 3e-6, "{tau} {share}");
            assert!((f64::from(opacity) - opaque).abs() < 3e-6, "{tau} {share}");
            assert!(
                (f64::from(color) - 0.25 * opaque).abs() < 2e-6,
                "{tau} {share}: {color}"
            );
        }
    }

    #[test]
    fn pixels_of_one_layer_keep_its_numbers() {
        let mut layers = [[(0.0f32, 0.0f32); 16]; 2];
        for lane in 0..16 {
            layers[lane % 2][lane] = (0.1 + lane as f32, 0.5);
        }
        let level = Level::new();
        let both = dispatch!(level, simd => gathered(simd, &layers));
        let alone = layers.map(|layer| dispatch!(level, simd => gathered(simd, &[layer])));
        for lane in 0..16 {
            let own = &alone[lane % 2];
            assert_eq!((both.0[lane], both.1[lane]), (own.0[lane], own.1[lane]));
        }
    }
}
