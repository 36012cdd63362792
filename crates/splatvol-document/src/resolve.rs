//! From a document to a picture that can be rendered: everything that it leaves open is decided here, for all
//! programs alike.
//!
//! Decisions are made in the order of their dependence. The items are read, and each gets the look of its keys or one
//! that its data suggest. The method follows from keys and from the wishes of the data; then come effects, camera and
//! motion.

use std::path::PathBuf;

use splatvol_scene::transfer_function::linear_from_srgb;
use splatvol_scene::{
    Camera, Classification, Compositing, Content, FlatSettings, Gradient, Image, ImageSize, RenderSettings,
    Scene, SheetSettings, Shows, TransferFunction2d, View,
};

use crate::camera::{CameraPose, Surroundings};
use crate::effects::{self, Effects};
use crate::held::Held;
use crate::input::Reading;
use crate::items::{self, Among, Loaded};
use crate::keys::names::ClassificationName;
use crate::keys::{Background, CHARCOAL, CameraKeys, EffectKeys, ItemKeys, PictureSize, SettingKeys};
use crate::look::Wishes;
use crate::motion::{self, CameraMotion, Shot};
use crate::outline::outline;
use crate::settings::written;
use crate::{Document, DocumentError, Listener};

/// Bits per channel unless asked otherwise.
const BITS: u8 = 8;

/// Everything that rendering needs, and the document that describes all of it.
#[derive(Debug, Clone)]
pub struct Picture {
    /// The document, with nothing left open.
    pub document: Document,
    /// The items, in world space.
    pub scene: Scene,
    /// Where it is seen from.
    pub camera: Camera,
    /// Cameras of the pictures of which this is the mean, if it is one.
    pub sub_frames: Vec<Camera>,
    /// How it is rendered.
    pub settings: RenderSettings,
    /// Files that it was read from.
    pub files: Vec<PathBuf>,
}

/// Circumstances in which a document is resolved.
#[derive(Clone, Copy)]
pub struct Resolving<'a> {
    /// Where and how files are read.
    pub reading: Reading<'a>,
    /// Data that need not be read, each of the item with the same number.
    pub held: &'a [Option<Held>],
    /// Motion of the camera from frame to frame.
    pub moves: CameraMotion,
    /// Whether the output keeps its alpha, whatever the background.
    pub keeps_alpha: bool,
    /// Whether it is made window by window, so that it may be larger than memory.
    pub in_windows: bool,
}

/// A picture over a background (sRGB, straight alpha), as a PNG has it.
pub fn laid_over(image: &Image, [r, g, b, a]: [f64; 4]) -> Image {
    let [r, g, b] = [r, g, b].map(|c| linear_from_srgb(c) as f32);
    image.over([r, g, b, a as f32])
}

impl Picture {
    /// Background: sRGB and straight alpha; `None` if the picture keeps its alpha.
    pub fn background(&self) -> Option<[f64; 4]> {
        self.document.background.and_then(Background::color)
    }

    /// Bits per channel.
    pub fn bits(&self) -> u8 {
        self.document.bits.unwrap_or(BITS)
    }

    /// Refuses a picture that does not fit into the memory that there is.
    ///
    /// # Errors
    /// A picture that is too large, and its size.
    pub fn check_size(&self) -> Result<(), DocumentError> {
        check_size(self.settings.size)
    }
}

/// Bytes of a pixel while a picture is made: colour and alpha, depth, optical depth, and the codes of its file.
const BYTES_PER_PIXEL: u64 = 32;

/// Refuses pictures that do not fit into the memory that there is.
fn check_size(size: ImageSize) -> Result<(), DocumentError> {
    let needed = size.pixel_count() as u64 * BYTES_PER_PIXEL;
    let granted = splatvol_io::memory::granted();
    match needed <= granted {
        true => Ok(()),
        false => Err(DocumentError::refused(
            "size",
            format!(
                "{}x{}: it takes {} MiB, and the machine grants {} MiB",
                size.width(),
                size.height(),
                needed >> 20,
                granted >> 20
            ),
        )),
    }
}

impl Document {
    /// Reads the items, and decides everything that is left open.
    ///
    /// # Errors
    /// Files that cannot be read; keys that have no meaning for the data or for each other, by name.
    pub fn resolve(&self, resolving: Resolving<'_>) -> Result<Picture, DocumentError> {
        let reading = resolving.reading;
        if let Some(bits) = self.bits.filter(|bits| ![8, 16].contains(bits)) {
            return Err(DocumentError::refused(
                "bits",
                format!("{bits}: expected 8 or 16"),
            ));
        }
        let mut loaded = self.load(resolving)?;
        let settings = self
            .settings
            .resolve(self.size.map(|size| size.0), loaded.wishes)?;
        if !resolving.in_windows {
            check_size(settings.size)?;
        }
        self.keep_names(&mut loaded, &settings);
        let mut effects = self.effects.clone();
        add_gradient_opacity(&mut effects, &mut loaded, &settings, reading.listener);
        let framed = loaded.scene.clone();
        let applied = self.effects_of(&effects, &mut loaded, reading)?;
        let plain = applied.is_empty() && loaded.scene.single_volume().is_ok();
        let mut scene = applied.apply(loaded.scene)?;
        let background = self.background.unwrap_or(Background::Color(CHARCOAL));
        if let (Background::Color([r, g, b, a]), false) = (background, resolving.keeps_alpha) {
            let [r, g, b] = [r, g, b].map(|c| linear_from_srgb(c) as f32);
            scene.background = [r, g, b, a as f32];
        }
        let mut settings = settings;
        let camera = self.framed(&framed, &settings, (resolving.moves, loaded.preferred))?;
        let shot = Shot {
            camera: &camera,
            centre: scene.bounds()?.centre(),
            plain,
            shutter: resolving.moves.shutter,
        };
        let motion = motion::resolve(&self.motion, shot, &mut settings)?;
        if let Some(motion) = motion.motion()? {
            scene = scene.with_motion(&motion);
        }
        let sub_frames = motion.sub_frames.iter().flatten().map(CameraPose::camera);
        let sub_frames: Vec<Camera> = sub_frames.collect::<Result<_, _>>()?;
        let document = Self {
            name: self.name.clone(),
            size: Some(PictureSize(settings.size)),
            background: Some(background),
            bits: Some(self.bits.unwrap_or(BITS)),
            items: loaded.keys,
            camera: CameraKeys::from(&CameraPose::from(&camera)),
            settings: recorded(&settings, loaded.wishes),
            effects,
            motion,
            ..Self::default()
        };
        Ok(Picture {
            document,
            scene,
            camera,
            sub_frames,
            settings,
            files: loaded.files,
        })
    }

    /// Reads the items that are visible.
    fn load(&self, resolving: Resolving<'_>) -> Result<All, DocumentError> {
        let visible = self.items.iter().filter(|item| item.is_visible()).count();
        let mut reading = resolving.reading;
        if let Some(chunks) = &mut reading.rules.chunks {
            chunks.memory /= visible.max(1) as u64;
        }
        let among = Among {
            compositing: self.settings.compositing(),
            alone: visible == 1,
            effects: &self.effects,
            reading,
        };
        let mut all = Vec::new();
        let mut keys = Vec::new();
        let several = self.items.len() > 1 || self.name.is_some();
        for (index, item) in self.items.iter().enumerate() {
            if !item.is_visible() {
                keys.push(item.clone());
                continue;
            }
            let held = resolving.held.get(index).and_then(Option::as_ref);
            let loaded = items::load(item, held, among).map_err(|error| match several {
                true => error.of_index(index),
                false => error,
            })?;
            keys.push(loaded.keys.clone());
            all.push(loaded);
        }
        All::of(all, keys).map_err(|error| match error {
            None => DocumentError::usage(format!("no item of {} is visible", self.reference())),
            Some(error) => error,
        })
    }

    /// Stops treating values as labels if data are to be interpolated.
    fn keep_names(&self, all: &mut All, settings: &RenderSettings) {
        let method = &settings.method;
        let is_data = method.compositing() == Compositing::ImageSheets && !method.splats_colors();
        let asked = self.settings.classification == Some(ClassificationName::Post);
        let is_data = is_data && all.scene.single_volume().is_ok();
        let visible = all.keys.iter_mut().filter(|item| item.is_visible());
        for (item, keys) in all.scene.items.iter_mut().zip(visible) {
            if let Content::Volume { labels, .. } = &mut item.content {
                *labels &= !is_data && (!asked || keys.labels == Some(true));
                keys.labels = labels.then_some(true);
            }
        }
    }

    /// The requested effects.
    fn effects_of(
        &self,
        effects: &EffectKeys,
        all: &mut All,
        reading: Reading<'_>,
    ) -> Result<Effects, DocumentError> {
        let of_both = [
            ("effects.tf2d", effects.tf2d.is_some()),
            ("effects.regions", effects.regions.is_some()),
        ];
        let asked = of_both.iter().find(|(_, asked)| *asked);
        if let Some((key, _)) = asked.filter(|_| all.tf2d.is_none()) {
            return Err(DocumentError::refused(
                key,
                "is of one volume or one mesh alone: items of scenes have the transfer functions that they say",
            ));
        }
        let first = self.items.iter().find(|item| item.is_visible());
        let first = first.cloned().unwrap_or_default();
        let bounds = all.scene.bounds()?;
        effects::resolve(effects, &first, &bounds, (all.tf2d.take(), reading))
    }

    /// The requested camera, or one that shows everything.
    fn framed(
        &self,
        scene: &Scene,
        settings: &RenderSettings,
        (moves, preferred): (CameraMotion, Option<View>),
    ) -> Result<Camera, DocumentError> {
        let fit = self.camera.fit.unwrap_or_default();
        let outlines = || scene.items.iter().flat_map(|item| outline(item, fit)).collect();
        let surroundings = Surroundings::of_outline(outlines, settings.size.aspect())
            .preferring(preferred)
            .turning(moves.turns);
        self.camera.resolve(&surroundings)
    }
}

/// The keys of known settings, without a classification that means nothing.
fn recorded(settings: &RenderSettings, wishes: Wishes) -> SettingKeys {
    let keys = written(&FlatSettings::from(*settings));
    SettingKeys {
        classification: keys.classification.filter(|_| !wishes.unclassified),
        ..keys
    }
}

/// Adds the gradient opacity of a transfer function's file if nothing else is requested and it can be shown.
fn add_gradient_opacity(
    effects: &mut EffectKeys,
    all: &mut All,
    settings: &RenderSettings,
    listener: &dyn Listener,
) {
    let Some(mut curve) = all.gradient_opacity.take() else {
        return;
    };
    // Files may list the points in any order.
    curve.sort_by(|a, b| a.gradient.total_cmp(&b.gradient));
    if effects.gradient_opacity.is_some() {
        return;
    }
    if shows_gradients(settings) && all.scene.items.len() == 1 {
        effects.gradient_opacity = Some(curve);
    } else {
        listener.warn("the transfer function's gradient opacity was left out: only post-classified image sheets of one item with gradients by differences have it");
    }
}

/// Whether sheets are classified pixel by pixel, with gradients.
fn shows_gradients(settings: &RenderSettings) -> bool {
    let is_post = |sheets: &SheetSettings| sheets.shows == Shows::Material(Classification::Post);
    let sheets = settings.method.sheets().filter(|sheets| is_post(sheets));
    sheets.is_some_and(|sheets| sheets.gradient == Gradient::Differences)
}

/// The items, and their wishes.
struct All {
    scene: Scene,
    /// Keys of all items, with what was chosen; also of those that are not visible.
    keys: Vec<ItemKeys>,
    wishes: Wishes,
    preferred: Option<View>,
    files: Vec<PathBuf>,
    gradient_opacity: Option<Vec<splatvol_scene::GradientOpacityPoint>>,
    tf2d: Option<TransferFunction2d>,
}

impl All {
    /// Collects items. A single item keeps the wishes of its data; several share one method. Fails if there is no item.
    fn of(mut loaded: Vec<Loaded>, keys: Vec<ItemKeys>) -> Result<Self, Option<DocumentError>> {
        let (mut wishes, preferred) = match &loaded[..] {
            [] => return Err(None),
            [single] => (single.wishes, single.preferred),
            _ => (Wishes::default(), None),
        };
        let gradient_opacity = loaded.iter_mut().find_map(|item| item.gradient_opacity.take());
        let tf2d = loaded.iter_mut().find_map(|item| item.tf2d.take());
        let files = loaded.iter().flat_map(|item| item.files.clone()).collect();
        let items: Vec<_> = loaded.into_iter().map(|loaded| loaded.item).collect();
        wishes.differences = items
            .iter()
            .any(|item| matches!(item.content, Content::Mesh { .. }));
        wishes.unclassified = items
            .iter()
            .all(|item| matches!(item.content, Content::Points { .. } | Content::Gaussians(_)));
        Ok(Self {
            scene: Scene::of_items(items).map_err(|error| Some(error.into()))?,
            keys,
            wishes,
            preferred,
            files,
            gradient_opacity,
            tf2d,
        })
    }
}
