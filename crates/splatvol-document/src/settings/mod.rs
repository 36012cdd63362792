//! The method: from keys to complete settings, and back.

mod footprint;
pub mod kernel;
mod table;
mod written;

use splatvol_scene::{Coverage, Filter, FlatSettings, Gradient, ImageSize, Lighting, RenderSettings};

use crate::DocumentError;
use crate::keys::SettingKeys;
use crate::keys::names::{CoverageName, FilterName, PresetName};
use crate::look::Wishes;
pub use written::written;

/// Side of a picture unless asked otherwise, pixels.
const SIDE: u32 = 1024;

impl SettingKeys {
    /// How sheets become a picture: as asked, as a paper's preset says, or by default.
    pub fn compositing(&self) -> splatvol_scene::Compositing {
        match (self.compositing, self.preset.and_then(paper)) {
            (Some(name), _) => name.into(),
            (None, Some(settings)) => settings.method.compositing(),
            (None, None) => splatvol_scene::Compositing::default(),
        }
    }

    /// The settings: keys over a preset, over the defaults and the wishes of the data.
    ///
    /// # Errors
    /// Keys that have no meaning together, by name; values outside their domain.
    pub fn resolve(&self, size: Option<ImageSize>, wishes: Wishes) -> Result<RenderSettings, DocumentError> {
        let mut settings = self.base(wishes)?;
        settings.compositing = self.compositing();
        if let Some(size) = size {
            settings.size = size;
        }
        set_named(&mut settings.classification, self.classification);
        set_named(&mut settings.gaussians, self.gaussians);
        set_named(&mut settings.gradient, self.gradient);
        set(&mut settings.sheet_thickness, self.sheet_thickness);
        set(&mut settings.level_bias, self.level_bias);
        set(&mut settings.termination, self.termination);
        settings.filter = self.resolved_filter(settings.filter)?;
        settings.coverage = self.resolved_coverage(settings.coverage)?;
        settings.kernel = kernel::resolve(self, settings.kernel)?;
        // Only Gaussians are prefiltered.
        let interpolates = settings.kernel.gaussian().is_some();
        if self.prefilter == Some(true) && !interpolates {
            return Err(DocumentError::refused(
                "settings.prefilter",
                format!(
                    "needs the gaussian kernel: data are not interpolated by {}",
                    settings.kernel.name()
                ),
            ));
        }
        settings.prefilter = self.prefilter.unwrap_or(settings.prefilter && interpolates);
        settings.lighting = self.lighting(settings.lighting);
        table::set(self, &mut settings)?;
        footprint::set(self, &mut settings)?;
        footprint::complete(self, &mut settings, self.classification.is_none());
        let settings = RenderSettings::try_from(settings)?;
        settings.validate()?;
        Ok(settings)
    }

    /// The preset, or the defaults, with the wishes of the data. A preset sets the quality, not the kind of picture,
    /// except for those of the papers, which are whole methods.
    fn base(&self, wishes: Wishes) -> Result<FlatSettings, DocumentError> {
        let shown = FlatSettings {
            size: ImageSize::new(SIDE, SIDE)?,
            classification: wishes.classification.unwrap_or_default(),
            lighting: RenderSettings::default().lighting.filter(|_| !wishes.unlit),
            ..FlatSettings::default()
        };
        let mut settings = match self.preset {
            None => return Ok(shown),
            Some(name) => preset(name, &shown),
        };
        if wishes.differences {
            settings.gradient = Gradient::Differences;
        }
        Ok(settings)
    }

    fn resolved_filter(&self, old: Filter) -> Result<Filter, DocumentError> {
        let width = match old {
            Filter::None | Filter::Swan | Filter::SwanAlpha => Filter::default().pixel_sigma(),
            Filter::Ewa { pixel_sigma } | Filter::Matched { pixel_sigma } => pixel_sigma,
        };
        let pixel_sigma = self.pixel_sigma.unwrap_or(width);
        let refused = |why: &str| match self.pixel_sigma {
            Some(_) => Err(DocumentError::refused("settings.pixel-sigma", why)),
            None => Ok(()),
        };
        Ok(match (self.filter, old) {
            (Some(FilterName::None), _) => {
                refused("has no meaning with `settings.filter` none")?;
                Filter::None
            }
            (Some(name @ (FilterName::Swan | FilterName::SwanAlpha)), _) => {
                refused(
                    "has no meaning with `settings.filter` swan: footprints grow until voxels are a pixel apart",
                )?;
                match name {
                    FilterName::Swan => Filter::Swan,
                    _ => Filter::SwanAlpha,
                }
            }
            (Some(FilterName::Matched), _) | (None, Filter::Matched { .. }) => {
                Filter::Matched { pixel_sigma }
            }
            (Some(FilterName::Ewa), _) | (None, Filter::Ewa { .. }) => Filter::Ewa { pixel_sigma },
            (None, old) => match self.pixel_sigma {
                Some(pixel_sigma) => Filter::Ewa { pixel_sigma },
                None => old,
            },
        })
    }

    fn resolved_coverage(&self, old: Coverage) -> Result<Coverage, DocumentError> {
        let named = match (self.coverage, old) {
            (Some(CoverageName::Off), _) => Coverage::Off,
            (Some(CoverageName::Adaptive), Coverage::Off) => Coverage::ADAPTIVE,
            _ => old,
        };
        match named {
            Coverage::Adaptive { samples, contrast } => Ok(Coverage::Adaptive {
                samples: self.coverage_samples.unwrap_or(samples),
                contrast: self.coverage_contrast.unwrap_or(contrast),
            }),
            Coverage::Off => {
                let needs = "needs `settings.coverage` adaptive";
                if self.coverage_samples.is_some() {
                    return Err(DocumentError::refused("settings.coverage-samples", needs));
                }
                if self.coverage_contrast.is_some() {
                    return Err(DocumentError::refused("settings.coverage-contrast", needs));
                }
                Ok(Coverage::Off)
            }
        }
    }

    /// Asking for any property of the light turns it on.
    fn lighting(&self, old: Option<Lighting>) -> Option<Lighting> {
        if self.shade == Some(false) {
            return None;
        }
        let asked = self.shade.is_some() || self.describes_light();
        let mut lighting = old.or(asked.then(Lighting::default))?;
        set(&mut lighting.ambient, self.ambient);
        set(&mut lighting.diffuse, self.diffuse);
        set(&mut lighting.specular, self.specular);
        set(&mut lighting.specular_power, self.specular_power);
        set(&mut lighting.gradient_floor, self.gradient_floor);
        set(&mut lighting.direction, self.light);
        Some(lighting)
    }
}

fn preset(name: PresetName, shown: &FlatSettings) -> FlatSettings {
    if let Some(method) = paper(name) {
        return FlatSettings {
            size: shown.size,
            lighting: shown.lighting,
            ..method.into()
        };
    }
    let quality = match name {
        PresetName::Best => RenderSettings::best(),
        PresetName::Balanced => RenderSettings::balanced(),
        PresetName::Draft => RenderSettings::draft(),
        _ => RenderSettings::fast(),
    };
    FlatSettings {
        size: shown.size,
        compositing: shown.compositing,
        classification: shown.classification,
        lighting: shown.lighting,
        ..quality.into()
    }
}

/// A paper's method, which also says what is splatted and how it is composited.
fn paper(name: PresetName) -> Option<RenderSettings> {
    match name {
        PresetName::Best | PresetName::Balanced | PresetName::Fast | PresetName::Draft => None,
        PresetName::Swan1997 => Some(RenderSettings::swan1997()),
        PresetName::Mueller1998 => Some(RenderSettings::mueller1998()),
        PresetName::FastSplats2000 => Some(RenderSettings::fastsplats2000()),
        PresetName::Ewa2001 => Some(RenderSettings::ewa2001()),
    }
}

fn set<T>(field: &mut T, value: Option<T>) {
    if let Some(value) = value {
        *field = value;
    }
}

fn set_named<T, Name: Into<T>>(field: &mut T, name: Option<Name>) {
    set(field, name.map(Into::into));
}

#[cfg(test)]
mod tests;
