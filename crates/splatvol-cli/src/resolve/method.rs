//! The render settings.

use splatvol::{
    Classification, Compositing, Coverage, Filter, FlatSettings, Gradient, ImageSize, Lighting,
    RenderSettings,
};

use super::look::Wishes;
use super::{fastsplats, footprint};
use crate::args::{
    ClassificationName, CompositingName, CoverageName, FilterName, GradientName, MethodArgs, PresetName,
};
use crate::failure::{During, Failure, Step};
use crate::resolve::kernel;

/// Side of a picture unless asked otherwise, pixels.
const SIDE: u32 = 1024;

/// How sheets become a picture: the flag's, that of a paper's preset, the earlier picture's, or the default.
pub(crate) fn compositing(args: &MethodArgs, like: Option<&FlatSettings>) -> Compositing {
    match args.compositing {
        Some(CompositingName::ImageSheets) => Compositing::ImageSheets,
        Some(CompositingName::Xray) => Compositing::Xray,
        Some(CompositingName::Mip) => Compositing::Mip,
        Some(CompositingName::Minip) => Compositing::MinimumIntensity,
        Some(CompositingName::Mean) => Compositing::Mean,
        Some(CompositingName::PerSplat) => Compositing::PerSplat,
        Some(CompositingName::PerSplatBackToFront) => Compositing::PerSplatBackToFront,
        Some(CompositingName::AxisSheets) => Compositing::AxisSheets,
        None => match (args.preset.and_then(paper), like) {
            (Some(settings), _) => settings.method.compositing(),
            (None, Some(like)) => like.compositing,
            (None, None) => Compositing::default(),
        },
    }
}

/// The settings: flags over a preset, over those of an earlier picture, over defaults and what the data want.
pub(crate) fn resolve(
    args: &MethodArgs,
    size: Option<ImageSize>,
    like: Option<&FlatSettings>,
    wishes: Wishes,
) -> Result<RenderSettings, Failure> {
    let mut settings = match like {
        Some(like) => *like,
        None => FlatSettings {
            size: ImageSize::new(SIDE, SIDE).during(Step::Usage)?,
            classification: wishes.classification.unwrap_or_default(),
            lighting: RenderSettings::default().lighting.filter(|_| !wishes.unlit),
            ..FlatSettings::default()
        },
    };
    if let Some(name) = args.preset {
        settings = preset(name, &settings);
        if wishes.differences {
            settings.gradient = Gradient::Differences;
        }
    }
    settings.compositing = compositing(args, like);
    if let Some(size) = size {
        settings.size = size;
    }
    match args.classification {
        Some(ClassificationName::Pre) => settings.classification = Classification::Pre,
        Some(ClassificationName::Post) => settings.classification = Classification::Post,
        None => {}
    }
    set(&mut settings.sheet_thickness, args.sheet_thickness);
    set(&mut settings.termination, args.termination);
    settings.filter = filter(args, settings.filter)?;
    settings.coverage = coverage(args, settings.coverage)?;
    settings.kernel = kernel::resolve(&args.kernel, settings.kernel)?;
    match args.gradient {
        Some(GradientName::Analytic) => settings.gradient = Gradient::Analytic,
        Some(GradientName::Differences) => settings.gradient = Gradient::Differences,
        None => {}
    }
    // Only Gaussians are prefiltered.
    let kept = settings.prefilter && settings.kernel.gaussian().is_some();
    if args.prefilter && settings.kernel.gaussian().is_none() {
        return Err(Failure::usage(format!(
            "--prefilter needs the gaussian kernel: data are not interpolated by {}",
            settings.kernel.name()
        )));
    }
    settings.prefilter = !args.no_prefilter && (args.prefilter || kept);
    settings.lighting = lighting(args, settings.lighting);
    footprint::set(&args.footprint, &mut settings)?;
    fastsplats::set(&args.fastsplats, &mut settings)?;
    let is_free = args.classification.is_none() && (like.is_none() || wishes.unclassified);
    footprint::complete(&args.footprint, &mut settings, is_free);
    let settings = RenderSettings::try_from(settings).during(Step::Usage)?;
    settings.validate().during(Step::Usage)?;
    Ok(settings)
}

/// Whether what was found to be a label map is one: who asks for data to be interpolated gets names interpolated.
pub(crate) fn keeps_names(args: &MethodArgs, settings: &RenderSettings) -> bool {
    let method = &settings.method;
    let data = method.compositing() == Compositing::ImageSheets && !method.splats_colors();
    !data && args.classification != Some(ClassificationName::Post)
}

/// The settings of a preset, for a picture that shows the same as with the settings `shown`: a preset says how well, not
/// what, but for those of the papers, which are whole methods.
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

/// A paper's method, which says too what is splatted and how it is composited.
fn paper(name: PresetName) -> Option<RenderSettings> {
    match name {
        PresetName::Best | PresetName::Balanced | PresetName::Fast => None,
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

fn filter(args: &MethodArgs, old: Filter) -> Result<Filter, Failure> {
    let width = match old {
        Filter::None | Filter::Swan | Filter::SwanAlpha => Filter::default().pixel_sigma(),
        Filter::Ewa { pixel_sigma } | Filter::Matched { pixel_sigma } => pixel_sigma,
    };
    match (args.filter, args.pixel_sigma) {
        (Some(FilterName::None), Some(_)) => {
            Err(Failure::usage("--pixel-sigma has no meaning with --filter none"))
        }
        (Some(FilterName::Swan | FilterName::SwanAlpha), Some(_)) => Err(Failure::usage(
            "--pixel-sigma has no meaning with --filter swan: footprints grow until voxels are a pixel apart",
        )),
        (Some(FilterName::Swan), None) => Ok(Filter::Swan),
        (Some(FilterName::SwanAlpha), None) => Ok(Filter::SwanAlpha),
        (Some(FilterName::None), None) => Ok(Filter::None),
        (Some(FilterName::Ewa), Some(pixel_sigma)) => Ok(Filter::Ewa { pixel_sigma }),
        (Some(FilterName::Matched), Some(pixel_sigma)) => Ok(Filter::Matched { pixel_sigma }),
        (Some(FilterName::Ewa), None) => Ok(Filter::Ewa { pixel_sigma: width }),
        (Some(FilterName::Matched), None) => Ok(Filter::Matched { pixel_sigma: width }),
        (None, Some(pixel_sigma)) => Ok(match old {
            Filter::Matched { .. } => Filter::Matched { pixel_sigma },
            _ => Filter::Ewa { pixel_sigma },
        }),
        (None, None) => Ok(old),
    }
}

fn coverage(args: &MethodArgs, old: Coverage) -> Result<Coverage, Failure> {
    let named = match (args.coverage, old) {
        (Some(CoverageName::Off), _) => Coverage::Off,
        (Some(CoverageName::Adaptive), Coverage::Off) => Coverage::ADAPTIVE,
        _ => old,
    };
    match (named, args.coverage_samples) {
        (Coverage::Adaptive { contrast, .. }, Some(samples)) => Ok(Coverage::Adaptive { samples, contrast }),
        (Coverage::Off, Some(_)) => Err(Failure::usage("--coverage-samples needs --coverage adaptive")),
        (named, None) => Ok(named),
    }
}

/// Asking for any property of the light turns it on.
fn lighting(args: &MethodArgs, old: Option<Lighting>) -> Option<Lighting> {
    if args.no_shade {
        return None;
    }
    let numbers = [
        args.ambient,
        args.diffuse,
        args.specular,
        args.specular_power,
        args.gradient_floor,
    ];
    let asked = args.shade || args.light.is_some() || numbers.iter().any(Option::is_some);
    let mut lighting = old.or(asked.then(Lighting::default))?;
    set(&mut lighting.ambient, args.ambient);
    set(&mut lighting.diffuse, args.diffuse);
    set(&mut lighting.specular, args.specular);
    set(&mut lighting.specular_power, args.specular_power);
    set(&mut lighting.gradient_floor, args.gradient_floor);
    set(&mut lighting.direction, args.light);
    Some(lighting)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::KernelArgs;

    fn resolve(args: &MethodArgs, like: Option<&FlatSettings>, wishes: Wishes) -> FlatSettings {
        super::resolve(args, None, like, wishes).unwrap().into()
    }

    #[test]
    fn flags_beat_the_earlier_picture_which_beats_defaults() {
        let like = FlatSettings {
            lighting: None,
            filter: Filter::None,
            sheet_thickness: 1.0,
            ..FlatSettings::default()
        };
        let resolve = |args: &MethodArgs| resolve(args, Some(&like), Wishes::default());
        assert_eq!(resolve(&MethodArgs::default()), like);
        let lit = resolve(&MethodArgs {
            ambient: Some(0.5),
            ..MethodArgs::default()
        });
        assert_eq!(lit.lighting.unwrap().ambient, 0.5);
        assert_eq!(lit.sheet_thickness, 1.0);
        let filtered = resolve(&MethodArgs {
            filter: Some(FilterName::Ewa),
            ..MethodArgs::default()
        });
        assert_eq!(filtered.filter, Filter::default());
    }

    #[test]
    fn a_preset_beats_the_earlier_picture_and_loses_to_flags() {
        let like = FlatSettings {
            lighting: None,
            sheet_thickness: 3.0,
            prefilter: false,
            ..FlatSettings::default()
        };
        let args = MethodArgs {
            preset: Some(PresetName::Fast),
            filter: Some(FilterName::None),
            kernel: KernelArgs {
                kernel_sigma: Some(0.7),
                ..KernelArgs::default()
            },
            ..MethodArgs::default()
        };
        let settings = resolve(&args, Some(&like), Wishes::default());
        let fast = preset(PresetName::Fast, &like);
        assert_eq!(settings.sheet_thickness, fast.sheet_thickness);
        assert_eq!(settings.filter, Filter::None);
        // What is shown stays the picture's.
        assert_eq!((settings.prefilter, settings.lighting), (true, None));
        let sigma = |settings: FlatSettings| settings.kernel.gaussian().unwrap().0;
        assert!(sigma(settings) == 0.7 && sigma(fast) != 0.7);
        let args = MethodArgs {
            preset: Some(PresetName::Best),
            ..MethodArgs::default()
        };
        let settings = resolve(&args, Some(&like), Wishes::default());
        assert_eq!(
            settings,
            FlatSettings {
                lighting: None,
                ..RenderSettings::best().into()
            }
        );
    }

    #[test]
    fn a_wider_kernel_keeps_its_cut_off_in_sigmas() {
        let args = MethodArgs {
            kernel: KernelArgs {
                kernel_sigma: Some(1.4),
                ..KernelArgs::default()
            },
            no_prefilter: true,
            ..MethodArgs::default()
        };
        let settings = resolve(&args, None, Wishes::default());
        let (sigma, radius) = settings.kernel.gaussian().unwrap();
        let (default_sigma, default_radius) = FlatSettings::default().kernel.gaussian().unwrap();
        assert_eq!(sigma, 1.4);
        assert!((radius / sigma - default_radius / default_sigma).abs() < 1e-12);
        assert!(!settings.prefilter);
    }

    #[test]
    fn labels_are_classified_first_unless_told_otherwise() {
        let wishes = Wishes {
            classification: Some(Classification::Pre),
            ..Wishes::default()
        };
        let pre = resolve(&MethodArgs::default(), None, wishes);
        assert_eq!(pre.classification, Classification::Pre);
        let args = MethodArgs {
            classification: Some(ClassificationName::Post),
            ..MethodArgs::default()
        };
        let post = resolve(&args, None, wishes);
        assert_eq!(post.classification, Classification::Post);
    }

    #[test]
    fn presets_light_meshes_by_differences_and_flags_say_otherwise() {
        let wishes = Wishes {
            differences: true,
            ..Wishes::default()
        };
        let best = MethodArgs {
            preset: Some(PresetName::Best),
            ..MethodArgs::default()
        };
        let settings = resolve(&best, None, wishes);
        assert_eq!(settings.gradient, Gradient::Differences);
        assert_eq!(settings.kernel, RenderSettings::best().method.kernel());
        let asked = MethodArgs {
            gradient: Some(GradientName::Analytic),
            ..best
        };
        let settings = resolve(&asked, None, wishes);
        assert_eq!(settings.gradient, Gradient::Analytic);
    }

    #[test]
    fn photographs_are_unlit_unless_light_is_asked_for() {
        let wishes = Wishes {
            unlit: true,
            ..Wishes::default()
        };
        let plain = resolve(&MethodArgs::default(), None, wishes);
        assert_eq!(plain.lighting, None);
        let args = MethodArgs {
            gradient_floor: Some(0.25),
            ..MethodArgs::default()
        };
        let lit = resolve(&args, None, wishes).lighting.unwrap();
        assert_eq!(
            (lit.gradient_floor, lit.ambient),
            (0.25, Lighting::default().ambient)
        );
    }
}
