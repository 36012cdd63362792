//! The reconstruction kernel.

use splatvol::{Kernel, RenderSettings};

use crate::args::{KernelArgs, KernelName};
use crate::failure::Failure;

/// The kernel of the flags over an earlier one, which counts where it is of the same name.
pub(crate) fn resolve(args: &KernelArgs, old: Kernel) -> Result<Kernel, Failure> {
    match (args.kernel, old) {
        (Some(KernelName::Gaussian), _) => gaussian(args, old),
        (Some(KernelName::CrawfisMax), _) => fixed(args, Kernel::CrawfisMax),
        (Some(KernelName::CubicBspline), _) => fixed(args, Kernel::CubicBspline),
        (Some(KernelName::KaiserBessel), _) => kaiser_bessel(args, old),
        (None, Kernel::Gaussian { .. }) => gaussian(args, old),
        (None, Kernel::CrawfisMax | Kernel::CubicBspline) => fixed(args, old),
        (None, Kernel::KaiserBessel { .. }) => kaiser_bessel(args, old),
    }
}

/// A kernel of another sigma keeps its cut-off in sigmas.
fn gaussian(args: &KernelArgs, old: Kernel) -> Result<Kernel, Failure> {
    refuse(
        "--kernel-alpha",
        args.kernel_alpha,
        "the gaussian kernel, whose shape is --kernel-sigma",
    )?;
    let usual = || RenderSettings::default().method.kernel().gaussian();
    let old = old.gaussian().or_else(usual);
    let (old_sigma, old_radius) = old.ok_or_else(|| Failure::usage("no gaussian kernel is known"))?;
    let sigma = args.kernel_sigma.unwrap_or(old_sigma);
    let scaled = args
        .kernel_sigma
        .map_or(old_radius, |sigma| old_radius / old_sigma * sigma);
    let radius = args.kernel_radius.unwrap_or(scaled);
    Ok(Kernel::Gaussian { sigma, radius })
}

/// A kernel of another radius has the shape with the least ripple at that radius, unless told otherwise.
fn kaiser_bessel(args: &KernelArgs, old: Kernel) -> Result<Kernel, Failure> {
    refuse(
        "--kernel-sigma",
        args.kernel_sigma,
        "the kaiser-bessel kernel, whose shape is --kernel-radius and --kernel-alpha",
    )?;
    let start = match (args.kernel_radius, old) {
        (Some(radius), _) => Kernel::kaiser_bessel(radius),
        (None, Kernel::KaiserBessel { .. }) => old,
        (None, _) => Kernel::KAISER_BESSEL,
    };
    Ok(match (start, args.kernel_alpha) {
        (Kernel::KaiserBessel { radius, .. }, Some(alpha)) => Kernel::KaiserBessel { radius, alpha },
        (start, _) => start,
    })
}

fn fixed(args: &KernelArgs, kernel: Kernel) -> Result<Kernel, Failure> {
    let kind = format!("the {} kernel, whose shape is fixed", kernel.name());
    refuse("--kernel-sigma", args.kernel_sigma, &kind)?;
    refuse("--kernel-radius", args.kernel_radius, &kind)?;
    refuse("--kernel-alpha", args.kernel_alpha, &kind)?;
    Ok(kernel)
}

fn refuse(flag: &str, value: Option<f64>, kind: &str) -> Result<(), Failure> {
    match value {
        Some(_) => Err(Failure::usage(format!("{flag} has no meaning with {kind}"))),
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
        let args = KernelArgs::default();
        for old in [Kernel::default(), wide, Kernel::CubicBspline] {
            assert_eq!(resolve(&args, old).unwrap(), old);
        }
        let named = |kernel| KernelArgs {
            kernel: Some(kernel),
            ..args
        };
        assert_eq!(resolve(&named(KernelName::KaiserBessel), wide).unwrap(), wide);
        let fresh = resolve(&named(KernelName::KaiserBessel), Kernel::CrawfisMax);
        assert_eq!(fresh.unwrap(), Kernel::KAISER_BESSEL);
        let usual = resolve(&named(KernelName::Gaussian), wide);
        assert_eq!(usual.unwrap(), RenderSettings::default().method.kernel());
    }

    #[test]
    fn another_radius_brings_its_shape_unless_told_otherwise() {
        let args = KernelArgs {
            kernel: Some(KernelName::KaiserBessel),
            kernel_radius: Some(2.5),
            ..KernelArgs::default()
        };
        assert_eq!(
            resolve(&args, Kernel::default()).unwrap(),
            Kernel::kaiser_bessel(2.5)
        );
        let told = KernelArgs {
            kernel_alpha: Some(3.0),
            ..args
        };
        let expected = Kernel::KaiserBessel {
            radius: 2.5,
            alpha: 3.0,
        };
        assert_eq!(resolve(&told, Kernel::default()).unwrap(), expected);
    }
}
