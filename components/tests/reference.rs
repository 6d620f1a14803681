//! The tables of ports and properties in the READMEs equal the declarations.
//!
//! `UPDATE_REFERENCE=1 cargo test -p asmotion-components --test main reference` writes them.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use asmotion_component::Interface;
use asmotion_components::COMPONENTS;

/// End marker of a generated section.
const END: &str = "<!-- end -->";

fn begin(subject: &str) -> String {
    format!("<!-- reference: {subject} -->\n")
}

/// The folder of this crate, with a folder for each component.
fn folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The READMEs of the components, sorted by folder.
fn readmes() -> Vec<PathBuf> {
    let entries = fs::read_dir(folder()).unwrap();
    let readmes = entries.map(|entry| entry.unwrap().path().join("README.md"));
    let mut readmes: Vec<_> = readmes.filter(|path| path.exists()).collect();
    readmes.sort();
    readmes
}

/// Compares a generated section of a README with the expected text, or writes it.
fn keep(readme: &Path, subject: &str, section: &str) {
    let text = fs::read_to_string(readme).unwrap();
    let begin = begin(subject);
    let (before, rest) = text.split_once(&begin).unwrap_or_else(|| {
        panic!("{} has no line `{}`", readme.display(), begin.trim_end());
    });
    let (present, after) = rest.split_once(END).unwrap();
    if present == section {
        return;
    }
    assert!(
        std::env::var_os("UPDATE_REFERENCE").is_some(),
        "the reference of {subject} in {} is out of date: UPDATE_REFERENCE=1 cargo test -p \
         asmotion-components --test main reference",
        readme.display()
    );
    fs::write(readme, format!("{before}{begin}{section}{END}{after}")).unwrap();
}

fn reference(of: &str) -> String {
    let mut scratch = Interface::new();
    asmotion_components::component(of).unwrap()(&mut scratch);
    format!("\n{}\n", scratch.declaration().tables())
}

#[test]
fn every_component_has_its_reference_in_the_readme_of_its_folder() {
    let readmes = readmes();
    for (name, _) in COMPONENTS {
        let has = |path: &&PathBuf| fs::read_to_string(path).unwrap().contains(&begin(name));
        let readme = readmes.iter().find(has);
        let readme = readme.unwrap_or_else(|| {
            panic!("no README has a line `{}`", begin(name).trim_end());
        });
        keep(readme, name, &reference(name));
    }
}

#[test]
fn the_readme_of_the_catalogue_lists_every_component() {
    let mut rows = String::from("\n| component | folder | |\n|---|---|---|\n");
    let readmes = readmes();
    for (name, _) in COMPONENTS {
        let mut texts = readmes
            .iter()
            .map(|path| (path, fs::read_to_string(path).unwrap()));
        let (path, text) = texts
            .rfind(|(_, text)| text.contains(&begin(name)))
            .unwrap();
        let room = path
            .parent()
            .unwrap()
            .file_name()
            .unwrap()
            .to_str()
            .unwrap();
        let title = text.lines().next().unwrap();
        let (_, purpose) = title.split_once(": ").unwrap();
        writeln!(rows, "| `{name}` | [`{room}`]({room}) | {purpose} |").unwrap();
    }
    rows.push('\n');
    keep(&folder().join("README.md"), "components", &rows);
}
