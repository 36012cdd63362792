//! Profiles: line integrals of the kernel, and the rasterisers' lookup tables of these, kept between frames.

use splatvol_core::splats::{GaussianProfile, KernelShape, RadialProfile};
use splatvol_scene::{
    Kernel, KernelEdge, Rasterizer, Reconstruction, RenderSettings, SceneError, SplatSettings, TableLayout,
};

use super::raster::Tables;

/// Footprints of a kernel, by the way they are evaluated.
#[derive(Debug, Clone, Copy)]
pub(crate) enum FootprintProfile<'a> {
    /// A Gaussian, without tables.
    Gaussian(&'a GaussianProfile),
    /// Any radial kernel, looked up by a rasteriser if there are tables, otherwise interpolated.
    Radial(&'a RadialProfile, Option<&'a Tables>),
}

#[derive(Debug)]
enum Prepared {
    Gaussian(GaussianProfile),
    Radial(RadialProfile, Option<Tables>),
}

type Key = (Kernel, KernelEdge, Rasterizer, TableLayout);

/// The last frame's kernel.
#[derive(Debug)]
pub(crate) struct ProfileStore {
    key: Key,
    prepared: Prepared,
}

impl Default for ProfileStore {
    fn default() -> Self {
        let kernel = Kernel::default();
        let (sigma, radius) = kernel.gaussian().unwrap_or((1.0, 4.0));
        Self {
            key: (
                kernel,
                KernelEdge::default(),
                Rasterizer::Auto,
                TableLayout::default(),
            ),
            prepared: Prepared::Gaussian(GaussianProfile::new(radius / sigma)),
        }
    }
}

impl ProfileStore {
    /// Prepares the profile and tables for the settings, unless they are cached.
    ///
    /// # Errors
    /// Kernel or table outside their domain.
    pub(crate) fn prepare(&mut self, settings: &RenderSettings<SplatSettings>) -> Result<(), SceneError> {
        let key = (
            settings.method.kernel,
            settings.method.kernel_edge,
            settings.method.rasterizer,
            settings.method.table,
        );
        if self.key == key {
            return Ok(());
        }
        self.prepared = match (settings.method.kernel.gaussian(), settings.method.rasterizer) {
            (Some((sigma, radius)), Rasterizer::Auto) => {
                Prepared::Gaussian(match settings.method.kernel_edge {
                    KernelEdge::Smooth => GaussianProfile::new(radius / sigma),
                    KernelEdge::Raw => GaussianProfile::raw(radius / sigma),
                })
            }
            (_, rasterizer) => Prepared::Radial(
                RadialProfile::new(settings.method.kernel),
                Tables::new((rasterizer, settings.method.table), settings.method.kernel)?,
            ),
        };
        self.key = key;
        Ok(())
    }

    /// The prepared footprints.
    pub(crate) fn footprints(&self) -> FootprintProfile<'_> {
        match &self.prepared {
            Prepared::Gaussian(profile) => FootprintProfile::Gaussian(profile),
            Prepared::Radial(profile, tables) => FootprintProfile::Radial(profile, tables.as_ref()),
        }
    }

    /// Covariances of the splats, from the kernel's second moment. A Gaussian without tables has its nominal sigma,
    /// since its cut is smooth.
    pub(crate) fn shape(&self, settings: &RenderSettings<SplatSettings>) -> KernelShape {
        let sigma = match (&self.prepared, self.key.0.gaussian()) {
            (Prepared::Gaussian(_), Some((sigma, _))) => sigma,
            (Prepared::Radial(profile, _), _) => profile.sigma(),
            (Prepared::Gaussian(_), None) => 1.0,
        };
        match settings.method.reconstruction {
            Reconstruction::Volume => KernelShape::Sphere { sigma },
            Reconstruction::Surface { flatness } => KernelShape::Flattened {
                sigma,
                flatness,
                threshold: 0.0,
            },
            Reconstruction::Mixed { flatness, gradient } => KernelShape::Flattened {
                sigma,
                flatness,
                threshold: gradient,
            },
        }
    }
}
