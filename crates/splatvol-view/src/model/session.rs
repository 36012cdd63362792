//! The document that is shown, with its history. A gesture, from the press of a button to its release, is one step.

use serde::Serialize;
use serde_json::Value;
use splatvol::{Camera, GradientOpacityPoint, Projection, Region};
use splatvol_document::keys::{AnimationKeys, CameraKeys, EffectKeys, ItemKeys, Parallel};
use splatvol_document::{CameraPose, Document, DocumentError, Edit, History};

/// A document, the edits that led to it, and the gesture that is being made.
#[derive(Debug, Clone, Default)]
pub struct Session {
    history: History,
    in_gesture: bool,
    revision: u64,
}

impl Session {
    /// A document that nobody has edited.
    pub fn new(document: Document) -> Self {
        Self {
            history: History::new(document),
            ..Self::default()
        }
    }

    /// Another document in place of an earlier session's, whose numbers of changes are not used again.
    pub(super) fn continuing(document: Document, earlier: &Self) -> Self {
        Self {
            revision: earlier.revision + 1,
            ..Self::new(document)
        }
    }

    /// The document as it is.
    pub fn document(&self) -> &Document {
        self.history.document()
    }

    /// Number of changes so far: equal numbers, equal documents.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Whether there is a step to undo.
    pub fn can_undo(&self) -> bool {
        self.history.can_undo()
    }

    /// Whether there is a step to repeat.
    pub fn can_redo(&self) -> bool {
        self.history.can_redo()
    }

    /// Makes an edit that is a step of its own.
    ///
    /// # Errors
    /// See [`History::edit`].
    pub fn edit(&mut self, edit: Edit) -> Result<(), DocumentError> {
        self.end_gesture();
        self.history.edit(edit)?;
        self.revision += 1;
        Ok(())
    }

    /// Makes an edit as a part of the gesture that is being made, or begins one: all edits of one key in a gesture are
    /// undone at once.
    ///
    /// # Errors
    /// See [`History::edit`].
    pub fn adjust(&mut self, edit: Edit) -> Result<(), DocumentError> {
        match self.in_gesture {
            true => self.history.edit_on(edit)?,
            false => self.history.edit(edit)?,
        }
        self.in_gesture = true;
        self.revision += 1;
        Ok(())
    }

    /// Ends the gesture: what follows is another step.
    pub fn end_gesture(&mut self) {
        self.in_gesture = false;
    }

    /// Undoes a step; returns whether there was one.
    ///
    /// # Errors
    /// See [`History::undo`].
    pub fn undo(&mut self) -> Result<bool, DocumentError> {
        self.end_gesture();
        self.revision += 1;
        self.history.undo()
    }

    /// Repeats the step that was undone last; returns whether there was one.
    ///
    /// # Errors
    /// See [`History::redo`].
    pub fn redo(&mut self) -> Result<bool, DocumentError> {
        self.end_gesture();
        self.revision += 1;
        self.history.redo()
    }

    /// The camera, if the document places it, as resolved documents do.
    pub fn camera(&self) -> Option<Camera> {
        placed(&self.document().camera)
    }

    /// Places the camera, as a part of a gesture.
    ///
    /// # Errors
    /// See [`History::edit`].
    pub fn place_camera(&mut self, camera: &Camera) -> Result<(), DocumentError> {
        self.adjust(camera_edit(camera)?)
    }

    /// Changes keys of an item, as a part of a gesture.
    ///
    /// # Errors
    /// See [`History::edit`]; items that are not there.
    pub fn adjust_item(
        &mut self,
        index: usize,
        key: &str,
        value: &impl Serialize,
    ) -> Result<(), DocumentError> {
        self.adjust(Edit::set(format!("item[{index}].{key}"), json(value)?))
    }

    /// Changes clips and effects, as a part of a gesture.
    ///
    /// # Errors
    /// See [`History::edit`].
    pub fn adjust_effects(&mut self, effects: &EffectKeys) -> Result<(), DocumentError> {
        self.adjust(table("effects", effects.is_empty(), effects)?)
    }

    /// Changes the transfer function of values and gradients, as a part of a gesture.
    ///
    /// # Errors
    /// See [`History::edit`].
    pub fn adjust_regions(&mut self, regions: &[Region]) -> Result<(), DocumentError> {
        self.adjust(Edit::set("effects.regions", json(&regions)?))
    }

    /// Changes the curve of opacity by gradient, as a part of a gesture.
    ///
    /// # Errors
    /// See [`History::edit`].
    pub fn adjust_gradient_opacity(&mut self, points: &[GradientOpacityPoint]) -> Result<(), DocumentError> {
        self.adjust(Edit::set("effects.gradient-opacity", json(&points)?))
    }

    /// Changes the animation, as a part of a gesture.
    ///
    /// # Errors
    /// See [`History::edit`].
    pub fn adjust_animation(&mut self, animation: &AnimationKeys) -> Result<(), DocumentError> {
        self.adjust(table("animation", animation.is_empty(), animation)?)
    }

    /// The items.
    pub fn items(&self) -> &[ItemKeys] {
        &self.document().items
    }
}

/// A camera that is placed by its keys and nothing else.
pub fn placed(keys: &CameraKeys) -> Option<Camera> {
    let projection = match (keys.fov, keys.orthographic) {
        (Some(fov_degrees), None) => Projection::Perspective { fov_degrees },
        (None, Some(Parallel::Height(height))) => Projection::Orthographic { height },
        _ => return None,
    };
    let pose = CameraPose {
        position: keys.position?,
        target: keys.target?,
        up: keys.up?,
        projection,
    };
    let moved = keys.azimuth.is_some() || keys.elevation.is_some() || keys.zoom.is_some();
    pose.camera().ok().filter(|_| !moved)
}

/// The edit that places a camera.
fn camera_edit(camera: &Camera) -> Result<Edit, DocumentError> {
    Ok(Edit::set(
        "camera",
        json(&CameraKeys::from(&CameraPose::from(camera)))?,
    ))
}

/// The edit that sets a table, or takes an empty one away.
fn table(name: &str, is_empty: bool, value: &impl Serialize) -> Result<Edit, DocumentError> {
    Ok(match is_empty {
        true => Edit::unset(name),
        false => Edit::set(name, json(value)?),
    })
}

/// A value as edits have it.
fn json(value: &impl Serialize) -> Result<Value, DocumentError> {
    serde_json::to_value(value)
        .map_err(|error| DocumentError::usage(format!("the value is no JSON: {error}")))
}
