//! Options that choose among a file's contents, and the formats that have such a choice. Others refuse them: an option
//! that does nothing would promise another volume.

use super::ReadOptions;
use super::detect::Format;
use crate::IoError;
use crate::error::Context;

/// Refuses options for which the format has no choice, by name.
pub(super) fn check(format: Format, options: &ReadOptions, context: &Context<'_>) -> Result<(), IoError> {
    use Format::{Dicom, LegacyVtk, MetaImage, Mgh, Nifti, Npz, Nrrd, Slices, Tiff, Vti, Zarr};

    let number = |number: usize| (number > 0).then(|| number.to_string());
    let choices: [(&str, Option<String>, &[Format]); 7] = [
        ("array", options.array.clone(), &[Vti, LegacyVtk, Npz]),
        (
            "component",
            options.component.map(|component| component.to_string()),
            &[Nrrd, Nifti, MetaImage, Vti, LegacyVtk],
        ),
        (
            "channel",
            options.channel.map(|channel| channel.to_string()),
            // Components of vectors are channels, too.
            &[Dicom, Zarr, Slices, Tiff, Nrrd, Nifti, MetaImage, Vti, LegacyVtk],
        ),
        (
            "time",
            options.time.and_then(number),
            &[Mgh, Nrrd, Dicom, Zarr, Nifti, Tiff, MetaImage],
        ),
        ("level", number(options.level), &[Zarr]),
        ("series", options.series.clone(), &[Dicom, Zarr, Tiff]),
        (
            "solution",
            options.solution.as_ref().map(|path| path.display().to_string()),
            &[],
        ),
    ];
    for (name, asked, formats) in choices {
        if let Some(asked) = asked.filter(|_| !formats.contains(&format)) {
            let what =
                format!("{name} {asked} was asked for; files of this format ({format}) have no such choice");
            return Err(context.unsupported(what));
        }
    }
    Ok(())
}
