//! Every scene file that the documentation shows is valid: the schema allows it, and it can be read.

use std::path::{Path, PathBuf};

use splatvol_document::{Document, schema};

/// Fenced blocks of TOML in a page.
fn blocks(page: &str) -> Vec<String> {
    let mut blocks = Vec::new();
    let mut rest = page;
    while let Some((_, after)) = rest.split_once("```toml\n") {
        let Some((block, next)) = after.split_once("```") else {
            break;
        };
        blocks.push(block.to_owned());
        rest = next;
    }
    blocks
}

fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let in_docs = std::fs::read_dir(root.join("docs")).expect("the documentation is there");
    let docs = in_docs.map(|entry| entry.expect("folders can be read").path());
    let pages = docs.filter(|path| path.extension().is_some_and(|extension| extension == "md"));
    pages.chain([root.join("README.md")]).collect()
}

#[test]
fn scenes_of_the_documentation_are_documents() {
    let validator = jsonschema::validator_for(&serde_json::to_value(schema()).unwrap())
        .expect("the documentation is there");
    let mut count = 0;
    for page in pages() {
        let text = std::fs::read_to_string(&page).expect("the documentation is there");
        for block in blocks(&text).iter().filter(|block| block.contains("[[item]]")) {
            let tree: serde_json::Value = toml::from_str(block).expect("the documentation is there");
            if let Err(error) = validator.validate(&tree) {
                panic!("{}: {error}\n{block}", page.display());
            }
            Document::from_toml(block, &page).expect("the documentation is there");
            count += 1;
        }
    }
    assert!(count > 0, "no page shows a scene");
}
