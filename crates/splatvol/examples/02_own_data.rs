//! Teaches: samples of your own become a volume, and a transfer function gives them colours and opacities.
//!
//! `cargo run --release --example 02_own_data [orbital.png]`
//!
//! The samples are the density of an electron in the 3d orbital of hydrogen, m = 0:
//! `|psi|^2 ~ r^4 exp(-2 r / 3) (3 cos^2 theta - 1)^2`, lengths in Bohr radii.

use splatvol::{
    Camera, ColorMap, EngineConfig, Grid, ImageSize, LengthUnit, OpacityPoint, Projection, RenderSettings,
    Renderer, Rescale, Samples, Scene, TransferFunction, View, Volume, io,
};

/// Samples along each axis.
const SIDE: usize = 72;
/// Half the side of the cube that is sampled, Bohr radii.
const REACH: f32 = 19.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let output = std::env::args()
        .nth(1)
        .unwrap_or_else(|| "orbital.png".to_owned());

    let volume = orbital()?;
    let [_, densest] = volume.value_range();

    // Colours by a map over the values. Opacity is that of a length of one Bohr radius: a faint outer surface, then
    // nothing for a while, so that the dense inside shows through.
    let colors = ColorMap::from_name("plasma")?.points([0.0, densest], 32);
    let opacities = [
        (0.00, 0.0),
        (0.04, 0.0),
        (0.06, 0.12),
        (0.09, 0.0),
        (0.25, 0.02),
        (0.60, 0.5),
    ];
    let opacities = opacities.map(|(share, opacity)| OpacityPoint::new(share * densest, opacity));
    let one_bohr_radius = Some(1.0);
    let transfer_function = TransferFunction::new(colors, opacities.to_vec(), one_bohr_radius)?;

    let scene = Scene::new(volume, transfer_function);
    let settings = RenderSettings::default().with_size(ImageSize::new(480, 480)?);
    let aspect = settings.size.aspect();
    let camera = Camera::framing(&scene.bounds()?, View::Iso, Projection::default(), aspect)?;
    let frame = Renderer::new(EngineConfig::default())?.render(&scene, &camera, &settings)?;

    // Pixels are transparent where there is nothing; this puts black behind them.
    let mut frame = frame;
    frame.image = frame.image.over([0.0, 0.0, 0.0, 1.0]);
    io::write_frame(
        &output,
        &frame,
        &[("Title".to_owned(), "3d orbital, m = 0".to_owned())],
    )?;
    println!("wrote {output}");
    Ok(())
}

/// The density on a cube, x fastest.
fn orbital() -> Result<Volume, splatvol::SceneError> {
    let spacing = 2.0 * REACH / (SIDE - 1) as f32;
    let at = |index: usize| index as f32 * spacing - REACH;
    let samples: Vec<f32> = (0..SIDE * SIDE * SIDE)
        .map(|i| density([i % SIDE, i / SIDE % SIDE, i / (SIDE * SIDE)].map(at)))
        .collect();
    let grid = Grid::centred([SIDE; 3], [f64::from(spacing); 3])?;
    Volume::new(
        grid,
        Samples::F32(samples.into()),
        Rescale::default(),
        LengthUnit::Unknown,
    )
}

fn density([x, y, z]: [f32; 3]) -> f32 {
    let r2 = x * x + y * y + z * z;
    // r^4 (3 cos^2 - 1)^2 = (3 z^2 - r^2)^2
    (3.0 * z * z - r2).powi(2) * (-2.0 / 3.0 * r2.sqrt()).exp()
}
