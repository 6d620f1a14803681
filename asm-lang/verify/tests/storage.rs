//! Ways to store states: all find the same states, and say how far they can be relied on.

use crate::naive::Random;
use crate::threads::everything;
use crate::{open, verified};
use asmotion_verify::{
    Options, PropertyKind, Refusal, SpillFile, SpillSpace, Storage, Verdict, Verification, verify,
};
use std::io;
use std::sync::{Arc, Mutex};

/// Space in memory, with a limit for all files together.
#[derive(Clone, Debug)]
pub(crate) struct Limited(Arc<Mutex<usize>>);

impl Limited {
    pub fn of(bytes: usize) -> Storage {
        Storage::Disk(Arc::new(Self(Arc::new(Mutex::new(bytes)))))
    }
}

#[derive(Debug)]
struct LimitedFile {
    left: Arc<Mutex<usize>>,
    bytes: Mutex<Vec<u8>>,
}

impl SpillSpace for Limited {
    fn create(&self) -> io::Result<Box<dyn SpillFile>> {
        Ok(Box::new(LimitedFile {
            left: self.0.clone(),
            bytes: Mutex::default(),
        }))
    }
}

impl SpillFile for LimitedFile {
    fn read_at(&self, bytes: &mut [u8], offset: u64) -> io::Result<()> {
        let all = self.bytes.lock().unwrap();
        let start = offset as usize;
        let read = all.get(start..start + bytes.len());
        bytes.copy_from_slice(read.ok_or(io::ErrorKind::UnexpectedEof)?);
        Ok(())
    }

    fn append(&self, bytes: &[u8], offset: u64) -> io::Result<()> {
        let mut left = self.left.lock().unwrap();
        let mut all = self.bytes.lock().unwrap();
        assert_eq!(offset, all.len() as u64, "at the end");
        *left = left
            .checked_sub(bytes.len())
            .ok_or(io::ErrorKind::StorageFull)?;
        all.extend(bytes);
        Ok(())
    }
}

/// A space whose files cannot be read.
#[derive(Debug)]
struct Unreadable;

#[derive(Debug)]
struct UnreadableFile;

impl SpillSpace for Unreadable {
    fn create(&self) -> io::Result<Box<dyn SpillFile>> {
        Ok(Box::new(UnreadableFile))
    }
}

impl SpillFile for UnreadableFile {
    fn read_at(&self, _: &mut [u8], _: u64) -> io::Result<()> {
        Err(io::ErrorKind::TimedOut.into())
    }

    fn append(&self, _: &[u8], _: u64) -> io::Result<()> {
        Ok(())
    }
}

pub(crate) const ENOUGH: usize = 1 << 30;

fn with(text: &str, options: &Options, storage: Storage) -> Result<Verification, Refusal> {
    let options = Options {
        storage,
        ..options.clone()
    };
    verify(open(text), &options, &mut |_| true)
}

/// Numbers, verdicts, notes and lengths of runs: the runs in compact storage are not the simplest ones.
fn outline(found: &Verification) -> String {
    let mut text = format!(
        "{} {} {} {} {:?} {}\n",
        found.states,
        found.transitions,
        found.depth,
        found.excluded,
        found.incomplete,
        found.is_grounded
    );
    for property in &found.properties {
        let verdict = match &property.verdict {
            Verdict::Holds(_) => "holds",
            Verdict::Violated(_) => "violated",
            Verdict::Unknown => "unknown",
        };
        let run = property.verdict.run();
        let lengths = run.map(|run| (run.steps.len(), run.cycle));
        text += &format!("{} {verdict} {lengths:?}\n", property.text);
    }
    text
}

#[test]
fn random_specifications_have_equal_results_in_every_storage() {
    let mut random = Random(0x0dd5_7a7e_0f57_a7e5);
    let mut compact = 0;
    for index in 0..120 {
        let text = random.specification().replace(
            "import StandardLibrary",
            "import StandardLibrary\nimport CTLLibrary",
        );
        let properties = [
            "ag(p or n < 3)",
            "ef(q and n = 2)",
            "ag(ef(m(1) = 2))",
            "af(q)",
        ];
        let options = Options {
            properties: properties.iter().map(|it| (*it).to_owned()).collect(),
            threads: 1 + index % 3,
            without_grounding: index % 2 == 0,
            ..Options::default()
        };
        let exact = with(&text, &options, Storage::Exact);
        let disk = with(&text, &options, Limited::of(ENOUGH));
        assert_eq!(everything(&disk), everything(&exact), "{text}");
        let stored = with(&text, &options, Storage::Compact);
        match (&stored, &exact) {
            (Ok(stored), Ok(exact)) => {
                assert_eq!(outline(stored), outline(exact), "{text}");
                assert!(exact.expected_missed.is_none());
                compact += u32::from(stored.expected_missed.is_some());
            }
            (Err(_), Err(_)) => assert_eq!(everything(&stored), everything(&exact)),
            _ => panic!("{text}"),
        }
    }
    assert!(compact > 30, "{compact}");
}

/// Peterson's lock for three or four processes.
fn peterson(processes: u32) -> Option<String> {
    let path = asmotion_skip::shared("verify/pet.asm")?;
    let last = processes - 1;
    let text = std::fs::read_to_string(path).unwrap();
    let text = text.replace("domain Pid = {0:4}", &format!("domain Pid = {{0:{last}}}"));
    Some(text.replace("j($i)<4", &format!("j($i)<{last}")))
}

#[test]
fn verdicts_about_states_that_may_be_missed_are_marked() {
    let text = peterson(3).unwrap_or_default();
    if text.is_empty() {
        return;
    }
    let options = Options {
        properties: vec![
            "(forall $p in Pid with pc($p) < 4)".to_owned(),
            "(forall $p in Pid with level($p) < 3)".to_owned(),
        ],
        possible: vec!["pc(0) = 4".to_owned(), "pc(0) = 4 and pc(1) = 4".to_owned()],
        storage: Storage::Compact,
        without_grounding: true,
        ..Options::default()
    };
    let found = verified(&text, &options);
    let missed = found.expected_missed.unwrap();
    assert!(missed > 0.0 && missed < 1e-12, "{missed}");
    let marked = found.properties.iter().map(|it| it.is_about_all_states());
    let marked: Vec<bool> = marked.collect();
    // violated by a run, holds, possible, impossible, no fault, not stuck, rules run
    assert_eq!(marked, [false, true, false, true, true, true, true]);
    let run = found.properties[0].verdict.run().unwrap();
    assert_eq!(run.steps.last().unwrap().updates[0].after, "4");
    assert_eq!(found.properties[2].kind, PropertyKind::Possible);
}

#[test]
fn a_full_or_unreadable_disk_gives_no_verdict() {
    let Some(text) = peterson(4) else { return };
    for without_grounding in [false, true] {
        let options = Options {
            without_grounding,
            threads: 2,
            ..Options::default()
        };
        let space = Storage::Disk(Arc::new(Unreadable));
        for storage in [Limited::of(0), Limited::of(70_000), space] {
            let refusal = with(&text, &options, storage).err().unwrap();
            let number = refusal.report.diagnostics[0].code.name;
            assert_eq!(number, "M013");
            let message = &refusal.report.diagnostics[0].message;
            assert!(
                message.starts_with("the states that were found cannot be stored: "),
                "{message}"
            );
        }
    }
}

#[test]
fn a_full_disk_is_reported_with_a_way_out() {
    let text = "asm disk\nimport StandardLibrary\nsignature:\n  domain Small subsetof Integer\n  controlled n: Small\n\
        definitions:\n  domain Small = {0 : 5000}\n  main rule r_Main = n := (n + 1) mod 5001\ndefault init s0:\n  function n = 0\n";
    let refusal = with(text, &Options::default(), Limited::of(0)).err();
    insta::assert_snapshot!("M013", crate::refused(&refusal.unwrap()));
}
