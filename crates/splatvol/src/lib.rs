//! Volume rendering by splatting, on the CPU: a scan, a simulation, points or 3-D Gaussians become a picture, the same
//! to the bit for any number of threads.
#![doc = include_str!("../docs/picture.md")]
//! *What [`examples/`][examples] 01, 03 and 04 make: a volume as it is read, its X-ray, and a scene of several things.*
//!
//! A [`Scene`] of [`Item`]s, a [`Camera`] and [`RenderSettings`] are plain, validated data; a [`Renderer`] makes a
//! [`Frame`] of them, and keeps what it derives from the items for the next one.
//!
//! # From a file to a picture
//!
//! Any file or folder that [`io`] reads becomes an item with a look that suits its values.
//!
//! ```no_run
//! use splatvol::{Camera, EngineConfig, Projection, RenderSettings, Renderer, Scene, View, io};
//!
//! let scene = Scene::from(io::read_item("head.nrrd")?);
//! let settings = RenderSettings::default();
//! let aspect = settings.size.aspect();
//! let camera = Camera::framing(&scene.bounds()?, View::Front, Projection::default(), aspect)?;
//! let frame = Renderer::new(EngineConfig::default())?.render(&scene, &camera, &settings)?;
//! io::write_frame("head.png", &frame, &[])?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Samples of your own, in colours of your own
//!
//! Samples are kept in the type they come in, x fastest. Opacity is per unit of length, so that it does not depend on
//! the spacing of samples or sheets.
//!
//! ```
//! use splatvol::{
//!     Camera, ColorMap, EngineConfig, Grid, ImageSize, LengthUnit, OpacityPoint, Projection, RenderSettings, Renderer,
//!     Rescale, Samples, Scene, TransferFunction, View, Volume,
//! };
//!
//! // A ball whose values fall from 1 in its middle to 0.
//! let at = |i: usize| [i % 32, i / 32 % 32, i / 1024].map(|at| at as f32 / 15.5 - 1.0);
//! let value = |[x, y, z]: [f32; 3]| (1.0 - (x * x + y * y + z * z).sqrt()).max(0.0);
//! let samples: Vec<f32> = (0..32 * 32 * 32).map(|i| value(at(i))).collect();
//! let grid = Grid::centred([32; 3], [1.0; 3])?;
//! let volume = Volume::new(grid, Samples::F32(samples.into()), Rescale::default(), LengthUnit::Millimetre)?;
//!
//! let colors = ColorMap::from_name("viridis")?.points([0.0, 1.0], 16);
//! let opacities = vec![OpacityPoint::new(0.3, 0.0), OpacityPoint::new(1.0, 0.5)];
//! let scene = Scene::new(volume, TransferFunction::new(colors, opacities, Some(1.0))?);
//!
//! let settings = RenderSettings::best().with_size(ImageSize::new(64, 64)?);
//! let camera = Camera::framing(&scene.bounds()?, View::Iso, Projection::default(), settings.size.aspect())?;
//! let frame = Renderer::new(EngineConfig::default())?.render(&scene, &camera, &settings)?;
//! assert!(frame.image.pixel(32, 32)[3] > 0.9); // alpha; colours are linear and premultiplied
//! assert_eq!(frame.image.pixel(0, 0), [0.0; 4]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # A picture that can be cancelled
//!
//! A [`Control`] hears of progress and of tiles as they finish, and stops a picture within milliseconds, as a viewer's
//! loop needs.
//!
//! ```
//! use std::sync::atomic::{AtomicBool, Ordering};
//! use splatvol::{Camera, Control, EngineConfig, Frame, Item, Projection, RenderSettings, Renderer, Scene, SceneError, View};
//!
//! let scene = Scene::from(Item::automatic(splatvol::samples::sample("marschner-lobb", None)?));
//! let settings = RenderSettings::fast();
//! let camera = Camera::framing(&scene.bounds()?, View::Iso, Projection::default(), settings.size.aspect())?;
//!
//! let stop = AtomicBool::new(false);
//! let give_up_half_way = |share: f64| stop.store(share > 0.5, Ordering::Relaxed);
//! let control = Control { stop: Some(&stop), progress: Some(&give_up_half_way), ..Control::default() };
//! let mut frame = Frame::empty(settings.size);
//! let mut renderer = Renderer::new(EngineConfig::default())?;
//! let result = renderer.render_with(&scene, &camera, &settings, &mut frame, &control);
//! assert_eq!(result, Err(SceneError::Stopped));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Where things are
//!
//! | module | holds |
//! |---|---|
//! | [`volume`], [`grid`], [`storage`], [`source`] | samples, where they lie, whose memory holds them, and their levels |
//! | [`mesh`], [`points`], [`gaussians`], [`harmonics`] | other data: irregular grids, points of surfaces, 3-D Gaussians and their colours |
//! | [`transfer_function`] | colour and opacity of values: points, named maps, or chosen from the data |
//! | [`item`], [`scene`], [`clip`], [`operator`], [`motion`] | things that are rendered together, what is cut away or done to them, how they move |
//! | [`camera`], [`camera_path`] | from where; turntables and key frames |
//! | [`settings`], [`lighting`] | how: presets, the method and its fields, the light |
//! | [`image`], [`exposure`] | what comes out: linear, premultiplied floats with depth; means of several |
//! | [`io`] | files: what is read, and how pictures and animations are written (feature `io`, on by default) |
//! | [`samples`] | built-in volumes, generated on the spot (feature `samples`, on by default) |
//! | `gpu` | the engine on a GPU (feature `gpu`, off by default); [`EngineChoice`] takes it where there is one |
//! | [`radial`] | kernels of the distance and their footprints, to analyse and to tabulate |
//! | [`glam`] | the vectors of signatures; most functions take an array instead |
//!
//! The rest is the making of pictures, at the top of this crate: [`Renderer`], [`EngineConfig`], [`Control`],
//! [`check`], and [`Engine`] for engines other than the CPU's.
//!
//! Settings grow: start from a preset and change what differs, by `with_*` or `..`, and new fields break nothing
//! ([`settings`]).
//!
//! # Where to go on
//!
//! [`examples/`][examples] 01 to 06 go from ten lines to a viewer's loop. The repository's `docs/` have
//! [what is computed, and how exactly][numerics], [the papers' methods][methods], [scenes][scenes],
//! [animations][animation] and [what it costs][performance].
//!
//! [examples]: https://github.com/splatvol/splatvol/tree/main/crates/splatvol/examples
//! [numerics]: https://github.com/splatvol/splatvol/blob/main/docs/numerics.md
//! [methods]: https://github.com/splatvol/splatvol/blob/main/docs/methods.md
//! [scenes]: https://github.com/splatvol/splatvol/blob/main/docs/scenes.md
//! [animation]: https://github.com/splatvol/splatvol/blob/main/docs/animation.md
//! [performance]: https://github.com/splatvol/splatvol/blob/main/docs/performance.md
#![forbid(unsafe_code)]

mod check;
mod choice;
mod cpu;
mod part;
mod progressive;
mod renderer;
mod shutter;

pub use check::check;
pub use choice::EngineChoice;
pub use cpu::CpuEngine;
pub use glam;
pub use progressive::Pass;
pub use renderer::Renderer;
pub use splatvol_core::bin::TileRect;
#[cfg(all(target_family = "wasm", target_os = "unknown"))]
pub use splatvol_core::clock::set_clock;
pub use splatvol_core::engine::{
    Control, Engine, MemoryUse, OnProgress, OnTile, Partial, PassSeconds, RenderStatistics, Share, Shot,
    StageSeconds, Task,
};
pub use splatvol_core::radial;
pub use splatvol_cpu::{EngineConfig, EngineError, Pool, SimdLevel, most_threads};
pub use splatvol_scene::*;

/// The GPU's engine.
#[cfg(feature = "gpu")]
pub mod gpu {
    pub use splatvol_gpu::*;
}

/// Files: readers of all kinds of data, writers of pictures and animations.
#[cfg(feature = "io")]
pub mod io {
    pub use splatvol_io::*;
}

/// Built-in volumes, generated on the spot: nothing to download, the same samples on every run.
#[cfg(feature = "samples")]
pub mod samples {
    pub use splatvol_samples::*;
}

/// The README's programs are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
