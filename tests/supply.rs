//! Dependencies: their licences and sources are those that `deny.toml` allows.

use cargo_metadata::MetadataCommand;
use std::collections::BTreeSet;
use std::path::Path;
use xtask::licences::accepts;

/// A list of texts in a table of `deny.toml`.
fn allowed(table: &str, key: &str) -> BTreeSet<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("deny.toml");
    let text = std::fs::read_to_string(path).expect("deny.toml");
    let config: toml::Table = toml::from_str(&text).expect("TOML");
    let list = config[table][key].as_array().expect("a list");
    let texts = list.iter().map(|it| it.as_str().expect("a text"));
    texts.map(str::to_owned).collect()
}

#[test]
fn every_dependency_has_an_accepted_licence() {
    let licences = allowed("licenses", "allow");
    let platform = "--filter-platform=x86_64-unknown-linux-gnu";
    let options = [platform, "--offline", "--locked"].map(str::to_owned);
    let metadata = MetadataCommand::new()
        .other_options(options)
        .exec()
        .expect("cargo metadata");
    assert!(metadata.packages.len() > 100);
    for package in &metadata.packages {
        let licence = package.license.as_deref().unwrap_or_default();
        assert!(
            accepts(&licences, licence),
            "{} has the licence {licence:?}",
            package.name
        );
    }
}

#[test]
fn every_dependency_comes_from_an_accepted_registry() {
    let registries = allowed("sources", "allow-registry");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.lock");
    let text = std::fs::read_to_string(path).expect("Cargo.lock");
    let lock: toml::Table = toml::from_str(&text).expect("TOML");
    let packages = lock["package"].as_array().expect("a list");
    assert!(packages.len() > 100);
    // packages without a source are our own
    for source in packages.iter().filter_map(|package| package.get("source")) {
        let source = source.as_str().expect("a text");
        let registry = source.strip_prefix("registry+").unwrap_or(source);
        assert!(registries.contains(registry), "{source}");
    }
}
