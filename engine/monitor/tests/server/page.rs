//! The files of the page.

use std::io::Write;

use crate::Fixture;

#[test]
fn the_page_is_small_and_builds_nothing_from_text() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/page");
    let fixture = Fixture::open(|_| {});
    let mut compressed = 0;
    let files = |folder: &std::path::Path| {
        let files = std::fs::read_dir(folder)
            .unwrap()
            .map(|it| it.unwrap().path());
        // how others' files are updated is no part of the page
        let served = files.filter(|path| path.is_file() && !path.ends_with("README.md"));
        served.collect::<Vec<_>>()
    };
    let own = files(&folder);
    for path in own.iter().chain(&files(&folder.join("vendor"))) {
        let name = path
            .strip_prefix(&folder)
            .unwrap()
            .to_str()
            .unwrap()
            .to_owned();
        let text = std::fs::read_to_string(path).unwrap();
        // a file without a row in the table would be missing in the program
        let (head, body) = fixture.request(&format!("/{name}"), &fixture.host());
        assert!(head.starts_with("HTTP/1.1 200") && body == text, "{name}");
        for forbidden in [
            "innerHTML",
            "outerHTML",
            "insertAdjacentHTML",
            "document.write",
            "eval(",
            "new Function",
            "setAttribute(\"style",
        ] {
            assert!(!text.contains(forbidden), "{name}: {forbidden}");
        }
        // comments of others name their sources
        assert!(!own.contains(path) || !text.contains("https://"), "{name}");
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        encoder.write_all(text.as_bytes()).unwrap();
        compressed += encoder.finish().unwrap().len();
    }
    assert!(compressed < 150_000, "{compressed} bytes");
    println!("{compressed} bytes compressed");
}

/// Contrast of two colours by WCAG, from 1 to 21.
fn contrast(one: &str, other: &str) -> f64 {
    let luminance = |colour: &str| {
        let part = |at: usize| {
            let share = f64::from(u8::from_str_radix(&colour[at..at + 2], 16).unwrap()) / 255.0;
            if share <= 0.040_45 {
                share / 12.92
            } else {
                ((share + 0.055) / 1.055).powf(2.4)
            }
        };
        0.2126 * part(1) + 0.7152 * part(3) + 0.0722 * part(5)
    };
    let (one, other) = (luminance(one), luminance(other));
    (one.max(other) + 0.05) / (one.min(other) + 0.05)
}

#[test]
fn texts_can_be_read_in_both_themes() {
    let style = include_str!("../../src/page/style.css");
    let themes: Vec<&str> = style
        .split(":root")
        .filter(|it| it.contains("--ground:"))
        .collect();
    // light, dark by preference, and dark by choice
    assert_eq!(themes.len(), 3);
    for theme in themes {
        let block = theme.split('}').next().unwrap();
        let colour = |name: &str| {
            let after = block.split(&format!("--{name}: ")).nth(1);
            let after = after.unwrap_or_else(|| panic!("no --{name} in {block}"));
            after[..7].to_owned()
        };
        for (text, ground) in [
            ("ink", "panel"),
            ("ink", "ground"),
            ("ink", "changed"),
            ("ink", "accent-soft"),
            ("faint", "panel"),
            ("faint", "sunken"),
            ("faint", "ground"),
            ("accent", "panel"),
            ("accent", "accent-soft"),
            ("good", "good-soft"),
            ("bad", "panel"),
            ("bad", "bad-soft"),
            ("note", "note-soft"),
            ("note", "panel"),
            ("on-accent", "accent"),
        ] {
            let found = contrast(&colour(text), &colour(ground));
            assert!(found >= 4.5, "{text} on {ground}: {found:.2}");
        }
    }
}

#[test]
fn vendored_files_are_those_of_their_version() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/page/vendor");
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let version = "1.6.32";
    assert!(read("README.md").contains(version));
    assert!(read("uPlot.esm.js").contains(&format!("(v{version})")));
    assert!(read("LICENSE.uPlot").contains("Permission is hereby granted"));
}
