//! Shares: what is left out because no wanted tile is near changes no byte of those that are wanted.

use glam::{DAffine3, DVec3};
use splatvol_core::engine::{Control, Share};
use splatvol_scene::{Camera, Frame, Gaussians, Projection};

use super::{Cloud, CloudSettings, LowPass, Random, Renderer, attributes, perspective, settings};

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
