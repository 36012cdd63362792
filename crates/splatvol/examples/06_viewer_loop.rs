//! Teaches: the loop of a viewer: a draft at once, tiles as they finish, progress, and a picture that is cancelled as
//! soon as the user turns the view.
//!
//! `cargo run --release --example 06_viewer_loop [view.png]` plays a user who drags the view three times while it
//! renders, and writes the final picture.
//!
//! The renderer lives on a thread of its own. The window's thread (here this program's main thread) only sends views,
//! which cancel the picture being made, and takes what comes.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

use splatvol::samples::{Sample, SampleSize};
use splatvol::{
    Camera, CameraPath, Control, EngineConfig, EngineError, Frame, Image, ImageSize, Item, Projection,
    RenderSettings, Renderer, Scene, SceneError, TileRect, View, io,
};

/// A view that the user wants, and the flag that cancels it.
struct Wanted {
    number: usize,
    camera: Camera,
    stop: Arc<AtomicBool>,
}

/// What the renderer reports about a view.
struct News {
    view: usize,
    what: What,
}

enum What {
    /// Some pixels of the picture: its draft, or a finished tile.
    Pixels(TileRect, Vec<[f32; 4]>),
    /// The finished share.
    Share(f64),
    /// The picture is complete.
    Finished(Box<Frame>),
    /// The picture was cancelled.
    GivenUp,
    /// There will be no picture.
    Failed(SceneError),
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let output = std::env::args().nth(1).unwrap_or_else(|| "view.png".to_owned());
    let scene = Scene::from(Item::automatic(
        Sample::Head.generate(Some(SampleSize::Longest(80)))?,
    ));
    let settings = RenderSettings::balanced().with_size(ImageSize::new(360, 360)?);
    let aspect = settings.size.aspect();
    let start = Camera::framing(&scene.bounds()?, View::Front, Projection::default(), aspect)?;
    let path = CameraPath::turntable(start, 40.0)?;

    let (views, wanted) = channel();
    let (news, heard) = channel();
    let renderer = thread::spawn(move || render(&scene, settings, &wanted, &news));

    let mut window = Image::filled(settings.size, [0.0; 4]);
    let mut view = send(&views, 0, &path)?;
    for News { view: of, what } in heard {
        // News of views that are no longer wanted comes late, and does not matter.
        if of != view.number {
            continue;
        }
        match what {
            What::Pixels(rect, pixels) => paste(&mut window, &rect, &pixels),
            // The user drags the view while its picture is being made.
            What::Share(share) if share > 0.3 && of < 3 => {
                println!("view {of}: {:.0} % done, but the user turns on", 100.0 * share);
                view.stop.store(true, Ordering::Relaxed);
                view = send(&views, of + 1, &path)?;
            }
            What::Share(_) | What::GivenUp => {}
            What::Finished(frame) => {
                println!("view {of}: complete");
                assert_eq!(window, frame.image, "what was shown is the picture");
                io::write_frame(&output, &frame, &[])?;
                break;
            }
            What::Failed(error) => return Err(error.into()),
        }
    }
    // When nobody wants views any more, the renderer's thread ends.
    drop(views);
    renderer.join().map_err(|_| "the renderer's thread panicked")??;
    println!("wrote {output}");
    Ok(())
}

/// Asks for a view.
fn send(
    views: &Sender<Arc<Wanted>>,
    number: usize,
    path: &CameraPath,
) -> Result<Arc<Wanted>, Box<dyn std::error::Error>> {
    let view = Arc::new(Wanted {
        number,
        camera: path.camera(number as f64 / 3.0)?,
        stop: Arc::new(AtomicBool::new(false)),
    });
    views.send(Arc::clone(&view))?;
    Ok(view)
}

/// The renderer's thread: only the last of the waiting views is wanted.
fn render(
    scene: &Scene,
    settings: RenderSettings,
    wanted: &Receiver<Arc<Wanted>>,
    news: &Sender<News>,
) -> Result<(), EngineError> {
    let mut renderer = Renderer::new(EngineConfig::default())?;
    while let Ok(first) = wanted.recv() {
        let view = wanted.try_iter().last().unwrap_or(first);
        let tell = |what| {
            let number = view.number;
            // The window is closed, so nobody hears the last news.
            let _ = news.send(News { view: number, what });
        };
        let result = picture(&mut renderer, scene, &settings, &view, &tell);
        tell(match result {
            Ok(frame) => What::Finished(Box::new(frame)),
            Err(SceneError::Stopped) => What::GivenUp,
            Err(error) => What::Failed(error),
        });
    }
    Ok(())
}

/// A view: a draft of a quarter of the pixels along each side, then tile by tile.
fn picture(
    renderer: &mut Renderer,
    scene: &Scene,
    settings: &RenderSettings,
    view: &Wanted,
    tell: &(dyn Fn(What) + Sync),
) -> Result<Frame, SceneError> {
    let control = Control {
        stop: Some(&view.stop),
        ..Control::default()
    };
    let [width, height] = <[u32; 2]>::from(settings.size);
    let small = RenderSettings::fast().with_size(ImageSize::new(width / 4, height / 4)?);
    let mut frame = Frame::empty(small.size);
    renderer.render_with(scene, &view.camera, &small, &mut frame, &control)?;
    let whole = TileRect {
        x0: 0,
        y0: 0,
        x1: width as usize,
        y1: height as usize,
    };
    let enlarged = (0..whole.y1).flat_map(|y| (0..whole.x1).map(move |x| [x / 4, y / 4]));
    let pixels = enlarged.map(|[x, y]| frame.image.pixel(x, y)).collect();
    tell(What::Pixels(whole, pixels));

    let tile = |rect: &TileRect, pixels: &[[f32; 4]]| tell(What::Pixels(*rect, pixels.to_vec()));
    let progress = |share| tell(What::Share(share));
    let control = Control {
        tile: Some(&tile),
        progress: Some(&progress),
        ..control
    };
    renderer.render_with(scene, &view.camera, settings, &mut frame, &control)?;
    Ok(frame)
}

/// Puts pixels in their place.
fn paste(window: &mut Image, rect: &TileRect, pixels: &[[f32; 4]]) {
    let width = window.size().width() as usize;
    let columns = rect.x1 - rect.x0;
    for (row, pixels) in pixels.chunks_exact(columns).enumerate() {
        let start = (rect.y0 + row) * width + rect.x0;
        window.pixels[start..start + columns].copy_from_slice(pixels);
    }
}
