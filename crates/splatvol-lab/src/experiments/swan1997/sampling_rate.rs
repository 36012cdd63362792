//! Fig. 6: the factor that the distance k neglects off the axis, `1 / cos alpha`.
//!
//! Neighbouring rays at the angle alpha from the axis meet the plane of depth d in points r = d p / D apart, whatever
//! the angle, but pass each other at the distance `r' = r cos alpha` (section 4.6). Eq. 4 takes r.

use glam::{DVec2, DVec3};
use splatvol::{Camera, Filter, ImageSize, Projection, ScreenFromCamera};

use super::single::Single;
use crate::{
    Axis, Curve, Expectation, Experiment, Finding, LabError, Outcome, Plot, Published, Table, Workbench,
};

pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "swan1997-sampling-rate",
    paper: "swan1997",
    title: "The sampling rate off the axis",
    figures: &["Fig. 6"],
    about: "The paper estimates how much too large its splats are off the axis: neighbouring rays pass each other closer than eq. 4 \
says, by cos(alpha), so at 30 degrees splats are 1 / .87 = 1.15 times too large; it says *about*, because one angle of its drawing \
is not quite a right one.\n\n\
We take neighbouring rays of the camera and measure their distance exactly; and we draw a single splat at twice the distance k, \
at angles of 0 to 45 degrees from the axis, and measure its standard deviation in pixels against that on the axis: away from \
the axis, which is what the paper's drawing shows, and across, which it does not.",
    run,
};

/// Rays, and a splat drawn, at one angle.
struct Row {
    degrees: f64,
    /// Distance of neighbouring rays in a plane of depth over that between the rays themselves.
    rays: f64,
    /// Size of the splat away from the axis and across, over that on the axis.
    splat: DVec2,
}

fn run(bench: &Workbench<'_>) -> Result<Outcome, LabError> {
    let step = bench.choose(3, 15);
    let angles: Vec<f64> = (0..=45).step_by(step).map(f64::from).collect();
    let size = ImageSize::new(270, 157)?;
    let projection = Projection::Perspective { fov_degrees: 60.0 };
    let screen = Camera::new(DVec3::ZERO, DVec3::X, DVec3::Z, projection)?.screen_from_camera(size);
    let single = Single::new(screen.scale, bench.choose(8, 4))?;
    let mut renderer = bench.renderer()?;
    let depth = 2.0 * screen.scale;
    let mut rows: Vec<Row> = Vec::new();
    let mut on_axis = DVec2::ONE;
    for (index, &degrees) in angles.iter().enumerate() {
        bench.step(index, angles.len(), "splats");
        let angle = degrees.to_radians();
        let drawn = single.moments(&mut renderer, Filter::Swan, (depth, angle))?;
        if index == 0 {
            on_axis = drawn.deviation;
        }
        rows.push(Row {
            degrees,
            rays: rays_apart(&screen, angle),
            splat: drawn.deviation / on_axis,
        });
    }
    let mut outcome = Outcome::default();
    find(&mut outcome, &rows);
    outcome.tables.push(table(&rows));
    outcome.plots.push(plot(&rows));
    Ok(outcome)
}

/// r / r' of two rays through pixels side by side, half a pixel to either side of the angle.
fn rays_apart(screen: &ScreenFromCamera, angle: f64) -> f64 {
    let ray = |offset: f64| {
        let column = screen.scale * angle.tan() + offset;
        screen.ray(screen.centre + DVec2::new(column, 0.0)).1
    };
    let [near, far] = [ray(-0.5), ray(0.5)];
    let in_plane = (far - near).length();
    // Distance of the outer ray's point at depth 1 from the inner ray.
    let across = far.cross(near.normalize()).length();
    in_plane / across
}

fn find(outcome: &mut Outcome, rows: &[Row]) {
    let Some(at_30) = rows.iter().find(|row| row.degrees == 30.0) else {
        return;
    };
    outcome.find(
        Finding::new(
            "Fig. 6",
            "rays-at-30",
            "how much closer rays pass each other at 30 degrees than eq. 4 says",
            at_30.rays,
            Expectation::Near {
                value: 1.15,
                within: 0.01,
            },
        )
        .published(Published::Number(1.15)),
    );
    let cosine = rows.iter().map(|row| {
        let exact = row.rays * row.degrees.to_radians().cos();
        (exact - 1.0).abs()
    });
    outcome.find(
        Finding::new(
            "Fig. 6",
            "right-angle",
            "largest error of r cos alpha for the distance of rays, up to 45 degrees",
            cosine.fold(0.0, f64::max),
            Expectation::AtMost(0.01),
        )
        .published(Published::Claim("approximately equal".to_owned())),
    );
    outcome.find(
        Finding::new(
            "Fig. 6",
            "splat-at-30",
            "size of a splat beyond k at 30 degrees, away from the axis, against that on it",
            at_30.splat.x,
            Expectation::Near {
                value: 1.15,
                within: 0.015,
            },
        )
        .published(Published::Number(1.15)),
    );
    outcome.find(Finding::new(
        "Fig. 6",
        "across-at-30",
        "the same across that direction, which the drawing leaves out: rays pass at r there, and no splat is too large",
        at_30.splat.y,
        Expectation::Near {
            value: 1.0,
            within: 0.015,
        },
    ));
    let least = rows
        .iter()
        .map(|row| row.splat.min_element())
        .fold(f64::INFINITY, f64::min);
    outcome.find(
        Finding::new(
            "Fig. 6",
            "smallest",
            "smallest size of a splat beyond k in any direction up to 45 degrees, against that on the axis",
            least,
            Expectation::AtLeast(0.99),
        )
        .published(Published::Claim(
            "eq. 2 is still satisfied: no aliasing results".to_owned(),
        )),
    );
}

fn table(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "angles",
        "Fig. 6",
        "Rays and splats by the angle from the axis",
        &[
            "angle (degrees)",
            "1 / cos",
            "r / r' of neighbouring rays",
            "splat, away from the axis",
            "splat, across",
        ],
    );
    for row in rows {
        table.row([
            row.degrees.into(),
            row.degrees.to_radians().cos().recip().into(),
            row.rays.into(),
            row.splat.x.into(),
            row.splat.y.into(),
        ]);
    }
    table
}

fn plot(rows: &[Row]) -> Plot {
    let curve =
        |name: &str, of: fn(&Row) -> f64| Curve::new(name, rows.iter().map(|row| [row.degrees, of(row)]));
    let cosine = (0..=45).map(f64::from).map(|a| [a, a.to_radians().cos().recip()]);
    Plot::curves(
        "angles",
        "Fig. 6",
        "how much larger splats are than the distance of the rays asks for",
        Axis::new("angle from the axis (degrees)"),
        Axis::new("size against that on the axis").range(0.95, 1.45),
    )
    .curve(curve("splat, away from the axis", |row| row.splat.x).dots())
    .curve(curve("splat, across", |row| row.splat.y).dots())
    .curve(curve("rays", |row| row.rays))
    .curve(Curve::new("1 / cos", cosine).dashed())
}
