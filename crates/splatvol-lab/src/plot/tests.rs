use super::*;

fn axes() -> [Axis; 2] {
    [Axis::new("distance (voxels)"), Axis::new("error (levels)")]
}

fn curves() -> Plot {
    let [x, y] = axes();
    Plot::curves("c", "Fig. 1", "Curves", x, y)
        .curve(Curve::new("measured", [[0.0, 1.0], [1.0, 3.0], [2.0, 2.0]]).dots())
        .curve(Curve::new("a < b & c", [[0.0, 2.0], [2.0, 1.0]]).dashed())
        .mark(Mark::Vertical {
            at: 0.5,
            label: "Nyquist".to_owned(),
        })
        .mark(Mark::Horizontal {
            at: 1.5,
            label: "budget".to_owned(),
        })
}

fn logarithmic() -> Plot {
    let axes = [
        Axis::logarithmic("thickness (voxels)").range(0.1, 10.0),
        Axis::logarithmic("error (rms)"),
    ];
    let [x, y] = axes;
    Plot::curves("l", "Fig. 2", "Convergence", x, y).curve(Curve::new("sheets", [[0.25, 1e-4], [2.0, 1e-2]]))
}

fn bars() -> Plot {
    let kind = PlotKind::Bars {
        bars: vec!["plain".to_owned(), "prefiltered".to_owned()],
        groups: vec![
            ("gaussian".to_owned(), vec![1.0, 2.0]),
            ("cubic".to_owned(), vec![3.0, 4.0]),
        ],
    };
    Plot::new("b", "Table 1", "Bars", axes(), kind)
}

/// Columns, rows and values of a bump.
fn grid() -> (Vec<f64>, Vec<f64>, Vec<Vec<f64>>) {
    let side: Vec<f64> = (0..9).map(|i| f64::from(i) - 4.0).collect();
    let row = |y: &f64| side.iter().map(|x| (-0.1 * (x * x + y * y)).exp()).collect();
    let values = side.iter().map(row).collect();
    (side.clone(), side, values)
}

fn contours() -> Plot {
    let (x, y, values) = grid();
    let kind = PlotKind::Contours {
        x,
        y,
        values,
        label: "height (m)".to_owned(),
        levels: vec![0.25, 0.5, 0.75],
    };
    Plot::new("k", "Fig. 10", "Contours", axes(), kind)
}

fn surface() -> Plot {
    let (x, y, values) = grid();
    let kind = PlotKind::Surface {
        x,
        y,
        values,
        label: "height (m)".to_owned(),
    };
    Plot::new("s", "Fig. 10", "A surface", axes(), kind)
}

/// All text of an SVG, without marks, words separated by one space.
fn text(svg: &str) -> String {
    let texts = svg
        .split("<text")
        .skip(1)
        .filter_map(|rest| rest.split("</text>").next());
    let bare = texts.map(|rest| {
        let inner = rest.split_once('>').map_or("", |(_, inner)| inner);
        let parts = inner
            .split('<')
            .map(|part| part.split_once('>').map_or(part, |(_, words)| words));
        parts.collect::<Vec<_>>().join(" ")
    });
    bare.collect::<Vec<_>>()
        .join(" ")
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
}

#[test]
fn every_kind_names_its_axes_its_figure_and_what_it_draws() {
    let axes = ["distance (voxels)", "error (levels)"];
    let cases: [(Plot, Vec<&str>); 5] = [
        (
            curves(),
            [
                &axes[..],
                &[
                    "Fig. 1: Curves",
                    "measured",
                    "a &lt; b &amp; c",
                    "Nyquist",
                    "budget",
                ],
            ]
            .concat(),
        ),
        (
            logarithmic(),
            vec![
                "Fig. 2: Convergence",
                "thickness (voxels)",
                "error (rms)",
                "sheets",
            ],
        ),
        (
            bars(),
            [
                &axes[..],
                &["Table 1: Bars", "plain", "prefiltered", "gaussian", "cubic"],
            ]
            .concat(),
        ),
        (
            contours(),
            [&axes[..], &["Fig. 10: Contours", "height (m)"]].concat(),
        ),
        (
            surface(),
            [&axes[..], &["Fig. 10: A surface", "height (m)"]].concat(),
        ),
    ];
    for (plot, words) in cases {
        let svg = plot.svg();
        assert!(
            svg.trim_start().starts_with("<svg") && svg.trim_end().ends_with("</svg>"),
            "{}",
            plot.name
        );
        let text = text(&svg);
        for word in words {
            assert!(text.contains(word), "{}: no '{word}' in {text}", plot.name);
        }
    }
}

#[test]
fn the_same_plot_has_the_same_bytes() {
    for plot in [curves, logarithmic, bars, contours, surface] {
        assert!(plot().svg() == plot().svg(), "{}", plot().name);
    }
}

#[test]
fn what_is_dashed_is_drawn_dashed_and_points_are_shown_where_asked_for() {
    let [x, y] = axes();
    let with = |curve: Curve| {
        Plot::curves("c", "F", "C", x.clone(), y.clone())
            .curve(curve)
            .svg()
    };
    let line = || Curve::new("line", [[0.0, 1.0], [1.0, 2.0]]);
    let dashes = |svg: &str| svg.matches("stroke-dasharray").count();
    let dots = |svg: &str| svg.matches("<circle").count();
    let plain = with(line());
    assert!(dashes(&with(line().dashed())) > dashes(&plain));
    assert_eq!(dots(&with(line().dots())), dots(&plain) + 2);
}

#[test]
fn curves_and_marks_are_for_plots_of_curves_alone() {
    let [before, after] = [bars(), bars().curve(Curve::new("x", [[0.0, 0.0]]))];
    assert_eq!(before.svg(), after.svg());
}

#[test]
fn circles_are_circles_where_units_are_as_long_on_both_axes() {
    let circle = (0..=64).map(|i| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 64.0).sin_cos();
        [cos, sin]
    });
    let [x, y] = [
        Axis::new("x (voxels)").range(-2.0, 2.0),
        Axis::new("y (voxels)").range(-1.5, 1.5),
    ];
    let plot = Plot::curves("e", "F", "C", x, y).curve(Curve::new("circle", circle).dots());
    let extent = |svg: &str, name: &str| {
        let values = svg.split("<circle").skip(1).filter_map(|rest| {
            let (_, value) = rest.split_once(&format!(" {name}=\""))?;
            value.split('"').next()?.parse::<f64>().ok()
        });
        let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(value), high.max(value)]
        });
        high - low
    };
    let ratio = |svg: &str| extent(svg, "cx") / extent(svg, "cy");
    assert!((ratio(&plot.svg()) - 1.0).abs() > 0.05);
    assert!((ratio(&plot.equal().svg()) - 1.0).abs() < 0.01);
}

#[test]
fn numbers_on_a_logarithmic_axis_are_written_alike() {
    let words = |range: [f64; 2]| {
        let [x, y] = [Axis::logarithmic("x").range(range[0], range[1]), Axis::new("y")];
        let line = Curve::new("line", range.map(|at| [at, 1.0]));
        text(&Plot::curves("l", "F", "C", x, y).curve(line).svg())
    };
    let plain = words([0.1, 10.0]);
    assert!(plain.contains("0.1 0.2 0.5 1 2 5 10"), "{plain}");
    let wide = words([1e-6, 1.0]);
    assert!(wide.contains("1e-6 1e-5 1e-4 1e-3 1e-2 1e-1 1e0"), "{wide}");
}

#[test]
fn bars_of_a_single_series_have_no_legend() {
    let kind = PlotKind::Bars {
        bars: vec!["roughness".to_owned()],
        groups: vec![("plain".to_owned(), vec![1.0]), ("both".to_owned(), vec![2.0])],
    };
    let text = text(&Plot::new("b", "F", "C", axes(), kind).svg());
    assert!(text.contains("both") && !text.contains("roughness"), "{text}");
}
