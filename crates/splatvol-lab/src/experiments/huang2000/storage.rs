//! Storage of the tables: sections 3, 3.2 and 5.1.

use std::collections::BTreeSet;

use splatvol::radial::{FootprintTable, Precision, TableSettings};

use super::tables::KERNEL;
use crate::{
    Axis, Curve, Expectation, Experiment, Finding, LabError, Outcome, Plot, Published, Table, Workbench,
};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "huang2000-storage",
    paper: "huang2000",
    title: "Memory of footprint tables",
    figures: &["Section 3", "Section 3.2", "Section 5.1"],
    about: "The paper compares what footprints take: two-dimensional tables of real numbers for texture hardware, footprints drawn beforehand \
for every radius and position within the pixel (eq. 5), and its one-dimensional tables of 128 sections.

One-dimensional tables are the program's own, and counted. The 2D FastSplat is counted entry by entry: footprints of \
1 to 128 pixels in diameter, centred on the cells of a 2 x 2 grid within the pixel. Entries that mirrors at the axes \
and the diagonal make equal count as one byte.

Eq. 5 adds up k² i². Taken as a footprint of i x i pixels it gives the paper's number. So the radius of that section is an edge in pixels.",
    run,
};

/// Pixels of the largest footprint's edge, the paper's maximum.
const MOST: usize = 128;

/// eq. 5: bytes of footprints of all sizes, without symmetry.
fn equation_5(cells: usize, most: usize) -> f64 {
    (1..=most).map(|i| (cells * cells * i * i) as f64).sum()
}

/// Count of the bytes that remain of footprints of `edge` x `edge` pixels on 2 x 2 positions: those with different
/// offsets, whatever their signs and order. Offsets are quarters of a pixel.
fn distinct(edge: usize) -> usize {
    let edge = edge as i64;
    let along = |cell: i64| (0..edge).map(move |pixel| (4 * pixel - 2 * (edge - 1) - cell).abs());
    let offsets: BTreeSet<i64> = [-1, 1].into_iter().flat_map(along).collect();
    let pairs = offsets.iter().map(|x| offsets.range(x..).count());
    pairs.sum()
}

fn table_bytes(entries: usize, precision: Precision) -> Result<f64, LabError> {
    let settings = TableSettings {
        entries,
        precision,
        ..TableSettings::default()
    };
    Ok(FootprintTable::new(KERNEL, settings)?.bytes() as f64)
}

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let mut outcome = Outcome::default();
    bench.step(0, 3, "tables");
    let real = (128 * 128 * 128 * size_of::<f32>()) as f64;
    outcome.find(
        Finding::new(
            "Section 3",
            "texture",
            "128 sections of 128 x 128 numbers of 32 bits",
            real / 1e6,
            Expectation::Between(8.0, 8.5),
        )
        .unit("MB")
        .published(Published::Claim("over 8 MB".to_owned())),
    );
    for (entries, published) in [(64, 8.0), (256, 32.0)] {
        outcome.find(
            Finding::new(
                "Section 5.1",
                &format!("table-{entries}"),
                &format!("table of {entries} entries of 8 bits in 128 sections"),
                table_bytes(entries, Precision::U8)? / 1024.0,
                Expectation::relative(published, 0.01),
            )
            .unit("KB")
            .published(Published::Number(published)),
        );
    }
    outcome.find(
        Finding::new(
            "Section 5.1",
            "sixteen-bits",
            "table of 256 entries of 16 bits over one of 8 bits",
            table_bytes(256, Precision::U16)? / table_bytes(256, Precision::U8)?,
            Expectation::relative(2.0, 0.01),
        )
        .published(Published::Claim("doubles the storage".to_owned())),
    );
    bench.step(1, 3, "footprints drawn beforehand");
    let counted: Vec<usize> = (1..=2 * MOST).map(distinct).collect();
    outcome.find(
        Finding::new(
            "Section 3.2",
            "equation-5",
            "eq. 5 for 2 x 2 positions up to 128, by the eight symmetries",
            equation_5(2, MOST) / 8.0 / 1e3,
            Expectation::relative(354.0, 0.01),
        )
        .unit("KB")
        .published(Published::Number(354.0)),
    );
    let edges: usize = counted[..MOST].iter().sum();
    let diameters: usize = counted.iter().skip(1).step_by(2).sum();
    outcome.find(
        Finding::new(
            "Section 3.2",
            "counted-edges",
            "footprints of 1 to 128 pixels in diameter, counted with symmetry",
            edges as f64 / 1e3,
            Expectation::relative(354.0, 0.05),
        )
        .unit("KB")
        .published(Published::Number(354.0)),
    );
    outcome.find(Finding::new(
        "Section 3.2",
        "counted-radii",
        "footprints of 1 to 128 pixels in radius, counted with symmetry, over those in diameter",
        diameters as f64 / edges as f64,
        Expectation::relative(4.0, 0.05),
    ));
    let default = table_bytes(128, Precision::U8)?;
    outcome.find(
        Finding::new(
            "Section 3",
            "share-of-texture",
            "the paper's usual table, 128 entries of 8 bits in 128 sections, over the texture",
            default / real,
            Expectation::AtMost(0.01),
        )
        .published(Published::Claim("minimal storage".to_owned())),
    );
    outcome.tables.push(numbers(&counted)?);
    outcome.plots.push(plot(&counted)?);
    Ok(outcome)
}

fn running_sums(counted: &[usize]) -> Vec<f64> {
    let mut sum = 0.0;
    let add = |&count: &usize| {
        sum += count as f64;
        sum
    };
    counted.iter().map(add).collect()
}

fn numbers(counted: &[usize]) -> Result<Table, LabError> {
    let mut table = Table::new(
        "bytes",
        "Section 3.2",
        "Bytes of a footprint of all sizes up to a diameter (2D, 2 x 2 positions), and of tables of 128 sections",
        &["what", "bytes"],
    );
    let sums = running_sums(counted);
    for diameter in [16, 32, 64, 128, 256] {
        table.row([
            format!("2D, up to {diameter} pixels").into(),
            sums[diameter - 1].into(),
        ]);
    }
    for entries in [32, 64, 128, 256, 512, 1024] {
        for (bits, precision) in [(8, Precision::U8), (16, Precision::U16)] {
            let bytes = table_bytes(entries, precision)?;
            table.row([
                format!("1D, {entries} entries of {bits} bits").into(),
                bytes.into(),
            ]);
        }
    }
    Ok(table)
}

fn plot(counted: &[usize]) -> Result<Plot, LabError> {
    let sums = running_sums(counted);
    let at = |index: usize| (index + 1) as f64;
    let every = |values: &dyn Fn(usize) -> f64| -> Vec<[f64; 2]> {
        (0..sums.len())
            .step_by(3)
            .map(|index| [at(index), values(index)])
            .collect()
    };
    let mut plot = Plot::curves(
        "bytes",
        "Section 3.2",
        "memory by the largest footprint: one 2D footprint, and 128 sections in 1D tables",
        Axis::logarithmic("largest diameter (pixels)"),
        Axis::logarithmic("memory (bytes)"),
    )
    .curve(Curve::new("2D, counted", every(&|index| sums[index])))
    .curve(Curve::new("2D, eq. 5 over 8", every(&|index| equation_5(2, index + 1) / 8.0)).dashed());
    for entries in [64, 256] {
        let bytes = table_bytes(entries, Precision::U8)?;
        let label = format!("1D, {entries} entries of 8 bits");
        plot = plot.curve(Curve::new(&label, every(&|_| bytes)));
    }
    Ok(plot)
}
