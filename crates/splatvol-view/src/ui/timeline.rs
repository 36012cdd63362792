//! The animation: key frames of the camera, their pace, and a preview of the way between them.

use eframe::egui::{CollapsingHeader, DragValue, Slider, Ui};
use splatvol::{Camera, MotionBlur};
use splatvol_document::Plan;
use splatvol_document::animation::FRAMES;
use splatvol_document::keys::{AnimationKeys, CameraFrame};

use crate::model::Model;

/// Frames at most that the panel offers.
const MOST_FRAMES: u32 = 100_000;

/// Where the preview is.
#[derive(Debug, Default)]
pub(super) struct Timeline {
    /// The way through the key frames, and the keys of which it was made.
    planned: Option<(AnimationKeys, Planned)>,
    frame: u32,
    /// The window's time and the frame at which the preview was started, while it runs.
    playing: Option<(f64, u32)>,
}

/// A way; `None` where there are too few key frames, or why there is none.
type Planned = Result<Option<Plan>, String>;

impl Timeline {
    /// Whether the preview runs: it is one step of the history.
    pub(super) fn is_playing(&self) -> bool {
        self.playing.is_some()
    }

    /// Stops the preview.
    pub(super) fn stop(&mut self) {
        self.playing = None;
    }

    pub(super) fn show(&mut self, ui: &mut Ui, model: &mut Model) {
        let opened = CollapsingHeader::new("Animation").show(ui, |ui| {
            let Some(camera) = model.session().camera() else {
                return;
            };
            let old = model.document().animation.clone();
            let mut new = old.clone();
            match &old.path {
                Some(path) => {
                    ui.label(format!("The key frames are those of {path}."));
                }
                None => key_frames(ui, model, (&mut new, &camera)),
            }
            let planned = self.plan(&old, &camera);
            let frames = planned.as_ref().ok().and_then(Option::as_ref).map(Plan::frames);
            pace(ui, &mut new, frames.unwrap_or(FRAMES));
            if new != old {
                model.gesture(|session| session.adjust_animation(&new));
            }
            match &planned {
                Ok(Some(plan)) => self.preview(ui, model, (plan, old.rate())),
                Ok(None) => {
                    ui.label("Two views or more make a way.");
                }
                Err(error) => {
                    ui.label(error);
                }
            }
            ui.label("Save the scene as SCENE.toml; splatvol animate SCENE.toml makes the film.");
        });
        if opened.fully_closed() {
            self.stop();
        }
    }

    /// The way through key frames, planned anew when they change: it takes as long as there are frames.
    fn plan(&mut self, keys: &AnimationKeys, camera: &Camera) -> Planned {
        match &self.planned {
            Some((of, planned)) if of == keys => planned.clone(),
            _ => {
                let planned = plan(keys, camera);
                self.planned = Some((keys.clone(), planned.clone()));
                planned
            }
        }
    }

    /// The frame that is shown, by hand or as time goes.
    fn preview(&mut self, ui: &mut Ui, model: &mut Model, (plan, rate): (&Plan, f64)) {
        let last = plan.frames().saturating_sub(1);
        let now = ui.input(|input| input.time);
        let mut frame = self.frame.min(last);
        if let Some((since, from)) = self.playing {
            frame = from.saturating_add(((now - since) * rate) as u32).min(last);
            ui.ctx().request_repaint();
        }
        ui.add(Slider::new(&mut frame, 0..=last).text("Frame"));
        ui.horizontal(|ui| match self.playing {
            None if ui.button("Play").clicked() => {
                let from = if frame == last { 0 } else { frame };
                self.playing = Some((now, from));
            }
            Some(_) if ui.button("Stop").clicked() || frame == last => self.playing = None,
            _ => {}
        });
        if frame != self.frame {
            self.frame = frame;
            match plan.camera(frame) {
                Ok(camera) => model.move_camera(|_| Ok(camera)),
                Err(error) => model.say(error.to_string(), true),
            }
        }
    }
}

/// The way through the key frames; `None` where there are too few. The preview knows no shutter.
fn plan(keys: &AnimationKeys, camera: &Camera) -> Planned {
    if keys.keys.as_ref().is_none_or(|frames| frames.len() < 2) {
        return Ok(None);
    }
    let keys = AnimationKeys {
        shutter: None,
        ..keys.clone()
    };
    Plan::new(&keys, &Default::default(), (camera, MotionBlur::None))
        .map(Some)
        .map_err(|error| error.to_string())
}

/// The key frames, and the views that become some.
fn key_frames(ui: &mut Ui, model: &mut Model, (keys, camera): (&mut AnimationKeys, &Camera)) {
    let mut frames = keys.keys.clone().unwrap_or_default();
    // Above the list, where it stays.
    if ui.button("Add this view").clicked() {
        frames.push(CameraFrame {
            // All have times, or none: a second later.
            time: frames.last().and_then(|last| last.time).map(|time| time + 1.0),
            ..camera.into()
        });
        keys.turntable = None;
    }
    let mut removed = None;
    for (index, frame) in frames.iter_mut().enumerate() {
        let number = index + 1;
        ui.horizontal(|ui| {
            if ui.button(format!("Go to key {number}")).clicked() {
                model.move_camera(|camera| frame.camera(camera));
            }
            let set = ui.small_button("Set").on_hover_text("to the present view");
            set.widget_info(|| named(format!("Set key {number} to this view")));
            if set.clicked() {
                *frame = CameraFrame {
                    time: frame.time,
                    ..camera.into()
                };
            }
            let remove = ui.small_button("Remove");
            remove.widget_info(|| named(format!("Remove key {number}")));
            if remove.clicked() {
                removed = Some(index);
            }
        });
    }
    if let Some(index) = removed {
        frames.remove(index);
    }
    keys.keys = (!frames.is_empty()).then_some(frames);
}

fn named(name: String) -> eframe::egui::WidgetInfo {
    eframe::egui::WidgetInfo::labeled(eframe::egui::Role::Button, true, name)
}

/// Number of frames, which is the planned one where the document names none, their rate, and whether the ends are gentle.
fn pace(ui: &mut Ui, keys: &mut AnimationKeys, planned: u32) {
    let mut frames = keys.frames.unwrap_or(planned);
    ui.horizontal(|ui| {
        let label = ui.label("Frames");
        let value = DragValue::new(&mut frames).range(1..=MOST_FRAMES);
        if ui.add(value).labelled_by(label.id).changed() {
            keys.frames = Some(frames);
        }
        let mut rate = keys.rate();
        let label = ui.label("per second");
        let value = DragValue::new(&mut rate).range(1.0..=240.0);
        if ui.add(value).labelled_by(label.id).changed() {
            keys.fps = Some(rate);
        }
    });
    let mut gentle = keys.ease == Some(true);
    if ui.checkbox(&mut gentle, "Start and stop gently").changed() {
        keys.ease = gentle.then_some(true);
    }
}
