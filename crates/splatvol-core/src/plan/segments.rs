//! Segments: levels of a volume behind each other in one picture.
//!
//! The distance of a level's planes is a whole multiple of that of the level before, so that the last interval of one
//! ends on the plane on which the first of the next begins. No interval is left out, and none is shown twice.
//!
//! A level looks different from the next where material is thin, so that a border would show. In the last half octave of
//! a level both lie side by side on its planes, with shares of their extinctions that change from interval to interval
//! ([`Ramp`]).

use splatvol_scene::{Camera, Grid, RenderSettings, SheetSettings};

use super::view::{GridView, Sampling};

/// Share by which planes may lie farther apart than a level's voxels ask: halves of odd sizes are not twice as large.
const WIDER: f64 = 0.02;
/// Octaves of depth in which a level fades into the next.
const FADE: f64 = 0.5;

/// Intervals in which a level fades into the next, counted from depth 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ramp {
    /// The first interval.
    pub first: i64,
    /// One past the last.
    pub end: i64,
}

impl Ramp {
    /// Share of the next level in an interval, 0 to 1.
    pub fn share(&self, interval: i64) -> f32 {
        let into = (interval - self.first) as f64 + 0.5;
        (into / (self.end - self.first) as f64) as f32
    }
}

/// Intervals of a picture that one level shows, or two side by side.
#[derive(Debug)]
pub struct Segment {
    /// Index of the level among those that were given.
    pub level: usize,
    /// Its view.
    pub view: GridView,
    /// View of the next level on the same planes, and its shares.
    pub next: Option<(GridView, Ramp)>,
}

/// The segments of a volume's levels, nearest first, given the depths at which each but the last gives way to the next.
/// `None` where the planes of one level cannot be among those of the level before.
pub fn behind_each_other(
    grids: &[Grid],
    ends: &[f64],
    shot: (&Camera, &RenderSettings<SheetSettings>),
    sampling: Sampling,
) -> Option<Vec<Segment>> {
    let mut segments = Vec::with_capacity(2 * grids.len());
    let mut view = GridView::new(grids.first()?, shot, sampling, None);
    // Where the level begins, in intervals from depth 0.
    let mut begin = i64::MIN;
    for (level, grid) in grids.iter().enumerate().skip(1) {
        let spacing = view.spacing();
        let own = GridView::new(grid, shot, sampling, None);
        let times = (own.spacing() * (1.0 + WIDER) / spacing).floor().max(1.0);
        let [beside, behind] = [1.0, times].map(|times| {
            let wanted = times * spacing;
            let view = GridView::new(grid, shot, sampling, Some(wanted));
            (view.spacing() == wanted).then_some(view)
        });
        let (beside, behind) = (beside?, behind?);
        let end = ends[level - 1];
        let next = (end / behind.spacing()).round() as i64;
        let end_here = next.saturating_mul(times as i64);
        let faded = (end * libm::exp2(-FADE) / spacing).round() as i64;
        let ramp = Ramp {
            first: faded.clamp(begin.min(end_here), end_here),
            end: end_here,
        };
        segments.push(Segment {
            level: level - 1,
            view: view.clone().between(&(begin..ramp.first)),
            next: None,
        });
        let both = ramp.first..ramp.end;
        segments.push(Segment {
            level: level - 1,
            view: view.between(&both),
            next: Some((beside.between(&both), ramp)),
        });
        (view, begin) = (behind, next);
    }
    segments.push(Segment {
        level: grids.len() - 1,
        view: view.between(&(begin..i64::MAX)),
        next: None,
    });
    segments.retain(|segment| !segment.view.shown().is_empty());
    Some(segments)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use splatvol_scene::{ImageSize, Projection};

    use super::*;

    /// Grids of a box with so many voxels a side.
    fn grids(counts: &[usize]) -> Vec<Grid> {
        let grid = |&n: &usize| Grid::centred([n; 3], DVec3::splat(120.0 / n as f64)).unwrap();
        counts.iter().map(grid).collect()
    }

    fn segments(counts: &[usize], ends: &[f64]) -> Vec<Segment> {
        let eye = DVec3::new(10.0, -55.0, 4.0);
        let projection = Projection::Perspective { fov_degrees: 60.0 };
        let camera = Camera::new(eye, DVec3::ZERO, DVec3::Z, projection).unwrap();
        let settings = RenderSettings {
            size: ImageSize::new(64, 64).unwrap(),
            ..RenderSettings::default().with(SheetSettings::default())
        };
        let shot = (&camera, &settings);
        behind_each_other(&grids(counts), ends, shot, Sampling::Field).unwrap()
    }

    #[test]
    fn every_interval_is_shown_once_and_levels_meet_on_planes_of_both() {
        // Halves of odd sizes; the last is as fine as the one before, as levels of a file may be.
        for counts in [[120, 60, 30, 15], [121, 61, 31, 16], [120, 60, 60, 59]] {
            let segments = segments(&counts, &[20.0, 40.0, 80.0]);
            assert_eq!(segments.len(), 7, "{counts:?}");
            for (at, pair) in segments.windows(2).enumerate() {
                let end = pair[0].view.shown().end as f64 * pair[0].view.spacing();
                let begin = pair[1].view.shown().start as f64 * pair[1].view.spacing();
                assert!((end - begin).abs() < 1e-9, "{counts:?} {at}: {end} {begin}");
            }
            for Segment { level, view, next } in &segments {
                let Some((beside, ramp)) = next else { continue };
                assert_eq!((beside.spacing(), beside.shown()), (view.spacing(), view.shown()));
                assert_eq!(ramp.first..ramp.end, view.shown());
                let shares: Vec<f32> = view.shown().map(|interval| ramp.share(interval)).collect();
                assert!(shares[0] > 0.0 && shares.is_sorted() && shares[shares.len() - 1] < 1.0);
                // It ends where it was asked to, but for planes.
                let end = ramp.end as f64 * view.spacing() / [20.0, 40.0, 80.0][*level];
                assert!((end - 1.0).abs() < 0.1, "{level}: {end}");
            }
        }
    }

    #[test]
    fn what_lies_behind_the_volume_has_no_segment() {
        let levels: Vec<_> = segments(&[120, 60, 30, 15], &[20.0, 60.0, 500.0])
            .iter()
            .map(|segment| (segment.level, segment.next.is_some()))
            .collect();
        assert_eq!(levels, [(0, false), (0, true), (1, false), (1, true), (2, false)]);
    }
}
