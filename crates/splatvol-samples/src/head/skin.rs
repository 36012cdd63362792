//! The skin's surface: cranium, face, nose, lips, ears and neck.
//!
//! Millimetres from the midpoint between the ear canals, in the Frankfurt plane (ear canals and lower orbital rims
//! at z = 0): x to the right, y forward, z up. Proportions follow adult anthropometric means: head length 190,
//! breadth 150, ear canal to vertex 125, vertex to chin 217.

use super::solid::{Part, Solid, cone, ellipsoid, tube};

pub(super) fn skin() -> Solid {
    Solid::new(
        cranium()
            .into_iter()
            .chain(neck())
            .chain(face())
            .chain(eyes())
            .chain(nose())
            .chain(mouth())
            .chain(ear()),
    )
}

fn cranium() -> Vec<Part> {
    vec![
        ellipsoid([0.0, -22.0, 55.0], [79.0, 78.0, 69.0]),
        ellipsoid([0.0, 25.0, 50.0], [67.0, 69.0, 64.0]).blend(24.0),
        ellipsoid([0.0, -45.0, 0.0], [58.0, 47.0, 42.0]).blend(20.0),
    ]
}

fn neck() -> Vec<Part> {
    vec![
        cone([0.0, -20.0, -30.0], [0.0, -34.0, -140.0], [46.0, 51.0]).blend(24.0),
        cone([0.0, -34.0, -20.0], [0.0, -50.0, -140.0], [42.0, 50.0]).blend(16.0),
        // Sternocleidomastoid muscles, larynx, and the floor of the mouth.
        cone([56.0, -14.0, -22.0], [26.0, 14.0, -140.0], [10.0, 12.0])
            .mirrored_softly()
            .blend(14.0),
        cone([0.0, 34.0, -96.0], [0.0, 20.0, -140.0], [13.0, 16.0]).blend(18.0),
        ellipsoid([0.0, 36.0, -103.0], [8.0, 11.0, 11.0]).blend(10.0),
        cone([0.0, 66.0, -72.0], [0.0, 16.0, -92.0], [20.0, 30.0]).blend(16.0),
    ]
}

fn face() -> Vec<Part> {
    vec![
        ellipsoid([0.0, 40.0, -8.0], [60.0, 52.0, 58.0]).blend(20.0),
        ellipsoid([0.0, 62.0, 6.0], [46.0, 30.0, 34.0]).blend(14.0),
        // Cheek bones, cheeks, jaw angles, muzzle and chin.
        ellipsoid([46.0, 66.0, -6.0], [18.0, 18.0, 15.0])
            .mirrored_softly()
            .blend(14.0),
        ellipsoid([30.0, 66.0, -34.0], [21.0, 24.0, 26.0])
            .mirrored_softly()
            .blend(18.0),
        ellipsoid([42.0, 18.0, -44.0], [16.0, 28.0, 29.0])
            .mirrored_softly()
            .blend(18.0),
        cone([44.0, 20.0, -58.0], [29.0, 58.0, -71.0], [13.5, 12.0])
            .mirrored_softly()
            .blend(14.0),
        cone([29.0, 58.0, -71.0], [13.0, 80.0, -77.0], [12.0, 12.5])
            .mirrored_softly()
            .blend(10.0),
        // Over the cheek bones' arches and the orbits' outer rims.
        cone([50.0, 62.0, -4.0], [63.0, 30.0, -1.0], [9.0, 8.0])
            .mirrored_softly()
            .blend(12.0),
        cone([63.0, 30.0, -1.0], [62.0, -4.0, 2.0], [8.0, 11.0])
            .mirrored_softly()
            .blend(12.0),
        cone([42.0, 74.0, 34.0], [48.0, 67.0, 20.0], [8.0, 8.0])
            .mirrored_softly()
            .blend(10.0),
        cone([48.0, 67.0, 20.0], [46.0, 68.0, 0.0], [8.0, 9.0])
            .mirrored_softly()
            .blend(10.0),
        ellipsoid([0.0, 76.0, -44.0], [30.0, 25.0, 28.0]).blend(16.0),
        ellipsoid([0.0, 85.0, -77.0], [18.0, 14.0, 14.0]).blend(12.0),
        ellipsoid([8.0, 91.0, -77.0], [9.0, 7.0, 9.0])
            .mirrored_softly()
            .blend(10.0),
        // The cheeks between arch and jaw.
        ellipsoid([39.0, 44.0, -28.0], [18.0, 30.0, 28.0])
            .mirrored_softly()
            .blend(16.0),
        // Brows, and the temples' hollows.
        cone([8.0, 88.0, 33.0], [38.0, 78.0, 36.0], [8.5, 7.5])
            .mirrored_softly()
            .blend(10.0),
        ellipsoid([75.0, 50.0, 36.0], [14.0, 26.0, 20.0])
            .mirrored_softly()
            .cut(20.0),
    ]
}

fn eyes() -> Vec<Part> {
    vec![
        ellipsoid([30.0, 96.0, 17.0], [16.0, 13.5, 10.5])
            .mirrored_softly()
            .cut(11.0),
        ellipsoid([17.0, 98.0, 12.0], [6.0, 10.0, 12.0])
            .mirrored_softly()
            .cut(9.0),
        // Closed lids over the globe, the slit between them, and the fold above.
        ellipsoid([31.5, 75.5, 16.0], [15.5, 13.5, 13.2])
            .mirrored_softly()
            .blend(4.0),
        cone([19.0, 88.0, 13.0], [31.0, 90.6, 11.2], [0.6, 0.9])
            .mirrored_softly()
            .cut(2.4),
        cone([31.0, 90.6, 11.2], [44.0, 84.0, 13.0], [0.9, 0.6])
            .mirrored_softly()
            .cut(2.4),
        cone([20.0, 87.5, 19.0], [31.0, 88.8, 22.5], [0.5, 0.7])
            .mirrored_softly()
            .cut(3.0),
        cone([31.0, 88.8, 22.5], [44.0, 82.5, 20.0], [0.7, 0.5])
            .mirrored_softly()
            .cut(3.0),
    ]
}

fn nose() -> Vec<Part> {
    vec![
        // Bridge, side walls, tip, wings, columella.
        cone([0.0, 89.0, 26.0], [0.0, 99.0, 8.0], [6.0, 5.5]).blend(9.0),
        cone([0.0, 98.0, 10.0], [0.0, 110.5, -8.0], [5.5, 7.0]).blend(6.0),
        cone([5.0, 90.0, 16.0], [9.0, 98.0, -12.0], [5.0, 7.5])
            .mirrored_softly()
            .blend(8.0),
        ellipsoid([0.0, 110.5, -11.0], [9.5, 9.5, 7.5]).blend(7.0),
        ellipsoid([3.6, 114.5, -11.0], [4.5, 4.5, 4.5])
            .mirrored_softly()
            .blend(5.0),
        ellipsoid([11.0, 102.0, -15.0], [6.5, 9.5, 6.8])
            .mirrored_softly()
            .blend(6.0),
        cone([0.0, 112.0, -16.0], [0.0, 98.0, -22.0], [3.8, 4.0]).blend(4.0),
        // Groove behind the wings, nostrils.
        cone([18.5, 98.0, -10.0], [19.0, 96.0, -19.0], [0.4, 0.6])
            .mirrored_softly()
            .cut(5.0),
        cone([6.4, 107.0, -25.0], [6.6, 103.0, -17.0], [2.8, 3.2])
            .mirrored_softly()
            .cut(2.0),
        cone([6.6, 103.0, -17.0], [6.4, 92.0, -14.0], [3.2, 3.6])
            .mirrored_softly()
            .cut(2.0),
    ]
}

fn mouth() -> Vec<Part> {
    let upper = [
        ([0.0, 101.2, -37.8], 3.8),
        ([5.0, 101.3, -37.0], 4.2),
        ([14.0, 97.0, -39.2], 3.8),
        ([28.0, 83.0, -43.0], 2.0),
    ];
    let lower = [
        ([0.0, 99.6, -47.6], 5.0),
        ([10.0, 98.2, -47.2], 4.8),
        ([28.0, 83.0, -43.6], 2.0),
    ];
    let slit = [
        ([0.0, 105.0, -42.2], 0.3),
        ([10.0, 102.4, -41.9], 0.3),
        ([27.0, 90.0, -43.0], 0.5),
    ];
    tube(&upper, 5.0)
        .chain(tube(&lower, 5.0))
        .map(Part::mirrored_softly)
        .chain(tube(&slit, 1.0).map(|part| part.mirrored_softly().cut(2.6)))
        .chain([
            // Philtrum and its ridges, and the fold over the chin.
            cone([3.2, 99.0, -26.0], [4.6, 101.4, -34.0], [1.0, 1.6])
                .mirrored_softly()
                .blend(4.0),
            cone([0.0, 104.4, -27.0], [0.0, 105.6, -33.0], [0.3, 0.6]).cut(4.0),
            cone([0.0, 100.5, -59.0], [13.0, 95.0, -59.0], [3.5, 2.5])
                .mirrored_softly()
                .cut(10.0),
        ])
        .collect()
}

/// The auricle: a plate leaning back and standing off the head, hollowed, with a rim, an inner rim, and a lobe.
fn ear() -> Vec<Part> {
    const LEAN: f32 = -12.0;
    const FLARE: f32 = 22.0;
    // The plate's own frame: u outwards, v along the ear's breadth, w along its height.
    let place = |u: f32, v: f32, w: f32| -> [f32; 3] {
        let (sin_flare, cos_flare) = libm::sincosf(FLARE.to_radians());
        let (sin_lean, cos_lean) = libm::sincosf((-LEAN).to_radians());
        let (y, z) = (v * cos_lean - w * sin_lean, v * sin_lean + w * cos_lean);
        [
            77.0 + u * cos_flare - y * sin_flare,
            -12.0 + u * sin_flare + y * cos_flare,
            5.0 + z,
        ]
    };
    let rim = |half_breadth: f32, half_height: f32, radius: f32, degrees: [f32; 2], out: f32| {
        let count = 18;
        let points: Vec<_> = (0..=count)
            .map(|i| {
                let t = i as f32 / count as f32;
                let angle = (degrees[0] + t * (degrees[1] - degrees[0])).to_radians();
                let taper = radius * (0.7 + 0.6 * t * (1.0 - t));
                (
                    place(
                        out,
                        half_breadth * libm::cosf(angle),
                        half_height * libm::sinf(angle),
                    ),
                    taper,
                )
            })
            .collect();
        tube(&points, 0.6).collect::<Vec<_>>()
    };
    let turned = |part: Part| part.turned([-LEAN, 0.0, FLARE]);
    let plate = turned(ellipsoid(place(-1.0, 0.0, 1.0), [3.4, 16.0, 28.0])).blend(5.0);
    let scapha = turned(ellipsoid(place(4.4, -1.0, 6.0), [3.8, 11.0, 20.0])).cut(3.0);
    let concha = turned(ellipsoid(place(3.0, 4.0, -4.0), [7.0, 9.0, 12.0])).cut(3.0);
    let lobe = ellipsoid(place(0.5, 5.0, -25.0), [3.8, 7.5, 8.0]).blend(4.0);
    let tragus = ellipsoid(place(1.0, 13.0, -4.0), [3.0, 3.5, 6.0]).blend(3.0);
    let antitragus = ellipsoid(place(1.5, 3.0, -16.0), [2.6, 5.0, 3.2]).blend(3.0);
    let canal = cone(place(2.0, 9.0, -4.0), [30.0, 2.0, 0.0], [3.6, 3.0]).cut(2.0);
    let mut parts = vec![plate, scapha];
    parts.extend(rim(7.6, 15.0, 2.4, [50.0, 235.0], 0.2));
    parts.extend([concha, lobe, tragus, antitragus]);
    parts.extend(rim(13.6, 26.5, 2.9, [-10.0, 232.0], 1.0));
    parts.push(canal);
    parts.into_iter().map(Part::mirrored).collect()
}
