//! Random documents, made from the schema itself: so no key can be left out.

use serde_json::{Map, Value, json};
use splatvol_document::{Document, schema};

/// Most items of a random list.
const LONGEST: u64 = 3;

/// Seeded numbers (splitmix64).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// One of 0, 1... below a count.
    pub(crate) fn below(&mut self, count: u64) -> u64 {
        self.next() % count
    }

    fn share(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn one_of<'a, T>(&mut self, list: &'a [T]) -> &'a T {
        &list[self.below(list.len() as u64) as usize]
    }
}

/// Makes values that a schema allows.
pub(crate) struct Generator {
    root: Value,
}

impl Generator {
    pub(crate) fn new() -> Self {
        Self {
            root: serde_json::to_value(schema()).expect("the schema is well formed"),
        }
    }

    /// A document, or `None` if values that the schema allows one by one do not go together.
    pub(crate) fn document(&self, random: &mut Random) -> Option<Document> {
        let mut tree = self.value(&self.root, random);
        tree["version"] = json!(2);
        let text = serde_json::to_string(&tree).expect("the schema is well formed");
        Document::from_json(&text, "random.json".as_ref()).ok()
    }

    /// A key in a table of the document, and a value for it.
    pub(crate) fn setting(&self, random: &mut Random) -> (String, Value) {
        let tables = ["camera", "settings", "effects", "motion", "animation"];
        let table = *random.one_of(&tables);
        let of_table = self.followed(&self.root["properties"][table]);
        let keys: Vec<_> = of_table["properties"]
            .as_object()
            .expect("the schema is well formed")
            .iter()
            .collect();
        let (key, of_key) = random.one_of(&keys);
        (format!("{table}.{key}"), self.value(of_key, random))
    }

    fn followed<'a>(&'a self, schema: &'a Value) -> &'a Value {
        match schema["$ref"].as_str() {
            Some(name) => {
                let pointer = name.strip_prefix('#').expect("the schema is well formed");
                self.followed(self.root.pointer(pointer).expect("the schema is well formed"))
            }
            None => schema,
        }
    }

    fn value(&self, schema: &Value, random: &mut Random) -> Value {
        let schema = self.followed(schema);
        if let Some(only) = schema.get("const") {
            return only.clone();
        }
        if let Some(names) = schema["enum"].as_array() {
            let names: Vec<_> = names.iter().filter(|name| !name.is_null()).collect();
            return (*random.one_of(&names)).clone();
        }
        for several in ["oneOf", "anyOf"] {
            if let Some(list) = schema[several].as_array() {
                let list: Vec<_> = list.iter().filter(|one| one["type"] != "null").collect();
                let one = *random.one_of(&list);
                return self.value(one, random);
            }
        }
        let kind = match &schema["type"] {
            Value::Array(kinds) => kinds[0].as_str(),
            kind => kind.as_str(),
        };
        match kind {
            Some("object") => self.table(schema, random),
            Some("array") => self.list(schema, random),
            Some("boolean") => json!(random.below(2) == 1),
            Some("integer") => {
                let least = schema["minimum"].as_u64().unwrap_or(0);
                let most = schema["maximum"].as_u64().unwrap_or(40_000);
                json!(least + random.below(most - least + 1))
            }
            Some("number") => match schema.get("maximum") {
                Some(_) => json!(random.share()),
                None => json!((random.share() - 0.2) * 10_f64.powi(random.below(7) as i32 - 3)),
            },
            Some("string") if schema.get("pattern").is_some() => {
                json!(format!("{}x{}", 1 + random.below(999), 1 + random.below(999)))
            }
            Some("string") => {
                let names = [
                    "none",
                    "white",
                    "a b.nrrd",
                    "täglich \"x\" \\ \n",
                    "u16",
                    "viridis",
                ];
                json!(*random.one_of(&names))
            }
            other => panic!("no value for {other:?}: {schema}"),
        }
    }

    fn table(&self, schema: &Value, random: &mut Random) -> Value {
        let required: Vec<_> = schema["required"].as_array().into_iter().flatten().collect();
        let mut table = Map::new();
        for (key, of_key) in schema["properties"]
            .as_object()
            .expect("the schema is well formed")
        {
            let needed = required.iter().any(|name| *name == key);
            if needed || random.below(3) == 0 {
                table.insert(key.clone(), self.value(of_key, random));
            }
        }
        Value::Object(table)
    }

    fn list(&self, schema: &Value, random: &mut Random) -> Value {
        if let Some(of_places) = schema["prefixItems"].as_array() {
            return of_places.iter().map(|one| self.value(one, random)).collect();
        }
        let least = schema["minItems"].as_u64().unwrap_or(0);
        let most = schema["maxItems"].as_u64().unwrap_or(least + LONGEST);
        let count = least + random.below(most - least + 1);
        (0..count).map(|_| self.value(&schema["items"], random)).collect()
    }
}

/// Paths of all keys that hold a value, with `item` for each of several items.
pub(crate) fn paths(tree: &Value) -> Vec<String> {
    let Value::Object(tables) = tree else {
        return Vec::new();
    };
    let of_table = |name: &str, table: &Value| -> Vec<String> {
        table
            .as_object()
            .map(|keys| keys.keys().map(|key| format!("{name}.{key}")).collect())
            .unwrap_or_default()
    };
    tables
        .iter()
        .flat_map(|(name, table)| match table {
            Value::Array(items) => items.iter().flat_map(|item| of_table(name, item)).collect(),
            Value::Object(_) => of_table(name, table),
            _ => vec![name.clone()],
        })
        .collect()
}
