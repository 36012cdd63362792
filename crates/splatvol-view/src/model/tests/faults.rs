//! Errors that come and go, and what is known of meshes.

use super::*;

fn failed() -> News {
    News::Failed {
        number: None,
        message: "no memory".to_owned(),
    }
}

#[test]
fn the_error_of_a_picture_goes_when_a_later_one_is_there() {
    let mut model = opened(&["sample:head:16"]);
    let size = |pane| {
        move |model: &Model| {
            let shown = model.shown().unwrap();
            model.is_final() && [shown.view_size.width(), shown.view_size.height()] == pane
        }
    };
    model.hear(failed());
    assert!(model.message().unwrap().is_error && model.shown().is_some());
    // Of another size.
    model.tick([100, 80]);
    wait(&mut model, "a picture of the first size again", size(PANE));
    assert_eq!(model.message(), None);
    // What is said of something else stays.
    model.say("a file is missing", true);
    model.tick([100, 80]);
    wait(&mut model, "a picture of the first size again", size(PANE));
    assert!(model.message().is_some());
}

#[test]
fn a_picture_of_other_data_is_not_left_where_there_is_none_of_these() {
    let mut model = opened(&["sample:head:16"]);
    model.open(&["sample:tomato:16".to_owned()]);
    let start = Instant::now();
    while model.asked_since().is_some() {
        assert!(start.elapsed() < PATIENCE);
        model.listen();
    }
    assert!(model.shown().is_some());
    model.hear(failed());
    assert!(model.shown().is_none());
    wait(&mut model, "the other data", Model::is_final);
    assert_eq!(model.message(), None);
}

#[test]
fn what_is_not_written_is_said_before_anything_is_rendered() {
    let folder = tempfile::tempdir().unwrap();
    let mut model = opened(&["sample:head:16"]);
    model.save(folder.path().join("missing/a.png"), None, false);
    assert!(model.writing().is_none());
    assert!(model.refused().unwrap().contains("no such folder"));
    let path = folder.path().join("a.png");
    saved(&mut model, &path);
    assert_eq!(model.refused(), None);
}

#[test]
fn meshes_have_a_histogram() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cell.vtk");
    let points = "0 0 0 1 0 0 0 1 0 0 0 1";
    let text = format!(
        "# vtk DataFile Version 3.0\na cell\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n{points}\nCELLS 1 5\n4 0 1 2 3\n\
         CELL_TYPES 1\n10\nPOINT_DATA 4\nSCALARS heat float 1\nLOOKUP_TABLE default\n1 2 3 5\n"
    );
    fs::write(&path, text).unwrap();
    let model = opened(&[path.to_str().unwrap()]);
    let facts = model.facts(&model.document().items[0]).unwrap();
    let values = facts.values.as_ref().unwrap();
    assert_eq!(values.range, [1.0, 5.0]);
    assert_eq!(values.histogram.iter().sum::<u64>(), 4);
    assert!(!values.is_grid);
}
