//! Whether settings can be rendered.

use glam::DVec3;

use super::{
    Absorption, Alignment, Classification, Compositing, Filter, Kernel, Occlusion, Reconstruction,
    RenderSettings, SheetContent, Stretch,
};
use crate::SceneError;

impl RenderSettings {
    /// Checks every field's domain.
    ///
    /// # Errors
    /// The first field outside its domain, by name.
    pub fn validate(&self) -> Result<(), SceneError> {
        let check = |field, value: f64, range: std::ops::RangeInclusive<f64>, expected| {
            if range.contains(&value) {
                Ok(())
            } else {
                Err(SceneError::invalid(field, value, expected))
            }
        };
        check(
            "sheet thickness",
            self.sheet_thickness,
            0.01..=16.0,
            "0.01 to 16 voxels",
        )?;
        check(
            "pixel sigma",
            self.filter.pixel_sigma(),
            0.0..=16.0,
            "0 to 16 pixels",
        )?;
        if let Alignment::Auto { budget } = self.alignment {
            check("alignment budget", budget, 0.0..=1.0, "0 to 1 of a footprint's peak")?;
        }
        self.combinations()?;
        self.stretching()?;
        check("termination", self.termination, 0.0..=0.5, "0 to 0.5")?;
        let Kernel::Gaussian { sigma, radius } = self.kernel;
        check("kernel sigma", sigma, 0.3..=4.0, "0.3 to 4 voxels")?;
        check(
            "kernel radius",
            radius,
            1.5 * sigma..=8.0 * sigma,
            "1.5 to 8 sigma",
        )?;
        // Wider kernels amplify noise without bound when they are inverted.
        if self.prefilter && self.classification == Classification::Post {
            check(
                "kernel sigma",
                sigma,
                0.3..=1.2,
                "0.3 to 1.2 voxels with the prefilter",
            )?;
        }
        if let Some(light) = self.lighting {
            for (field, value) in [
                ("ambient", light.ambient),
                ("diffuse", light.diffuse),
                ("specular", light.specular),
            ] {
                check(field, value, 0.0..=10.0, "0 to 10")?;
            }
            let direction = DVec3::from_array(light.direction);
            if direction.try_normalize().is_none() || (direction.normalize() - DVec3::Z).length() < 1e-6 {
                return Err(SceneError::invalid(
                    "light direction",
                    light.direction,
                    "finite, and not from behind",
                ));
            }
            check("specular power", light.specular_power, 1.0..=1000.0, "1 to 1000")?;
            check(
                "gradient floor",
                light.gradient_floor,
                1e-6..=10.0,
                "0.000001 to 10",
            )?;
        }
        Ok(())
    }

    /// Refuses methods that make no sense together.
    fn combinations(&self) -> Result<(), SceneError> {
        let refuse =
            |field, value: &dyn std::fmt::Debug, reason| Err(SceneError::invalid(field, value, reason));
        let pre = self.classification == Classification::Pre;
        let colors = self.compositing == Compositing::Xray || pre;
        if self.compositing.needs_colors() && !pre {
            return refuse(
                "classification",
                &self.classification,
                "pre: whole footprints are composited as colours, so data must be classified before they are splatted",
            );
        }
        if self.sheet == Some(SheetContent::Sample) && colors {
            return refuse(
                "sheet",
                &SheetContent::Sample,
                "section: classified colours are integrated over a sheet's depth, or mass would be lost",
            );
        }
        if self.filter == Filter::SwanAlpha
            && !matches!(
                self.compositing,
                Compositing::PerSplat | Compositing::PerSplatBackToFront
            )
        {
            return refuse(
                "filter",
                &self.filter,
                "swan: swan-alpha lowers the opacity of single splats, which only per-splat compositing has",
            );
        }
        if self.occlusion == Occlusion::Sat
            && matches!(
                self.compositing,
                Compositing::PerSplatBackToFront | Compositing::Xray | Compositing::Mip
            )
        {
            return refuse(
                "occlusion",
                &self.occlusion,
                "none: only what is composited front to back can be hidden by what is there",
            );
        }
        match self.reconstruction {
            Reconstruction::Surface { flatness } | Reconstruction::Mixed { flatness, .. }
                if !(1.0..=1e6).contains(&flatness) =>
            {
                return refuse("flatness", &flatness, "1 to 1000000");
            }
            Reconstruction::Mixed { gradient, .. } if !(0.0..=1e3).contains(&gradient) => {
                return refuse("surface gradient", &gradient, "0 to 1000 value ranges per voxel");
            }
            Reconstruction::Surface { .. } | Reconstruction::Mixed { .. } if !colors => {
                return refuse(
                    "reconstruction",
                    &self.reconstruction,
                    "volume: flattened kernels of data do not add up to one; classify before splatting (pre)",
                );
            }
            _ => {}
        }
        let samples = !colors && self.sheet != Some(SheetContent::Section);
        if samples && self.uses_footprints() {
            return refuse(
                "sheet",
                &self.sheet,
                "section: this filter, alignment, kernel, occlusion or absorption works on footprints, which are \
                 classified first (pre) or splatted as sections of sheets",
            );
        }
        Ok(())
    }

    /// Refuses a stretch that nothing would apply.
    fn stretching(&self) -> Result<(), SceneError> {
        if self.stretch == Stretch::Box {
            return Ok(());
        }
        let reason = if !matches!(self.filter, Filter::Swan | Filter::SwanAlpha) {
            "box: only the swan filter stretches kernels"
        } else if self.alignment != Alignment::Exact {
            "box: a trapezoid has another footprint at every depth, which only exact alignment integrates"
        } else {
            return Ok(());
        };
        Err(SceneError::invalid("stretch", self.stretch, reason))
    }

    /// Whether a method is asked for that only whole or sectioned footprints have.
    fn uses_footprints(&self) -> bool {
        matches!(self.filter, Filter::Swan | Filter::SwanAlpha)
            || self.alignment != Alignment::Sheet
            || self.occlusion != Occlusion::Auto
            || self.absorption != Absorption::Exp
    }
}
