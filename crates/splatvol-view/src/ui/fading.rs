//! Opacity by gradient by hand: a curve of factors over the gradients of the data.

use eframe::egui::{RichText, Ui};
use splatvol::SceneError;

use super::curve::{self, CurveState, Names};
use super::regions::RegionsState;
use crate::model::shown_volume::ShownVolume;
use crate::model::{Model, fading};

/// What its points are called.
const NAMES: Names = Names {
    value: "Gradient",
    opacity: "Factor",
    point: "gradient point",
};

/// Shows the curve of the selected volume, and takes edits of it. `histogram` counts its gradients.
pub(super) fn show(
    ui: &mut Ui,
    (model, selected): (&mut Model, usize),
    (state, histogram): (&mut CurveState, &mut RegionsState),
) {
    let Some(gradients) = histogram.gradients(ui.ctx(), ShownVolume::of(model, selected)) else {
        ui.label("The selected item is no volume that is shown.");
        return;
    };
    let values = fading::magnitudes(gradients);
    let points = model.document().effects.gradient_opacity.clone();
    let mut fades = points.is_some();
    let label = ui.checkbox(&mut fades, "Fade by gradient").on_hover_text(
        "opacities are multiplied by a factor of the gradient: what is flat fades, boundaries stay",
    );
    if label.changed() {
        let mut document = model.document().clone();
        document.effects.gradient_opacity = fades.then(|| fading::begun(values.range[1]));
        model.change(document);
    }
    let Some(points) = points else {
        return;
    };
    let mut changed = None;
    match fading::curve(&points) {
        Ok(function) => {
            let shown = (&function, Some(&values));
            curve::plot(ui, shown, NAMES, (state, &mut changed));
            ui.label(
                RichText::new("gradients in data units per world length")
                    .small()
                    .weak(),
            );
            curve::table(ui, &function, NAMES, (state, &mut changed));
        }
        Err(error) => changed = Some(Err(error)),
    }
    match changed.map(|changed| changed.map(|curve| fading::points(&curve))) {
        Some(Ok(edited)) if edited != points => {
            model.gesture(|session| session.adjust_gradient_opacity(&edited));
        }
        Some(Err(error)) => model.say(SceneError::to_string(&error), true),
        _ => {}
    }
}
