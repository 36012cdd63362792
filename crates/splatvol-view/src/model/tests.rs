//! The model without a window: edits and their undoing, drafts and final pictures, saved bytes.

mod chunks;
mod faults;

use std::ffi::OsString;
use std::fs;
use std::path::Path;
use std::time::Instant;

use splatvol::{ColorMap, EngineConfig, Renderer};
use splatvol_document::keys::names::{PresetName, ViewName};
use splatvol_document::{Reading, Resolving, Silent};

use super::*;

const PANE: [u32; 2] = [120, 90];
/// Longer than any machine takes.
const PATIENCE: Duration = Duration::from_secs(120);

fn model(files: &[&str]) -> Model {
    let start = Start {
        files: files.iter().map(|&file| file.to_owned()).collect(),
        command: "splatvol view".to_owned(),
        ..Start::default()
    };
    Model::new(start, Arc::new(|| {})).unwrap()
}

/// Ticks until something holds.
fn wait(model: &mut Model, what: &str, mut done: impl FnMut(&Model) -> bool) {
    let start = Instant::now();
    loop {
        model.tick(PANE);
        if done(model) {
            return;
        }
        assert!(start.elapsed() < PATIENCE, "{what}: {:?}", model.message());
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn opened(files: &[&str]) -> Model {
    let mut model = model(files);
    wait(&mut model, "the first picture", Model::is_final);
    model
}

/// What `render` makes of a document.
fn rendered(document: &Document) -> Vec<[u8; 4]> {
    let document = Document {
        size: document
            .size
            .or(Some(PictureSize(ImageSize::new(PANE[0], PANE[1]).unwrap()))),
        ..document.clone()
    };
    let reading = Reading {
        rules: ReadRules::default(),
        folder: None,
        listener: &Silent,
    };
    let resolving = Resolving {
        reading,
        held: &[],
        moves: splatvol_document::CameraMotion::default(),
        keeps_alpha: false,
        in_windows: false,
    };
    let picture = document.resolve(resolving).unwrap();
    let mut renderer = Renderer::new(EngineConfig::default()).unwrap();
    let frame = renderer
        .render(&picture.scene, &picture.camera, &picture.settings)
        .unwrap();
    let background = picture.background().unwrap();
    splatvol_io::image::png::srgb8(&splatvol_document::resolve::laid_over(&frame.image, background))
}

#[test]
fn a_drag_shows_drafts_and_at_rest_what_render_makes() {
    let mut model = opened(&["sample:head:24"]);
    assert_eq!(model.shown().unwrap().codes, rendered(model.document()));
    let mut drafts = 0;
    for _ in 0..5 {
        model.move_camera(|camera| navigate::orbit(camera, 10.0, 3.0));
        let before = model.pictures();
        wait(&mut model, "a draft", |model| model.pictures() > before);
        drafts += usize::from(model.shown().unwrap().draft_step.is_some());
    }
    assert!(drafts > 0);
    wait(&mut model, "the picture at rest", Model::is_final);
    assert_eq!(model.shown().unwrap().codes, rendered(model.document()));
    // The drag was one step.
    model.end_gesture();
    model.undo();
    assert!(!model.session().can_undo());
}

#[test]
fn views_and_settings_are_steps_that_leave_nothing_open() {
    let mut model = opened(&["sample:head:24"]);
    let start = model.document().clone();
    model.change_camera(CameraKeys {
        view: Some(ViewName::Left),
        ..CameraKeys::default()
    });
    wait(&mut model, "the view", |model| model.session().can_undo());
    assert!(model.session().camera().unwrap().position().x < 0.0);
    model.change_settings(SettingKeys {
        preset: Some(PresetName::Fast),
        ..SettingKeys::default()
    });
    wait(&mut model, "the preset", |model| model.asked_since().is_none());
    assert_ne!(model.document().settings, start.settings);
    model.undo();
    model.undo();
    assert_eq!(model.document(), &start);
}

#[test]
fn what_cannot_be_is_said_and_changes_nothing() {
    let mut model = opened(&["sample:head:24"]);
    let start = model.document().clone();
    for (ask, says) in [
        (
            &(|model: &mut Model| model.open(&["no/such/file.nrrd".to_owned()])) as &dyn Fn(&mut Model),
            "no/such/file.nrrd",
        ),
        (
            &|model: &mut Model| model.add(ItemKeys::of_file("sample:nothing")),
            "nothing",
        ),
        (
            &|model: &mut Model| model.edit(Edit::set("item[7].cmap", "gray")),
            "item[7]",
        ),
        (
            &|model: &mut Model| model.edit(Edit::set("background", "mauve")),
            "mauve",
        ),
    ] {
        ask(&mut model);
        wait(&mut model, says, |model| model.message().is_some());
        let message = model.message().unwrap().clone();
        assert!(message.is_error && message.text.contains(says), "{message:?}");
        assert_eq!(model.document(), &start);
        model.dismiss();
    }
}

/// The bytes of a picture that the model saves.
fn saved(model: &mut Model, path: &Path) -> Vec<u8> {
    model.save(path.to_owned(), None, false);
    wait(model, "a saved picture", |model| model.writing().is_none());
    let message = model.message().unwrap();
    assert!(!message.is_error, "{}", message.text);
    fs::read(path).unwrap()
}

fn splatvol(arguments: &[&Path]) -> u8 {
    let arguments = arguments.iter().map(|argument| argument.as_os_str().to_owned());
    splatvol_cli::run(std::iter::once(OsString::from("splatvol")).chain(arguments))
}

#[test]
fn a_saved_picture_has_the_bytes_of_render_like_and_restores_everything() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("head.nrrd");
    let sample = ["sample", "head", "--size", "24", "-o"].map(Path::new);
    assert_eq!(splatvol(&[&sample[..], &[data.as_path()]].concat()), 0);
    for file in ["sample:head:24".to_owned(), data.to_string_lossy().into_owned()] {
        let mut model = opened(&[&file]);
        model.move_camera(|camera| navigate::orbit(camera, 33.0, -7.0));
        model.end_gesture();
        model.gesture(|session| {
            let function = session.items()[0].transfer_function.clone().unwrap();
            let (function, _) = curve::add_point(&function, [321.0, 0.3])?;
            session.adjust_item(0, "transfer-function", &function)
        });
        model.edit(Edit::set("background", "white"));
        let name = if file == data.to_string_lossy() {
            "b.png"
        } else {
            "a.png"
        };
        let path = folder.path().join(name);
        let bytes = saved(&mut model, &path);
        // The record leaves nothing of the pane open.
        let again = folder.path().join(format!("like-{name}"));
        let like = [
            Path::new("render"),
            Path::new("--like"),
            &path,
            Path::new("-o"),
            &again,
        ];
        assert_eq!(splatvol(&like), 0);
        assert!(
            fs::read(&again).unwrap() == bytes,
            "{name}: render --like made other bytes"
        );

        let mut restored = opened(&["sample:tomato:16"]);
        restored.drop_file(&path.to_string_lossy(), (false, 0));
        wait(&mut restored, "the dropped picture", |restored| {
            restored.document().items[0].file.contains("head") && restored.is_final()
        });
        let expected = Document {
            size: restored.document().size,
            ..model.document().clone()
        };
        assert_eq!(restored.document().camera, expected.camera);
        assert_eq!(
            restored.document().items[0].transfer_function,
            expected.items[0].transfer_function
        );
        assert_eq!(restored.document().settings, expected.settings);
        let other = folder.path().join(format!("again-{name}"));
        assert!(
            saved(&mut restored, &other) == bytes,
            "{name}: saving again made other bytes"
        );
    }
}

#[test]
fn existing_files_and_unknown_formats_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut model = opened(&["sample:head:24"]);
    let path = folder.path().join("a.png");
    fs::write(&path, "mine").unwrap();
    for (path, says) in [
        (path.clone(), "already exists"),
        (folder.path().join("a.jpg"), ".png and .exr"),
    ] {
        model.save(path, None, false);
        wait(&mut model, says, |model| model.writing().is_none());
        let message = model.message().unwrap();
        assert!(message.is_error && message.text.contains(says), "{message:?}");
    }
    assert_eq!(fs::read(&path).unwrap(), b"mine");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn input_stops_a_slow_picture() {
    let mut model = opened(&["sample:head:64"]);
    model.change_settings(SettingKeys {
        preset: Some(PresetName::Best),
        ..SettingKeys::default()
    });
    wait(&mut model, "the preset", |model| model.asked_since().is_none());
    // So large that a busy machine, too, is interrupted long before the picture is finished.
    model.edit(Edit::set("size", "880x640"));
    // A picture may be finished just before the input comes, but not every time.
    for _ in 0..20 {
        model.move_camera(|camera| navigate::orbit(camera, 5.0, 0.0));
        wait(&mut model, "a slow picture", |model| {
            model.progress().is_some() || model.is_final()
        });
        let interrupted = model.views;
        model.move_camera(|camera| navigate::orbit(camera, 5.0, 0.0));
        let mut finished = false;
        wait(&mut model, "a draft of a later view", |model| {
            let shown = model.shown().unwrap();
            finished |= shown.draft_step.is_none() && shown.number == interrupted;
            shown.number > interrupted
        });
        if !finished {
            return;
        }
    }
    panic!("no picture was stopped");
}

/// Numbers without a pattern, the same on every run.
struct Dice(u64);

impl Dice {
    fn below(&mut self, count: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % count
    }

    fn share(&mut self) -> f64 {
        self.below(1 << 20) as f64 / f64::from(1 << 20)
    }
}

/// One of all kinds of edits that the window makes.
fn edit(session: &mut Session, dice: &mut Dice) -> Result<(), DocumentError> {
    let index = dice.below(session.items().len());
    let camera = session.camera().unwrap();
    let function = session.items()[index].transfer_function.clone().unwrap();
    let point = dice.below(function.opacities().len());
    let [low, high] = curve::span(&function);
    let place = [low + (high - low) * dice.share(), dice.share()];
    let look = |function| ("transfer-function", function);
    let (key, function) = match dice.below(14) {
        0 => return session.place_camera(&navigate::orbit(&camera, 9.0 * dice.share(), 5.0)?),
        1 => return session.place_camera(&navigate::zoom(&camera, 0.5 + dice.share(), Default::default())?),
        2 => return session.place_camera(&navigate::other_projection(&camera)?),
        3 => look(curve::add_point(&function, place)?.0),
        4 => look(curve::move_point(&function, point, place)?),
        5 => look(curve::remove_point(&function, point)?),
        6 => look(curve::with_map(&function, ColorMap::from_name("magma")?)?),
        7 => look(curve::with_span(
            &function,
            [low - dice.share(), high + dice.share()],
        )?),
        8 => return session.adjust(Edit::set("settings.ambient", dice.share())),
        9 => return session.adjust_item(index, "translate", &[dice.share(), 0.0, 1.0]),
        10 if dice.below(2) == 0 => return session.edit(Edit::unset("effects")),
        10 => {
            let [a, b] = [dice.share(), 1.5 + dice.share()];
            let effects = splatvol_document::keys::EffectKeys {
                clip_box: Some([a, b, a, b, a, b]),
                ..Default::default()
            };
            return session.adjust_effects(&effects);
        }
        11 if session.items().len() > 1 => return session.edit(Edit::Remove(index)),
        11 => {
            let item = Box::new(session.items()[index].clone());
            return session.edit(Edit::Insert(index, item));
        }
        12 => {
            let other = dice.below(session.items().len());
            return session.edit(Edit::Move(index, other));
        }
        _ => {
            let mut document = session.document().clone();
            document.background = ["white", "black"][dice.below(2)].parse().ok();
            return session.edit(Edit::Replace(Box::new(document)));
        }
    };
    session.adjust_item(index, key, &function)
}

#[test]
fn ten_thousand_random_edits_are_undone_to_the_same_document() {
    let model = opened(&["sample:head:16", "sample:tomato:16"]);
    let start = model.document().clone();
    let mut session = Session::new(start.clone());
    let mut dice = Dice(19);
    let mut made = 0;
    while made < 10_000 {
        match dice.below(20) {
            0 => drop(session.undo().unwrap()),
            1 => drop(session.redo().unwrap()),
            2..=7 => session.end_gesture(),
            _ => {
                edit(&mut session, &mut dice).unwrap();
                made += 1;
            }
        }
    }
    let end = session.document().clone();
    assert_ne!(end, start);
    while session.undo().unwrap() {}
    assert_eq!(session.document(), &start);
    while session.redo().unwrap() {}
    assert_eq!(session.document(), &end);
}

#[test]
fn two_looks_change_places_and_keep_everything_else() {
    let mut model = opened(&["sample:head:16"]);
    let keys = |name: &str| ItemKeys {
        cmap: Some(name.to_owned()),
        ..ItemKeys::default()
    };
    let a = model.document().clone();
    assert_eq!(model.looks().letter(), None);
    model.change_looks();
    assert_eq!((model.looks().letter(), model.document()), (Some('B'), &a));
    model.change_look(0, keys("viridis"));
    wait(&mut model, "another look", |model| model.asked_since().is_none());
    model.change_settings(SettingKeys {
        preset: Some(PresetName::Fast),
        ..SettingKeys::default()
    });
    wait(&mut model, "a preset", |model| model.asked_since().is_none());
    let b = model.document().clone();
    assert_ne!(a.items, b.items);
    model.change_looks();
    assert_eq!((model.looks().letter(), model.document()), (Some('A'), &a));
    // The camera and the place belong to both.
    model.move_camera(|camera| navigate::orbit(camera, 20.0, 0.0));
    model.end_gesture();
    model.edit(Edit::set("item[0].translate", serde_json::json!([1.0, 2.0, 3.0])));
    let moved = model.document().clone();
    model.change_looks();
    let (items, settings) = (&model.document().items, &model.document().settings);
    assert_eq!((&model.document().camera, settings), (&moved.camera, &b.settings));
    assert_eq!(items[0].translate, Some([1.0, 2.0, 3.0]));
    assert_eq!(items[0].transfer_function, b.items[0].transfer_function);
    // A step back is the other look, and neither is lost.
    model.undo();
    assert_eq!((model.looks().letter(), model.document()), (Some('A'), &moved));
    model.change_looks();
    assert_eq!(model.document().settings, b.settings);
    assert_eq!(model.looks().letter(), Some('B'));
    // Other data have one look.
    model.open(&["sample:ball:8".to_owned()]);
    wait(&mut model, "another file", |model| model.asked_since().is_none());
    assert_eq!(model.looks().letter(), None);
}

#[test]
fn a_saved_scene_is_the_document_with_its_animation() {
    let folder = tempfile::tempdir().unwrap();
    let mut model = opened(&["sample:head:16"]);
    let frame = splatvol_document::keys::CameraFrame::from(&model.session().camera().unwrap());
    let animation = splatvol_document::keys::AnimationKeys {
        keys: Some(vec![frame; 2]),
        frames: Some(7),
        ..Default::default()
    };
    model.gesture(|session| session.adjust_animation(&animation));
    let path = folder.path().join("scene.toml");
    let size = ImageSize::new(40, 30).unwrap();
    for says in ["wrote", "already exists"] {
        model.save(path.clone(), Some(size), false);
        wait(&mut model, "the scene", |model| {
            model.writing().is_none() && model.message().is_some()
        });
        let said = model.message().unwrap().text.clone();
        assert!(said.contains(says), "{said}");
        model.dismiss();
    }
    let read = splatvol_document::format::read_scene(&path).unwrap();
    let wanted = Document {
        name: read.name.clone(),
        size: Some(PictureSize(size)),
        ..model.document().clone()
    };
    assert_eq!(read, wanted);
    assert_eq!(rendered(&read), rendered(&wanted));
}

#[test]
fn another_engine_draws_the_same_view_and_says_who_it_is() {
    let mut model = opened(&["sample:head:16"]);
    let codes = model.shown().unwrap().codes.clone();
    assert_eq!(model.shown().unwrap().drawn_by, DrawnBy::default());
    let pictures = model.pictures();
    model.choose_engine(EngineChoice::Auto);
    wait(&mut model, "another engine", |model| {
        model.pictures() > pictures && model.is_final()
    });
    let drawn_by = model.shown().unwrap().drawn_by.clone();
    // Without a GPU it is said why there is none, and the picture is the same.
    if drawn_by.device.is_empty() {
        assert!(!drawn_by.why.is_empty());
        assert_eq!(model.shown().unwrap().codes, codes);
    }
    if !EngineChoice::WITH_GPU {
        model.choose_engine(EngineChoice::Gpu);
        wait(&mut model, "a refusal", |model| model.message().is_some());
        let message = model.message().unwrap().text.clone();
        assert!(message.contains("built without the feature gpu"), "{message}");
        model.choose_engine(EngineChoice::Cpu);
        wait(&mut model, "the engine of before", Model::is_final);
        assert_eq!(model.shown().unwrap().codes, codes);
    }
}
