//! Operators of an item: their functions in one text, and their numbers.

use std::fmt::Write;
use std::sync::Arc;

use glam::DAffine3;
use splatvol_scene::{PixelOperator, WgslOperator};

const PLAIN: &str = include_str!("../shaders/plain.wgsl");
const OPERATORS: &str = include_str!("../shaders/operators.wgsl");
/// Pieces into which an interval is cut, at least and at most.
const PIECES: [usize; 2] = [2, 64];
/// Vectors in front of the places of the operators' numbers.
const HEAD: usize = 4;

/// Operators of an item.
#[derive(Debug, Clone)]
pub(crate) struct Operators {
    /// The function `operate`, and those that it calls. Items with the same one share their passes.
    pub text: Arc<str>,
    /// Behind the isosurfaces in `effects`.
    pub data: Vec<[f32; 4]>,
}

impl Default for Operators {
    fn default() -> Self {
        Self {
            text: PLAIN.into(),
            data: Vec::new(),
        }
    }
}

impl Operators {
    /// Operators of samples in camera space, whose values lie in a range; those without WGSL are left out.
    pub(crate) fn new(
        operators: &[Arc<dyn PixelOperator>],
        (world_from_camera, [low, high]): (&DAffine3, [f64; 2]),
    ) -> Self {
        if operators.is_empty() {
            return Self::default();
        }
        let own: Vec<WgslOperator> = operators.iter().filter_map(|operator| operator.wgsl()).collect();
        let [least, most] = PIECES;
        let pieces = operators
            .iter()
            .fold(least, |pieces, operator| pieces.max(operator.pieces()));
        let rows = world_from_camera.matrix3.transpose();
        let mut data: Vec<[f32; 4]> = [0, 1, 2]
            .map(|axis| {
                let offset = world_from_camera.translation[axis];
                rows.col(axis).extend(offset).as_vec4().to_array()
            })
            .to_vec();
        let range = if high > low { high - low } else { 1.0 };
        data.push([low as f32, range as f32, 0.0, 0.0]);
        let mut at = HEAD + own.len();
        for operator in &own {
            data.push([at as f32, 0.0, 0.0, 0.0]);
            at += operator.operands.len();
        }
        data.extend(own.iter().flat_map(|operator| &operator.operands));
        Self {
            text: text(&own, pieces.min(most)).into(),
            data,
        }
    }
}

/// The functions of operators, each once, and their list.
pub(crate) fn text(operators: &[WgslOperator], pieces: usize) -> String {
    let mut texts = vec![OPERATORS];
    for text in operators.iter().flat_map(|operator| &operator.texts) {
        if !texts.contains(text) {
            texts.push(text);
        }
    }
    let mut calls = String::new();
    for (i, operator) in operators.iter().enumerate() {
        // Writing to text does not fail.
        let _ = writeln!(
            calls,
            "    {}(sample, appearance, base + u32(effects[base + {}u].x));",
            operator.name,
            HEAD + i
        );
    }
    format!(
        "{}\nconst PIECES: i32 = {pieces};\n\n\
         fn apply_operators(sample: SheetSample, appearance: ptr<function, Appearance>, base: u32) {{\n{calls}}}\n",
        texts.join("\n")
    )
}
