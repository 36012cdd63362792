//! Writes NIfTI files for tests, valid and malformed.
#![allow(unreachable_pub, reason = "a module of a test")]

use glam::{DMat3, DQuat, DVec3};

/// A header under construction; the defaults are those of a valid file without orientation.
pub struct NiftiFile {
    /// NIfTI-2 instead of NIfTI-1.
    pub wide: bool,
    /// Big-endian.
    pub big: bool,
    /// One file instead of a pair.
    pub single: bool,
    pub dim: [i64; 8],
    pub datatype: i16,
    pub bitpix: i16,
    pub pixdim: [f64; 8],
    /// `None`: right behind header and extension.
    pub vox_offset: Option<f64>,
    pub scl_slope: f64,
    pub scl_inter: f64,
    pub xyzt_units: u8,
    pub qform_code: i16,
    pub sform_code: i16,
    pub quatern: [f64; 3],
    pub qoffset: [f64; 3],
    pub srow: [f64; 12],
    /// Extension flag and extensions.
    pub extension: Vec<u8>,
}

impl NiftiFile {
    pub fn new(sizes: &[i64], datatype: i16) -> Self {
        let mut dim = [1; 8];
        dim[0] = sizes.len() as i64;
        dim[1..=sizes.len()].copy_from_slice(sizes);
        let bitpix = match datatype {
            2 | 256 => 8,
            4 | 512 => 16,
            128 => 24,
            64 | 32 => 64,
            _ => 32,
        };
        Self {
            wide: false,
            big: false,
            single: true,
            dim,
            datatype,
            bitpix,
            pixdim: [1.0; 8],
            vox_offset: None,
            scl_slope: 0.0,
            scl_inter: 0.0,
            xyzt_units: 2,
            qform_code: 0,
            sform_code: 0,
            quatern: [0.0; 3],
            qoffset: [0.0; 3],
            srow: [0.0; 12],
            extension: vec![0; 4],
        }
    }

    pub fn set_sform(&mut self, code: i16, linear: DMat3, offset: DVec3) {
        self.sform_code = code;
        for row in 0..3 {
            let values = [
                linear.x_axis[row],
                linear.y_axis[row],
                linear.z_axis[row],
                offset[row],
            ];
            self.srow[4 * row..4 * row + 4].copy_from_slice(&values);
        }
    }

    pub fn set_qform(&mut self, code: i16, rotation: DQuat, offset: DVec3, handedness: f64) {
        let rotation = if rotation.w < 0.0 { -rotation } else { rotation };
        self.qform_code = code;
        self.quatern = [rotation.x, rotation.y, rotation.z];
        self.qoffset = offset.to_array();
        self.pixdim[0] = handedness;
    }

    /// The file, with `data` behind the header (none for a pair).
    pub fn bytes(&self, data: &[u8]) -> Vec<u8> {
        let length = if self.wide { 540 } else { 348 };
        let mut bytes = vec![0; length];
        let extension: &[u8] = if self.single { &self.extension } else { &[] };
        let offset = self
            .vox_offset
            .unwrap_or((length + extension.len()) as f64 * f64::from(u8::from(self.single)));
        self.put(&mut bytes, 0, (length as i32).to_le_bytes());
        self.put_text(&mut bytes);
        let at = |narrow: usize, wide: usize| if self.wide { wide } else { narrow };
        for (i, &size) in self.dim.iter().enumerate() {
            if self.wide {
                self.put(&mut bytes, 16 + 8 * i, size.to_le_bytes());
            } else {
                self.put(&mut bytes, 40 + 2 * i, (size as i16).to_le_bytes());
            }
        }
        self.put(&mut bytes, at(70, 12), self.datatype.to_le_bytes());
        self.put(&mut bytes, at(72, 14), self.bitpix.to_le_bytes());
        self.put_floats(&mut bytes, at(76, 104), &self.pixdim);
        if self.wide {
            self.put(&mut bytes, 168, (offset as i64).to_le_bytes());
        } else {
            self.put_floats(&mut bytes, 108, &[offset]);
        }
        self.put_floats(&mut bytes, at(112, 176), &[self.scl_slope, self.scl_inter]);
        for (place, code) in [(at(252, 344), self.qform_code), (at(254, 348), self.sform_code)] {
            if self.wide {
                self.put(&mut bytes, place, i32::from(code).to_le_bytes());
            } else {
                self.put(&mut bytes, place, code.to_le_bytes());
            }
        }
        if self.wide {
            self.put(&mut bytes, 500, i32::from(self.xyzt_units).to_le_bytes());
        } else {
            bytes[123] = self.xyzt_units;
        }
        self.put_floats(&mut bytes, at(256, 352), &self.quatern);
        self.put_floats(&mut bytes, at(268, 376), &self.qoffset);
        self.put_floats(&mut bytes, at(280, 400), &self.srow);
        [&bytes, extension, data].concat()
    }

    fn put_text(&self, bytes: &mut [u8]) {
        let kind = if self.single { b'+' } else { b'i' };
        if self.wide {
            bytes[4..12].copy_from_slice(&[b'n', kind, b'2', 0, b'\r', b'\n', 0x1a, b'\n']);
        } else {
            bytes[344..348].copy_from_slice(&[b'n', kind, b'1', 0]);
        }
    }

    fn put<const N: usize>(&self, bytes: &mut [u8], place: usize, mut value: [u8; N]) {
        if self.big {
            value.reverse();
        }
        bytes[place..place + N].copy_from_slice(&value);
    }

    fn put_floats(&self, bytes: &mut [u8], place: usize, values: &[f64]) {
        for (i, &value) in values.iter().enumerate() {
            if self.wide {
                self.put(bytes, place + 8 * i, value.to_le_bytes());
            } else {
                self.put(bytes, place + 4 * i, (value as f32).to_le_bytes());
            }
        }
    }
}
