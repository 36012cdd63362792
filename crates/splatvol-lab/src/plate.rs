//! Pictures side by side, as the papers print them.

use splatvol::Image;

/// Pictures side by side.
#[derive(Debug, Clone)]
pub struct Plate {
    /// Name within the experiment, in kebab case; files are named after it.
    pub name: String,
    /// The paper's figure.
    pub figure: String,
    /// Description of the pictures.
    pub caption: String,
    /// The pictures, from left to right.
    pub panels: Vec<Panel>,
}

/// One of them.
#[derive(Debug, Clone)]
pub struct Panel {
    /// Label, in few words.
    pub label: String,
    /// The picture, linear light.
    pub image: Image,
}

impl Plate {
    /// A plate without panels.
    pub fn new(name: &str, figure: &str, caption: &str) -> Self {
        Self {
            name: name.to_owned(),
            figure: figure.to_owned(),
            caption: caption.to_owned(),
            panels: Vec::new(),
        }
    }

    /// Adds a picture to the right.
    #[must_use]
    pub fn panel(mut self, label: &str, image: Image) -> Self {
        self.panels.push(Panel {
            label: label.to_owned(),
            image,
        });
        self
    }

    /// File name of a panel.
    pub fn file_name(&self, index: usize) -> String {
        format!("{}-{}.png", self.name, index + 1)
    }
}
