//! The mandible, the hyoid and the teeth; coordinates as in [`super::skin`].

use super::solid::{Part, Solid, cone, ellipsoid, rounded_box, tube, wall};

pub(super) fn mandible() -> Solid {
    // Along the body, from the chin to the angle: x, y, z of the middle, half height; a thin upper part that holds
    // the teeth, and a thick lower border.
    let body = [
        ([0.0, 86.5, -66.0], 8.0),
        ([7.0, 85.6, -66.0], 8.0),
        ([14.0, 82.5, -66.0], 8.0),
        ([20.0, 76.0, -66.0], 8.0),
        ([27.0, 63.0, -65.0], 8.0),
        ([35.0, 47.0, -63.0], 8.0),
        ([44.0, 28.0, -57.0], 9.0),
        ([47.5, 17.0, -50.0], 9.0),
    ];
    let border = [
        ([0.0, 86.0, -81.0], 5.6),
        ([9.0, 85.0, -81.5], 5.8),
        ([18.0, 79.0, -81.0], 5.6),
        ([27.0, 64.0, -79.0], 5.4),
        ([36.0, 46.0, -75.5], 5.2),
        ([45.0, 27.0, -69.5], 5.0),
        ([48.5, 13.0, -61.0], 4.6),
    ];
    let body = body
        .windows(2)
        .map(|pair| {
            let ((a, from), (b, to)) = (pair[0], pair[1]);
            wall(a, b, [from, to], 5.0).mirrored().blend(1.0)
        })
        .chain(tube(&border, 7.0).map(Part::mirrored));
    let hyoid = [
        ([0.0, 48.0, -92.0], 3.4),
        ([13.0, 42.0, -91.0], 2.6),
        ([21.0, 22.0, -87.0], 2.0),
    ];
    Solid::new(
        body.chain([
            // Chin, ramus, its angle, coronoid and condylar processes, and the notch between them.
            ellipsoid([0.0, 88.5, -78.5], [10.0, 5.5, 8.0]).blend(8.0),
            ellipsoid([11.0, 86.0, -81.0], [7.0, 5.5, 5.0])
                .mirrored()
                .blend(6.0),
            rounded_box([49.5, 17.0, -38.0], [3.6, 14.5, 24.0], 3.2)
                .turned([9.0, 0.0, 4.0])
                .mirrored()
                .blend(6.0),
            ellipsoid([48.5, 9.0, -60.0], [4.6, 11.0, 9.0])
                .mirrored()
                .blend(6.0),
            cone([50.0, 27.0, -28.0], [51.0, 30.0, -7.0], [4.2, 2.0])
                .mirrored()
                .blend(4.0),
            cone([50.0, 10.0, -24.0], [51.0, 8.0, -9.0], [4.6, 3.6])
                .mirrored()
                .blend(4.0),
            ellipsoid([51.0, 8.5, -7.0], [9.0, 4.8, 4.4])
                .mirrored()
                .blend(3.0),
            ellipsoid([50.0, 19.0, -12.0], [12.0, 6.5, 8.0])
                .mirrored()
                .cut(4.0),
        ])
        .chain(tube(&hyoid, 2.0).map(Part::mirrored)),
    )
}

/// A tooth's place on its arch: x, y, breadth along the arch, depth across it, crown height.
type Place = [f32; 5];

const UPPER: [Place; 7] = [
    [4.4, 94.5, 8.4, 6.5, 10.5],
    [11.8, 92.0, 6.6, 6.0, 9.2],
    [18.0, 86.5, 7.4, 7.6, 10.2],
    [22.0, 79.8, 7.0, 9.0, 8.4],
    [24.4, 73.0, 6.8, 9.0, 8.0],
    [26.4, 64.2, 10.2, 10.8, 7.6],
    [28.0, 54.0, 9.6, 10.6, 7.2],
];
const LOWER: [Place; 7] = [
    [2.7, 91.0, 5.2, 5.6, 9.0],
    [8.0, 89.6, 5.7, 6.0, 9.2],
    [13.8, 86.0, 6.7, 7.4, 10.2],
    [18.6, 80.2, 6.9, 7.6, 8.6],
    [22.0, 73.6, 7.0, 8.2, 8.2],
    [25.4, 65.0, 11.0, 10.2, 7.8],
    [29.0, 54.6, 10.4, 10.0, 7.4],
];

pub(super) fn teeth() -> Solid {
    Solid::new(
        row(&UPPER, -43.6, 1.0)
            .into_iter()
            .chain(row(&LOWER, -42.4, -1.0)),
    )
}

/// One row of teeth; `up` is the direction of the roots, `edge` the height of the incisal edges.
fn row(places: &[Place; 7], edge: f32, up: f32) -> Vec<Part> {
    let mut parts = Vec::new();
    for (i, &[x, y, breadth, depth, height]) in places.iter().enumerate() {
        let (before, after) = (places[i.saturating_sub(1)], places[(i + 1).min(6)]);
        let along = libm::atan2f(after[1] - before[1], after[0] - before[0]).to_degrees();
        // Molars stop where they meet; incisors overlap.
        let edge = if i < 3 { edge } else { -43.0 + 0.3 * up };
        let middle = edge + up * 0.5 * height;
        let front = i < 3;
        let taper = if front { 0.62 } else { 0.8 };
        parts.extend([
            rounded_box(
                [x, y, middle],
                [
                    0.5 * breadth - 0.25,
                    0.5 * depth * if front { 0.62 } else { 0.94 },
                    0.5 * height,
                ],
                1.5,
            )
            .turned([0.0, 0.0, along])
            .mirrored()
            .blend(0.4),
            cone(
                [x * 0.97, y - 1.5, edge + up * height * 0.7],
                [x * 0.90, y - 5.0, edge + up * (height + 10.0)],
                [0.5 * breadth.min(depth) * taper, 1.4],
            )
            .mirrored()
            .blend(1.6),
        ]);
    }
    parts
}
