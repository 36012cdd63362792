//! Keys over keys, and keys to settings.

use splatvol_scene::Classification;

use super::*;
use crate::keys::names::{ClassificationName, GradientName};

fn resolve(keys: &SettingKeys, below: Option<&FlatSettings>, wishes: Wishes) -> FlatSettings {
    let below = below.map(written).unwrap_or_default();
    let size = Some(FlatSettings::default().size);
    keys.clone().over(&below).resolve(size, wishes).unwrap().into()
}

#[test]
fn flags_beat_the_earlier_picture_which_beats_defaults() {
    let like = FlatSettings {
        lighting: None,
        filter: Filter::None,
        sheet_thickness: 1.0,
        ..FlatSettings::default()
    };
    let resolve = |keys: &SettingKeys| resolve(keys, Some(&like), Wishes::default());
    assert_eq!(resolve(&SettingKeys::default()), like);
    let lit = resolve(&SettingKeys {
        ambient: Some(0.5),
        ..SettingKeys::default()
    });
    assert_eq!(lit.lighting.unwrap().ambient, 0.5);
    assert_eq!(lit.sheet_thickness, 1.0);
    let filtered = resolve(&SettingKeys {
        filter: Some(FilterName::Ewa),
        ..SettingKeys::default()
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
    let args = SettingKeys {
        preset: Some(PresetName::Fast),
        filter: Some(FilterName::None),
        kernel_sigma: Some(0.7),
        ..SettingKeys::default()
    };
    let settings = resolve(&args, Some(&like), Wishes::default());
    let fast = preset(PresetName::Fast, &like);
    assert_eq!(settings.sheet_thickness, fast.sheet_thickness);
    assert_eq!(settings.filter, Filter::None);
    // The kind of picture stays as it was.
    assert_eq!((settings.prefilter, settings.lighting), (true, None));
    let sigma = |settings: FlatSettings| settings.kernel.gaussian().unwrap().0;
    assert!(sigma(settings) == 0.7 && sigma(fast) != 0.7);
    let args = SettingKeys {
        preset: Some(PresetName::Best),
        ..SettingKeys::default()
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
    let args = SettingKeys {
        kernel_sigma: Some(1.4),
        prefilter: Some(false),
        ..SettingKeys::default()
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
    let pre = resolve(&SettingKeys::default(), None, wishes);
    assert_eq!(pre.classification, Classification::Pre);
    let args = SettingKeys {
        classification: Some(ClassificationName::Post),
        ..SettingKeys::default()
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
    let best = SettingKeys {
        preset: Some(PresetName::Best),
        ..SettingKeys::default()
    };
    let settings = resolve(&best, None, wishes);
    assert_eq!(settings.gradient, Gradient::Differences);
    assert_eq!(settings.kernel, RenderSettings::best().method.kernel());
    let asked = SettingKeys {
        gradient: Some(GradientName::Analytic),
        ..best.clone()
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
    let plain = resolve(&SettingKeys::default(), None, wishes);
    assert_eq!(plain.lighting, None);
    let args = SettingKeys {
        gradient_floor: Some(0.25),
        ..SettingKeys::default()
    };
    let lit = resolve(&args, None, wishes).lighting.unwrap();
    assert_eq!(
        (lit.gradient_floor, lit.ambient),
        (0.25, Lighting::default().ambient)
    );
}

#[test]
fn keys_of_random_settings_lead_back_to_them() {
    use proptest::prelude::*;
    let config = ProptestConfig::with_cases(2000);
    proptest!(config, |(thickness in 0.1..3.0f64, sigma in 0.3..2.0f64, name in 0..8usize, samples in 2..9u32, light: bool)| {
        let presets = [
            RenderSettings::best(),
            RenderSettings::balanced(),
            RenderSettings::fast(),
            RenderSettings::draft(),
            RenderSettings::swan1997(),
            RenderSettings::mueller1998(),
            RenderSettings::ewa2001(),
            RenderSettings::fastsplats2000(),
        ];
        let mut flat = FlatSettings::from(presets[name]);
        flat.motion_blur = Default::default();
        flat.sheet_thickness = thickness;
        flat.coverage = Coverage::Adaptive { samples, contrast: 0.01 * thickness };
        flat.lighting = light.then_some(Lighting { ambient: sigma / 3.0, ..Lighting::default() });
        if let Filter::Ewa { .. } | Filter::Matched { .. } = flat.filter {
            flat.filter = Filter::Matched { pixel_sigma: sigma };
        }
        let Ok(settings) = RenderSettings::try_from(flat) else { return Ok(()) };
        prop_assume!(settings.validate().is_ok());
        let flat = FlatSettings::from(settings);
        let again = written(&flat).resolve(Some(flat.size), Wishes::default()).unwrap();
        prop_assert_eq!(again, settings);
    });
}
