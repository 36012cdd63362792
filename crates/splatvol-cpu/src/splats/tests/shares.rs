//! Shares: what is left out because no wanted tile is near changes no byte of those that are wanted.

use std::sync::atomic::{AtomicU64, Ordering};

use fearless_simd::{Level, dispatch};
use glam::{DAffine3, DVec3};
use splatvol_core::bin::TileGrid;
use splatvol_core::engine::{Control, Share, Task};
use splatvol_scene::{Camera, Frame, Gaussians, Projection};

use super::{Cloud, CloudSettings, LowPass, Random, Renderer, attributes, perspective, settings};
use crate::splats::blend::Published;
use crate::splats::cover::TILE;
use crate::splats::picked::{Kept, RANGE};
use crate::splats::project::{LANES, ProjectedSplat, Rect, Target, project, project_picked};
use crate::splats::view::CloudView;
use crate::splats::wanted::WantedTiles;

/// Gaussians of all sizes, neighbours of the file being neighbours in space, so that whole groups of lanes are left out.
fn coherent(seed: u64, count: usize) -> Gaussians {
    let mut random = Random(seed);
    let mut made = attributes(seed, count, 1, [0.001, 0.2]);
    for group in made.means.chunks_mut(40) {
        let middle = 1.3 * random.vector();
        for mean in group {
            *mean = (middle + 0.02 * random.vector()).as_vec3().to_array();
        }
    }
    made.scales[7] = [30.0, 1e-4, 1e-4];
    Gaussians::new(made, 1, DAffine3::IDENTITY).unwrap()
}

fn together(cloud: &Gaussians, view: (&Camera, &CloudSettings), count: usize, edge: usize) -> Frame {
    let clouds = [Cloud::Gaussians(cloud, DAffine3::IDENTITY)];
    let mut whole = Frame::empty(view.1.size);
    let width = view.1.size.width() as usize;
    for index in 0..count {
        let share = Share::new(index, count, edge).unwrap();
        let control = Control {
            share: Some(share),
            ..Control::default()
        };
        let mut frame = Frame::empty(view.1.size);
        let mut renderer = Renderer::new(2, None).unwrap();
        renderer.render_with(&clouds, view, &control, &mut frame);
        for rect in share.blocks(view.1.size) {
            for i in (rect.y0..rect.y1).flat_map(|y| y * width + rect.x0..y * width + rect.x1) {
                whole.image.pixels[i] = frame.image.pixels[i];
                whole.depth[i] = frame.depth[i];
                whole.optical_depth[i] = frame.optical_depth[i];
            }
        }
    }
    whole
}

#[test]
fn shares_of_clouds_have_the_bytes_of_the_whole() {
    let cloud = coherent(11, 12_000);
    let orthographic = Projection::Orthographic { height: 2.5 };
    let inside = perspective(DVec3::new(0.4, 0.3, 0.0), 80.0);
    let outside = perspective(DVec3::new(2.6, 1.0, 0.4), 50.0);
    let parallel = Camera::new(outside.position(), DVec3::ZERO, DVec3::Z, orthographic).unwrap();
    for camera in [inside, outside, parallel] {
        for low_pass in [LowPass::Added(0.3), LowPass::Lacking(0.25)] {
            let settings = CloudSettings {
                low_pass,
                ..settings(301, 200)
            };
            let view = (&camera, &settings);
            let whole = together(&cloud, view, 1, 64);
            for (count, edge) in [(2, 64), (3, 32), (5, 20)] {
                let found = together(&cloud, view, count, edge);
                assert!(found == whole, "{count} shares of {edge} pixels, {low_pass:?}");
            }
        }
    }
}

/// Depths and places of the splats of a range that a share stores. `all`: of every splat, its footprint is computed.
fn stored(cloud: &Gaussians, (view, wanted): (&CloudView, &WantedTiles), all: bool) -> Vec<u64> {
    let mut splats = vec![ProjectedSplat::default(); RANGE];
    let mut rects = vec![Rect::default(); RANGE];
    let keys: Vec<AtomicU64> = (0..RANGE).map(|_| AtomicU64::new(0)).collect();
    let mut target = Target {
        first: 0,
        wanted,
        splats: &mut splats,
        rects: &mut rects,
        keys: &keys,
    };
    let blend = Published::new([0.0; 4]);
    let count = dispatch!(Level::new(), simd => {
        if all {
            let mut kept = Kept::new();
            for first in (0..cloud.len()).step_by(LANES) {
                kept.add(first, (1 << LANES.min(cloud.len() - first)) - 1);
            }
            let mut count = 0;
            for picked in kept.picked() {
                count += project_picked(simd, blend, (view, cloud), &picked, (&mut target, count));
            }
            count
        } else {
            project(simd, blend, (view, cloud), 0..cloud.len(), &mut target)
        }
    });
    let bits = |splat: &ProjectedSplat| u64::from(splat.centre[0].to_bits());
    let depths = keys[..count].iter().map(|key| key.load(Ordering::Relaxed));
    depths
        .zip(&splats)
        .flat_map(|(key, splat)| [key, bits(splat)])
        .collect()
}

#[test]
fn no_splat_is_left_out_by_its_place_and_size_that_shows() {
    let inside = perspective(DVec3::new(0.4, 0.3, 0.0), 80.0);
    let outside = perspective(DVec3::new(2.6, 1.0, 0.4), 50.0);
    for (seed, count) in [(21, RANGE), (22, 2005), (23, 9)] {
        let cloud = coherent(seed, count);
        for camera in [&inside, &outside] {
            for low_pass in [LowPass::Added(0.3), LowPass::Lacking(0.25)] {
                for shares in 1..4 {
                    let settings = settings(301, 200);
                    let view = CloudView::new(&DAffine3::IDENTITY, 0.2, (camera, settings.size), low_pass);
                    let control = Control {
                        share: Some(Share::new(0, shares, 64).unwrap()),
                        ..Control::default()
                    };
                    let task = Task::new(&control, &|_| {});
                    let wanted = WantedTiles::new(&task, &TileGrid::new(settings.size, TILE));
                    let found = stored(&cloud, (&view, &wanted), false);
                    assert_eq!(found, stored(&cloud, (&view, &wanted), true), "{shares} shares");
                    assert!(count < 10 || !found.is_empty());
                }
            }
        }
    }
}
