//! Cameras that move: around their target, or through key frames.
//!
//! Between key frames, positions, targets, up vectors and the logarithm of the enlargement follow Catmull-Rom
//! splines (Barry and Goldman, *A recursive evaluation algorithm for a class of Catmull-Rom splines*, SIGGRAPH
//! 1988). The knots are at the keys' own times, and the splines are written as cubic Hermite curves. With `t_i` the
//! times, `h_i = t_{i+1} - t_i` and `d_i = (p_{i+1} - p_i) / h_i`, the velocity in key i is that of the parabola
//! through it and its neighbours, `m_i = (h_i d_{i-1} + h_{i-1} d_i) / (h_{i-1} + h_i)`. At the ends it is that of
//! the outermost parabola, `m_0 = d_0 + (d_0 - d_1) h_0 / (h_0 + h_1)`. So velocities are continuous, straight and
//! parabolic motion is reproduced exactly, and a path whose last key is its first is closed: it passes that key
//! without a jolt.

use glam::DVec3;

use crate::{Camera, Projection, SceneError, rotation};

/// A camera and when it is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraKey {
    /// Time, in any unit.
    pub time: f64,
    /// The camera at that time.
    pub camera: Camera,
}

/// A camera for every time from 0 to 1.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraPath(Motion);

#[derive(Debug, Clone, PartialEq)]
enum Motion {
    Turntable { start: Camera, degrees: f64 },
    Keys { times: Vec<f64>, spline: Spline },
}

impl CameraPath {
    /// The camera `start` turned by `degrees` in total around its target and its up axis, to its right.
    ///
    /// # Errors
    /// An angle that is not finite.
    pub fn turntable(start: Camera, degrees: f64) -> Result<Self, SceneError> {
        if !degrees.is_finite() {
            return Err(SceneError::invalid(
                "turntable",
                degrees,
                "a finite angle, degrees",
            ));
        }
        Ok(Self(Motion::Turntable { start, degrees }))
    }

    /// Through key frames; the first is at 0, the last at 1.
    ///
    /// # Errors
    /// Fewer than two keys, times that are not finite or do not increase, or projections of both kinds.
    pub fn through(keys: &[CameraKey]) -> Result<Self, SceneError> {
        let [first, .., last] = keys else {
            return Err(SceneError::invalid("camera keys", keys.len(), "at least 2"));
        };
        let duration = last.time - first.time;
        if !duration.is_finite() {
            return Err(SceneError::invalid("time", duration, "finite times of keys"));
        }
        for pair in keys.windows(2) {
            let [before, after] = [pair[0].time, pair[1].time];
            if after.partial_cmp(&before) != Some(std::cmp::Ordering::Greater) {
                return Err(SceneError::invalid("time", after, "later than the key before"));
            }
            let kinds = [pair[0], pair[1]].map(|key| std::mem::discriminant(&key.camera.projection()));
            if kinds[0] != kinds[1] {
                return Err(SceneError::invalid(
                    "projection",
                    pair[1].camera.projection(),
                    "perspective or orthographic in all keys",
                ));
            }
        }
        let times: Vec<f64> = keys
            .iter()
            .map(|key| (key.time - first.time) / duration)
            .collect();
        let points = keys.iter().map(|key| point(&key.camera)).collect();
        let spline = Spline::new(&times, points);
        Ok(Self(Motion::Keys { times, spline }))
    }

    /// Whether the last camera is the first, so that an animation can go round.
    pub fn is_closed(&self) -> bool {
        match &self.0 {
            Motion::Turntable { degrees, .. } => *degrees != 0.0 && degrees % 360.0 == 0.0,
            Motion::Keys { spline, .. } => spline.closed,
        }
    }

    /// The camera at a time from 0 to 1. Times beyond belong to the next round of a closed path, or to the end of
    /// an open one.
    ///
    /// # Errors
    /// Between keys, a path through the target, or an up vector along the view.
    pub fn camera(&self, time: f64) -> Result<Camera, SceneError> {
        let time = if (0.0..=1.0).contains(&time) || !self.is_closed() {
            time.clamp(0.0, 1.0)
        } else {
            time.rem_euclid(1.0)
        };
        match &self.0 {
            Motion::Turntable { start, degrees } => turned(start, degrees * time),
            Motion::Keys { times, spline } => camera(&spline.at(times, time), spline.perspective),
        }
    }
}

/// A camera turned around the axis through its target along its up vector.
fn turned(camera: &Camera, degrees: f64) -> Result<Camera, SceneError> {
    let turn = rotation::about(camera.up().normalize(), degrees.to_radians());
    let position = camera.target() + turn * (camera.position() - camera.target());
    Camera::new(position, camera.target(), camera.up(), camera.projection())
}

/// Position, target, up and enlargement.
const COMPONENTS: usize = 10;

type Point = [f64; COMPONENTS];

/// Cubic Hermite curves through cameras.
#[derive(Debug, Clone, PartialEq)]
struct Spline {
    points: Vec<Point>,
    velocities: Vec<Point>,
    closed: bool,
    perspective: bool,
}

/// A camera as numbers that may be interpolated; the last is the logarithm of what half the picture's height shows,
/// so that zooming by equal factors takes equal times.
fn point(camera: &Camera) -> (Point, bool) {
    let (shown, perspective) = match camera.projection() {
        Projection::Perspective { fov_degrees } => (libm::tan((0.5 * fov_degrees).to_radians()), true),
        Projection::Orthographic { height } => (0.5 * height, false),
    };
    let [p, t, u] = [camera.position(), camera.target(), camera.up().normalize()];
    (
        [p.x, p.y, p.z, t.x, t.y, t.z, u.x, u.y, u.z, libm::log(shown)],
        perspective,
    )
}

fn camera(point: &Point, perspective: bool) -> Result<Camera, SceneError> {
    let [px, py, pz, tx, ty, tz, ux, uy, uz, shown] = *point;
    let shown = libm::exp(shown);
    let projection = if perspective {
        Projection::Perspective {
            fov_degrees: 2.0 * libm::atan(shown).to_degrees(),
        }
    } else {
        Projection::Orthographic { height: 2.0 * shown }
    };
    let vector = DVec3::new;
    Camera::new(
        vector(px, py, pz),
        vector(tx, ty, tz),
        vector(ux, uy, uz),
        projection,
    )
}

impl Spline {
    fn new(times: &[f64], points: Vec<(Point, bool)>) -> Self {
        let perspective = points.first().is_some_and(|(_, perspective)| *perspective);
        let points: Vec<Point> = points.into_iter().map(|(point, _)| point).collect();
        let closed = points.len() > 2 && points.first() == points.last();
        let mut spline = Self {
            velocities: vec![[0.0; COMPONENTS]; points.len()],
            points,
            closed,
            perspective,
        };
        for i in 0..spline.points.len() {
            spline.velocities[i] = spline.velocity(times, i);
        }
        spline
    }

    /// The velocity in key i; see the head of this module.
    fn velocity(&self, times: &[f64], i: usize) -> Point {
        let last = self.points.len() - 1;
        let slope = |i: usize| -> (f64, Point) {
            let step = times[i + 1] - times[i];
            let (from, to) = (&self.points[i], &self.points[i + 1]);
            (step, std::array::from_fn(|c| (to[c] - from[c]) / step))
        };
        let mixed = |(ha, a): (f64, Point), (hb, b): (f64, Point)| -> Point {
            std::array::from_fn(|c| (hb * a[c] + ha * b[c]) / (ha + hb))
        };
        let outermost = |(ha, a): (f64, Point), (hb, b): (f64, Point)| -> Point {
            std::array::from_fn(|c| a[c] + (a[c] - b[c]) * ha / (ha + hb))
        };
        match i {
            _ if last == 1 => slope(0).1,
            _ if self.closed && (i == 0 || i == last) => mixed(slope(last - 1), slope(0)),
            0 => outermost(slope(0), slope(1)),
            _ if i == last => outermost(slope(last - 1), slope(last - 2)),
            _ => mixed(slope(i - 1), slope(i)),
        }
    }

    /// The point at a time from 0 to 1.
    fn at(&self, times: &[f64], time: f64) -> Point {
        let i = times
            .partition_point(|&key| key <= time)
            .clamp(1, times.len() - 1)
            - 1;
        let step = times[i + 1] - times[i];
        let s = (time - times[i]) / step;
        let (from, to) = (&self.points[i], &self.points[i + 1]);
        let (leaving, arriving) = (&self.velocities[i], &self.velocities[i + 1]);
        std::array::from_fn(|c| {
            let bend = |leaving: f64, arriving: f64| {
                let r = 1.0 - s;
                step * s * r * (r * leaving - s * arriving)
            };
            let rise = s * s * (3.0 - 2.0 * s);
            from[c] + (to[c] - from[c]) * rise + bend(leaving[c], arriving[c])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERSPECTIVE: Projection = Projection::Perspective { fov_degrees: 30.0 };

    fn looking(position: DVec3, target: DVec3) -> Camera {
        Camera::new(position, target, DVec3::Z, PERSPECTIVE).unwrap()
    }

    fn key(time: f64, position: DVec3) -> CameraKey {
        let camera = looking(position, DVec3::new(0.0, 1000.0, 0.0));
        CameraKey { time, camera }
    }

    #[test]
    fn a_turntable_keeps_distance_and_height() {
        let start = looking(DVec3::new(3.0, 10.0, 5.0), DVec3::new(1.0, 2.0, 3.0));
        let path = CameraPath::turntable(start, 360.0).unwrap();
        assert!(path.is_closed());
        for i in 0..12 {
            let camera = path.camera(f64::from(i) / 12.0).unwrap();
            let angle = f64::from(i) * std::f64::consts::TAU / 12.0;
            // Around +z, counter-clockwise seen from above: to the right of a camera that faces the axis.
            let expected = DVec3::new(
                1.0 + 2.0 * angle.cos() - 8.0 * angle.sin(),
                2.0 + 2.0 * angle.sin() + 8.0 * angle.cos(),
                5.0,
            );
            assert!((camera.position() - expected).length() < 1e-12, "{i}");
            assert_eq!((camera.target(), camera.up()), (start.target(), start.up()));
        }
        assert!(!CameraPath::turntable(start, 90.0).unwrap().is_closed());
        assert!(CameraPath::turntable(start, f64::NAN).is_err());
    }

    #[test]
    fn keys_are_met_and_parabolas_reproduced() {
        // Unequal times, three components of different parabolas.
        let parabola = |t: f64| DVec3::new(1.0 + t, 2.0 - 3.0 * t * t, 0.5 * t * t - t);
        let times = [0.0, 0.7, 1.0, 2.5, 4.0];
        let keys: Vec<CameraKey> = times.iter().map(|&t| key(t, parabola(t))).collect();
        let path = CameraPath::through(&keys).unwrap();
        for i in 0..=100 {
            let t = f64::from(i) * 0.04;
            let at = path.camera(t / 4.0).unwrap().position();
            assert!((at - parabola(t)).length() < 1e-11, "{t}: {at}");
        }
        for key in &keys {
            assert!(
                (path.camera(key.time / 4.0).unwrap().position() - key.camera.position()).length() < 1e-12
            );
        }
    }

    #[test]
    fn velocities_are_continuous_also_where_a_closed_path_begins() {
        let corners = [
            DVec3::X,
            DVec3::Y,
            -DVec3::X,
            DVec3::new(0.3, -1.0, 0.2),
            DVec3::X,
        ];
        let keys: Vec<CameraKey> = corners
            .iter()
            .zip([0.0, 1.0, 3.0, 3.5, 5.0])
            .map(|(&p, t)| key(t, p))
            .collect();
        let path = CameraPath::through(&keys).unwrap();
        assert!(path.is_closed());
        let position = |t: f64| path.camera(t / 5.0).unwrap().position();
        let step = 1e-6;
        for t in [0.0, 1.0, 3.0, 3.5, 5.0, 10.0] {
            let before = (position(t) - position(t - step)) / step;
            let after = (position(t + step) - position(t)) / step;
            assert!((before - after).length() < 1e-4, "{t}: {before} {after}");
        }
    }

    #[test]
    fn zooming_takes_equal_times_for_equal_factors() {
        let at = |time: f64, height: f64| CameraKey {
            time,
            camera: Camera::new(
                DVec3::X,
                DVec3::ZERO,
                DVec3::Z,
                Projection::Orthographic { height },
            )
            .unwrap(),
        };
        let path = CameraPath::through(&[at(0.0, 1.0), at(1.0, 16.0)]).unwrap();
        let Projection::Orthographic { height } = path.camera(0.25).unwrap().projection() else {
            panic!("the projection changed its kind");
        };
        // The spline of two keys is a straight line.
        assert!((height - 2.0).abs() < 1e-12, "{height}");
    }

    #[test]
    fn open_paths_stop_at_their_ends() {
        let path = CameraPath::through(&[key(3.0, DVec3::X), key(5.0, DVec3::Y)]).unwrap();
        assert!(!path.is_closed());
        assert_eq!(path.camera(-1.0), path.camera(0.0));
        assert_eq!(path.camera(7.0), path.camera(1.0));
        assert_eq!(path.camera(0.0).unwrap().position(), DVec3::X);
    }

    #[test]
    fn nonsense_is_refused_by_name() {
        let refused = |keys: &[CameraKey], field: &str| {
            let error = CameraPath::through(keys).unwrap_err().to_string();
            assert!(error.starts_with(field), "{error}");
        };
        refused(&[key(0.0, DVec3::X)], "camera keys");
        refused(&[key(1.0, DVec3::X), key(1.0, DVec3::Y)], "time");
        refused(&[key(0.0, DVec3::X), key(f64::NAN, DVec3::Y)], "time");
        let parallel = Projection::Orthographic { height: 1.0 };
        let other = Camera::new(DVec3::X, DVec3::ZERO, DVec3::Z, parallel).unwrap();
        refused(
            &[
                key(0.0, DVec3::X),
                CameraKey {
                    time: 1.0,
                    camera: other,
                },
            ],
            "projection",
        );
        // Through the target.
        let through = |x: f64| CameraKey {
            time: x,
            camera: looking(DVec3::X * x, DVec3::ZERO),
        };
        let path = CameraPath::through(&[through(-1.0), through(1.0)]).unwrap();
        assert!(path.camera(0.5).is_err());
    }
}
