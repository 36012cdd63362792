//! Values with a spelling of their own: picture sizes and backgrounds.

use std::borrow::Cow;
use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use splatvol_scene::ImageSize;

use super::names::nearest;

/// Named backgrounds, sRGB and alpha.
const COLORS: [(&str, [f64; 4]); 4] = [
    ("black", [0.0, 0.0, 0.0, 1.0]),
    ("white", [1.0, 1.0, 1.0, 1.0]),
    ("gray", [0.5, 0.5, 0.5, 1.0]),
    ("charcoal", CHARCOAL),
];

/// The default background: dark enough for translucent shells to glow, light enough for dark material to stand out.
pub const CHARCOAL: [f64; 4] = [0.094, 0.098, 0.110, 1.0];

/// Size of a picture, pixels: `"WxH"`, or N for both.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PictureSize(pub ImageSize);

/// Background of a picture: a name, `#rrggbb`, `r,g,b[,a]`, or `none`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Background {
    /// Nothing: the picture keeps its alpha.
    None,
    /// sRGB and straight alpha, 0..1.
    Color([f64; 4]),
}

fn numbers<T: FromStr>(text: &str, separators: &[char]) -> Option<Vec<T>> {
    text.split(separators)
        .map(|part| part.trim().parse().ok())
        .collect()
}

impl FromStr for PictureSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let sides = numbers::<u32>(text, &['x', 'X', ',']);
        let size = match sides.as_deref() {
            Some(&[width, height]) => ImageSize::new(width, height),
            Some(&[side]) => ImageSize::new(side, side),
            _ => return Err("expected WxH, W,H or N, in pixels".to_owned()),
        };
        size.map(Self).map_err(|error| error.to_string())
    }
}

impl Display for PictureSize {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}x{}", self.0.width(), self.0.height())
    }
}

impl Background {
    /// sRGB and straight alpha; `None` where the picture keeps its alpha.
    pub fn color(self) -> Option<[f64; 4]> {
        match self {
            Self::None => None,
            Self::Color(color) => Some(color),
        }
    }

    fn checked(color: &[f64]) -> Option<Self> {
        let color = match *color {
            [r, g, b] => [r, g, b, 1.0],
            [r, g, b, a] => [r, g, b, a],
            _ => return None,
        };
        let valid = color.iter().all(|channel| (0.0..=1.0).contains(channel));
        valid.then_some(Self::Color(color))
    }
}

impl FromStr for Background {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let name = text.to_ascii_lowercase();
        if name == "none" || name == "transparent" {
            return Ok(Self::None);
        }
        if let Some((_, color)) = COLORS.iter().find(|(known, _)| *known == name) {
            return Ok(Self::Color(*color));
        }
        let found = match name.strip_prefix('#') {
            Some(hex) => hex_color(hex),
            None => numbers::<f64>(&name, &[',']).and_then(|color| Self::checked(&color)),
        };
        found.ok_or_else(|| {
            let names = COLORS.map(|(name, _)| name);
            let listed = names.join(", ");
            let expected = format!("expected r,g,b or r,g,b,a in 0..1, #rrggbb, none, or one of {listed}");
            match nearest(&name, names.into_iter().chain(["none"])) {
                Some(nearest) => format!("{expected}; did you mean '{nearest}'?"),
                None => expected,
            }
        })
    }
}

fn hex_color(hex: &str) -> Option<Background> {
    let channel = |i: usize| {
        u8::from_str_radix(hex.get(i..i + 2)?, 16)
            .ok()
            .map(|v| f64::from(v) / 255.0)
    };
    (hex.len() == 6).then_some(())?;
    Some(Background::Color([channel(0)?, channel(2)?, channel(4)?, 1.0]))
}

/// Forms in which these values may be written.
#[derive(Deserialize)]
#[serde(untagged)]
enum Written {
    Text(String),
    Number(u32),
    List(Vec<f64>),
}

impl Serialize for PictureSize {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for PictureSize {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = match Written::deserialize(deserializer) {
            Ok(Written::Text(text)) => text,
            Ok(Written::Number(side)) => side.to_string(),
            _ => return Err(serde::de::Error::custom("expected \"WxH\" or N, in pixels")),
        };
        text.parse()
            .map_err(|why: String| serde::de::Error::custom(format!("size {text:?}: {why}")))
    }
}

impl Serialize for Background {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::None => serializer.serialize_str("none"),
            Self::Color(color) => match COLORS.iter().find(|(_, known)| known == color) {
                Some((name, _)) => serializer.serialize_str(name),
                None => color.serialize(serializer),
            },
        }
    }
}

impl<'de> Deserialize<'de> for Background {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        use serde::de::Error;
        match Written::deserialize(deserializer) {
            Ok(Written::Text(text)) => text
                .parse()
                .map_err(|why: String| D::Error::custom(format!("background {text:?}: {why}"))),
            Ok(Written::List(color)) => Self::checked(&color).ok_or_else(|| {
                D::Error::custom(format!(
                    "background {color:?}: expected [r, g, b] or [r, g, b, a] in 0..1"
                ))
            }),
            _ => Err(D::Error::custom(
                "expected a colour: a name, #rrggbb, or [r, g, b]",
            )),
        }
    }
}

impl JsonSchema for PictureSize {
    fn schema_name() -> Cow<'static, str> {
        "PictureSize".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Size of a picture, pixels: \"WxH\", or N for both.",
            "oneOf": [
                { "type": "string", "pattern": "^ *[0-9]+ *([xX,] *[0-9]+ *)?$" },
                { "type": "integer", "minimum": 1 },
            ],
        })
    }
}

impl JsonSchema for Background {
    fn schema_name() -> Cow<'static, str> {
        "Background".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Background: a name, #rrggbb, r,g,b[,a], none, or a list of sRGB 0..1 and straight alpha.",
            "oneOf": [
                { "type": "string" },
                {
                    "type": "array",
                    "items": { "type": "number", "minimum": 0, "maximum": 1 },
                    "minItems": 3,
                    "maxItems": 4,
                },
            ],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_come_in_three_spellings() {
        let size = |text: &str| text.parse::<PictureSize>().unwrap().0;
        assert_eq!(size("640x480"), ImageSize::new(640, 480).unwrap());
        assert_eq!(size("640,480"), size("640x480"));
        assert_eq!(size("64"), size("64x64"));
        for bad in ["", "0x4", "4x", "4x4x4", "-3", "70000x2"] {
            assert!(bad.parse::<PictureSize>().is_err(), "{bad}");
        }
    }

    #[test]
    fn backgrounds_are_names_numbers_or_hex() {
        let background = |text: &str| text.parse::<Background>();
        assert_eq!(background("NONE"), Ok(Background::None));
        assert_eq!(background("white"), Ok(Background::Color([1.0; 4])));
        assert_eq!(background("#ff0000"), Ok(Background::Color([1.0, 0.0, 0.0, 1.0])));
        assert_eq!(
            background("0,0.5,1,0.25"),
            Ok(Background::Color([0.0, 0.5, 1.0, 0.25]))
        );
        for bad in ["mauve", "#ff00", "#\u{e9}12345", "1,2,3", "0,0", "nan,0,0"] {
            assert!(background(bad).is_err(), "{bad}");
        }
        assert!(background("whte").unwrap_err().ends_with("did you mean 'white'?"));
        assert!(!background("qqqqq").unwrap_err().contains("did you mean"));
    }
}
