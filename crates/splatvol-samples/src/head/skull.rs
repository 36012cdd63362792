//! The skull without the jaw, and the upper neck's vertebrae; coordinates as in [`super::skin`].

use super::solid::{Part, Solid, cone, ellipsoid, rounded_box, tube, wall};

/// Bone, before the brain's cavity is taken out of it.
pub(super) fn skull() -> Solid {
    Solid::new(
        vault()
            .into_iter()
            .chain(base())
            .chain(face())
            .chain(openings())
            .chain(nasal())
            .chain(spine()),
    )
}

/// The brain's cavity, down to the spinal canal.
pub(super) fn cranial_cavity() -> Solid {
    Solid::new([
        ellipsoid([0.0, -22.0, 55.0], [67.5, 66.0, 58.0]),
        ellipsoid([0.0, 25.0, 53.0], [54.0, 56.0, 51.0]).blend(20.0),
        ellipsoid([36.0, 20.0, 14.0], [22.0, 32.0, 20.0])
            .mirrored()
            .blend(12.0),
        ellipsoid([0.0, -46.0, 4.0], [47.0, 35.0, 30.0]).blend(12.0),
        cone([0.0, -20.0, 0.0], [0.0, -29.0, -45.0], [15.0, 9.5]).blend(8.0),
        cone([0.0, -29.0, -45.0], [0.0, -40.0, -150.0], [9.0, 8.0]).blend(4.0),
    ])
}

fn vault() -> Vec<Part> {
    vec![
        ellipsoid([0.0, -22.0, 55.0], [74.0, 72.5, 64.5]),
        ellipsoid([0.0, 25.0, 52.0], [60.5, 63.0, 58.0]).blend(20.0),
        ellipsoid([40.0, 18.0, 14.0], [25.0, 36.0, 25.0])
            .mirrored()
            .blend(10.0),
        ellipsoid([0.0, -46.0, 3.0], [54.0, 41.0, 36.0]).blend(12.0),
        // Nuchal ridge and its protuberance.
        ellipsoid([0.0, -83.0, 4.0], [14.0, 8.0, 7.0]).blend(8.0),
        // Temporal lines, and the fossa below them.
        ellipsoid([66.0, 50.0, 24.0], [16.0, 24.0, 24.0])
            .mirrored()
            .cut(14.0),
    ]
}

fn base() -> Vec<Part> {
    vec![
        ellipsoid([0.0, 12.0, -6.0], [17.0, 30.0, 12.0]).blend(8.0),
        ellipsoid([34.0, -6.0, 3.0], [28.0, 11.0, 9.0])
            .mirrored()
            .blend(6.0),
        // Mastoid and styloid processes, occipital condyles.
        cone([52.0, -17.0, 0.0], [50.0, -11.0, -24.0], [13.0, 6.5])
            .mirrored()
            .blend(8.0),
        cone([40.0, -4.0, -8.0], [36.0, 6.0, -36.0], [2.6, 1.2])
            .mirrored()
            .blend(3.0),
        ellipsoid([17.0, -14.0, -27.0], [7.0, 11.0, 6.0])
            .mirrored()
            .blend(4.0),
        // Pterygoid plates.
        rounded_box([11.0, 33.0, -20.0], [1.8, 7.0, 15.0], 1.6)
            .mirrored()
            .blend(4.0),
        rounded_box([18.0, 33.0, -18.0], [1.6, 8.0, 15.0], 1.5)
            .turned([0.0, 0.0, -24.0])
            .mirrored()
            .blend(4.0),
    ]
}

fn face() -> Vec<Part> {
    let arch = [
        ([52.0, 63.0, -4.0], 4.6),
        ([60.0, 47.0, -3.0], 3.4),
        ([64.5, 28.0, -1.0], 3.0),
        ([62.0, 10.0, 3.0], 4.0),
        ([54.0, -4.0, 4.0], 6.0),
    ];
    let lateral_rim = [
        ([30.0, 83.0, 38.0], 3.5),
        ([43.0, 76.5, 34.0], 4.2),
        ([50.0, 70.0, 22.0], 4.2),
        ([49.5, 70.0, 8.0], 5.0),
        ([46.0, 71.0, -4.0], 8.0),
    ];
    let lower_rim = [
        ([46.0, 72.0, -2.0], 6.0),
        ([33.0, 79.0, -4.5], 5.0),
        ([20.0, 82.5, -1.0], 4.5),
        ([13.0, 86.0, 8.0], 4.0),
        ([11.0, 87.0, 22.0], 4.5),
    ];
    let alveolar = [
        [0.0, 91.5],
        [11.0, 88.5],
        [18.5, 81.0],
        [24.0, 68.0],
        [27.5, 46.0],
    ];
    let mut parts = vec![
        // Brow ridges and glabella, sphenoid wings, ethmoid block.
        cone([7.0, 86.0, 35.0], [32.0, 80.5, 41.0], [7.0, 4.5])
            .mirrored_softly()
            .blend(10.0),
        ellipsoid([0.0, 84.0, 33.0], [12.0, 8.0, 9.0]).blend(8.0),
        ellipsoid([38.0, 52.0, 16.0], [9.0, 20.0, 18.0])
            .mirrored()
            .blend(6.0),
        ellipsoid([0.0, 56.0, 8.0], [17.0, 34.0, 22.0]).blend(6.0),
        // Maxilla, cheek bone.
        ellipsoid([22.0, 66.0, -14.0], [18.0, 20.0, 18.0])
            .mirrored()
            .blend(6.0),
        cone([10.0, 86.0, 20.0], [15.0, 83.0, -16.0], [4.5, 6.5])
            .mirrored()
            .blend(5.0),
        ellipsoid([42.0, 71.0, -9.0], [14.0, 8.0, 9.5])
            .turned([0.0, 18.0, -38.0])
            .mirrored()
            .blend(5.0),
        cone([44.0, 68.0, -12.0], [30.0, 66.0, -26.0], [6.0, 6.0])
            .mirrored()
            .blend(6.0),
        // Palate.
        rounded_box([0.0, 67.0, -25.0], [23.0, 25.0, 2.6], 2.0).blend(4.0),
    ];
    parts.extend(tube(&arch, 1.0).map(Part::mirrored));
    parts.extend(tube(&lateral_rim, 8.0).map(Part::mirrored));
    parts.extend(tube(&lower_rim, 4.0).map(Part::mirrored));
    parts.extend(alveolar.windows(2).map(|pair| {
        let at = |[x, y]: [f32; 2]| [x, y, -27.5];
        wall(at(pair[0]), at(pair[1]), [5.0, 5.0], 5.6)
            .mirrored()
            .blend(5.0)
    }));
    parts
}

/// Orbits, nose, sinuses and ear canals.
fn openings() -> Vec<Part> {
    vec![
        cone([31.0, 92.0, 17.0], [16.0, 42.0, 18.0], [18.0, 4.0])
            .mirrored()
            .cut(3.0),
        ellipsoid([33.0, 84.0, 16.5], [18.5, 21.0, 16.0])
            .turned([0.0, 8.0, -14.0])
            .mirrored()
            .cut(3.0),
        ellipsoid([0.0, 86.0, -9.0], [11.0, 22.0, 16.0]).cut(3.0),
        ellipsoid([5.0, 88.0, -15.0], [8.5, 22.0, 8.5])
            .mirrored()
            .cut(3.0),
        ellipsoid([0.0, 60.0, -4.0], [13.5, 36.0, 20.0]).cut(2.0),
        // Infraorbital and mental foramina are too small for a millimetre; the sinuses and canals are not.
        ellipsoid([26.0, 65.0, -13.0], [12.5, 15.0, 13.0])
            .mirrored()
            .cut(2.0),
        ellipsoid([9.0, 82.0, 40.0], [8.0, 4.0, 9.0]).mirrored().cut(2.0),
        ellipsoid([6.5, 24.0, 3.0], [6.0, 11.0, 8.0]).mirrored().cut(2.0),
        cone([80.0, -3.0, 1.0], [28.0, 2.0, 1.0], [3.6, 3.0])
            .mirrored()
            .cut(1.5),
        ellipsoid([50.0, -14.0, -10.0], [5.0, 4.0, 8.0])
            .mirrored()
            .cut(2.0),
    ]
}

/// Structures inside the opened nose: nasal bones, spine, septum and conchae.
fn nasal() -> Vec<Part> {
    vec![
        cone([0.0, 86.0, 28.0], [0.0, 98.5, 8.0], [4.0, 2.4]).blend(6.0),
        cone([4.0, 86.0, 26.0], [4.5, 94.0, 6.5], [3.6, 2.0])
            .mirrored_softly()
            .blend(5.0),
        cone([0.0, 88.0, -23.0], [0.0, 97.0, -21.5], [3.0, 1.6]).blend(3.0),
        rounded_box([0.0, 64.0, -4.0], [0.9, 25.0, 19.0], 0.8).blend(2.0),
        cone([9.0, 74.0, -15.0], [8.0, 45.0, -13.0], [1.6, 2.2])
            .mirrored()
            .blend(1.5),
        cone([9.0, 70.0, -2.0], [8.0, 45.0, -1.0], [1.6, 2.0])
            .mirrored()
            .blend(1.5),
    ]
}

fn spine() -> Vec<Part> {
    let mut parts = atlas();
    // Dens of the axis.
    parts.push(cone([0.0, -8.0, -62.0], [0.0, -7.0, -36.0], [7.0, 5.0]).blend(3.0));
    for level in 0..5u8 {
        let down = f32::from(level);
        let (y, z) = (-9.0 - 2.0 * down, -64.0 - 17.5 * down);
        let canal = y - 21.0;
        let spread = if level == 0 { 1.3 } else { 1.0 };
        parts.extend([
            rounded_box([0.0, y, z], [10.0, 8.5, 6.6], 3.0).blend(2.0),
            ellipsoid([17.0, y - 10.0, z], [6.5, 7.0, 7.0])
                .mirrored()
                .blend(3.0),
            cone([10.0, y - 2.0, z], [25.0, y - 7.0, z - 3.0], [4.0, 3.2])
                .mirrored()
                .blend(3.0),
            wall(
                [17.0, y - 12.0, z - 1.0],
                [4.0, canal - 9.0, z - 3.0],
                [3.5, 3.0],
                2.6,
            )
            .mirrored()
            .blend(3.0),
            cone(
                [0.0, canal - 8.0, z - 3.0],
                [0.0, canal - 22.0, z - 9.0],
                [4.4 * spread, 3.2 * spread],
            )
            .blend(3.0),
        ]);
    }
    parts
}

fn atlas() -> Vec<Part> {
    let ring = [
        ([0.0, -1.0, -43.0], 4.0),
        ([12.0, -6.0, -43.0], 4.0),
        ([21.0, -17.0, -43.0], 6.0),
        ([18.0, -32.0, -44.0], 3.4),
        ([0.0, -42.0, -44.0], 4.0),
    ];
    let mut parts: Vec<_> = tube(&ring, 3.0).map(Part::mirrored).collect();
    parts.push(
        ellipsoid([19.0, -15.0, -43.0], [8.5, 10.0, 8.0])
            .mirrored()
            .blend(3.0),
    );
    parts.push(
        cone([24.0, -17.0, -43.0], [37.0, -20.0, -44.0], [5.0, 4.0])
            .mirrored()
            .blend(3.0),
    );
    parts
}
