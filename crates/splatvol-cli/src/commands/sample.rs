//! `splatvol sample`: the built-in volumes, listed or written.

use splatvol_io::{WriteOptions, write_volume};
use splatvol_samples::Sample;

use super::convert::check_volume_extension;
use crate::args::SampleArgs;
use crate::failure::{During, Failure, Step};
use crate::output::{Target, replace};
use crate::terminal::Terminal;

pub(crate) fn run(args: &SampleArgs, terminal: &Terminal) -> Result<(), Failure> {
    let (Some(name), Some(output)) = (&args.name, &args.output) else {
        return list();
    };
    check_volume_extension(output)?;
    Target::File(output.clone()).check(args.write.overwrite)?;
    let sample = Sample::from_name(name).during(Step::Usage)?;
    let volume = {
        let _spinner = terminal.spinner(format!("Generating {name}"));
        sample.generate(args.size).during(Step::Usage)?
    };
    replace(output, args.write.overwrite, |path| {
        Ok(write_volume(path, &volume, &WriteOptions::default())?)
    })?;
    let [x, y, z] = volume.grid().dims();
    terminal.note(format!(
        "wrote {} ({x}x{y}x{z} {})",
        output.display(),
        volume.samples().type_name()
    ));
    Ok(())
}

fn list() -> Result<(), Failure> {
    let mut text = String::new();
    for sample in Sample::ALL {
        let dims = sample.default_dims().map(|n| n.to_string()).join("x");
        text.push_str(&format!(
            "{:<15} {dims:<12} {}\n",
            sample.name(),
            sample.description()
        ));
    }
    Target::Stdout.write(text.as_bytes(), false)
}
