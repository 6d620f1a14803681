//! The examples in the documentation for users of ASMETA, run in both modes to check the page.

use asmotion_lang::simulate::{Recording, Trace};
use asmotion_lang::{FirstChoice, MemoryFiles, ReadOptions};
use std::path::Path;

#[test]
fn does_what_the_page_says() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("../docs/coming-from-asmeta.md")).unwrap();
    let mut count = 0;
    for section in page.split("\n## ").skip(1) {
        let Some(example) = Example::of(section) else {
            continue;
        };
        count += 1;
        assert_eq!(example.run(false), example.here, "{}", example.title);
        assert_eq!(example.run(true), example.there, "{}", example.title);
        assert_ne!(example.here, example.there, "{}", example.title);
    }
    assert_eq!(count, page.matches("```asm").count());
    assert!(count > 10);
}

/// A section with an example: three lines, and the effects of the first step in both modes.
struct Example<'a> {
    title: &'a str,
    text: String,
    answers: Option<&'a str>,
    here: Vec<String>,
    there: Vec<String>,
}

impl<'a> Example<'a> {
    fn of(section: &'a str) -> Option<Self> {
        let (title, _) = section.split_once('\n')?;
        let (_, rest) = section.split_once("```asm\n")?;
        let (code, rest) = rest.split_once("```")?;
        let [signature, rules, initial] = code.lines().collect::<Vec<_>>()[..] else {
            panic!("{title}: an example has three lines");
        };
        let between = |from: &str| {
            let (_, rest) = rest.split_once(from)?;
            rest.split_once('`').map(|(quoted, _)| quoted)
        };
        Some(Self {
            title,
            text: format!(
                "asm example\nimport StandardLibrary\n{signature}\ndefinitions:\n{rules}\n{initial}\n"
            ),
            answers: between("with the answers `"),
            here: sorted(between("- here: `")?),
            there: sorted(between("- `--compat asmeta`: `")?),
        })
    }

    /// The updates of the first step, or the code of its failure.
    fn run(&self, compatible: bool) -> Vec<String> {
        let mut files = MemoryFiles::new();
        files.add("example.asm", self.text.as_str());
        let options = ReadOptions {
            compatible,
            initial: None,
        };
        let specification = asmotion_lang::open_with("example.asm", &files, &options)
            .unwrap_or_else(|failure| panic!("{}:\n{failure}", self.title));
        let mut machine = specification.machine().unwrap();
        let answers = self.answers.into_iter().flat_map(|all| all.split(", "));
        let lines: Vec<String> = answers.map(|answer| format!("M {answer}\n")).collect();
        let recording = Recording::read(&format!("@step 1\n{}", lines.concat()));
        let mut inputs = recording.steps()[0].inputs(&machine).unwrap();
        if let Err(fault) = machine.step(&mut inputs, &mut FirstChoice, 0).map(|_| ()) {
            return vec![specification.explain(&fault).code.to_string()];
        }
        let mut trace = Trace::begin(&machine, "");
        trace.step(&machine);
        super::semantics::updates(&trace.end(&machine, None))
            .into_iter()
            .filter(|update| !update.starts_with("result "))
            .collect()
    }
}

fn sorted(all: &str) -> Vec<String> {
    // a comma within quotes is no separator
    let mut parts: Vec<String> = Vec::new();
    for part in all.split(", ") {
        match parts.last_mut() {
            Some(open) if open.matches('"').count() % 2 == 1 => {
                open.push_str(", ");
                open.push_str(part);
            }
            _ => parts.push(part.to_owned()),
        }
    }
    parts.sort();
    parts
}
