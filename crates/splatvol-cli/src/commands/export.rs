//! `splatvol export`: one HTML file, with the engine and the data.
//!
//! The picture is rendered twice, from all data and from those of the page: how far the two are apart is what the page's
//! size costs.

use std::path::PathBuf;

use serde::Serialize;
use splatvol::{Content, Frame, Item};
use splatvol_document::resolve::laid_over;
use splatvol_document::{CameraMotion, ChunkRules, Document, Held, Picture, Resolving, Silent};
use splatvol_io::ImageFormat;
use splatvol_page::{Absent, Bits, Fitted, Page, PageContent, PageError, WebGpu};
use splatvol_web::{ItemData, held, size_of};

use super::asked::{self, Asked};
use super::metrics::PictureDifference;
use super::outputs::{encode_with_bits, short_name};
use super::studio::{Means, Studio};
use crate::args::{EngineName, ExportArgs, PageArgs};
use crate::failure::{During, Failure, Step};
use crate::output::{Target, check_distinct};
use crate::terminal::Terminal;

/// Largest page unless asked otherwise, bytes.
const MOST_BYTES: u64 = 15_000_000;
/// Bytes of the sentences about the data, which are known only after they have been fitted.
const NOTES: u64 = 2048;

pub(crate) fn run(args: &ExportArgs, terminal: &Terminal) -> Result<(), Failure> {
    splatvol_page::engine().map_err(|absent| Failure::usage(absent).hint(Absent::REMEDY))?;
    warn_of_outdated(terminal);
    let asked = Asked::of_page(&args.page)?;
    let name = short_name(asked.document.reference());
    let output = args
        .output
        .clone()
        .unwrap_or_else(|| PathBuf::from(format!("{name}.html")));
    let page = Target::new(&output);
    let report = args.report.as_deref().map(Target::new);
    let overwrite = args.write.overwrite;
    let mut targets = vec![("the page", &page)];
    targets.extend(report.as_ref().map(|report| ("--report", report)));
    check_distinct(&targets)?;
    targets
        .iter()
        .try_for_each(|(_, target)| target.check(overwrite))?;

    let exported = Exported::new(&asked, (&args.page, None), terminal)?;
    let title = args.page.title.as_deref().unwrap_or(&name);
    let quantize = args.quantize.map(|bits| vec![Bits::from(bits)]);
    let bits = quantize.as_deref().unwrap_or(&Bits::ALL);
    let readers = match args.open_files {
        true => splatvol_page::readers().map_err(Failure::usage)?,
        false => &[],
    };
    let kind = PageKind::File { readers };
    let (html, said) = exported.page(title, (args.page.max_size, bits), kind)?;
    page.write(html.as_bytes(), overwrite)?;
    if let Some(target) = &report {
        let json = serde_json::to_string_pretty(&said).during(Step::Output)? + "\n";
        target.write(json.as_bytes(), overwrite)?;
    }
    terminal.note(said.data());
    terminal.note(said.error());
    if !said.webgpu && exported.webgpu.is_some() {
        terminal.note("The engine for WebGPU would make the page larger than --max-size, and was left out.");
    }
    if let Target::File(path) = &page {
        terminal.note(format!("wrote {} ({})", path.display(), megabytes(said.bytes)));
    }
    Ok(())
}

/// Says that the program's engine for browsers was built of other sources.
pub(super) fn warn_of_outdated(terminal: &Terminal) {
    if let Some(sentence) = splatvol_page::outdated() {
        terminal.warn(sentence);
    }
}

/// Where a page comes from.
#[derive(Debug, Clone, Copy)]
enum PageKind {
    /// A file, which may have readers of other files.
    File { readers: &'static [u8] },
    /// A server.
    Served,
}

/// A picture that a page can show, and how it is rendered.
pub(super) struct Exported {
    picture: Picture,
    means: Means,
    /// The picture of all data.
    frame: Frame,
    /// The GPU engine, if pages may have it.
    webgpu: Option<WebGpu>,
}

/// What was made, and what it costs.
#[derive(Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
struct Report {
    /// Bytes of the page.
    bytes: u64,
    /// Bytes of the data in it, as gzip.
    data_bytes: u64,
    /// Most bits per number: 32 where nothing was rounded.
    bits: Bits,
    /// Levels of detail that were left out: halvings of the resolution along each axis, degrees of harmonics.
    level: usize,
    /// What is in the page, for each item.
    items: Vec<Kept>,
    /// The same, for people.
    #[serde(skip)]
    said: Vec<String>,
    /// Whether the numbers are those of the files.
    exact: bool,
    /// Whether browsers draw what moves by WebGPU.
    webgpu: bool,
    /// PSNR of the page's picture, decibel; absent where it is the same in 8 bits.
    psnr: Option<f64>,
}

/// What is in a page of an item.
#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
enum Kept {
    /// Samples along x, y, z.
    Volume {
        dims: [usize; 3],
    },
    Points {
        count: usize,
    },
    Gaussians {
        count: usize,
        degree: u32,
    },
    Mesh {
        points: usize,
    },
}

impl From<&ItemData> for Kept {
    fn from(data: &ItemData) -> Self {
        match data {
            ItemData::Volume(data) => Self::Volume { dims: data.dims },
            ItemData::Points(data) => Self::Points { count: data.count },
            ItemData::Gaussians(data) => Self::Gaussians {
                count: data.count,
                degree: data.degree,
            },
            ItemData::Mesh(data) => Self::Mesh { points: data.count },
        }
    }
}

impl Report {
    /// What the data are.
    fn data(&self) -> String {
        let items = self.said.join(", ");
        let bits = u8::from(self.bits);
        match (self.exact, self.level) {
            (true, _) => format!("This page has {items}: all data, as they are."),
            (false, 0) => format!("This page has {items}, in {bits} bits."),
            (false, 1) => format!("This page has {items}, in {bits} bits, one level coarser than the data."),
            (false, level) => {
                format!("This page has {items}, in {bits} bits, {level} levels coarser than the data.")
            }
        }
    }

    /// How far the picture is from that of all data.
    fn error(&self) -> String {
        match self.psnr {
            None => "The first picture is that of all data, in 8 bits.".to_owned(),
            Some(psnr) => format!("The first picture is {psnr:.1} dB (PSNR) from that of all data."),
        }
    }
}

impl Exported {
    /// Resolves and renders what is asked for. With rules for chunks, large volumes stay where they are.
    pub(super) fn new(
        asked: &Asked,
        (args, chunks): (&PageArgs, Option<ChunkRules>),
        terminal: &Terminal,
    ) -> Result<Self, Failure> {
        let mut reading = asked.reading(&args.picture, terminal);
        reading.rules.chunks = chunks;
        let resolving = Resolving {
            reading,
            held: &[],
            moves: CameraMotion::default(),
            keeps_alpha: false,
            in_windows: false,
        };
        let mut picture = asked.picture(&asked.document, &args.picture, resolving)?;
        PageContent::of(&picture)?;
        if chunks.is_some_and(|rules| chunk_bytes(&picture) <= rules.memory / 2) {
            picture.scene = picture.scene.in_memory().during(Step::Input)?;
        }
        let picture = asked::whole_where_needed(picture, EngineName::Cpu, terminal)?;
        let means = Means {
            engine: splatvol::EngineChoice::Cpu,
            threads: asked::threads(args.threads, terminal),
        };
        let frame = rendered(&picture, means)?;
        Ok(Self {
            picture,
            means,
            frame,
            webgpu: splatvol_page::webgpu().filter(|_| !args.no_webgpu),
        })
    }

    /// The number of threads that is asked for.
    pub(super) fn threads(&self) -> Option<usize> {
        self.means.threads
    }

    /// The page of a server that has all data, and a sentence about it: with smaller data for drafts, where this program has
    /// the engine for browsers.
    pub(super) fn served_page(&self, title: &str, most: Option<u64>) -> Result<(String, String), Failure> {
        let drafts = match splatvol_page::engine() {
            Ok(_) => {
                let (html, report) = self.page(title, (most, &Bits::ROUNDED), PageKind::Served)?;
                return Ok((
                    html,
                    format!("while the view turns, browsers draw: {}", report.data()),
                ));
            }
            Err(absent) => format!("drafts come from the server, too: {absent} ({})", Absent::REMEDY),
        };
        let document = PageContent::of(&self.picture)?.document(0, short_name);
        let document = serde_json::to_value(document).during(Step::Output)?;
        let page = Page {
            title,
            description: &described(title),
            document: &document,
            data: &[],
            bytes: &[],
            poster: &self.poster()?,
            notes: &[served_by(), made_by()],
            readers: &[],
            webgpu: None,
            is_served: true,
        };
        Ok((page.html().map_err(refused)?, drafts))
    }

    /// The document and the data of its items, all of them.
    pub(super) fn document_and_data(&self) -> Result<(Document, Vec<Option<Held>>), Failure> {
        let content = PageContent::of(&self.picture)?;
        let held = content.data().map(|data| Some(held(data.clone())));
        Ok((content.document(0, short_name), held.collect()))
    }

    /// The picture as a PNG.
    fn poster(&self) -> Result<Vec<u8>, Failure> {
        let look = (ImageFormat::Png8, 8);
        encode_with_bits(&self.frame, look, self.picture.background(), &[])
    }

    /// The page, and what it cost.
    fn page(
        &self,
        title: &str,
        (most, bits): (Option<u64>, &[Bits]),
        kind: PageKind,
    ) -> Result<(String, Report), Failure> {
        let (readers, is_served): (&[u8], bool) = match kind {
            PageKind::File { readers } => (readers, false),
            PageKind::Served => (&[], true),
        };
        let most = most.unwrap_or(MOST_BYTES);
        let content = PageContent::of(&self.picture)?;
        let poster = self.poster()?;
        let description = described(title);
        let json = |document: &Document| serde_json::to_value(document).during(Step::Output);
        let document = json(&content.document(0, short_name))?;
        let empty = Page {
            title,
            description: &description,
            document: &document,
            data: &[],
            bytes: &[],
            poster: &poster,
            notes: &[],
            readers,
            webgpu: None,
            is_served,
        };
        let overhead = empty.overhead().map_err(refused)? + NOTES;
        let fitted = content.fit(bits, Page::room(most, overhead));
        let fitted = fitted.map_err(|error| match error {
            // The limit is the page's; the data have what the rest leaves.
            PageError::TooLarge { why, .. } => Failure::usage(format!("--max-size {most}: {why}"))
                .hint(format!("without the data the page has {overhead} bytes")),
            other => refused(other),
        })?;
        let document = content.document(fitted.level, short_name);
        let shown = resolved(&document, &fitted)?;
        let psnr = self.difference(&rendered(&shown, self.means)?).psnr();
        let mut report = Report {
            bytes: 0,
            data_bytes: fitted.bytes.len() as u64,
            bits: fitted.bits,
            level: fitted.level,
            items: fitted.data.iter().map(Kept::from).collect(),
            said: fitted
                .held
                .iter()
                .flatten()
                .map(|held| size_of(held.content()))
                .collect(),
            exact: fitted.exact,
            webgpu: false,
            psnr,
        };
        let notes = match is_served {
            true => vec![served_by(), made_by()],
            false => {
                let alone = "Everything is in this file: it makes no connection, and sends nothing anywhere.";
                vec![report.data(), report.error(), alone.to_owned(), made_by()]
            }
        };
        let page = Page {
            document: &json(&document)?,
            data: &fitted.data,
            bytes: &fitted.bytes,
            notes: &notes,
            webgpu: self.webgpu,
            ..empty
        };
        let mut html = page.html().map_err(refused)?;
        report.webgpu = self.webgpu.is_some();
        if report.webgpu && html.len() as u64 > most {
            // Data come first.
            html = Page { webgpu: None, ..page }.html().map_err(refused)?;
            report.webgpu = false;
        }
        report.bytes = html.len() as u64;
        Ok((html, report))
    }

    fn difference(&self, frame: &Frame) -> PictureDifference {
        let shown = |frame: &Frame| match self.picture.background() {
            Some(color) => laid_over(&frame.image, color),
            None => frame.image.clone(),
        };
        PictureDifference::new(&shown(&self.frame), &shown(frame))
    }
}

/// Bytes of the samples that would be read in chunks.
fn chunk_bytes(picture: &Picture) -> u64 {
    let bytes = |item: &Item| match &item.content {
        Content::Volume { volume, .. } if volume.chunks().is_some() => {
            let samples = volume.finest_grid().sample_count();
            (samples * volume.samples().bytes_per_sample()) as u64
        }
        _ => 0,
    };
    picture.scene.items.iter().map(bytes).sum()
}

fn described(title: &str) -> String {
    format!("Picture of {title}, rendered by splatvol")
}

fn served_by() -> String {
    "Pictures at rest come from the server, and are made of all data.".to_owned()
}

fn made_by() -> String {
    format!("Made by splatvol {}.", env!("CARGO_PKG_VERSION"))
}

/// The picture of a page's data.
fn resolved(document: &Document, fitted: &Fitted) -> Result<Picture, Failure> {
    let resolving = Resolving {
        reading: splatvol_document::Reading {
            rules: splatvol_document::ReadRules::default(),
            folder: None,
            listener: &Silent,
        },
        held: &fitted.held,
        moves: CameraMotion::default(),
        keeps_alpha: false,
        in_windows: false,
    };
    Ok(document.resolve(resolving)?)
}

fn rendered(picture: &Picture, means: Means) -> Result<Frame, Failure> {
    let mut studio = Studio::new(&picture.scene, picture.settings, means)?;
    Ok(studio.expose(&[picture.camera])?.clone())
}

fn refused(error: PageError) -> Failure {
    Failure::of(Step::Output, error.into())
}

fn megabytes(bytes: u64) -> String {
    format!("{:.2} MB", bytes as f64 / 1e6)
}
