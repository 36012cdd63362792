//! The presets against the reference, as people get them: the table of docs/numerics.md.
//!
//! The reference has no matched filter; it integrates the same field, kernel and light without one, so that the figures
//! of `fast` and `balanced` hold what their filter changes, too.

use splatvol::{Filter, FlatSettings, ImageSize, Projection, RenderSettings, Scene};
use splatvol_testing::{Comparison, checked};

use super::{PIXELS, compare_with, name_of, scenes};
use crate::common::PROJECTIONS;

/// What a picture may lose against what was measured, dB.
const SLACK: f64 = 1.0;
/// What it may gain before the table says too little: a third of the error.
const STALE: f64 = 9.5;

/// Preset, field, projection, and the PSNR measured, dB: lit, unlit.
type Row = (&'static str, &'static str, Projection, [f64; 2]);

fn preset(name: &str) -> RenderSettings {
    let settings = match name {
        "fast" => RenderSettings::fast(),
        "balanced" => RenderSettings::balanced(),
        _ => RenderSettings::best(),
    };
    RenderSettings {
        size: ImageSize::new(PIXELS, PIXELS).unwrap(),
        ..settings
    }
}

fn rows() -> Vec<Row> {
    let measured = [
        ("fast", "marschner-lobb", [[32.3, 37.6], [31.1, 37.4]]),
        ("fast", "head", [[42.1, 49.5], [41.4, 48.9]]),
        ("fast", "ball", [[41.9, 66.4], [41.0, 64.9]]),
        ("fast", "noise", [[40.6, 53.6], [39.4, 52.5]]),
        ("balanced", "marschner-lobb", [[36.0, 52.4], [34.4, 51.3]]),
        ("balanced", "head", [[50.8, 57.4], [50.2, 56.2]]),
        ("balanced", "ball", [[41.8, 74.9], [40.9, 74.1]]),
        ("balanced", "noise", [[41.3, 63.9], [40.0, 62.6]]),
        ("best", "marschner-lobb", [[52.5, 65.5], [51.0, 65.6]]),
        ("best", "head", [[60.5, 74.1], [59.3, 73.9]]),
        ("best", "ball", [[75.3, 74.7], [74.1, 73.5]]),
        ("best", "noise", [[65.6, 70.6], [63.9, 69.1]]),
    ];
    let row = |(preset, field, figures): (&'static str, &'static str, [[f64; 2]; 2])| {
        PROJECTIONS
            .into_iter()
            .zip(figures)
            .map(move |(projection, measured)| (preset, field, projection, measured))
    };
    measured.into_iter().flat_map(row).collect()
}

/// PSNR of a preset's picture of a field, dB.
fn measure(scene: &Scene, projection: Projection, settings: RenderSettings, lit: bool) -> f64 {
    let settings = RenderSettings {
        lighting: settings.lighting.filter(|_| lit),
        ..settings
    };
    let exact = match settings.method.filter() {
        Filter::Matched { .. } => checked(FlatSettings {
            filter: Filter::None,
            ..settings.into()
        }),
        _ => settings,
    };
    let (found, expected) = compare_with(scene, projection, &settings, &exact);
    Comparison::of(&found, &expected).psnr
}

/// Measures the rows of one preset.
fn check(name: &str) {
    let scenes = scenes();
    let mut failures = Vec::new();
    for (preset_name, field, projection, measured) in rows().into_iter().filter(|row| row.0 == name) {
        let (_, scene) = scenes.iter().find(|(name, _)| *name == field).unwrap();
        let found = [true, false].map(|lit| measure(scene, projection, preset(preset_name), lit));
        println!("{}", line(&(preset_name, field, projection, found)));
        for (found, measured) in found.into_iter().zip(measured) {
            if !(measured - SLACK..measured + STALE).contains(&found) {
                failures.push(format!(
                    "{name} {field} {}: {found:.1}, not {measured}",
                    name_of(projection)
                ));
            }
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn fast_agrees_as_documented() {
    check("fast");
}

#[test]
fn balanced_agrees_as_documented() {
    check("balanced");
}

#[test]
fn best_agrees_as_documented() {
    check("best");
}

/// A row of the documented table.
fn line((preset, field, projection, [lit, unlit]): &Row) -> String {
    format!(
        "| {preset} | {field} | {} | {:.1} | {lit:.1} | {:.1} | {unlit:.1} |",
        name_of(*projection),
        lit - SLACK,
        unlit - SLACK
    )
}

#[test]
fn the_table_of_the_page_is_the_one_that_is_tested() {
    let page = include_str!("../../../../../docs/numerics.md");
    for row in rows() {
        let line = line(&row);
        assert!(page.contains(&line), "docs/numerics.md lacks\n{line}");
    }
}
