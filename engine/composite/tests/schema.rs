//! The JSON Schema of the dialect agrees with the reader.
#![allow(missing_docs, clippy::expect_used, clippy::panic, reason = "tests")]

use std::path::{Path, PathBuf};

use serde_json::Value as Json;

/// Returns all composite and type files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut paths: Vec<PathBuf> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    paths.sort();
    let found = paths.into_iter().flat_map(|path| {
        if path.is_dir() {
            files(&path)
        } else {
            vec![path]
        }
    });
    found
        .filter(|path| path.extension().is_some_and(|it| it == "toml"))
        .collect()
}

/// Returns a file as JSON and the schema it should satisfy; `None` for other files.
fn document(path: &Path) -> Option<(Json, Json)> {
    let text = std::fs::read_to_string(path).expect("a file");
    let json: Json = toml::from_str(&text).ok()?;
    let schema = match json.get("schema")?.as_str()? {
        "composite/1" => asmotion_composite::schema::composite(),
        "composite-types/1" => asmotion_composite::schema::types(),
        "mission/1" => asmotion_composite::schema::mission(),
        _ => return None,
    };
    Some((json, schema))
}

fn complaints(json: &Json, schema: &Json) -> Vec<String> {
    let validator = jsonschema::draft7::new(schema).expect("a schema");
    let complaints = validator.iter_errors(json);
    complaints
        .map(|it| format!("{}: {it}", it.instance_path()))
        .collect()
}

#[test]
fn it_is_what_a_person_has_read() {
    let schemas = [
        asmotion_composite::schema::composite(),
        asmotion_composite::schema::types(),
        asmotion_composite::schema::mission(),
    ];
    for (name, schema) in ["composite", "types", "mission"].into_iter().zip(schemas) {
        let shown = serde_json::to_string_pretty(&schema).expect("JSON");
        insta::assert_snapshot!(name, shown);
    }
}

#[test]
fn the_reference_page_is_that_of_the_declarations() {
    let (path, page) = (
        "../../docs/composites-reference.md",
        asmotion_composite::schema::reference(),
    );
    if std::env::var("INSTA_UPDATE").is_ok_and(|update| update == "always") {
        std::fs::write(path, &page).expect("the page");
    }
    let written = std::fs::read_to_string(path).expect("the page");
    assert!(
        written == page,
        "write {path} again with INSTA_UPDATE=always"
    );
}

#[test]
fn it_accepts_every_composite_that_the_reader_accepts() {
    let mut seen = 0;
    let own = files(Path::new("../plan/tests/composites"))
        .into_iter()
        .chain(files(Path::new("../../specs")));
    for path in own {
        let Some((json, schema)) = document(&path) else {
            continue;
        };
        // the schema cannot detect semantic errors
        let text = std::fs::read_to_string(&path).expect("a file");
        let is_read = (1..=10).all(|code| !text.contains(&format!("C{code:03}")));
        if is_read {
            assert_eq!(complaints(&json, &schema), [""; 0], "{}", path.display());
            seen += 1;
        }
    }
    assert!(seen > 50, "{seen}");
}

#[test]
fn a_component_of_a_base_inherits_its_implementation() {
    let schema = asmotion_composite::schema::composite();
    let [own, based] = [
        "composite = { name = \"a\" }",
        "base = \"b.composite.toml\"",
    ]
    .map(|first| {
        let text = format!(
            "schema = \"composite/1\"\n{first}\n[components.Planner]\nproperties = {{ goal = 1 }}\n"
        );
        let json: Json = toml::from_str(&text).expect("TOML");
        complaints(&json, &schema)
    });
    assert_eq!(based, [""; 0]);
    let [complaint] = &*own else {
        panic!("{own:?}");
    };
    assert!(
        complaint.contains("\"implementation\" is a required property"),
        "{complaint}"
    );
}

#[test]
fn it_finds_the_mistakes_that_the_reader_finds() {
    for file in [
        "c003_unknown_key",
        "c003_unknown_keys_everywhere",
        "c004_missing_key",
        "c005_wrong_type",
        "c006_unknown_word",
        "c007_out_of_range",
        "c008_other_schema",
        "c010_two_implementations",
    ] {
        let path = format!("../plan/tests/composites/{file}.toml");
        let text = std::fs::read_to_string(&path).expect("a file");
        let json: Json = toml::from_str(&text).expect("TOML");
        let found = complaints(&json, &asmotion_composite::schema::composite());
        let planted = text.matches("#~").count();
        assert!(!found.is_empty(), "{file}");
        if file == "c003_unknown_keys_everywhere" {
            assert_eq!(found.len(), planted, "{found:#?}");
        }
    }
}
