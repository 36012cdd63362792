//! Renderers that share threads.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::common::PROJECTIONS;
use splatvol::{
    Camera, Classification, Compositing, EngineConfig, EngineError, FlatSettings, ImageSize, Pool,
    RenderSettings, Renderer, Scene, View,
};
use splatvol_samples::{Sample, SampleSize};
use splatvol_testing::{alone, checked};

fn settings() -> [RenderSettings; 4] {
    let default = RenderSettings {
        size: ImageSize::new(120, 90).unwrap(),
        ..RenderSettings::default()
    };
    let with = |compositing, classification| {
        checked(FlatSettings {
            compositing,
            classification,
            ..default.into()
        })
    };
    [
        default,
        with(Compositing::ImageSheets, Classification::Pre),
        with(Compositing::Mip, Classification::Post),
        with(Compositing::AxisSheets, Classification::Pre),
    ]
}

/// Threads of this process, if the system reports them.
fn threads_of_the_process() -> Option<usize> {
    Some(std::fs::read_dir("/proc/self/task").ok()?.count())
}

#[test]
fn twenty_renderers_share_one_pool() {
    alone!();
    let volume = Sample::Shells.generate(Some(SampleSize::Longest(40))).unwrap();
    let camera = Camera::framing(&volume.grid().bounds(), View::Iso, PROJECTIONS[0], 1.2).unwrap();
    let scene = Scene::new(volume, Sample::Shells.default_transfer_function().unwrap());
    let alone = EngineConfig {
        threads: Some(1),
        ..EngineConfig::default()
    };
    let expected = settings().map(|settings| {
        let mut renderer = Renderer::new(alone).unwrap();
        renderer.render(&scene, &camera, &settings).unwrap()
    });
    let started = Arc::new(AtomicUsize::new(0));
    let count = Arc::clone(&started);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(2)
        .start_handler(move |_| {
            count.fetch_add(1, Ordering::Relaxed);
        })
        .build()
        .unwrap();
    let pool = Pool::from(Arc::new(pool));
    let before = threads_of_the_process();
    let mut renderers: Vec<Renderer> = (0..20)
        .map(|_| Renderer::with_pool(pool.clone(), EngineConfig::default()).unwrap())
        .collect();
    // All of them at the same time, from threads of this test.
    std::thread::scope(|scope| {
        for (i, renderer) in renderers.iter_mut().enumerate() {
            let (scene, camera, expected) = (&scene, &camera, &expected);
            scope.spawn(move || {
                let turn = i % settings().len();
                let frame = renderer.render(scene, camera, &settings()[turn]).unwrap();
                assert!(frame == expected[turn], "renderer {i}");
            });
        }
    });
    assert_eq!(started.load(Ordering::Relaxed), 2);
    // The scope's threads may take a moment to end.
    let settled = (0..100).any(|_| {
        std::thread::sleep(std::time::Duration::from_millis(20));
        threads_of_the_process() <= before
    });
    assert!(settled, "no renderer starts threads");
}

#[test]
fn another_number_of_threads_than_the_pool_has_is_refused() {
    let pool = Pool::new(Some(2)).unwrap();
    let config = |threads| EngineConfig {
        threads: Some(threads),
        ..EngineConfig::default()
    };
    assert!(Renderer::with_pool(pool.clone(), config(2)).is_ok());
    let refused = Renderer::with_pool(pool, config(3)).unwrap_err();
    assert!(matches!(refused, EngineError::Pool { threads: 3, there: 2 }));
    assert!(refused.to_string().starts_with("threads: 3 is not allowed"));
}
