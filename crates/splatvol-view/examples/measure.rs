//! Measures the viewer's model without a window, at 1280 x 800: opening, drafts while the view turns, the final picture after rest, edits of
//! the transfer function, and how fast a slow picture is given up.
//!
//! `cargo run --release -p splatvol-view --example measure -- FILE...`

use std::sync::Arc;
use std::time::{Duration, Instant};

use splatvol_document::keys::SettingKeys;
use splatvol_document::keys::names::PresetName;
use splatvol_view::Start;
use splatvol_view::model::{Model, curve, navigate};

const PANE: [u32; 2] = [1280, 800];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for file in std::env::args().skip(1) {
        println!("{file}");
        measure(&file)?;
    }
    Ok(())
}

fn measure(file: &str) -> Result<(), Box<dyn std::error::Error>> {
    let start = Instant::now();
    let asked = Start {
        files: vec![file.to_owned()],
        ..Start::default()
    };
    let mut model = Model::new(asked, Arc::new(|| {}))?;
    wait(&mut model, |model| model.shown().is_some());
    say("opened, to the first draft", start.elapsed());
    wait(&mut model, Model::is_final);
    say("opened, to the final picture", start.elapsed());
    turn(&mut model);
    edit(&mut model)?;
    cancel(&mut model);
    Ok(())
}

fn say(what: &str, time: Duration) {
    println!("  {what}: {:.0} ms", 1e3 * time.as_secs_f64());
}

/// Ticks until something holds.
fn wait(model: &mut Model, done: impl Fn(&Model) -> bool) {
    loop {
        model.tick(PANE);
        if done(model) {
            return;
        }
        std::thread::sleep(Duration::from_micros(300));
    }
}

/// A view that turns for three seconds, with input every 8 ms, as from a mouse.
fn turn(model: &mut Model) {
    let (start, before) = (Instant::now(), model.pictures());
    let mut steps = Vec::new();
    while start.elapsed() < Duration::from_secs(3) {
        model.move_camera(|camera| navigate::orbit(camera, 0.7, 0.1));
        let pictures = model.pictures();
        model.tick(PANE);
        if let (true, Some(step)) = (
            model.pictures() > pictures,
            model.shown().and_then(|shown| shown.draft_step),
        ) {
            steps.push(step);
        }
        std::thread::sleep(Duration::from_millis(8));
    }
    let rate = (model.pictures() - before) as f64 / start.elapsed().as_secs_f64();
    steps.sort_by(f64::total_cmp);
    let middle = steps.get(steps.len() / 2).copied().unwrap_or_default();
    println!("  moving: {rate:.1} frames per second, raster of 1/{middle:.1}");
    let rest = Instant::now();
    wait(model, Model::is_final);
    say("from rest to the final picture", rest.elapsed());
}

/// Edits of the transfer function, each to its draft.
fn edit(model: &mut Model) -> Result<(), Box<dyn std::error::Error>> {
    let mut times = Vec::new();
    for number in 0..15 {
        let item = &model.document().items[0];
        let function = item.transfer_function.clone().ok_or("no transfer function")?;
        let last = function.opacities().len() - 1;
        let point = function.opacities()[last];
        let opacity = point.opacity * (0.9 + 0.01 * f64::from(number));
        let function = curve::move_point(&function, last, [point.value, opacity])?;
        let (start, before) = (Instant::now(), model.pictures());
        model.gesture(|session| session.adjust_item(0, "transfer-function", &function));
        wait(model, |model| model.pictures() > before);
        times.push(start.elapsed());
    }
    times.sort();
    say(
        "edit of the transfer function to its draft, median",
        times[times.len() / 2],
    );
    wait(model, Model::is_final);
    Ok(())
}

/// From input to the draft that replaces a slow picture: the time in which that was given up, and a draft's.
fn cancel(model: &mut Model) {
    model.change_settings(SettingKeys {
        preset: Some(PresetName::Best),
        ..SettingKeys::default()
    });
    wait(model, |model| model.asked_since().is_none());
    let mut times = Vec::new();
    for _ in 0..5 {
        model.move_camera(|camera| navigate::orbit(camera, 2.0, 0.0));
        wait(model, |model| {
            model.progress().is_some_and(|share| share > 0.05) || model.is_final()
        });
        if model.is_final() {
            continue;
        }
        let (start, before) = (Instant::now(), model.pictures());
        model.move_camera(|camera| navigate::orbit(camera, 2.0, 0.0));
        wait(model, |model| model.pictures() > before);
        let draft = model.shown().map_or(0.0, |shown| shown.seconds);
        times.push(start.elapsed().saturating_sub(Duration::from_secs_f64(draft)));
    }
    times.sort();
    match times.get(times.len() / 2) {
        Some(time) => say(
            "input to a draft in place of the slow picture, less the draft itself, median",
            *time,
        ),
        None => println!("  no picture was slow enough to be given up"),
    }
}
