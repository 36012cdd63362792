//! Layouts: offsets of data in Rust are those in WGSL, and every shader is valid.

use std::mem::offset_of;

use naga::TypeInner;
use naga::valid::{Capabilities, ValidationFlags, Validator};

use crate::atlas::{ASSEMBLE, AssemblyData};
use crate::clouds::{CloudData, KernelData, PartData, ProfileData, SPLAT_BYTES, TilesData};
use crate::footprints::{FOOTPRINT_BYTES, ViewData, pairs_shader};
use crate::gaussians::{PictureData, shaders};
use crate::layout::{FrameData, SheetData, TILE};
use crate::mode::{CloudMode, Kept, Mode, classify_shader, cloud_shaders, integral_shaders, mixture_shader};
use crate::operators::{self, Operators};
use crate::pipelines::{CLEAR, cull_shader};
use crate::sort::{DigitData, ListsData, RADIX, SCAN, ScanData};

/// Members of a struct in WGSL, with their offsets, and its size.
fn members(module: &naga::Module, name: &str) -> (Vec<(String, u32)>, u32) {
    let found = module
        .types
        .iter()
        .find(|(_, own)| own.name.as_deref() == Some(name));
    let (_, own) = found.unwrap();
    let TypeInner::Struct { members, span } = &own.inner else {
        unreachable!("a struct")
    };
    let offsets = members
        .iter()
        .map(|member| (member.name.clone().unwrap(), member.offset))
        .collect();
    (offsets, *span)
}

macro_rules! offsets {
    ($type:ty: $($field:ident)*) => {
        vec![$((stringify!($field).to_owned(), offset_of!($type, $field) as u32)),*]
    };
}

/// The function `operate` without operators.
fn plain() -> std::sync::Arc<str> {
    Operators::default().text
}

/// The texts of all passes over planes, of whole volumes that are drawn alone.
fn shaders_of_planes() -> Vec<String> {
    let clouds = [
        CloudMode::Colors,
        CloudMode::Field,
        CloudMode::FieldEffects,
        CloudMode::Values(Kept::Mean),
    ];
    [cull_shader(), classify_shader(), mixture_shader()]
        .into_iter()
        .chain(clouds.map(|mode| mode.text(&plain())))
        .chain(cloud_shaders())
        .chain(MODES.map(|mode| mode.text([false; 2], &plain())))
        .collect()
}

/// Every mode.
const MODES: [Mode; 7] = [
    Mode::Material,
    Mode::Effects,
    Mode::Analytic,
    Mode::Values(Kept::Mean),
    Mode::ExactValues(Kept::Mean),
    Mode::Compose,
    Mode::Xray,
];

/// The texts of passes over planes of volumes that have holes, or are drawn among others.
pub(super) fn variants() -> Vec<String> {
    let of_mode = |mode: Mode| {
        let gathers = [[false, true], [true, true]].map(|how| mode.text(how, &plain()));
        let alone = mode.text([true, false], &plain());
        let settles = mode.settles();
        gathers.into_iter().filter(move |_| !settles).chain([alone])
    };
    MODES.into_iter().flat_map(of_mode).collect()
}

/// The texts of all passes but [`variants`].
pub(super) fn every_shader() -> Vec<String> {
    let small = [ASSEMBLE, RADIX, SCAN, CLEAR].map(str::to_owned);
    let operators: Vec<_> = super::operators::all()
        .iter()
        .filter_map(|(_, operator)| operator.wgsl())
        .collect();
    let operators = operators::text(&operators, 4);
    let operated = [
        Mode::Effects.text([false; 2], &operators),
        CloudMode::FieldEffects.text(&operators),
    ];
    shaders_of_planes()
        .into_iter()
        .chain(operated)
        .chain(shaders())
        .chain(integral_shaders())
        .chain([pairs_shader()])
        .chain(small)
        .collect()
}

#[test]
fn layouts_agree_and_shaders_are_valid() {
    for text in shaders_of_planes().into_iter().chain(variants()) {
        let module = valid(&text);
        let (found, size) = members(&module, "Frame");
        let wanted = offsets!(FrameData: size tiles principal per_pixel plane_per_pixel dims planes pages words margin
            sigma samples radius slots per_texel spacing background termination densest hull shows_background lit
            towards_light ambient half_way diffuse specular power floor_squared voxel from_interval to_interval
            first_plane unit_distance camera_from_lattice bodies isosurfaces
            first_isosurface channel_layers first_tile_row gather_offset
            band_pixels gathered_intervals gradient_from_lattice falls
            middle share interior share_step);
        assert_eq!(found, wanted);
        assert_eq!(size as usize, size_of::<FrameData>());
        let (found, size) = members(&module, "Sheet");
        let wanted =
            offsets!(SheetData: cell depth rest scale step_x low_pass step_y low_pass_points low_pass_pixels);
        assert_eq!(found, wanted);
        assert_eq!(size as usize, size_of::<SheetData>());
        let constant = |name: &str| {
            let found = module
                .constants
                .iter()
                .find(|(_, own)| own.name.as_deref() == Some(name));
            match module.global_expressions[found.unwrap().1.init] {
                naga::Expression::Literal(naga::Literal::U32(number)) => number,
                _ => unreachable!("a number"),
            }
        };
        assert_eq!([constant("TILE_WIDTH"), constant("TILE_HEIGHT")], TILE);
    }
}

/// The module of a text, which is valid.
pub(super) fn valid(text: &str) -> naga::Module {
    let module = naga::front::wgsl::parse_str(text).unwrap();
    Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .unwrap();
    module
}

#[test]
fn layouts_of_gaussians_and_of_sorting_agree() {
    let assemble = valid(ASSEMBLE);
    let wanted = offsets!(AssemblyData: pages edge channels channel_layers);
    assert_eq!(
        members(&assemble, "Assembly"),
        (wanted, size_of::<AssemblyData>() as u32)
    );
    let [project, composite] = shaders().map(|text| valid(&text));
    let pairs = valid(&pairs_shader());
    let wanted = offsets!(ViewData: eye near eye_rest scale to_x low_pass to_y is_perspective to_z degree direction
        is_antialiased centre tangent_limit reference_tiles count before first_key unseen_key unused);
    assert_eq!(members(&project, "View"), (wanted, size_of::<ViewData>() as u32));
    let wanted = offsets!(ListsData: splats pairs columns per_tile);
    assert_eq!(members(&pairs, "Lists"), (wanted, size_of::<ListsData>() as u32));
    let [open, _, planes, _] = cloud_shaders().map(|text| valid(&text));
    let wanted = offsets!(CloudData: low_pass is_matched nearest widening mass peaks_from count before);
    assert_eq!(members(&open, "Cloud"), (wanted, size_of::<CloudData>() as u32));
    assert_eq!(members(&open, "Kernel").1 as usize, size_of::<KernelData>());
    assert_eq!(u64::from(members(&planes, "Splat").1), SPLAT_BYTES);
    let (found, size) = members(&planes, "Part");
    let wanted = offsets!(PartData: columns groups first_row first_group pitch points unused);
    assert_eq!(found[..6], wanted[..6]);
    assert_eq!(size as usize, size_of::<PartData>());
    let wanted = offsets!(PictureData: size columns unused background);
    assert_eq!(
        members(&composite, "Picture"),
        (wanted, size_of::<PictureData>() as u32)
    );
    assert_eq!(u64::from(members(&composite, "Splat").1), FOOTPRINT_BYTES);
    let [project, integrate] = integral_shaders().map(|text| valid(&text));
    let wanted = offsets!(ProfileData: end edge height low_pass least_variance is_matched peaks_from unused);
    assert_eq!(
        members(&project, "Profile"),
        (wanted, size_of::<ProfileData>() as u32)
    );
    let wanted = offsets!(TilesData: end edge columns unused);
    assert_eq!(
        members(&integrate, "Tiles"),
        (wanted, size_of::<TilesData>() as u32)
    );
    let wanted = offsets!(DigitData: count shift blocks unused);
    assert_eq!(
        members(&valid(RADIX), "Digit"),
        (wanted, size_of::<DigitData>() as u32)
    );
    let (found, size) = members(&valid(SCAN), "Scan");
    assert_eq!(found[0], ("count".to_owned(), 0));
    assert_eq!(size as usize, size_of::<ScanData>());
}
