//! The viewer without its window: the document and its history, the engine beside it, and what is shown.
//!
//! | module | holds |
//! |---|---|
//! | [`session`] | the document that is shown, its edits and gestures |
//! | [`navigate`], [`curve`] | gestures of the camera; edits of a transfer function |
//! | [`handles`] | handles of clips, and what dragging them does |
//! | [`opening`] | from paths to documents |
//! | [`looks`] | two looks, to compare |
//! | [`engine`] | the engine's thread, with `mailbox`, `draft` and `store`: the latest view wins, drafts, data in memory |
//! | `saving` | pictures written in the background |
//! | `trouble` | what is said of errors |
//! | [`probe`] | what a ray meets |
//! | [`shown_volume`] | the selected item as it is shown, if it is a volume |
//! | [`slice`](mod@slice) | its samples in a plane of voxels |
//! | [`gradients`], [`regions`] | its values and gradients, and transfer functions of both |
//! | [`fading`] | the curve of opacity by gradient |

pub mod curve;
mod draft;
pub mod engine;
pub mod fading;
pub mod gradients;
pub mod handles;
pub mod looks;
mod mailbox;
pub mod navigate;
pub mod opening;
pub mod probe;
pub mod regions;
mod saving;
pub mod session;
pub mod shown_volume;
pub mod slice;
mod store;
mod trouble;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use splatvol::{Camera, EngineChoice, ImageSize, RenderSettings, SceneError};
use splatvol_document::keys::{CameraKeys, ItemKeys, PictureSize, SettingKeys};
use splatvol_document::{Document, DocumentError, Edit, ReadRules, Record};

use engine::{Asked, Engine, Reporter, View};
pub use engine::{DrawnBy, News, Shown, Wake};
use looks::{Look, Looks};
use opening::Opening;
use saving::Saving;
use session::Session;
pub use store::{Choices, Facts, Values};

/// Time after the last input of a gesture until the picture is refined.
const REST: Duration = Duration::from_millis(80);

/// How a viewer starts.
#[derive(Debug, Clone, Default)]
pub struct Start {
    /// Files to open: data side by side, or one scene or picture.
    pub files: Vec<String>,
    /// The command line, which pictures carry.
    pub command: String,
    /// What is refused when files are read.
    pub rules: ReadRules,
    /// Threads of the engine; `None` for one per processor.
    pub threads: Option<usize>,
    /// The engine that draws what the window shows.
    pub engine: EngineChoice,
}

/// A message for the user.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// What to say.
    pub text: String,
    /// Whether something failed.
    pub is_error: bool,
    /// Whether that was the picture: a later one takes the message away.
    is_of_picture: bool,
}

/// What the answer to a request becomes.
#[derive(Debug)]
enum Becomes {
    /// Another session: its document has no earlier one.
    Session(Option<Box<Record>>),
    /// A step of the present one.
    Step,
}

/// What was sent to the engine last.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sent {
    revision: u64,
    size: ImageSize,
    moving: bool,
    engine: EngineChoice,
}

/// The viewer's state.
pub struct Model {
    session: Session,
    engine: Engine,
    choice: EngineChoice,
    news: Receiver<News>,
    reporter: Reporter,
    rules: ReadRules,
    command: String,
    earlier: Option<Record>,
    looks: Looks,
    facts: Vec<(ItemKeys, Facts)>,
    asked: Option<(u64, Becomes, Instant)>,
    requests: u64,
    views: u64,
    sent: Option<Sent>,
    /// When a gesture changed something last.
    touched: Option<Instant>,
    size: Option<ImageSize>,
    shown: Option<Shown>,
    /// Number of the last view of the session before this one.
    views_before: u64,
    /// Number of pictures shown so far.
    pictures: u64,
    progress: Option<f64>,
    message: Option<Message>,
    writing: Option<(Arc<AtomicBool>, f64)>,
    /// Why nothing was written last.
    refused: Option<String>,
}

impl Model {
    /// Starts the engine, and opens the files.
    ///
    /// # Errors
    /// Threads that the system refuses.
    pub fn new(start: Start, wake: Wake) -> Result<Self, std::io::Error> {
        let (sender, news) = channel();
        let reporter = Reporter { news: sender, wake };
        let mut model = Self {
            session: Session::default(),
            engine: Engine::start(start.rules, start.threads, reporter.clone())?,
            choice: start.engine,
            news,
            reporter,
            rules: start.rules,
            command: start.command,
            earlier: None,
            looks: Looks::default(),
            facts: Vec::new(),
            asked: None,
            requests: 0,
            views: 0,
            sent: None,
            touched: None,
            size: None,
            shown: None,
            views_before: 0,
            pictures: 0,
            progress: None,
            message: None,
            writing: None,
            refused: None,
        };
        if !start.files.is_empty() {
            model.open(&start.files);
        }
        Ok(model)
    }

    /// The document and its history.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// The document.
    pub fn document(&self) -> &Document {
        self.session.document()
    }

    /// The picture that is shown.
    pub fn shown(&self) -> Option<&Shown> {
        self.shown.as_ref()
    }

    /// Number of pictures shown so far: equal numbers, equal pictures.
    pub fn pictures(&self) -> u64 {
        self.pictures
    }

    /// Whether the final picture of the document is shown.
    pub fn is_final(&self) -> bool {
        let newest = self.shown.as_ref().is_some_and(|shown| {
            shown.draft_step.is_none() && shown.number == self.views && Some(shown.view_size) == self.size
        });
        let current = self
            .sent
            .is_some_and(|sent| sent.revision == self.session.revision());
        newest && current && self.asked.is_none()
    }

    /// The engine that is to draw what is shown.
    pub fn engine_choice(&self) -> EngineChoice {
        self.choice
    }

    /// Shows everything by another engine. Pictures are saved by the CPU's, whatever is chosen.
    pub fn choose_engine(&mut self, choice: EngineChoice) {
        self.choice = choice;
        self.message = None;
    }

    /// The finished share of the final picture, while it is made.
    pub fn progress(&self) -> Option<f64> {
        self.progress
    }

    /// The last message.
    pub fn message(&self) -> Option<&Message> {
        self.message.as_ref()
    }

    /// Takes the message away.
    pub fn dismiss(&mut self) {
        self.message = None;
    }

    /// Since when the engine reads or decides something.
    pub fn asked_since(&self) -> Option<Instant> {
        self.asked.as_ref().map(|(.., since)| *since)
    }

    /// The finished share of what is written in the background.
    pub fn writing(&self) -> Option<f64> {
        self.writing.as_ref().map(|(_, share)| *share)
    }

    /// What is known about the data of an item.
    pub fn facts(&self, item: &ItemKeys) -> Option<&Facts> {
        let keys = store::reading_keys(item);
        self.facts
            .iter()
            .find(|(of, _)| *of == keys)
            .map(|(_, facts)| facts)
    }

    /// Opens files instead of what is shown.
    pub fn open(&mut self, paths: &[String]) {
        match opening::documents(paths, self.rules) {
            Ok((document, record)) => self.ask(document, Becomes::Session(record.map(Box::new))),
            Err(error) => self.fail(&error),
        }
    }

    /// Opens a file that was dropped: a transfer function becomes the look of the item with this number, data are added if asked, and everything
    /// else replaces what is shown.
    pub fn drop_file(&mut self, path: &str, (adds, selected): (bool, usize)) {
        match Opening::of_path(path, self.rules) {
            Ok(Opening::Document(document, record)) => self.ask(*document, Becomes::Session(record)),
            Ok(Opening::Data(item)) if adds && !self.session.items().is_empty() => self.add(*item),
            Ok(Opening::Data(item)) => {
                self.ask(Document::of_items([*item]), Becomes::Session(None));
            }
            Ok(Opening::Look(path)) => {
                let keys = ItemKeys {
                    tf: Some(path),
                    ..ItemKeys::default()
                };
                self.change(opening::with_item_keys(self.document(), selected, keys));
            }
            Err(error) => self.fail(&error),
        }
    }

    /// Adds an item.
    pub fn add(&mut self, item: ItemKeys) {
        let mut document = self.document().clone();
        document.items.push(item);
        self.change(document);
    }

    /// Removes an item; the last one stays.
    pub fn remove(&mut self, index: usize) {
        if self.session.items().len() > 1 {
            self.edit(Edit::Remove(index));
        }
    }

    /// Asks for a document in place of the present one, as a step: what it leaves open is decided by the data.
    pub fn change(&mut self, document: Document) {
        self.ask(document, Becomes::Step);
    }

    /// Asks for settings over the present ones, as flags are laid over an earlier picture.
    pub fn change_settings(&mut self, settings: SettingKeys) {
        let asked = Document {
            settings,
            ..Document::default()
        };
        self.change(asked.over(self.document()));
    }

    /// Asks for a camera over the present one: a side to look from, or one that fits.
    pub fn change_camera(&mut self, camera: CameraKeys) {
        let asked = Document {
            camera,
            ..Document::default()
        };
        self.change(asked.over(self.document()));
    }

    /// Asks for the look of an item over its present one.
    pub fn change_look(&mut self, index: usize, keys: ItemKeys) {
        self.change(opening::with_item_keys(self.document(), index, keys));
    }

    fn ask(&mut self, document: Document, becomes: Becomes) {
        self.requests += 1;
        self.asked = Some((self.requests, becomes, Instant::now()));
        self.message = None;
        self.engine.ask(Asked {
            number: self.requests,
            document,
            size: self.size.unwrap_or(RenderSettings::default().size),
        });
    }

    /// Makes an edit that is a step of its own.
    pub fn edit(&mut self, edit: Edit) {
        let done = self.session.edit(edit);
        self.report(done);
    }

    /// Makes edits that belong to the gesture that is being made; drafts follow it.
    pub fn gesture(&mut self, change: impl FnOnce(&mut Session) -> Result<(), DocumentError>) {
        let done = change(&mut self.session);
        self.touched = Some(Instant::now());
        self.report(done);
    }

    /// Moves the camera, as a part of a gesture.
    pub fn move_camera(&mut self, change: impl FnOnce(&Camera) -> Result<Camera, SceneError>) {
        let Some(camera) = self.session.camera() else {
            return;
        };
        self.gesture(|session| session.place_camera(&change(&camera)?));
    }

    /// Ends the gesture: what follows is another step.
    pub fn end_gesture(&mut self) {
        self.session.end_gesture();
    }

    /// Undoes a step.
    pub fn undo(&mut self) {
        self.walk(Session::undo);
    }

    /// Repeats a step.
    pub fn redo(&mut self) {
        self.walk(Session::redo);
    }

    /// Walks a step through the history.
    fn walk(&mut self, step: impl FnOnce(&mut Session) -> Result<bool, DocumentError>) {
        let before = Look::of(self.document());
        let done = step(&mut self.session).map(drop);
        self.looks.follow(before, self.session.document());
        self.report(done);
    }

    /// Both looks.
    pub fn looks(&self) -> &Looks {
        &self.looks
    }

    /// Shows the other look, as a step. At first B is a copy of A.
    pub fn change_looks(&mut self) {
        match self.looks.change(self.session.document()) {
            Some(document) => self.edit(Edit::Replace(Box::new(document))),
            None => self.say(
                "This is look B, a copy of A: change it, and compare them by the key B.",
                false,
            ),
        }
    }

    fn report(&mut self, done: Result<(), DocumentError>) {
        match done {
            Ok(()) => self.message = None,
            Err(error) => self.fail(&error),
        }
    }

    fn fail(&mut self, error: &DocumentError) {
        self.say(error.to_string(), true);
    }

    /// Tells the user something.
    pub fn say(&mut self, text: impl Into<String>, is_error: bool) {
        self.message = Some(Message {
            text: text.into(),
            is_error,
            is_of_picture: false,
        });
    }

    /// Why what was to be written last was not.
    pub fn refused(&self) -> Option<&str> {
        self.refused.as_deref()
    }

    fn refuse(&mut self, text: String) {
        self.say(text.clone(), true);
        self.refused = Some(text);
    }

    /// Writes the picture of the document in the background, at its own size or the view's.
    pub fn save(&mut self, path: PathBuf, size: Option<ImageSize>, overwrite: bool) {
        let Some(view_size) = self.size.filter(|_| !self.session.items().is_empty()) else {
            return;
        };
        self.refused = None;
        if self.writing.is_some() {
            self.refuse("a picture is being written already".to_owned());
            return;
        }
        let document = Document {
            size: size.map(PictureSize).or(self.document().size),
            ..self.document().clone()
        };
        let saving = Saving {
            document,
            size: view_size,
            path,
            overwrite,
            earlier: self.earlier.clone(),
            command: self.command.clone(),
            rules: self.rules,
        };
        if let Err(error) = saving.check() {
            self.refuse(error);
            return;
        }
        let stop = Arc::new(AtomicBool::new(false));
        let control = (Arc::clone(&stop), self.reporter.clone());
        match saving::start(saving, Arc::clone(self.engine.store()), control) {
            Ok(()) => self.writing = Some((stop, 0.0)),
            Err(error) => self.refuse(error.to_string()),
        }
    }

    /// Stops what is written in the background.
    pub fn stop_writing(&self) {
        if let Some((stop, _)) = &self.writing {
            stop.store(true, Ordering::Relaxed);
        }
    }

    /// Takes news, and sends the view if it changed. See [`Self::send`].
    pub fn tick(&mut self, pane: [u32; 2]) -> Option<Duration> {
        self.listen();
        self.send(pane)
    }

    /// Takes news: the window may have other panels from now on.
    pub fn listen(&mut self) {
        while let Ok(news) = self.news.try_recv() {
            self.hear(news);
        }
    }

    /// Sends the view if it changed. `pane` is the room for the picture, pixels. Returns when to call again without input.
    pub fn send(&mut self, pane: [u32; 2]) -> Option<Duration> {
        let size = opening::view_size(self.document().size, pane);
        let Ok(size) = ImageSize::new(size[0], size[1]) else {
            return None;
        };
        self.size = Some(size);
        if self.session.items().is_empty() {
            return None;
        }
        let rests_in = self
            .touched
            .and_then(|touched| REST.checked_sub(touched.elapsed()));
        let wanted = Sent {
            revision: self.session.revision(),
            size,
            moving: rests_in.is_some(),
            engine: self.choice,
        };
        let changed = self.sent.is_none_or(|sent| {
            let comes_to_rest = sent.moving && !wanted.moving;
            let moving = wanted.moving;
            comes_to_rest || Sent { moving, ..sent } != wanted
        });
        if changed {
            self.views += 1;
            self.progress = None;
            self.engine.show(View {
                number: self.views,
                document: self.document().clone(),
                size,
                moving: wanted.moving,
                engine: wanted.engine,
            });
            self.sent = Some(wanted);
        }
        rests_in
    }

    fn hear(&mut self, news: News) {
        match news {
            News::Resolved {
                number,
                document,
                facts,
                warnings,
            } => {
                let Some((_, becomes, _)) = self.asked.take_if(|(asked, ..)| *asked == number) else {
                    return;
                };
                for (item, facts) in document.items.iter().zip(facts) {
                    if let Some(facts) = facts.filter(|_| self.facts(item).is_none()) {
                        self.facts.push((store::reading_keys(item), facts));
                    }
                }
                match becomes {
                    Becomes::Session(record) => {
                        self.session = Session::continuing(*document, &self.session);
                        self.looks = Looks::default();
                        self.earlier = record.map(|record| *record);
                        self.sent = None;
                        self.views_before = self.views;
                    }
                    Becomes::Step => self.edit(Edit::Replace(document)),
                }
                if !warnings.is_empty() {
                    self.say(warnings.join("; "), false);
                }
            }
            News::Failed { number, message } => {
                match number {
                    Some(number) => drop(self.asked.take_if(|(asked, ..)| *asked == number)),
                    None => {
                        self.progress = None;
                        // A picture of other data would seem to be one of these.
                        self.shown.take_if(|shown| shown.number <= self.views_before);
                    }
                }
                self.message = Some(Message {
                    text: message,
                    is_error: true,
                    is_of_picture: number.is_none(),
                });
            }
            News::Shown(shown) => {
                if shown.draft_step.is_none() {
                    self.progress = None;
                    self.message.take_if(|message| message.is_of_picture);
                }
                self.shown = Some(*shown);
                self.pictures += 1;
            }
            News::Progress(share) => self.progress = Some(share),
            News::Writing(share) => {
                if let Some((_, written)) = &mut self.writing {
                    *written = share;
                }
            }
            News::Written(result) => {
                let stopped = self
                    .writing
                    .take()
                    .is_some_and(|(stop, _)| stop.load(Ordering::Relaxed));
                match result {
                    Ok(text) => self.say(text, false),
                    Err(_) if stopped => self.say("stopped: nothing was written", false),
                    Err(text) => self.refuse(text),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
