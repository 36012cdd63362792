//! Which way a scan is up, where its file does not say.
//!
//! A thing stands where the points of its lowest three percent enclose its centre, seen from above. PLY files have no
//! frame: z is up unless the points stand on y and not on z. What neither stands nor lies stays as it is.

/// Share of the height that counts as the bottom.
const BOTTOM: f32 = 0.03;
/// Share of the footprint's box that a base has at least.
const BASE: f32 = 0.1;

/// Whether points stand with y up, but not with z up.
pub(super) fn is_y_up(positions: &[[f32; 3]]) -> bool {
    stands(positions, 1) && !stands(positions, 2)
}

/// Whether points stand with this axis up.
fn stands(positions: &[[f32; 3]], up: usize) -> bool {
    let across = [(up + 1) % 3, (up + 2) % 3];
    let (low, high) = bounds(positions.iter());
    let height = high[up] - low[up];
    let bottom = positions.iter().filter(|p| p[up] - low[up] <= BOTTOM * height);
    let (base_low, base_high) = bounds(bottom);
    let centre = across.map(|axis| {
        let sum: f64 = positions.iter().map(|p| f64::from(p[axis])).sum();
        (sum / positions.len() as f64) as f32
    });
    let encloses = across
        .iter()
        .zip(centre)
        .all(|(&axis, centre)| (base_low[axis]..=base_high[axis]).contains(&centre));
    let area = |low: [f32; 3], high: [f32; 3]| across.iter().map(|&a| high[a] - low[a]).product::<f32>();
    height > 0.0 && encloses && area(base_low, base_high) >= BASE * area(low, high)
}

fn bounds<'a>(positions: impl Iterator<Item = &'a [f32; 3]>) -> ([f32; 3], [f32; 3]) {
    positions.fold(([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]), |(low, high), p| {
        (
            std::array::from_fn(|a| low[a].min(p[a])),
            std::array::from_fn(|a| high[a].max(p[a])),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points within a pyramid, `up` being the axis along its height.
    fn pyramid(up: usize) -> Vec<[f32; 3]> {
        let mut points = Vec::new();
        for step in 0..20 {
            let height = 0.05 * step as f32;
            for side in 0..100 {
                let [x, y] = [side % 10, side / 10].map(|i| (i as f32 / 4.5 - 1.0) * (1.0 - height));
                let mut point = [0.0; 3];
                point[up] = height;
                point[(up + 1) % 3] = x;
                point[(up + 2) % 3] = y;
                points.push(point);
            }
        }
        points
    }

    #[test]
    fn a_pyramid_stands_on_its_base() {
        assert!(is_y_up(&pyramid(1)));
        assert!(!is_y_up(&pyramid(2)));
        assert!(!is_y_up(&pyramid(0)));
    }

    #[test]
    fn what_stands_either_way_stays_as_it_is() {
        let cube: Vec<[f32; 3]> = (0..1000)
            .map(|i| [i % 10, i / 10 % 10, i / 100].map(|at| at as f32))
            .collect();
        assert!(!is_y_up(&cube));
        assert!(!is_y_up(&[[1.0; 3]]));
    }
}
