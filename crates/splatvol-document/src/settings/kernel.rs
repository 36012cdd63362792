//! The reconstruction kernel.

use splatvol_scene::{Kernel, RenderSettings};

use crate::DocumentError;
use crate::keys::SettingKeys;
use crate::keys::names::KernelName;

/// The kernel of the keys over another one, which counts if it has the same name.
pub fn resolve(keys: &SettingKeys, old: Kernel) -> Result<Kernel, DocumentError> {
    match (keys.kernel, old) {
        (Some(KernelName::Gaussian), _) => gaussian(keys, old),
        (Some(KernelName::CrawfisMax), _) => fixed(keys, Kernel::CrawfisMax),
        (Some(KernelName::CubicBspline), _) => fixed(keys, Kernel::CubicBspline),
        (Some(KernelName::KaiserBessel), _) => kaiser_bessel(keys, old),
        (None, Kernel::Gaussian { .. }) => gaussian(keys, old),
        (None, Kernel::CrawfisMax | Kernel::CubicBspline) => fixed(keys, old),
        (None, Kernel::KaiserBessel { .. }) => kaiser_bessel(keys, old),
    }
}

/// A kernel of another sigma keeps its cut-off in sigmas.
fn gaussian(keys: &SettingKeys, old: Kernel) -> Result<Kernel, DocumentError> {
    refuse(
        "settings.kernel-alpha",
        keys.kernel_alpha,
        "the gaussian kernel, whose shape is `settings.kernel-sigma`",
    )?;
    let usual = || RenderSettings::default().method.kernel().gaussian();
    let old = old.gaussian().or_else(usual);
    let (old_sigma, old_radius) = old.ok_or_else(|| DocumentError::usage("no gaussian kernel is known"))?;
    let sigma = keys.kernel_sigma.unwrap_or(old_sigma);
    let scaled = keys
        .kernel_sigma
        .map_or(old_radius, |sigma| old_radius / old_sigma * sigma);
    let radius = keys.kernel_radius.unwrap_or(scaled);
    Ok(Kernel::Gaussian { sigma, radius })
}

/// A kernel of another radius has the shape with the least ripple at that radius, unless told otherwise.
fn kaiser_bessel(keys: &SettingKeys, old: Kernel) -> Result<Kernel, DocumentError> {
    refuse(
        "settings.kernel-sigma",
        keys.kernel_sigma,
        "the kaiser-bessel kernel, whose shape is `settings.kernel-radius` and `settings.kernel-alpha`",
    )?;
    let start = match (keys.kernel_radius, old) {
        (Some(radius), _) => Kernel::kaiser_bessel(radius),
        (None, Kernel::KaiserBessel { .. }) => old,
        (None, _) => Kernel::KAISER_BESSEL,
    };
    Ok(match (start, keys.kernel_alpha) {
        (Kernel::KaiserBessel { radius, .. }, Some(alpha)) => Kernel::KaiserBessel { radius, alpha },
        (start, _) => start,
    })
}

fn fixed(keys: &SettingKeys, kernel: Kernel) -> Result<Kernel, DocumentError> {
    let kind = format!("the {} kernel, whose shape is fixed", kernel.name());
    refuse("settings.kernel-sigma", keys.kernel_sigma, &kind)?;
    refuse("settings.kernel-radius", keys.kernel_radius, &kind)?;
    refuse("settings.kernel-alpha", keys.kernel_alpha, &kind)?;
    Ok(kernel)
}

fn refuse(key: &str, value: Option<f64>, kind: &str) -> Result<(), DocumentError> {
    match value {
        Some(_) => Err(DocumentError::refused(key, format!("has no meaning with {kind}"))),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_earlier_kernel_counts_where_it_is_of_the_same_name() {
        let wide = Kernel::KaiserBessel {
            radius: 3.0,
            alpha: 5.0,
        };
        let args = SettingKeys::default();
        for old in [Kernel::default(), wide, Kernel::CubicBspline] {
            assert_eq!(resolve(&args, old).unwrap(), old);
        }
        let named = |kernel| SettingKeys {
            kernel: Some(kernel),
            ..args.clone()
        };
        assert_eq!(resolve(&named(KernelName::KaiserBessel), wide).unwrap(), wide);
        let fresh = resolve(&named(KernelName::KaiserBessel), Kernel::CrawfisMax);
        assert_eq!(fresh.unwrap(), Kernel::KAISER_BESSEL);
        let usual = resolve(&named(KernelName::Gaussian), wide);
        assert_eq!(usual.unwrap(), RenderSettings::default().method.kernel());
    }

    #[test]
    fn another_radius_brings_its_shape_unless_told_otherwise() {
        let args = SettingKeys {
            kernel: Some(KernelName::KaiserBessel),
            kernel_radius: Some(2.5),
            ..SettingKeys::default()
        };
        assert_eq!(
            resolve(&args, Kernel::default()).unwrap(),
            Kernel::kaiser_bessel(2.5)
        );
        let told = SettingKeys {
            kernel_alpha: Some(3.0),
            ..args.clone()
        };
        let expected = Kernel::KaiserBessel {
            radius: 2.5,
            alpha: 3.0,
        };
        assert_eq!(resolve(&told, Kernel::default()).unwrap(), expected);
    }
}
