//! `splatvol animate`: many frames of one scene from a camera that moves.

mod destination;
mod movie;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::Serialize;
use splatvol::Frame;
use splatvol_document::{CameraMotion, Plan, Record};
use splatvol_io::ImageFormat;

use self::destination::{Destination, FrameNames};
use self::movie::Movie;
use crate::args::AnimateArgs;
use crate::commands::asked::{Asked, Delivery, Prepared};
use crate::commands::nothing;
use crate::commands::outputs::encode_with_bits;
use crate::commands::studio::Studio;
use crate::failure::{During, Failure, Step};
use crate::output::{Target, check_distinct};
use crate::record;
use crate::terminal::Terminal;

pub(crate) fn run(args: &AnimateArgs, terminal: &Terminal) -> Result<(), Failure> {
    if args.render.list_methods {
        return Target::Stdout.write(super::methods::list().as_bytes(), false);
    }
    if args.render.depth.is_some() {
        return Err(Failure::usage("--depth: an animation writes no depths")
            .hint("render writes them, for one camera"));
    }
    let start = Instant::now();
    let overwrite = args.render.write.overwrite;
    let mut asked = Asked::of_animation(args)?;
    let animation = asked
        .document
        .animation
        .loaded(asked.reading(&args.render.picture, terminal))?;
    let destination = Destination::new(args)?;
    let stats = args.render.stats.as_deref().map(Target::new);
    if let Some(stats) = &stats {
        stats.check(overwrite)?;
    }
    let moves = CameraMotion {
        turns: animation.turns(),
        shutter: animation.has_shutter(),
    };
    let delivery = Delivery {
        keeps_alpha: matches!(&destination, Destination::Frames(names) if names.format == ImageFormat::Exr),
        in_windows: false,
    };
    asked.leave_motion_of_camera();
    let prepared = asked.prepare(&args.render, (moves, delivery), terminal)?;
    let picture = &prepared.picture;
    let start_of_path = (&picture.camera, picture.settings.motion_blur);
    let plan = Plan::new(&animation, &asked.document.motion, start_of_path)?;
    if let Destination::Frames(names) = &destination {
        names.check(plan.frames(), overwrite || args.resume)?;
    }
    if let Some(stats) = &stats {
        for animation in destination.targets(plan.frames()) {
            check_distinct(&[("animation", &animation), ("statistics", stats)])?;
        }
    }
    let job = Job {
        args,
        plan: &plan,
        prepared: &prepared,
        terminal,
    };
    let times = match &destination {
        Destination::Frames(names) => job.frames(names)?,
        Destination::Movie(path, container) => {
            // The record of the first frame gives the beginning of a file of all frames.
            let metadata = job.metadata(&job.record(0)?)?;
            let timing = (plan.frames(), animation.rate());
            job.movie(Movie::start(path, *container, (picture, &metadata), timing)?)?
        }
    };
    let seconds = start.elapsed().as_secs_f64();
    job.say_done(&times, seconds);
    if let Some(stats) = stats {
        let mut json = serde_json::to_string_pretty(&times.report(&plan, seconds)).during(Step::Output)?;
        json.push('\n');
        stats.write(json.as_bytes(), overwrite)?;
    }
    Ok(())
}

/// Seconds that the frames took; none for those that were kept.
#[derive(Debug, Default)]
struct Times(Vec<Option<f64>>);

/// Statistics that `--stats` writes.
#[derive(Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
struct Report {
    frames: u32,
    kept: usize,
    seconds: f64,
    /// Rendering, one number per frame; null where it was kept.
    frame_seconds: Vec<Option<f64>>,
}

impl Times {
    fn kept(&self) -> usize {
        self.0.iter().filter(|seconds| seconds.is_none()).count()
    }

    fn report(&self, plan: &Plan, seconds: f64) -> Report {
        Report {
            frames: plan.frames(),
            kept: self.kept(),
            seconds,
            frame_seconds: self.0.clone(),
        }
    }
}

/// Everything about an animation except its destination.
struct Job<'a> {
    args: &'a AnimateArgs,
    plan: &'a Plan,
    prepared: &'a Prepared,
    terminal: &'a Terminal,
}

impl Job<'_> {
    fn studio(&self) -> Result<Studio, Failure> {
        let Prepared { picture, means, .. } = self.prepared;
        Studio::new(&picture.scene, picture.settings, *means)
    }

    fn frames(&self, names: &FrameNames) -> Result<Times, Failure> {
        let mut studio = self.studio()?;
        let mut times = Times::default();
        let bar = self.terminal.frames(self.plan.frames());
        for frame in 0..self.plan.frames() {
            let (path, record) = (names.path(frame), self.record(frame)?);
            if self.args.resume && self.is_made(&path, &record) {
                times.0.push(None);
            } else {
                let begun = Instant::now();
                let picture = self.expose(&mut studio, frame)?;
                times.0.push(Some(begun.elapsed().as_secs_f64()));
                self.look_at(picture, frame);
                let Prepared { picture: made, .. } = self.prepared;
                let format = (names.format, made.bits());
                let bytes = encode_with_bits(picture, format, made.background(), &self.metadata(&record)?)?;
                let overwrite = self.args.render.write.overwrite || self.args.resume;
                Target::File(path).write(&bytes, overwrite)?;
            }
            bar.advance();
        }
        Ok(times)
    }

    fn movie(&self, mut movie: Movie) -> Result<Times, Failure> {
        let mut studio = self.studio()?;
        let mut times = Times::default();
        let bar = self.terminal.frames(self.plan.frames());
        for frame in 0..self.plan.frames() {
            let begun = Instant::now();
            let picture = self.expose(&mut studio, frame)?;
            times.0.push(Some(begun.elapsed().as_secs_f64()));
            self.look_at(picture, frame);
            movie.write(picture)?;
            bar.advance();
        }
        movie.finish(self.args.render.write.overwrite)?;
        Ok(times)
    }

    fn expose<'s>(&self, studio: &'s mut Studio, frame: u32) -> Result<&'s Frame, Failure> {
        let sub_frames = self.plan.sub_frames(frame)?;
        if let Some(motion) = self.plan.motion(frame)? {
            studio.set_motion(&motion.motion().during(Step::Usage)?);
        }
        if sub_frames.is_empty() {
            studio.expose(&[self.plan.camera(frame)?])
        } else {
            studio.expose(&sub_frames)
        }
    }

    /// Warns where the first frame shows nothing.
    fn look_at(&self, picture: &Frame, frame: u32) {
        if frame == 0 {
            nothing::warn(nothing::is_empty(picture), &self.prepared.picture, self.terminal);
        }
    }

    /// Texts for a file, unless none are wanted.
    fn metadata(&self, record: &Record) -> Result<Vec<(String, String)>, Failure> {
        match self.args.render.no_metadata {
            true => Ok(Vec::new()),
            false => Ok(record.metadata()?),
        }
    }

    /// The record of a frame.
    fn record(&self, frame: u32) -> Result<Record, Failure> {
        let all = &self.prepared.record;
        Ok(Record {
            document: self.plan.document(&all.document, frame)?,
            command: all.command.clone(),
        })
    }

    /// Whether the file holds exactly the frame that would be made: its own record says so, and the data are no
    /// newer.
    fn is_made(&self, path: &Path, record: &Record) -> bool {
        path.exists()
            && record::of_picture(path).is_ok_and(|made| made.document == record.document)
            && !is_older(path, &self.prepared.picture.files)
    }

    fn say_done(&self, times: &Times, seconds: f64) {
        let size = self.prepared.picture.settings.size;
        let output = self.args.render.output.clone().unwrap_or_default();
        let kept = match times.kept() {
            0 => String::new(),
            kept => format!(", {kept} of them kept"),
        };
        self.terminal.note(format!(
            "wrote {} ({} frames{kept}, {}x{}, {seconds:.2} s)",
            output.display(),
            self.plan.frames(),
            size.width(),
            size.height()
        ));
    }
}

/// Whether a file is older than one of the others; if the system does not say, it is not.
fn is_older(path: &Path, others: &[PathBuf]) -> bool {
    let modified = |path: &Path| fs::metadata(path).and_then(|data| data.modified()).ok();
    let own = modified(path);
    others
        .iter()
        .any(|other| matches!((own, modified(other)), (Some(own), Some(other)) if own < other))
}
