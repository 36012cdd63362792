//! Laws: how far pictures of the GPU engine may be from the CPU engine's.
//!
//! | pictures | law |
//! |---|---|
//! | the preset `best` | within a level of eight bits but for a thousandth of the pixels, which are within four |
//! | other presets and modes | at least 50 dB, and 92 % of the pixels within a level |
//! | points, Gaussians as published, mixtures | at least 50 dB, and 99 % of the pixels within a level |
//!
//! In other presets the CPU's kernels of volumes are cut narrower than the GPU's, which shows at silhouettes; small pictures
//! have more of these than large ones.

use std::error::Error;

use serde::Serialize;
use splatvol::{
    Control, CpuEngine, Engine, EngineConfig, Frame, Image, RenderSettings, RenderStatistics, SceneError,
    Shot, Task,
};
use splatvol_gpu::{GpuConfig, GpuEngine};

use crate::scenes::{Case, cases};

/// A level of eight bits.
const LEVEL: f32 = 1.0 / 255.0;

/// What is asked of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Law {
    /// Least signal to noise, dB.
    pub psnr: f64,
    /// Least share of pixels of which no channel differs by more than a level.
    pub share: f64,
    /// Largest difference of a channel, levels.
    pub levels: f32,
}

impl Law {
    /// Of the preset `best`.
    pub const BEST: Self = Self {
        psnr: 50.0,
        share: 0.999,
        levels: 4.0,
    };
    /// Of volumes, by other presets and in other modes.
    pub const VOLUMES: Self = Self {
        psnr: 50.0,
        share: 0.92,
        levels: f32::INFINITY,
    };
    /// Of points, of Gaussians as published, and of these and volumes together.
    pub const OTHERS: Self = Self {
        share: 0.99,
        ..Self::VOLUMES
    };
}

/// How far both engines' pictures of a scene are apart.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// The scene, and how it is rendered.
    pub name: &'static str,
    /// The adapter.
    pub device: String,
    /// Signal to noise, dB; none where the pictures are equal.
    pub psnr: Option<f64>,
    /// Share of pixels of which no channel differs by more than a level.
    pub share: f64,
    /// Largest difference of a channel, levels.
    pub levels: f32,
    /// Share of pixels that show something.
    pub seen: f64,
    /// Whether the law holds, and the same picture has the same bytes when it is rendered again.
    pub holds: bool,
}

/// Renders all scenes by both engines.
///
/// # Errors
/// No device; or one that refuses something.
pub async fn findings() -> Result<Vec<Finding>, Box<dyn Error>> {
    let mut gpu = GpuEngine::open(&GpuConfig::default()).await?;
    let mut cpu = CpuEngine::new(EngineConfig::default())?;
    let mut findings = Vec::new();
    for case in cases()? {
        findings.push(finding((&mut gpu, &mut cpu), &case).await?);
    }
    Ok(findings)
}

async fn finding((gpu, cpu): (&mut GpuEngine, &mut CpuEngine), case: &Case) -> Result<Finding, SceneError> {
    let (own, statistics) = on_gpu(gpu, case).await?;
    let (again, _) = on_gpu(gpu, case).await?;
    let wanted = on_cpu(cpu, case)?;
    let mut finding = Finding {
        name: case.name,
        device: statistics.device,
        holds: false,
        ..apart(&own.image, &wanted.image)
    };
    let Law { psnr, share, levels } = case.law;
    finding.holds = finding.psnr.is_none_or(|found| found >= psnr)
        && finding.share >= share
        && finding.levels <= levels
        && finding.seen > 0.05
        && own.image == again.image;
    Ok(finding)
}

/// How far two pictures are apart, without names.
fn apart(own: &Image, wanted: &Image) -> Finding {
    let pixels = || own.pixels.iter().zip(&wanted.pixels);
    let largest = |(a, b): (&[f32; 4], &[f32; 4])| {
        let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        differences.fold(0.0, f32::max)
    };
    let square = |(a, b): (&f32, &f32)| f64::from(a - b).powi(2);
    let sum: f64 = pixels().flat_map(|(a, b)| a.iter().zip(b)).map(square).sum();
    let count = own.pixels.len() as f64;
    Finding {
        name: "",
        device: String::new(),
        psnr: (sum > 0.0).then(|| -10.0 * (sum / (4.0 * count)).log10()),
        share: pixels().filter(|&both| largest(both) <= LEVEL).count() as f64 / count,
        levels: pixels().map(largest).fold(0.0, f32::max) / LEVEL,
        seen: wanted.pixels.iter().filter(|pixel| pixel[3] > 0.1).count() as f64 / count,
        holds: false,
    }
}

fn frame(settings: &RenderSettings) -> Frame {
    Frame::empty(settings.size)
}

async fn on_gpu(engine: &mut GpuEngine, case: &Case) -> Result<(Frame, RenderStatistics), SceneError> {
    let mut frame = frame(&case.settings);
    engine.check(case.shot())?;
    let task = Task::new(&Control::default(), &|_| {});
    let statistics = engine.render_async(case.shot(), &mut frame, task).await?;
    Ok((frame, statistics))
}

fn on_cpu(engine: &mut CpuEngine, case: &Case) -> Result<Frame, SceneError> {
    let mut frame = frame(&case.settings);
    engine.render(case.shot(), &mut frame, Task::new(&Control::default(), &|_| {}))?;
    Ok(frame)
}

impl Case {
    fn shot(&self) -> Shot<'_> {
        Shot {
            scene: &self.scene,
            camera: &self.camera,
            settings: &self.settings,
        }
    }
}
