//! Transfer functions of value and gradient magnitude (Levoy 1988; Kindlmann and Durkin 1998): boundaries between
//! materials are arcs in that plane, and can be told apart where values alone cannot.
//!
//! Opacities are per unit distance, as everywhere: `kappa = sum -ln(1 - opacity) / unit_distance * weight`, colour
//! the mean weighted by those terms. A region's weight is 1 in its middle and falls to 0 within `softness` of its
//! half widths, by the smooth step `3 t^2 - 2 t^3`. A picture's columns are values, its rows gradient magnitudes,
//! the largest on top.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::marginal;
use super::picture::{Across, Picture};
use super::{Appearance, PixelOperator, SheetSample, WgslOperator, wgsl};
use crate::transfer_function::linear_from_srgb;
use crate::{ColorPoint, Image, OpacityPoint, SceneError, TransferFunction};

/// A soft rectangle of values and gradient magnitudes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Region {
    /// Smallest and largest value, data units.
    pub value: [f64; 2],
    /// Smallest and largest gradient magnitude, data units per world length.
    pub gradient: [f64; 2],
    /// sRGB, 0..1.
    pub rgb: [f64; 3],
    /// Opacity per unit distance, 0..1.
    pub opacity: f64,
    /// Share of the half widths over which it fades out, 0..1.
    #[serde(default = "default_softness")]
    pub softness: f64,
}

fn default_softness() -> f64 {
    0.25
}

/// Colour and opacity of values and gradient magnitudes together.
#[derive(Debug, Clone, PartialEq)]
pub struct TransferFunction2d {
    look: Look,
    unit_distance: f64,
}

#[derive(Debug, Clone, PartialEq)]
enum Look {
    Regions(Vec<Ready>),
    Picture {
        picture: Picture,
        value: [f64; 2],
        gradient: [f64; 2],
    },
}

/// A region, ready to be asked.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Ready {
    region: Region,
    value: Side,
    gradient: Side,
    color: Vec3,
    extinction: f32,
}

impl Ready {
    /// Its numbers in WGSL.
    fn operands(&self) -> [[f32; 4]; 3] {
        let of_side = |side: Side, last| [side.centre, side.half, side.per_fade, last];
        [
            of_side(self.value, self.extinction),
            of_side(self.gradient, 0.0),
            self.color.extend(0.0).to_array(),
        ]
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Side {
    centre: f32,
    half: f32,
    per_fade: f32,
}

impl Side {
    fn new([low, high]: [f64; 2], softness: f64) -> Self {
        let half = 0.5 * (high - low);
        Self {
            centre: (0.5 * (low + high)) as f32,
            half: half as f32,
            per_fade: (1.0 / (softness * half).max(1e-6 * half)) as f32,
        }
    }

    fn weight(&self, at: f32) -> f32 {
        let t = ((self.half - (at - self.centre).abs()) * self.per_fade).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }
}

fn extinction(opacity: f64, unit_distance: f64) -> f32 {
    (-libm::log1p(-opacity.min(TransferFunction::MAX_OPACITY)) / unit_distance) as f32
}

fn is_range([low, high]: [f64; 2]) -> bool {
    low.is_finite() && high.is_finite() && low < high
}

impl TransferFunction2d {
    /// Sum of soft regions; `unit_distance` is the world length to which their opacities refer.
    ///
    /// # Errors
    /// No regions, ranges that are empty or not finite, colours, opacities or softnesses outside 0..1, or a unit
    /// distance that is not positive.
    pub fn new(regions: &[Region], unit_distance: f64) -> Result<Self, SceneError> {
        check_unit_distance(unit_distance)?;
        if regions.is_empty() {
            return Err(SceneError::invalid("regions", regions, "at least one region"));
        }
        let unit = |value: &f64| (0.0..=1.0).contains(value);
        for region in regions {
            let Region {
                value,
                gradient,
                rgb,
                opacity,
                softness,
            } = region;
            let fine = is_range(*value) && is_range(*gradient) && rgb.iter().all(unit);
            if !(fine && unit(opacity) && unit(softness)) {
                return Err(SceneError::invalid(
                    "region",
                    region,
                    "value and gradient as LOW, HIGH; rgb, opacity and softness from 0 to 1",
                ));
            }
        }
        let ready = regions.iter().map(|&region| Ready {
            region,
            value: Side::new(region.value, region.softness),
            gradient: Side::new(region.gradient, region.softness),
            color: Vec3::from_array(region.rgb.map(|c| linear_from_srgb(c) as f32)),
            extinction: extinction(region.opacity, unit_distance),
        });
        Ok(Self {
            look: Look::Regions(ready.collect()),
            unit_distance,
        })
    }

    /// A picture's colours and alpha; left and right edge are the range of values, bottom and top that of gradient
    /// magnitudes. Nothing is seen beyond.
    ///
    /// # Errors
    /// Ranges that are empty or not finite, or a unit distance that is not positive.
    pub fn from_image(
        image: &Image,
        value: [f64; 2],
        gradient: [f64; 2],
        unit_distance: f64,
    ) -> Result<Self, SceneError> {
        check_unit_distance(unit_distance)?;
        for (field, range) in [("value range", value), ("gradient range", gradient)] {
            if !is_range(range) {
                return Err(SceneError::invalid(
                    field,
                    range,
                    "two numbers, the smaller first",
                ));
            }
        }
        Ok(Self {
            look: Look::Picture {
                picture: Picture::new(image, Across::Clamped),
                value,
                gradient,
            },
            unit_distance,
        })
    }

    /// Linear colour and extinction per world length of a value with a gradient magnitude.
    pub fn classify(&self, value: f32, gradient: f32) -> (Vec3, f32) {
        match &self.look {
            Look::Regions(regions) => {
                let (mut color, mut sum) = (Vec3::ZERO, 0.0);
                for region in regions {
                    let own =
                        region.extinction * region.value.weight(value) * region.gradient.weight(gradient);
                    color += region.color * own;
                    sum += own;
                }
                (color / sum.max(f32::MIN_POSITIVE), sum)
            }
            Look::Picture {
                picture,
                value: values,
                gradient: gradients,
            } => {
                let place = |at: f32, [low, high]: [f64; 2]| (at - low as f32) / (high - low) as f32;
                let (u, v) = (place(value, *values), 1.0 - place(gradient, *gradients));
                if !((0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v)) {
                    return (Vec3::ZERO, 0.0);
                }
                let pixel = picture.at([u, v]);
                let color = pixel.truncate() / pixel.w.max(f32::MIN_POSITIVE);
                (color, extinction(f64::from(pixel.w), self.unit_distance))
            }
        }
    }

    /// A transfer function of the value alone that shows every value which is visible with some gradient: the
    /// scene's own, by which invisible bricks are left out.
    ///
    /// # Errors
    /// Never for a function made by [`TransferFunction2d::new`].
    pub fn marginal(&self) -> Result<TransferFunction, SceneError> {
        let steps = match &self.look {
            Look::Regions(regions) => {
                marginal::of_regions(&regions.iter().map(|r| r.region).collect::<Vec<_>>())
            }
            Look::Picture { picture, value, .. } => marginal::of_picture(picture, *value),
        };
        let mut colors = Vec::new();
        let mut opacities = vec![OpacityPoint::new(steps[0].range[0], 0.0)];
        for step in &steps {
            for value in step.range {
                opacities.push(OpacityPoint::new(value, step.opacity));
                colors.push(ColorPoint::new(value, step.rgb));
            }
        }
        opacities.push(OpacityPoint::new(steps[steps.len() - 1].range[1], 0.0));
        TransferFunction::new(colors, opacities, Some(self.unit_distance))
    }
}

fn check_unit_distance(unit_distance: f64) -> Result<(), SceneError> {
    if unit_distance.is_finite() && unit_distance > 0.0 {
        Ok(())
    } else {
        Err(SceneError::invalid(
            "unit distance",
            unit_distance,
            "positive and finite",
        ))
    }
}

impl PixelOperator for TransferFunction2d {
    fn apply(&self, sample: &SheetSample, appearance: &mut Appearance) {
        (appearance.color, appearance.extinction) = self.classify(sample.value, sample.gradient.length());
    }

    fn pieces(&self) -> usize {
        4
    }

    fn wgsl(&self) -> Option<WgslOperator> {
        let (name, operands) = match &self.look {
            Look::Regions(regions) => {
                let count = [regions.len() as f32, 0.0, 0.0, 0.0];
                let each = regions.iter().flat_map(Ready::operands);
                ("regions_of_values", std::iter::once(count).chain(each).collect())
            }
            Look::Picture {
                picture,
                value,
                gradient,
            } => {
                let [[low, high], [flattest, steepest]] =
                    [value, gradient].map(|range| range.map(|end| end as f32));
                let least = (1.0 - TransferFunction::MAX_OPACITY) as f32;
                let head = [
                    [low, high, flattest, steepest],
                    [least, (1.0 / self.unit_distance) as f32, 0.0, 0.0],
                ];
                (
                    "picture_of_values",
                    head.into_iter().chain(picture.operands()).collect(),
                )
            }
        };
        Some(WgslOperator {
            name,
            texts: vec![wgsl::PICTURE, wgsl::TRANSFER_FUNCTION_2D],
            operands,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ImageSize;

    fn region() -> Region {
        Region {
            value: [10.0, 20.0],
            gradient: [2.0, 6.0],
            rgb: [1.0, 0.0, 0.0],
            opacity: 0.5,
            softness: 0.5,
        }
    }

    #[test]
    fn a_region_is_full_in_its_middle_and_fades_to_its_edges() {
        let function = TransferFunction2d::new(&[region()], 2.0).unwrap();
        let full = std::f32::consts::LN_2 / 2.0;
        let (color, extinction) = function.classify(15.0, 4.0);
        assert_eq!(color, Vec3::X);
        assert!((extinction - full).abs() < 1e-6);
        // Half way through the fading.
        assert!((function.classify(11.25, 4.0).1 - 0.5 * full).abs() < 1e-6);
        assert!((function.classify(15.0, 5.5).1 - 0.5 * full).abs() < 1e-6);
        for (value, gradient) in [(9.9, 4.0), (20.1, 4.0), (15.0, 1.9), (15.0, 6.1)] {
            assert_eq!(function.classify(value, gradient).1, 0.0);
        }
    }

    #[test]
    fn a_picture_is_a_table_with_the_largest_gradient_on_top() {
        let size = ImageSize::new(2, 2).unwrap();
        let half = [0.0, 0.5, 0.0, 0.5];
        let image = Image::from_pixels(size, vec![half, [0.0; 4], [0.0; 4], [0.0; 4]]).unwrap();
        let function = TransferFunction2d::from_image(&image, [0.0, 100.0], [0.0, 8.0], 1.0).unwrap();
        let (color, extinction) = function.classify(25.0, 6.0);
        assert_eq!(color, Vec3::Y);
        assert!((extinction - std::f32::consts::LN_2).abs() < 1e-6);
        assert_eq!(function.classify(75.0, 2.0).1, 0.0);
        assert_eq!(function.classify(25.0, 9.0).1, 0.0);
    }

    #[test]
    fn the_marginal_shows_all_that_is_visible() {
        let other = Region {
            value: [18.0, 40.0],
            ..region()
        };
        let size = ImageSize::new(3, 1).unwrap();
        let image = Image::from_pixels(size, vec![[0.0; 4], [0.3; 4], [0.0; 4]]).unwrap();
        let functions = [
            TransferFunction2d::new(&[region(), other], 1.0).unwrap(),
            TransferFunction2d::from_image(&image, [0.0, 30.0], [0.0, 8.0], 1.0).unwrap(),
        ];
        for function in functions {
            let marginal = function.marginal().unwrap();
            for i in 0..1000 {
                let value = f64::from(i) * 0.05;
                let densest = (0..90).fold(0.0f32, |most, g| {
                    most.max(function.classify(value as f32, g as f32 * 0.1).1)
                });
                let shown = -(-marginal.opacity(value)).ln_1p();
                assert!(f64::from(densest) <= shown + 1e-5, "{value}: {densest} {shown}");
            }
        }
    }

    #[test]
    fn wrong_regions_are_named() {
        let empty = Region {
            value: [3.0, 3.0],
            ..region()
        };
        let error = TransferFunction2d::new(&[empty], 1.0).unwrap_err().to_string();
        assert!(error.contains("value: [3.0, 3.0]"), "{error}");
        assert!(TransferFunction2d::new(&[], 1.0).is_err());
        assert!(TransferFunction2d::new(&[region()], 0.0).is_err());
    }
}
