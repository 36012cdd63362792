//! Volumes that are read in chunks.

use splatvol_document::ChunkRules;

use super::*;

/// An image with levels of detail, of the head.
fn image(folder: &Path) -> String {
    let path = folder.join("head.ome.zarr").to_string_lossy().into_owned();
    let words = ["convert", "sample:head:64", &path, "--chunk", "16"];
    assert_eq!(splatvol(&words.map(Path::new)), 0);
    path
}

/// A model that reads images in chunks, or whole if they fit.
fn model_of(path: &str, whole_if_it_fits: bool) -> Model {
    let start = Start {
        files: vec![path.to_owned()],
        command: "splatvol view".to_owned(),
        rules: ReadRules {
            chunks: Some(ChunkRules {
                memory: 48 << 20,
                holes: false,
                whole_if_it_fits,
            }),
            ..ReadRules::default()
        },
        threads: Some(2),
        ..Start::default()
    };
    let mut model = Model::new(start, Arc::new(|| {})).unwrap();
    wait(&mut model, "the first picture", Model::is_final);
    model
}

fn summary(model: &Model) -> &str {
    let item = &model.document().items[0];
    &model.facts(item).unwrap().summary
}

#[test]
fn pictures_from_chunks_are_those_of_render() {
    let folder = tempfile::tempdir().unwrap();
    let mut model = model_of(&image(folder.path()), false);
    assert_eq!(
        summary(&model),
        "64 x 64 x 64 i16 in chunks, overview 64 x 64 x 64"
    );
    for _ in 0..3 {
        model.move_camera(|camera| navigate::orbit(camera, 10.0, 3.0));
        let before = model.pictures();
        wait(&mut model, "a draft", |model| model.pictures() > before);
    }
    model.end_gesture();
    wait(&mut model, "the picture at rest", Model::is_final);
    assert_eq!(model.shown().unwrap().codes, rendered(model.document()));
    // Values are those of the overview.
    let shown = model.shown().unwrap();
    let middle = splatvol::glam::DVec2::new(f64::from(PANE[0]), f64::from(PANE[1])) * 0.5;
    let probe = probe::probe(&shown.scene, &shown.camera, shown.view_size, middle).unwrap();
    assert!(probe.value > 100.0, "{probe:?}");
    // A picture that is saved beside the window has chunks of its own.
    model.move_camera(|camera| navigate::orbit(camera, 40.0, 0.0));
    let path = folder.path().join("a.png");
    let bytes = saved(&mut model, &path);
    let again = folder.path().join("b.png");
    let words = ["render", "--like"].map(Path::new);
    let output = [path.as_path(), Path::new("-o"), &again];
    assert_eq!(splatvol(&[&words[..], &output].concat()), 0);
    assert!(fs::read(again).unwrap() == bytes);
}

#[test]
fn volumes_that_fit_are_read_whole() {
    let folder = tempfile::tempdir().unwrap();
    let model = model_of(&image(folder.path()), true);
    assert_eq!(summary(&model), "64 x 64 x 64 i16");
    assert_eq!(model.shown().unwrap().codes, rendered(model.document()));
}
