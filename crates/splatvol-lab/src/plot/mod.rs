//! Plots, as SVG: curves, bars, contours and surfaces, with labelled axes and colours that colour-blind readers tell
//! apart (Okabe and Ito's; viridis for values of two variables).

mod ids;
mod render;
#[cfg(test)]
mod tests;

/// Scale of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// Equal distances for equal differences.
    #[default]
    Linear,
    /// Equal distances for equal ratios; numbers must be positive.
    Logarithmic,
}

/// An axis.
#[derive(Debug, Clone)]
pub struct Axis {
    /// Quantity on the axis, with the unit: `distance (voxels)`.
    pub label: String,
    /// Scale.
    pub scale: Scale,
    /// Range; `None` takes that of the data.
    pub range: Option<[f64; 2]>,
}

impl Axis {
    /// A linear axis.
    pub fn new(label: &str) -> Self {
        Self {
            label: label.to_owned(),
            scale: Scale::Linear,
            range: None,
        }
    }

    /// A logarithmic axis.
    pub fn logarithmic(label: &str) -> Self {
        Self {
            scale: Scale::Logarithmic,
            ..Self::new(label)
        }
    }

    /// Sets the ends.
    #[must_use]
    pub fn range(mut self, low: f64, high: f64) -> Self {
        self.range = Some([low, high]);
        self
    }
}

/// A series of points that belong together.
#[derive(Debug, Clone)]
pub struct Curve {
    /// Name in the legend.
    pub label: String,
    /// Points, by x.
    pub points: Vec<[f64; 2]>,
    /// Whether to dash it: for theory and for published numbers.
    pub dashed: bool,
    /// Whether to show the points themselves: for few, measured ones.
    pub dots: bool,
}

impl Curve {
    /// A line.
    pub fn new(label: &str, points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        Self {
            label: label.to_owned(),
            points: points.into_iter().collect(),
            dashed: false,
            dots: false,
        }
    }

    /// Dashes it: theory, or published numbers.
    #[must_use]
    pub fn dashed(mut self) -> Self {
        self.dashed = true;
        self
    }

    /// Shows its points.
    #[must_use]
    pub fn dots(mut self) -> Self {
        self.dots = true;
        self
    }
}

/// A straight line across the plot.
#[derive(Debug, Clone)]
pub enum Mark {
    /// At a value of x.
    Vertical {
        /// The value.
        at: f64,
        /// Label of the line.
        label: String,
    },
    /// At a value of y.
    Horizontal {
        /// The value.
        at: f64,
        /// Label of the line.
        label: String,
    },
}

/// Contents of a plot.
#[derive(Debug, Clone)]
pub enum PlotKind {
    /// Functions of one variable.
    Curves {
        /// The functions.
        curves: Vec<Curve>,
        /// Lines across.
        marks: Vec<Mark>,
    },
    /// Groups of bars: one group per label of `groups`, with a bar per name of `bars`.
    Bars {
        /// Names in the legend, one per bar of a group.
        bars: Vec<String>,
        /// Label and heights of each group.
        groups: Vec<(String, Vec<f64>)>,
    },
    /// Lines of equal value of a function of two variables, over its colours.
    Contours {
        /// Columns.
        x: Vec<f64>,
        /// Rows.
        y: Vec<f64>,
        /// `values[row][column]`.
        values: Vec<Vec<f64>>,
        /// Quantity and its unit.
        label: String,
        /// Values of the lines.
        levels: Vec<f64>,
    },
    /// A function of two variables as a surface.
    Surface {
        /// Columns.
        x: Vec<f64>,
        /// Rows.
        y: Vec<f64>,
        /// `values[row][column]`.
        values: Vec<Vec<f64>>,
        /// Quantity and its unit.
        label: String,
    },
}

/// A plot.
#[derive(Debug, Clone)]
pub struct Plot {
    /// Name within the experiment, in kebab case; the file is named after it.
    pub name: String,
    /// The paper's figure.
    pub figure: String,
    /// Description of the plot.
    pub caption: String,
    /// Axis from left to right.
    pub x: Axis,
    /// Axis from bottom to top; of a surface, from front to back.
    pub y: Axis,
    /// Contents.
    pub kind: PlotKind,
    /// Whether a unit is as long on both axes, so that circles are circles; both need a range, and no logarithm.
    pub equal: bool,
}

impl Plot {
    /// A plot of curves, so far without any.
    pub fn curves(name: &str, figure: &str, caption: &str, x: Axis, y: Axis) -> Self {
        let kind = PlotKind::Curves {
            curves: Vec::new(),
            marks: Vec::new(),
        };
        Self::new(name, figure, caption, [x, y], kind)
    }

    /// A plot of anything; `axes` are x and y.
    pub fn new(name: &str, figure: &str, caption: &str, axes: [Axis; 2], kind: PlotKind) -> Self {
        let [x, y] = axes;
        Self {
            name: name.to_owned(),
            figure: figure.to_owned(),
            caption: caption.to_owned(),
            x,
            y,
            kind,
            equal: false,
        }
    }

    /// Makes a unit as long on both axes: the plot becomes as high as necessary.
    #[must_use]
    pub fn equal(mut self) -> Self {
        self.equal = true;
        self
    }

    /// Adds a curve; other kinds of plots stay as they are.
    #[must_use]
    pub fn curve(mut self, curve: Curve) -> Self {
        if let PlotKind::Curves { curves, .. } = &mut self.kind {
            curves.push(curve);
        }
        self
    }

    /// Adds a line across; other kinds of plots stay as they are.
    #[must_use]
    pub fn mark(mut self, mark: Mark) -> Self {
        if let PlotKind::Curves { marks, .. } = &mut self.kind {
            marks.push(mark);
        }
        self
    }

    /// The plot as SVG, the same bytes for the same plot.
    pub fn svg(&self) -> String {
        ids::stable(&render::svg(self))
    }

    /// File name.
    pub fn file_name(&self) -> String {
        format!("{}.svg", self.name)
    }
}
