//! Conversion of our plots to the plotting crate's.

use std::sync::Arc;

use kuva::plot::ColorMap;
use kuva::plot::LegendPosition;
use kuva::plot::Surface3DPlot;
use kuva::plot::annotations::ReferenceLine;
use kuva::plot::{BarPlot, ContourPlot, LinePlot, ScatterPlot};
use kuva::render::layout::{ComputedLayout, Layout, TickFormat};
use kuva::render::plots::Plot as Drawn;

use super::{Axis, Curve, Mark, Plot, PlotKind, Scale};

/// Okabe and Ito's colours, darkest contrasts first; yellow, which is hard to see on white paper, last.
const COLOURS: [&str; 8] = [
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#000000", "#E69F00", "#56B4E9", "#F0E442",
];
const MARK: &str = "#777777";
const SIZE: [f64; 2] = [720.0, 400.0];
/// A surface is drawn as large as this height allows.
const SURFACE_HEIGHT: f64 = 560.0;

/// The plot as SVG.
pub(super) fn svg(plot: &Plot) -> String {
    let drawn = match &plot.kind {
        PlotKind::Curves { curves, .. } => curves.iter().enumerate().flat_map(curve).collect(),
        PlotKind::Bars { bars, groups } => vec![Drawn::Bar(bar_plot(bars, groups))],
        PlotKind::Contours {
            x,
            y,
            values,
            label,
            levels,
        } => vec![Drawn::Contour(
            ContourPlot::new()
                .with_grid(values.clone(), x.clone(), y.clone())
                .with_levels(levels)
                .with_filled()
                .with_colormap(ColorMap::Viridis)
                .with_legend(label.as_str()),
        )],
        PlotKind::Surface { x, y, values, label } => vec![Drawn::Surface3D(
            Surface3DPlot::new(values.clone())
                .with_x_coords(x.clone())
                .with_y_coords(y.clone())
                .with_z_colormap(ColorMap::Viridis)
                // More ticks would run into those of the next axis.
                .with_grid_lines(3)
                .with_elevation(25.0)
                .with_x_label(plot.x.label.as_str())
                .with_y_label(plot.y.label.as_str())
                .with_z_label(label.as_str()),
        )],
    };
    let layout = layout(plot, &drawn);
    kuva::render_to_svg(drawn, layout)
}

fn curve((index, curve): (usize, &Curve)) -> Vec<Drawn> {
    let colour = COLOURS[index % COLOURS.len()];
    let points = || curve.points.iter().map(|&[x, y]| (x, y));
    let mut line = LinePlot::new()
        .with_data(points())
        .with_color(colour)
        .with_stroke_width(1.8)
        .with_legend(curve.label.as_str());
    if curve.dashed {
        line = line.with_dashed();
    }
    let mut drawn = vec![Drawn::Line(line)];
    if curve.dots {
        drawn.push(Drawn::Scatter(
            ScatterPlot::new()
                .with_data(points())
                .with_color(colour)
                .with_size(3.0),
        ));
    }
    drawn
}

fn bar_plot(bars: &[String], groups: &[(String, Vec<f64>)]) -> BarPlot {
    let coloured = |heights: &[f64]| -> Vec<(f64, &str)> {
        let colours = COLOURS.into_iter().cycle();
        heights.iter().copied().zip(colours).collect()
    };
    let plot = groups.iter().fold(BarPlot::new(), |plot, (label, heights)| {
        plot.with_group(label.as_str(), coloured(heights))
    });
    match bars {
        // A single series needs no legend: the axis describes it.
        [_] => plot,
        _ => plot.with_legend(bars.iter().map(String::as_str).collect()),
    }
}

fn layout(plot: &Plot, drawn: &[Drawn]) -> Layout {
    let surface = matches!(plot.kind, PlotKind::Surface { .. });
    let mut layout = Layout::auto_from_plots(drawn)
        .with_width(SIZE[0])
        .with_height(if surface { SURFACE_HEIGHT } else { SIZE[1] })
        .with_title(format!("{}: {}", plot.figure, plot.caption))
        .with_title_wrap(70)
        .with_title_size(14)
        .with_label_size(13)
        .with_tick_size(11)
        .with_body_size(12)
        .with_legend_position(LegendPosition::OutsideRightTop)
        .with_legend_box(false)
        .with_legend_wrap(24)
        .with_font_family("DejaVu Sans, Helvetica, Arial, sans-serif");
    if !surface {
        layout = layout
            .with_x_label(plot.x.label.as_str())
            .with_y_label(plot.y.label.as_str());
    }
    if plot.x.scale == Scale::Logarithmic {
        layout = layout.with_log_x().with_x_tick_format(powers(plot, 0));
    }
    if plot.y.scale == Scale::Logarithmic {
        layout = layout.with_log_y().with_y_tick_format(powers(plot, 1));
    }
    if let Axis {
        range: Some([low, high]),
        ..
    } = plot.x
    {
        layout = layout.with_x_axis_min(low).with_x_axis_max(high);
    }
    if let Axis {
        range: Some([low, high]),
        ..
    } = plot.y
    {
        layout = layout.with_y_axis_min(low).with_y_axis_max(high);
    }
    if let PlotKind::Curves { marks, .. } = &plot.kind {
        layout = marks
            .iter()
            .fold(layout, |layout, mark| layout.with_reference_line(line(mark)));
    }
    match (plot.equal, plot.x.range, plot.y.range) {
        (true, Some(x), Some(y)) => equal(layout, [x, y]),
        _ => layout,
    }
}

/// Sets the height so that a unit is as long along y as along x, whatever space the labels take.
fn equal(layout: Layout, ranges: [[f64; 2]; 2]) -> Layout {
    let [across, up] = ranges.map(|[low, high]| high - low);
    let computed = ComputedLayout::from_layout(&layout);
    let height = computed.height + computed.plot_width() * up / across - computed.plot_height();
    layout.with_height(height).with_equal_aspect()
}

/// Number format of a logarithmic axis (0: x, 1: y): all with exponents if any needs one.
fn powers(plot: &Plot, axis: usize) -> TickFormat {
    let [low, high] = ends(plot, axis);
    let plain = low > 0.9e-3 && high < 1.1e5;
    TickFormat::Custom(Arc::new(move |value: f64| match plain {
        true => format!("{value:.*}", -value.log10().floor().min(0.0) as usize),
        false => format!("{value:.0e}"),
    }))
}

/// Ends of an axis: its range, or those of the positive numbers along it.
fn ends(plot: &Plot, axis: usize) -> [f64; 2] {
    if let Some(range) = [&plot.x, &plot.y][axis].range {
        return range;
    }
    let values: Vec<f64> = match &plot.kind {
        PlotKind::Curves { curves, .. } => {
            let points = curves.iter().flat_map(|curve| &curve.points);
            points.map(|point| point[axis]).collect()
        }
        PlotKind::Bars { groups, .. } => groups.iter().flat_map(|(_, heights)| heights).copied().collect(),
        PlotKind::Contours { x, y, .. } | PlotKind::Surface { x, y, .. } => [x, y][axis].clone(),
    };
    let positive = values.into_iter().filter(|&value| value > 0.0);
    positive.fold([f64::INFINITY, 0.0], |[low, high], value| {
        [low.min(value), high.max(value)]
    })
}

fn line(mark: &Mark) -> ReferenceLine {
    let (line, label) = match mark {
        Mark::Vertical { at, label } => (ReferenceLine::vertical(*at), label),
        Mark::Horizontal { at, label } => (ReferenceLine::horizontal(*at), label),
    };
    line.with_color(MARK).with_label(label.as_str())
}
