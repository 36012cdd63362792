//! Which methods make no sense together, and why.

use super::{
    Absorption, Alignment, Classification, Compositing, Coverage, Filter, Occlusion, Rasterizer,
    Reconstruction, RenderSettings, SheetContent, Stretch,
};
use crate::SceneError;

impl RenderSettings {
    /// Refuses methods that make no sense together.
    pub(super) fn combinations(&self) -> Result<(), SceneError> {
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
            && (self.compositing.shows_one_value()
                || matches!(
                    self.compositing,
                    Compositing::PerSplatBackToFront | Compositing::Xray
                ))
        {
            return refuse(
                "occlusion",
                &self.occlusion,
                "none: only what is composited front to back can be hidden by what is there",
            );
        }
        if self.coverage != Coverage::Off && matches!(self.compositing, Compositing::Xray | Compositing::Mean)
        {
            return refuse(
                "coverage",
                &self.coverage,
                "off: X-rays and means are sums, which the filter of footprints is right for",
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
        self.rasterizer_suits_kernels()?;
        let samples = !colors && self.sheet != Some(SheetContent::Section);
        if self.compositing.shows_one_value() && self.uses_footprints() {
            return refuse(
                "compositing",
                &self.compositing,
                "image-sheets: maxima, minima and means are of values on planes; this filter, alignment, rasterizer, \
                 occlusion, absorption or extraction works on footprints",
            );
        }
        if samples && self.uses_footprints() {
            return refuse(
                "sheet",
                &self.sheet,
                "section: this filter, alignment, rasterizer, kernel, occlusion, absorption or extraction works on \
                 footprints, which are classified first (pre) or splatted as sections of sheets",
            );
        }
        Ok(())
    }

    /// Refuses a stretch that nothing would apply.
    pub(super) fn stretching(&self) -> Result<(), SceneError> {
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

    /// Whether voxels are classified before they are splatted: colours are splatted, not data.
    pub fn splats_colors(&self) -> bool {
        match self.compositing {
            Compositing::ImageSheets => self.classification == Classification::Pre,
            shown => !shown.shows_one_value(),
        }
    }

    /// Whether a method is asked for that only whole footprints have, or sections of them.
    pub fn uses_footprints(&self) -> bool {
        matches!(self.filter, Filter::Swan | Filter::SwanAlpha)
            || self.alignment != Alignment::Sheet
            || self.occlusion != Occlusion::Auto
            || self.absorption != Absorption::Exp
            || self.rasterizer != Rasterizer::Auto
            || self.extraction.is_some()
            || self.kernel.gaussian().is_none()
    }

    /// Refuses rasterisers of circles where footprints are none, whatever the camera.
    fn rasterizer_suits_kernels(&self) -> Result<(), SceneError> {
        let flattened = self.reconstruction != Reconstruction::Volume;
        match self.rasterizer {
            Rasterizer::Square1d | Rasterizer::Rlut { .. } | Rasterizer::Blit2d { .. } if flattened => {
                Err(SceneError::invalid(
                    "rasterizer",
                    self.rasterizer.name(),
                    "ellipse-1d, linear-1d or auto: flattened kernels leave ellipses of every direction",
                ))
            }
            _ => Ok(()),
        }
    }
}
