//! Handles of clips: places in the picture that move a side of the box, or a plane, or turn it.
//!
//! A side of the box moves along its axis, and a plane along its normal: by as much as the point of that line that is closest to the
//! pointer's ray. Where the line runs along the ray, up and down in the picture take its place. A plane turns around its
//! point as if a ball was dragged.

use splatvol::glam::{DVec2, DVec3};
use splatvol::{Bounds, Camera, ClipPlane, ImageSize};
use splatvol_document::keys::EffectKeys;

use super::navigate::height_at_target;
use super::probe::world_ray;

/// Smallest width of a box, share of the data's: a box without a width is refused.
pub const LEAST_WIDTH: f64 = 1e-3;
/// Length of a plane's normal, share of the data's diagonal.
const NORMAL_LENGTH: f64 = 0.18;
/// Least sine of the angle between a line and the pointer's ray at which one can be found from the other.
const LEAST_SINE: f64 = 0.2;

/// Something that can be dragged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Handle {
    /// A side of the box, in the order of its key: x0, x1, y0, y1, z0, z1.
    Side(usize),
    /// A plane with this number, along its normal.
    Depth(usize),
    /// The end of the normal of the plane with this number.
    Normal(usize),
}

impl Handle {
    /// What it moves, for a person.
    pub fn name(self) -> String {
        match self {
            Self::Side(side) => {
                let end = if side % 2 == 0 { "Lower" } else { "Upper" };
                format!("{end} {} side of the box", ["x", "y", "z"][side / 2])
            }
            Self::Depth(index) => format!("Depth of plane {}", index + 1),
            Self::Normal(index) => format!("Normal of plane {}", index + 1),
        }
    }
}

/// The view that handles are dragged in.
#[derive(Debug, Clone, Copy)]
pub struct Seen<'a> {
    /// From where.
    pub camera: &'a Camera,
    /// Size of the picture.
    pub size: ImageSize,
    /// Of the data, world.
    pub bounds: &'a Bounds,
}

/// The handles of all clips, and where they are, world.
pub fn handles(effects: &EffectKeys, bounds: &Bounds) -> Vec<(Handle, DVec3)> {
    let mut all = Vec::new();
    if let Some(sides) = &effects.clip_box {
        all.extend((0..6).map(|side| (Handle::Side(side), middle_of_side(sides, side))));
    }
    for (index, plane) in effects.clip_plane.iter().flatten().enumerate() {
        let pivot = pivot(plane, bounds);
        let end = pivot + normal_length(bounds) * plane.normal();
        // Where both are at one place of the picture, the later one is met: a plane that faces the camera is moved.
        all.push((Handle::Normal(index), end));
        all.push((Handle::Depth(index), pivot));
    }
    all
}

fn middle_of_side(sides: &[f64; 6], side: usize) -> DVec3 {
    let mut middle = DVec3::new(
        0.5 * (sides[0] + sides[1]),
        0.5 * (sides[2] + sides[3]),
        0.5 * (sides[4] + sides[5]),
    );
    middle[side / 2] = sides[side];
    middle
}

fn normal_length(bounds: &Bounds) -> f64 {
    NORMAL_LENGTH * bounds.diagonal()
}

/// The point around which a plane turns: its own if that is among the data, else the one that is closest to their middle.
pub fn pivot(plane: &ClipPlane, bounds: &Bounds) -> DVec3 {
    let own = plane.point();
    let is_among = (0..3).all(|axis| (bounds.min[axis]..=bounds.max[axis]).contains(&own[axis]));
    match is_among {
        true => own,
        false => bounds.centre() - plane.distance(bounds.centre()) * plane.normal(),
    }
}

/// The clips after a handle was dragged from one pixel to another; what cannot be is left as it was.
pub fn drag(effects: &EffectKeys, handle: Handle, seen: Seen<'_>, [from, to]: [DVec2; 2]) -> EffectKeys {
    let mut dragged = effects.clone();
    match handle {
        Handle::Side(side) => {
            if let Some(sides) = &mut dragged.clip_box {
                drag_side(sides, side, seen, [from, to]);
            }
        }
        Handle::Depth(index) | Handle::Normal(index) => {
            let planes = dragged.clip_plane.iter_mut().flatten();
            if let Some(plane) = planes.into_iter().nth(index) {
                let other = match handle {
                    Handle::Normal(_) => turned(plane, seen, to),
                    _ => moved(plane, seen, [from, to]),
                };
                *plane = other.unwrap_or(*plane);
            }
        }
    }
    dragged
}

fn drag_side(sides: &mut [f64; 6], side: usize, seen: Seen<'_>, pixels: [DVec2; 2]) {
    let axis = side / 2;
    let line = (middle_of_side(sides, side), DVec3::AXES[axis]);
    let [min, max] = [seen.bounds.min[axis], seen.bounds.max[axis]];
    let least = LEAST_WIDTH * (max - min).max(f64::MIN_POSITIVE);
    let wanted = sides[side] + way_along(line, seen, pixels);
    let (low, high) = (sides[2 * axis], sides[2 * axis + 1]);
    sides[side] = match side % 2 {
        0 => wanted.max(min).min(high - least),
        _ => wanted.min(max).max(low + least),
    };
}

fn moved(plane: &ClipPlane, seen: Seen<'_>, pixels: [DVec2; 2]) -> Option<ClipPlane> {
    let (pivot, normal) = (pivot(plane, seen.bounds), plane.normal());
    let distance = (pivot - seen.bounds.centre()).dot(normal);
    let reach = 0.5 * seen.bounds.diagonal();
    let wanted = (distance + way_along((pivot, normal), seen, pixels)).clamp(-reach, reach);
    ClipPlane::new(pivot + (wanted - distance) * normal, normal).ok()
}

/// The plane whose normal's end lies under a pixel, on the side of the ball around the pivot on which it was.
fn turned(plane: &ClipPlane, seen: Seen<'_>, pixel: DVec2) -> Option<ClipPlane> {
    let pivot = pivot(plane, seen.bounds);
    let (origin, direction) = world_ray(seen.camera, seen.size, pixel);
    let direction = direction.normalize_or_zero();
    let closest = origin + (pivot - origin).dot(direction) * direction;
    let across = closest - pivot;
    let radius = normal_length(seen.bounds);
    let along = libm::sqrt((radius * radius - across.length_squared()).max(0.0));
    let faces = plane.normal().dot(direction);
    let normal = across + along.copysign(faces) * direction;
    ClipPlane::new(pivot, normal.try_normalize()?).ok()
}

/// How far the point of a line that is closest to the pointer's ray has moved; the line's direction has length 1.
fn way_along((point, direction): (DVec3, DVec3), seen: Seen<'_>, pixels: [DVec2; 2]) -> f64 {
    let closest = pixels.map(|pixel| {
        let (origin, ray) = world_ray(seen.camera, seen.size, pixel);
        let ray = ray.normalize_or_zero();
        let cosine = direction.dot(ray);
        let sine_squared = 1.0 - cosine * cosine;
        let between = point - origin;
        let along = (cosine * ray.dot(between) - direction.dot(between)) / sine_squared;
        (sine_squared >= LEAST_SINE * LEAST_SINE).then_some(along)
    });
    match closest {
        [Some(before), Some(after)] => after - before,
        _ => {
            let per_pixel = height_at_target(seen.camera) / f64::from(seen.size.height());
            (pixels[0].y - pixels[1].y) * per_pixel
        }
    }
}

/// Where a plane cuts the box of the data, as a polygon; empty where it passes it by.
pub fn outline(plane: &ClipPlane, bounds: &Bounds) -> Vec<DVec3> {
    let mut points: Vec<DVec3> = edges(&bounds.min, &bounds.max)
        .filter_map(|[a, b]| {
            let (from, to) = (plane.distance(a), plane.distance(b));
            ((from < 0.0) != (to < 0.0)).then(|| a + from / (from - to) * (b - a))
        })
        .collect();
    let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let right = plane.normal().any_orthonormal_vector();
    let up = plane.normal().cross(right);
    let angle = |point: &DVec3| libm::atan2((point - middle).dot(up), (point - middle).dot(right));
    points.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    points
}

/// The edges of a box.
pub fn edges<'a>(min: &'a DVec3, max: &'a DVec3) -> impl Iterator<Item = [DVec3; 2]> + 'a {
    (0..3).flat_map(move |axis| {
        (0..4).map(move |corner| {
            let mut start = *min;
            for (bit, other) in [(axis + 1) % 3, (axis + 2) % 3].into_iter().enumerate() {
                if corner >> bit & 1 == 1 {
                    start[other] = max[other];
                }
            }
            let mut end = start;
            end[axis] = max[axis];
            [start, end]
        })
    })
}

#[cfg(test)]
mod tests {
    use splatvol::Projection;

    use super::*;

    fn bounds() -> Bounds {
        Bounds {
            min: DVec3::new(-10.0, -20.0, -30.0),
            max: DVec3::new(10.0, 20.0, 30.0),
        }
    }

    fn size() -> ImageSize {
        ImageSize::new(400, 300).unwrap()
    }

    fn cameras() -> [Camera; 2] {
        let position = DVec3::new(60.0, -120.0, 45.0);
        [
            Projection::Perspective { fov_degrees: 35.0 },
            Projection::Orthographic { height: 90.0 },
        ]
        .map(|projection| Camera::new(position, DVec3::ZERO, DVec3::Z, projection).unwrap())
    }

    fn seen<'a>(camera: &'a Camera, bounds: &'a Bounds) -> Seen<'a> {
        let size = size();
        Seen { camera, size, bounds }
    }

    fn pixel(camera: &Camera, place: DVec3) -> DVec2 {
        let local = camera.camera_from_world().transform_point3(place);
        camera.screen_from_camera(size()).project(local)
    }

    fn with_box() -> EffectKeys {
        EffectKeys {
            clip_box: Some([-10.0, 10.0, -20.0, 20.0, -30.0, 30.0]),
            ..EffectKeys::default()
        }
    }

    fn with_plane(point: DVec3, normal: DVec3) -> EffectKeys {
        EffectKeys {
            clip_plane: Some(vec![ClipPlane::new(point, normal).unwrap()]),
            ..EffectKeys::default()
        }
    }

    #[test]
    fn a_handle_that_is_dragged_to_a_place_of_its_line_arrives_there() {
        let bounds = bounds();
        for camera in &cameras() {
            let seen = seen(camera, &bounds);
            for (handle, place) in handles(&with_box(), &bounds) {
                let Handle::Side(side) = handle else {
                    unreachable!()
                };
                let wanted = place * 0.25;
                let pixels = [pixel(camera, place), pixel(camera, wanted)];
                let sides = drag(&with_box(), handle, seen, pixels).clip_box.unwrap();
                assert!(
                    (sides[side] - wanted[side / 2]).abs() < 1e-9,
                    "{handle:?}: {sides:?}"
                );
                let others = (0..6).filter(|other| *other != side);
                assert!(
                    others
                        .into_iter()
                        .all(|other| Some(sides[other]) == with_box().clip_box.map(|own| own[other]))
                );
            }
            let normal = DVec3::new(1.0, 0.5, -0.3).normalize();
            let cut = with_plane(DVec3::new(1.0, 2.0, 3.0), normal);
            let (handle, place) = handles(&cut, &bounds)[1];
            let wanted = place + 4.0 * normal;
            let pixels = [pixel(camera, place), pixel(camera, wanted)];
            let plane = drag(&cut, handle, seen, pixels).clip_plane.unwrap()[0];
            assert!(plane.point().distance(wanted) < 1e-9 && plane.normal().distance(normal) < 1e-12);
        }
    }

    #[test]
    fn sides_stay_between_the_data_and_each_other() {
        let (bounds, [camera, _]) = (bounds(), cameras());
        let seen = seen(&camera, &bounds);
        let (handle, place) = handles(&with_box(), &bounds)[4];
        let to = |z: f64| [pixel(&camera, place), pixel(&camera, DVec3::new(0.0, 0.0, z))];
        let low = |pixels| drag(&with_box(), handle, seen, pixels).clip_box.unwrap()[4];
        assert_eq!(low(to(-44.0)), -30.0);
        assert_eq!(low(to(44.0)), 30.0 - 60.0 * LEAST_WIDTH);
    }

    #[test]
    fn the_end_of_a_normal_goes_where_it_is_dragged() {
        let bounds = bounds();
        for camera in &cameras() {
            let seen = seen(camera, &bounds);
            // Towards the camera, and away from it.
            for start in [DVec3::new(0.4, -1.0, 0.3), DVec3::new(-0.4, 1.0, -0.3)] {
                let cut = with_plane(DVec3::ONE, start);
                let wanted = (start + DVec3::new(0.2, 0.1, 0.3)).normalize();
                let end = DVec3::ONE + normal_length(&bounds) * wanted;
                let pixels = [DVec2::ZERO, pixel(camera, end)];
                let plane = drag(&cut, Handle::Normal(0), seen, pixels).clip_plane.unwrap()[0];
                assert!(
                    plane.normal().distance(wanted) < 1e-9,
                    "{:?} {wanted}",
                    plane.normal()
                );
                assert_eq!(plane.point(), DVec3::ONE);
            }
        }
    }

    #[test]
    fn a_line_along_the_ray_moves_by_up_and_down() {
        let bounds = bounds();
        let projection = Projection::Orthographic { height: 90.0 };
        let camera = Camera::new(DVec3::new(0.0, -100.0, 0.0), DVec3::ZERO, DVec3::Z, projection).unwrap();
        let seen = seen(&camera, &bounds);
        let cut = with_plane(DVec3::ZERO, DVec3::Y);
        let pixels = [DVec2::new(200.0, 150.0), DVec2::new(230.0, 120.0)];
        let plane = drag(&cut, Handle::Depth(0), seen, pixels).clip_plane.unwrap()[0];
        assert!((plane.point().y - 9.0).abs() < 1e-9, "{:?}", plane.point());
    }

    #[test]
    fn a_plane_cuts_the_box_in_a_polygon_that_goes_round() {
        let bounds = bounds();
        let plane = ClipPlane::new(DVec3::new(0.0, 0.0, 7.0), DVec3::Z).unwrap();
        let points = outline(&plane, &bounds);
        assert_eq!(points.len(), 4);
        for (index, point) in points.iter().enumerate() {
            let way = points[(index + 1) % 4] - point;
            // Sides of the rectangle, no diagonals.
            assert!(way.x == 0.0 || way.y == 0.0);
            assert!((point.z - 7.0).abs() < 1e-12);
        }
        let corner = ClipPlane::new(DVec3::ZERO, DVec3::new(3.0, 2.0, 1.0)).unwrap();
        assert!(outline(&corner, &bounds).len() >= 3);
        let beyond = ClipPlane::new(DVec3::new(0.0, 0.0, 99.0), DVec3::Z).unwrap();
        assert!(outline(&beyond, &bounds).is_empty());
        assert_eq!(edges(&bounds.min, &bounds.max).count(), 12);
    }
}
