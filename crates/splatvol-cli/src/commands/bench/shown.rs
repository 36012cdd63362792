//! From flags to what is measured, by the way that `render` goes: the document of flags, scene file and earlier picture,
//! with the benchmark's own look, size and camera where these say nothing.

use glam::DVec3;
use splatvol::{ImageSize, Scene, TransferFunction, Volume};
use splatvol_document::held::HeldContent;
use splatvol_document::keys::{CameraKeys, PictureSize};
use splatvol_document::{CameraMotion, CameraPose, Held, Picture, Resolving};
use splatvol_io::ImageFormat;
use splatvol_samples::Sample;

use super::around::around;
use super::looks::Window;
use super::scenes::{SceneChoice, Variant};
use crate::args::{BenchArgs, LookName, ProjectionName};
use crate::commands::asked::Asked;
use crate::failure::{During, Failure, Step};
use crate::output::picture_format;
use crate::terminal::Terminal;

/// What a scene shows. Its data are read once for all cases.
pub(super) struct Shown<'a> {
    args: &'a BenchArgs,
    terminal: &'a Terminal,
    asked: Asked,
    held: Vec<Option<Held>>,
    /// Side of the picture unless asked otherwise, pixels.
    side: u32,
}

impl<'a> Shown<'a> {
    /// Reads the data of a scene.
    pub(super) fn read(
        scene: &SceneChoice,
        args: &'a BenchArgs,
        terminal: &'a Terminal,
    ) -> Result<Self, Failure> {
        let asked = Asked::of_bench(args, scene.input.as_deref())?;
        let reading = asked.reading(&args.picture, terminal);
        let items = asked.document.items.iter();
        let held = items
            .map(|item| match item.is_visible() {
                true => Held::read(item, reading).map(Some),
                false => Ok(None),
            })
            .collect::<Result<_, _>>()
            .map_err(|error| asked.failure(error))?;
        Ok(Self {
            args,
            terminal,
            asked,
            held,
            side: scene.side,
        })
    }

    /// The picture of a case.
    pub(super) fn picture(&self, variant: &Variant) -> Result<Picture, Failure> {
        let args = self.args;
        let mut document = self.asked.document.clone();
        let classification = &mut document.settings.classification;
        *classification = variant.classification.or(*classification);
        if let Some(transfer_function) = self.look(variant.look)? {
            document.items[0].transfer_function = Some(transfer_function);
        }
        if document.size.is_none() {
            let size = ImageSize::new(self.side, self.side).during(Step::Usage)?;
            document.size = Some(PictureSize(size));
        }
        let first_frame = args.first_frame.as_deref().map(picture_format).transpose()?;
        let resolving = Resolving {
            reading: self.asked.reading(&args.picture, self.terminal),
            held: &self.held,
            moves: CameraMotion::default(),
            keeps_alpha: first_frame == Some(ImageFormat::Exr),
            in_windows: false,
        };
        let placed = self.asked.picture(&document, &args.picture, resolving)?;
        let projection = variant.projection.unwrap_or(ProjectionName::Perspective);
        let around = around(
            &corners(&placed.scene)?,
            projection,
            placed.settings.size.aspect(),
        );
        let around = CameraPose::from(&around.during(Step::Usage)?);
        document.camera = document.camera.over(&CameraKeys::from(&around));
        self.asked.picture(&document, &args.picture, resolving)
    }

    /// The transfer function of a named look; `None` leaves the look to flags and data.
    fn look(&self, look: LookName) -> Result<Option<TransferFunction>, Failure> {
        let window = || -> Result<_, Failure> {
            let of = self.single_volume()?;
            Ok(Window::new(of, &self.args.picture.look))
        };
        match look {
            LookName::Opaque => window()?.opaque().map(Some).during(Step::Usage),
            LookName::Translucent => window()?.translucent().map(Some).during(Step::Usage),
            LookName::AsRender => Ok(None),
        }
    }

    fn single_volume(&self) -> Result<(&Volume, Option<Sample>), Failure> {
        let [Some(held)] = &self.held[..] else {
            return Err(Failure::usage("--looks: are of one volume, not of several items"));
        };
        match held.content() {
            HeldContent::Volume(volume) => Ok((volume, held.sample())),
            _ => Err(Failure::usage("--looks: are of volumes, which this is not")
                .hint("leave --looks out: the look is then that of render")),
        }
    }
}

/// Corners of the grid if there is one alone, else of the box of all that is shown, world.
fn corners(scene: &Scene) -> Result<[DVec3; 8], Failure> {
    if let Ok(single) = scene.single_volume() {
        return Ok(single.volume.grid().corners());
    }
    let bounds = scene.bounds().during(Step::Render)?;
    let corner = |i: usize| {
        let far = |axis: usize| {
            if i >> axis & 1 == 1 {
                bounds.max
            } else {
                bounds.min
            }
        };
        DVec3::new(far(0).x, far(1).y, far(2).z)
    };
    Ok(std::array::from_fn(corner))
}
