//! Documents as text, and edits of them: a round trip keeps whatever a document says.

mod examples;
mod random;

use std::collections::BTreeSet;
use std::path::Path;

use random::{Generator, Random, paths};
use splatvol_document::keys::ItemKeys;
use splatvol_document::{Document, Edit, History, Record, schema};

/// Random documents.
const COUNT: u64 = 3000;

fn documents() -> impl Iterator<Item = Document> {
    let generator = Generator::new();
    (0..COUNT).filter_map(move |seed| generator.document(&mut Random(seed)))
}

#[test]
fn toml_json_and_the_text_of_pictures_say_the_same_again() {
    let name = Path::new("any");
    let (mut count, mut seen) = (0, BTreeSet::new());
    for document in documents() {
        count += 1;
        let toml = document.to_toml().unwrap();
        assert_eq!(Document::from_toml(&toml, name).unwrap(), document, "{toml}");
        for pretty in [false, true] {
            let json = document.to_json(pretty).unwrap();
            assert_eq!(Document::from_json(&json, name).unwrap(), document, "{json}");
        }
        let record = Record {
            document,
            command: "splatvol render 'a b'".to_owned(),
        };
        let texts = record.metadata().unwrap();
        assert_eq!(Record::of_metadata(&texts, name).unwrap(), record);
        seen.extend(paths(&serde_json::to_value(&record.document).unwrap()));
    }
    assert!(count > COUNT / 3, "{count} documents");
    let missing: Vec<_> = all_keys().difference(&seen).cloned().collect();
    assert_eq!(missing, [""; 0], "keys that no document had");
}

/// All keys of the schema.
fn all_keys() -> BTreeSet<String> {
    let root = serde_json::to_value(schema()).expect("the schema is well formed");
    let mut all = BTreeSet::new();
    for (name, of_name) in root["properties"].as_object().expect("the schema is well formed") {
        let list = of_name["items"]["$ref"].as_str();
        let table = list.or(of_name["$ref"].as_str());
        let table = table.and_then(|name| root.pointer(name.strip_prefix('#')?));
        match table.and_then(|table| table["properties"].as_object()) {
            Some(keys) => all.extend(keys.keys().map(|key| format!("{name}.{key}"))),
            None => _ = all.insert(name.clone()),
        }
    }
    all
}

#[test]
fn random_documents_are_what_the_schema_allows() {
    let validator = jsonschema::validator_for(&serde_json::to_value(schema()).unwrap()).unwrap();
    for document in documents() {
        let tree = serde_json::to_value(&document).unwrap();
        if let Err(error) = validator.validate(&tree) {
            panic!("{error} at {}", error.instance_path());
        }
    }
}

#[test]
fn any_list_of_edits_can_be_undone_and_made_again() {
    let generator = Generator::new();
    for (seed, start) in documents().enumerate().step_by(20) {
        let random = &mut Random(seed as u64);
        let mut history = History::new(start.clone());
        let mut states = vec![start];
        for _ in 0..60 {
            if history.edit(edit(history.document(), &generator, random)).is_ok() {
                states.push(history.document().clone());
            }
        }
        assert!(states.len() > 20, "{} edits", states.len());
        for state in states.iter().rev().skip(1) {
            assert!(history.undo().unwrap());
            assert_eq!(history.document(), state);
        }
        assert!(!history.undo().unwrap());
        for state in &states[1..] {
            assert!(history.redo().unwrap());
            assert_eq!(history.document(), state);
        }
    }
}

fn edit(document: &Document, generator: &Generator, random: &mut Random) -> Edit {
    let count = document.items.len() as u64;
    let mut any = |count: u64| random.below(count) as usize;
    match any(8) {
        0 => Edit::Insert(any(count + 1), Box::new(ItemKeys::of_file("b.ply"))),
        1 => Edit::Remove(any(count + 1)),
        2 => Edit::Move(any(count + 1), any(count + 1)),
        3 => Edit::set(format!("item[{}].iso", any(count + 1)), any(900)),
        4 => Edit::unset(generator.setting(random).0),
        _ => {
            let (path, value) = generator.setting(random);
            Edit::set(path, value)
        }
    }
}

#[test]
fn nothing_over_a_document_is_the_document() {
    for document in documents() {
        assert_eq!(Document::default().over(&document), document);
    }
}
