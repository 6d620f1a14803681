//! Projects whose own program contains their components: the command that runs it.

use std::path::Path;

/// Returns the beginning of the command line of the program that the project around a file builds, as `asmotion new` creates one:
/// `cargo run --`. `None` outside such a project, and in its program itself.
pub(crate) fn cargo_run(file: &Path) -> Option<String> {
    let file = file.canonicalize().ok()?;
    let mut folders = file.ancestors().skip(1);
    let folder = folders.find(|folder| folder.join("Cargo.toml").is_file())?;
    let manifest = folder.join("Cargo.toml");
    let package = package_with_asmotion(&std::fs::read_to_string(&manifest).ok()?)?;
    let own = std::env::current_exe().ok();
    let own = own.as_deref().and_then(Path::file_stem);
    if own.is_some_and(|own| own == package.as_str()) {
        return None;
    }
    let here = std::env::current_dir().and_then(|it| it.canonicalize());
    if here.is_ok_and(|here| here.starts_with(folder)) {
        Some("cargo run --".to_owned())
    } else {
        Some(format!(
            "cargo run --manifest-path {} --",
            manifest.display()
        ))
    }
}

/// Returns the name of the package of a manifest that depends on asmotion.
fn package_with_asmotion(manifest: &str) -> Option<String> {
    let (mut section, mut name, mut depends) = ("", None, false);
    for line in manifest.lines().map(str::trim) {
        if line.starts_with('[') {
            section = line;
            depends |= line == "[dependencies.asmotion]";
            continue;
        }
        let Some((key, value)) = line.split_once('=') else {
            continue;
        };
        match (section, key.trim()) {
            ("[package]", "name") => name = Some(value.trim().trim_matches('"').to_owned()),
            ("[dependencies]", "asmotion" | "asmotion.workspace" | "asmotion.path") => {
                depends = true;
            }
            _ => {}
        }
    }
    name.filter(|_| depends)
}

#[cfg(test)]
mod tests {
    use super::package_with_asmotion;

    #[test]
    fn a_project_depends_on_asmotion() {
        let manifest = include_str!("command/new/rust/manifest.toml");
        let package = package_with_asmotion(manifest);
        assert_eq!(package.as_deref(), Some("gripper"));
        let other = manifest.replace("asmotion", "other");
        assert_eq!(package_with_asmotion(&other), None);
        assert_eq!(package_with_asmotion(""), None);
    }
}
