//! `splatvol compare`: how much two pictures or volumes differ.

use std::path::Path;
use std::sync::Arc;

use serde::Serialize;
use splatvol::{Image, Volume};
use splatvol_document::keys::ItemKeys;
use splatvol_document::{ReadRules, input};
use splatvol_io::{ImageFormat, encode_image, read_image};

use crate::args::CompareArgs;
use crate::commands::convert::volumes_only;
use crate::commands::metrics::{PictureDifference, VolumeDifference, difference_picture};
use crate::failure::{During, Failure, Step};
use crate::output::Target;
use crate::terminal::Terminal;

pub(crate) fn run(args: &CompareArgs, terminal: &Terminal) -> Result<(), Failure> {
    let is_picture = |name: &str| ImageFormat::from_path(Path::new(name)).is_some();
    match (is_picture(&args.a), is_picture(&args.b)) {
        (true, true) => pictures(args, terminal),
        (false, false) => volumes(args, terminal),
        _ => Err(Failure::usage(format!(
            "{} and {}: a picture and a volume cannot be compared",
            args.a, args.b
        ))),
    }
}

fn pictures(args: &CompareArgs, terminal: &Terminal) -> Result<(), Failure> {
    let target = args.output.as_deref().map(Target::new);
    if let Some(target) = &target {
        target.check(args.write.overwrite)?;
    }
    let read = |name: &str| -> Result<Image, Failure> { Ok(read_image(name).during(Step::Input)?.image) };
    let (a, b) = (read(&args.a)?, read(&args.b)?);
    if a.size() != b.size() {
        let size = |image: &Image| format!("{}x{}", image.size().width(), image.size().height());
        return Err(Failure::usage(format!(
            "sizes differ: {} and {}",
            size(&a),
            size(&b)
        )));
    }
    let difference = PictureDifference::new(&a, &b);
    if let (Some(target), Some(path)) = (target, &args.output) {
        let format = ImageFormat::from_path(path).unwrap_or_default();
        let picture = difference_picture(&a, &b).during(Step::Render)?;
        let bytes = encode_image(&picture, None, format, &[]).during(Step::Output)?;
        target.write(&bytes, args.write.overwrite)?;
        terminal.note(format!("wrote {}", path.display()));
    }
    print(args, &difference, &difference.text())
}

fn volumes(args: &CompareArgs, terminal: &Terminal) -> Result<(), Failure> {
    if args.output.is_some() {
        return Err(Failure::usage(
            "-o makes a picture of the differences between pictures, not volumes",
        ));
    }
    let read = |name: &str| -> Result<Arc<Volume>, Failure> {
        let (item, reading) = (ItemKeys::of_file(name), terminal.reads(ReadRules::default()));
        volumes_only(&item, reading, "compare")?;
        Ok(input::load(&item, reading)?.volume)
    };
    let (a, b) = (read(&args.a)?, read(&args.b)?);
    if a.grid().dims() != b.grid().dims() {
        return Err(Failure::usage(format!(
            "dims differ: {:?} and {:?}",
            a.grid().dims(),
            b.grid().dims()
        )));
    }
    let difference = VolumeDifference::new(&a, &b);
    print(args, &difference, &difference.text())
}

fn print(args: &CompareArgs, difference: &impl Serialize, text: &str) -> Result<(), Failure> {
    let mut text = if args.json {
        serde_json::to_string_pretty(difference).during(Step::Output)?
    } else {
        text.to_owned()
    };
    text.push('\n');
    Target::Stdout.write(text.as_bytes(), false)
}
