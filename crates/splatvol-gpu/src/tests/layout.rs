//! Layouts: offsets of data in Rust are those in WGSL, and every shader is valid.

use std::mem::offset_of;

use naga::TypeInner;
use naga::valid::{Capabilities, ValidationFlags, Validator};

use crate::layout::{FrameData, SheetData, TILE};
use crate::pipelines::{cull_shader, march_shader};

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

#[test]
fn layouts_agree_and_shaders_are_valid() {
    for text in [cull_shader(), march_shader()] {
        let module = naga::front::wgsl::parse_str(&text).unwrap();
        Validator::new(ValidationFlags::all(), Capabilities::empty())
            .validate(&module)
            .unwrap();
        let (found, size) = members(&module, "Frame");
        let wanted = offsets!(FrameData: size tiles principal per_pixel plane_per_pixel dims planes pages words margin
            sigma samples radius slots atlas spacing background termination densest hull shows_background lit
            towards_light ambient half_way diffuse specular power floor_squared voxel from_interval to_interval
            first_plane unused camera_from_lattice);
        assert_eq!(found, wanted);
        assert_eq!(size as usize, size_of::<FrameData>());
        let (found, size) = members(&module, "Sheet");
        let wanted = offsets!(SheetData: cell depth rest scale step_x low_pass step_y unused);
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
