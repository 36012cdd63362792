//! The engine's thread: it reads, decides what documents leave open, and draws views.
//!
//! ```text
//! window:  ask(document) ──────────►  read, resolve  ──►  News::Resolved
//!          show(view, moving) ─────►  draft          ──►  News::Shown (draft)
//!          show(view, at rest) ────►  draft, then the picture that `render` makes  ──►  News::Shown (final)
//! ```
//!
//! The window's thread never waits: it leaves work in a mailbox, and hears of results by a channel.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Instant;

use splatvol::{
    Camera, Control, EngineChoice, EngineConfig, EngineError, Frame, Image, ImageSize, RenderSettings,
    Renderer, Scene, SceneError,
};
use splatvol_document::keys::PictureSize;
use splatvol_document::resolve::laid_over;
use splatvol_document::{Document, DocumentError, Listener, Picture, ReadRules, Reading, Resolving};

use super::draft::{self, Pace};
use super::mailbox::{Mailbox, Work};
use super::store::{Facts, Store};
use super::trouble;

/// A final picture that is expected to take no longer than this needs no draft before it, seconds.
const AT_ONCE: f64 = 0.06;

/// A document whose open decisions are to be made.
#[derive(Debug)]
pub(super) struct Asked {
    /// Number of the request, which the answer repeats.
    pub(super) number: u64,
    pub(super) document: Document,
    /// Size of the picture, where the document has none: the window's.
    pub(super) size: ImageSize,
}

/// A view that is to be shown.
#[derive(Debug, Clone)]
pub(super) struct View {
    /// Number of the view, which its pictures repeat.
    pub(super) number: u64,
    pub(super) document: Document,
    pub(super) size: ImageSize,
    /// Whether something moves: a draft is enough.
    pub(super) moving: bool,
    /// Which engine draws it.
    pub(super) engine: EngineChoice,
}

/// What the engine's threads report.
#[derive(Debug)]
pub enum News {
    /// A document with everything decided, and what is known about its items.
    Resolved {
        /// Number of the request.
        number: u64,
        /// The document.
        document: Box<Document>,
        /// What is known about each item that was read.
        facts: Vec<Option<Facts>>,
        /// Warnings of readers.
        warnings: Vec<String>,
    },
    /// A request or a view that failed.
    Failed {
        /// Number of the request; `None` for a view.
        number: Option<u64>,
        /// What to tell the user.
        message: String,
    },
    /// A picture of a view.
    Shown(Box<Shown>),
    /// The finished share of the final picture of a view.
    Progress(f64),
    /// A picture or an animation was written, or not.
    Written(Result<String, String>),
    /// The finished share of a picture or an animation that is written in the background.
    Writing(f64),
}

/// A picture on the screen.
#[derive(Debug, Clone)]
pub struct Shown {
    /// Number of its view.
    pub number: u64,
    /// Codes of sRGB, straight alpha, row by row.
    pub codes: Vec<[u8; 4]>,
    /// Size of `codes`: smaller than the view's if it is a draft.
    pub size: ImageSize,
    /// Size of the view.
    pub view_size: ImageSize,
    /// Pixels per point of the raster; `None` if this is the final picture.
    pub draft_step: Option<f64>,
    /// Time that it took.
    pub seconds: f64,
    /// Who drew it.
    pub drawn_by: DrawnBy,
    /// What was drawn, for picking.
    pub scene: Scene,
    /// From where.
    pub camera: Camera,
}

/// Who drew a picture.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct DrawnBy {
    /// The device, as its driver names it; empty for the processor.
    pub device: String,
    /// Why the processor drew it where a device was preferred; empty elsewhere.
    pub why: String,
}

/// A way to tell the window that there is news.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// Hands news to the window.
#[derive(Clone)]
pub(super) struct Reporter {
    pub(super) news: Sender<News>,
    pub(super) wake: Wake,
}

impl Reporter {
    pub(super) fn tell(&self, news: News) {
        // A window that is closed hears nothing.
        let _ = self.news.send(news);
        (self.wake)();
    }
}

/// Hears warnings of readers.
#[derive(Debug, Default)]
pub(super) struct Warnings(Mutex<Vec<String>>);

impl Warnings {
    pub(super) fn take(&self) -> Vec<String> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Listener for Warnings {
    fn warn(&self, message: &str) {
        self.0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push(message.to_owned());
    }
}

/// The engine, on a thread of its own. It ends when this is dropped.
pub(super) struct Engine {
    mailbox: Arc<Mailbox<Asked, View>>,
    thread: Option<JoinHandle<()>>,
    store: Arc<Mutex<Store>>,
}

impl Engine {
    /// Starts the thread.
    ///
    /// # Errors
    /// Threads that the system refuses.
    pub(super) fn start(
        rules: ReadRules,
        threads: Option<usize>,
        reporter: Reporter,
    ) -> Result<Self, std::io::Error> {
        let mailbox = Arc::new(Mailbox::new());
        let store = Arc::new(Mutex::new(Store::default()));
        let worker = Worker {
            mailbox: Arc::clone(&mailbox),
            store: Arc::clone(&store),
            rules,
            reporter,
            config: EngineConfig {
                threads,
                ..EngineConfig::default()
            },
            renderer: None,
            prepared: None,
            pace: Pace::default(),
            drafted: None,
            final_seconds_per_pixel: None,
        };
        let thread = std::thread::Builder::new()
            .name("engine".to_owned())
            .spawn(move || worker.run())?;
        Ok(Self {
            mailbox,
            thread: Some(thread),
            store,
        })
    }

    pub(super) fn ask(&self, asked: Asked) {
        self.mailbox.request(asked);
    }

    pub(super) fn show(&self, view: View) {
        self.mailbox.view(view);
    }

    /// The data that are held.
    pub(super) fn store(&self) -> &Arc<Mutex<Store>> {
        &self.store
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        self.mailbox.close();
        if let Some(thread) = self.thread.take() {
            // A panic there has been printed; the window closes all the same.
            let _ = thread.join();
        }
    }
}

/// What was prepared for a view.
struct Prepared {
    document: Document,
    size: ImageSize,
    picture: Picture,
}

struct Worker {
    mailbox: Arc<Mailbox<Asked, View>>,
    store: Arc<Mutex<Store>>,
    rules: ReadRules,
    reporter: Reporter,
    config: EngineConfig,
    /// The engine that was started last.
    renderer: Option<(EngineChoice, Renderer)>,
    prepared: Option<Prepared>,
    pace: Pace,
    /// The document and size of the last draft.
    drafted: Option<(Document, ImageSize)>,
    final_seconds_per_pixel: Option<f64>,
}

impl Worker {
    fn run(mut self) {
        while let Some(work) = self.mailbox.next() {
            match work {
                Work::Request(asked) => {
                    let number = asked.number;
                    match self.resolved(asked) {
                        Ok(news) => self.reporter.tell(news),
                        Err(error) => self.fail(Some(number), &error),
                    }
                    self.pace = Pace::default();
                    self.final_seconds_per_pixel = None;
                }
                Work::View(view) => match self.view(&view) {
                    Ok(()) | Err(DocumentError::Scene(SceneError::Stopped)) => {}
                    Err(error) => self.fail(None, &error),
                },
            }
        }
    }

    fn fail(&self, number: Option<u64>, error: &DocumentError) {
        self.reporter.tell(News::Failed {
            number,
            message: trouble::of_window(error),
        });
    }

    /// Reads, and decides what is open.
    fn resolved(&mut self, asked: Asked) -> Result<News, DocumentError> {
        let warnings = Warnings::default();
        let follows_window = asked.document.size.is_none();
        let picture = resolve(
            &self.store,
            (&asked.document, asked.size),
            (self.rules, &warnings),
        )?;
        splatvol::check(&picture.scene, &picture.camera, &picture.settings)?;
        let facts = lock(&self.store).facts(&asked.document);
        let document = Document {
            size: picture.document.size.filter(|_| !follows_window),
            animation: asked.document.animation.clone(),
            ..picture.document
        };
        Ok(News::Resolved {
            number: asked.number,
            document: Box::new(document),
            facts,
            warnings: warnings.take(),
        })
    }

    /// Draws a view: a draft, and at rest what `render` makes.
    fn view(&mut self, view: &View) -> Result<(), DocumentError> {
        self.prepare(view)?;
        self.start(view.engine)
            .map_err(|error| DocumentError::usage(error.to_string()))?;
        let expected = self
            .final_seconds_per_pixel
            .map_or(f64::INFINITY, |cost| cost * view.size.pixel_count() as f64);
        let known = self
            .drafted
            .as_ref()
            .is_some_and(|(document, size)| *document == view.document && *size == view.size);
        if view.moving || (expected > AT_ONCE && !known) {
            self.draft(view)?;
        }
        if view.moving {
            return Ok(());
        }
        self.complete(view)
    }

    fn prepare(&mut self, view: &View) -> Result<(), DocumentError> {
        let same = |known: &Prepared| known.document == view.document && known.size == view.size;
        if self.prepared.as_ref().is_some_and(same) {
            return Ok(());
        }
        let picture = resolve(
            &self.store,
            (&view.document, view.size),
            (self.rules, &Warnings::default()),
        )?;
        self.prepared = Some(Prepared {
            document: view.document.clone(),
            size: view.size,
            picture,
        });
        Ok(())
    }

    /// Starts an engine unless it runs already.
    fn start(&mut self, choice: EngineChoice) -> Result<(), EngineError> {
        if self.renderer.as_ref().is_some_and(|(of, _)| *of == choice) {
            return Ok(());
        }
        // The memory of one is free before the other asks for its own.
        self.renderer = None;
        self.renderer = Some((choice, Renderer::start(choice, self.config)?));
        self.pace = Pace::default();
        self.drafted = None;
        self.final_seconds_per_pixel = None;
        Ok(())
    }

    fn draft(&mut self, view: &View) -> Result<(), DocumentError> {
        let (Some(Prepared { picture, .. }), Some((_, renderer))) = (&self.prepared, &mut self.renderer)
        else {
            return Ok(());
        };
        let step = self.pace.step(view.size);
        let size = draft::coarser(view.size, step);
        let settings = draft::settings(&picture.scene, &picture.camera, &picture.settings, size);
        let stop = self.mailbox.begin(true);
        let start = Instant::now();
        let frame = render(renderer, picture, &settings, (&[], &stop), &|_| {});
        let seconds = start.elapsed().as_secs_f64();
        self.mailbox.end();
        let frame = frame?;
        let stages = &renderer.statistics().seconds;
        // Preparation comes once, not with every frame.
        self.pace
            .learn(size, (seconds - stages.prefilter - stages.classify).max(0.0));
        self.drafted = Some((view.document.clone(), view.size));
        let drawn_by = drawn_by(renderer);
        self.reporter
            .tell(shown((view, picture), &frame, (Some(step), seconds, drawn_by)));
        Ok(())
    }

    fn complete(&mut self, view: &View) -> Result<(), DocumentError> {
        let (Some(Prepared { picture, .. }), Some((_, renderer))) = (&self.prepared, &mut self.renderer)
        else {
            return Ok(());
        };
        let stop = self.mailbox.begin(false);
        let told = AtomicU32::new(0);
        let progress = |share: f64| {
            // A picture reports each tile; the window needs no more than a hundred steps.
            let percent = (100.0 * share) as u32;
            if told.fetch_max(percent, Ordering::Relaxed) < percent {
                self.reporter.tell(News::Progress(share));
            }
        };
        let start = Instant::now();
        let frame = render(
            renderer,
            picture,
            &picture.settings,
            (&picture.sub_frames, &stop),
            &progress,
        );
        let seconds = start.elapsed().as_secs_f64();
        self.mailbox.end();
        let frame = frame?;
        self.final_seconds_per_pixel = Some(seconds / view.size.pixel_count() as f64);
        let drawn_by = drawn_by(renderer);
        self.reporter
            .tell(shown((view, picture), &frame, (None, seconds, drawn_by)));
        Ok(())
    }
}

pub(super) fn lock(store: &Mutex<Store>) -> std::sync::MutexGuard<'_, Store> {
    // A reader that panicked has left no entry behind.
    store.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A document with the data that are held; what is missing is read.
pub(super) fn resolve(
    store: &Mutex<Store>,
    (document, size): (&Document, ImageSize),
    (rules, listener): (ReadRules, &dyn Listener),
) -> Result<Picture, DocumentError> {
    let reading = Reading {
        rules,
        folder: None,
        listener,
    };
    let held = {
        let mut store = lock(store);
        store.read(document, reading)?;
        store.held(document)
    };
    let document = Document {
        size: document.size.or(Some(PictureSize(size))),
        ..document.clone()
    };
    document.resolve(Resolving {
        reading,
        held: &held,
        moves: splatvol_document::CameraMotion::default(),
        keeps_alpha: false,
        in_windows: false,
    })
}

/// Renders a picture, or the mean of what several cameras see.
pub(super) fn render(
    renderer: &mut Renderer,
    picture: &Picture,
    settings: &RenderSettings,
    (cameras, stop): (&[Camera], &AtomicBool),
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Frame, SceneError> {
    let control = Control {
        stop: Some(stop),
        progress: Some(progress),
        ..Control::default()
    };
    let mut frame = Frame::empty(settings.size);
    match cameras {
        [] => renderer.render_with(&picture.scene, &picture.camera, settings, &mut frame, &control)?,
        cameras => renderer.expose(&picture.scene, cameras, settings, &mut frame, &control)?,
    }
    Ok(frame)
}

fn drawn_by(renderer: &Renderer) -> DrawnBy {
    let statistics = renderer.statistics();
    DrawnBy {
        device: statistics.device.clone(),
        why: statistics.why.clone(),
    }
}

fn shown(
    (view, picture): (&View, &Picture),
    frame: &Frame,
    (draft_step, seconds, drawn_by): (Option<f64>, f64, DrawnBy),
) -> News {
    News::Shown(Box::new(Shown {
        number: view.number,
        codes: codes(&frame.image, picture),
        size: frame.image.size(),
        view_size: view.size,
        draft_step,
        seconds,
        drawn_by,
        scene: picture.scene.clone(),
        camera: picture.camera,
    }))
}

/// The codes that a PNG of 8 bits would hold.
fn codes(image: &Image, picture: &Picture) -> Vec<[u8; 4]> {
    match picture.background() {
        Some(background) => splatvol_io::image::png::srgb8(&laid_over(image, background)),
        None => splatvol_io::image::png::srgb8(image),
    }
}
