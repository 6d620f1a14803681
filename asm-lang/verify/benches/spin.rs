//! Distinct states per CPU second, compared with Spin's breadth-first search, on the models of `../shared/verify`.
//!
//! `cargo bench -p asmotion-verify --bench spin` runs both in turn, each in a process of its own, and prints the median of the
//! rounds. Spin's verifier is compiled with `-O3 -DSAFETY -DNOREDUCE -DBFS`; its compilation is not counted, whereas reading and
//! grounding the specification are. Then it compares two threads with one, and liveness under fairness with Spin's `-a -f`, and counts the
//! states of each model in every storage with one to three threads.
#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    clippy::disallowed_methods,
    reason = "a program that reads files and prints"
)]

use asmotion_lang::MemoryFiles;
use asmotion_verify::{FairName, Options, SpillFile, SpillSpace, Storage, verify};
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

/// Number of rounds.
const ROUNDS: usize = 5;

/// Model, states, transitions with the initial state, and the invariant that Spin asserts.
const MODELS: [(&str, u64, u64, &str); 4] = [
    (
        "phil",
        1_331_714,
        13_774_113,
        "(forall $i in Pid with not (pc($i) = 2 and pc(($i + 1) mod 16) = 2))",
    ),
    (
        "pet",
        344_805,
        1_205_326,
        "(forall $a in Pid, $b in Pid with $a = $b or not (pc($a) = 4 and pc($b) = 4))",
    ),
    (
        "tpc",
        1_745_408,
        18_507_778,
        "(forall $a in Pid, $b in Pid with not (rm($a) = ABORTED and rm($b) = COMMITTED))",
    ),
    (
        "queue",
        1_119_232,
        5_594_881,
        "(forall $i in Idx with q($i) = 3 or $i < len)",
    ),
];

/// Environment variable with the number of threads of a child.
const THREADS: &str = "ASMOTION_BENCH_THREADS";

fn threads() -> usize {
    let text = std::env::var(THREADS).unwrap_or_default();
    text.parse().unwrap_or(1)
}

/// Environment variable with the storage of a child.
const STORAGE: &str = "ASMOTION_BENCH_STORAGE";

fn storage() -> Storage {
    match std::env::var(STORAGE).unwrap_or_default().as_str() {
        "compact" => Storage::Compact,
        "disk" => Storage::Disk(Arc::new(ScratchFiles::default())),
        _ => Storage::Exact,
    }
}

/// Files of the folder for temporary files.
#[derive(Debug, Default)]
struct ScratchFiles {
    created: AtomicU32,
}

#[derive(Debug)]
struct ScratchFile(File);

impl SpillSpace for ScratchFiles {
    fn create(&self) -> io::Result<Box<dyn SpillFile>> {
        let number = self.created.fetch_add(1, Ordering::Relaxed);
        let name = format!("asmotion-bench-{}-{number}", std::process::id());
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let file = File::options()
            .read(true)
            .write(true)
            .create_new(true)
            .open(&path)?;
        std::fs::remove_file(&path)?;
        Ok(Box::new(ScratchFile(file)))
    }
}

impl SpillFile for ScratchFile {
    fn read_at(&self, bytes: &mut [u8], offset: u64) -> io::Result<()> {
        self.0.read_exact_at(bytes, offset)
    }

    fn append(&self, bytes: &[u8], offset: u64) -> io::Result<()> {
        self.0.write_all_at(bytes, offset)
    }
}

/// Counts the states of each model in every storage with one to three threads, with its steps grounded, and those of the smallest one
/// also by a machine.
fn counts(models: &Path, own: &Path) {
    for (model, states, transitions, invariant) in MODELS {
        let file = models.join(format!("{model}.asm"));
        for storage in ["exact", "compact", "disk"] {
            for threads in ["1", "2", "3"] {
                let flags = ["--model", "--machine"].into_iter();
                for flag in flags.take(if model == "pet" { 2 } else { 1 }) {
                    let output = Command::new(own)
                        .env(STORAGE, storage)
                        .env(THREADS, threads)
                        .args([flag, file.to_str().unwrap(), invariant])
                        .output()
                        .unwrap();
                    let output = String::from_utf8_lossy(&output.stdout).into_owned();
                    assert!(
                        output.starts_with(&format!("{states} {transitions} ")),
                        "{model} {storage} {threads} {flag}: {output}"
                    );
                }
            }
        }
        println!(
            "{model:6} {states} states and {transitions} transitions in every storage, with 1 to 3 threads"
        );
    }
}

/// CPU seconds, and the output of a command.
fn timed(folder: &Path, program: &Path, arguments: &[&str]) -> (f64, String) {
    let (seconds, _, output) = timed_with(folder, program, arguments, 1);
    (seconds, output)
}

/// CPU seconds, elapsed seconds, and the output of a command with several threads.
fn timed_with(
    folder: &Path,
    program: &Path,
    arguments: &[&str],
    threads: usize,
) -> (f64, f64, String) {
    // the shell reports the times of its child in milliseconds
    let output = Command::new("bash")
        .current_dir(folder)
        .env(THREADS, threads.to_string())
        .args(["-c", "TIMEFORMAT='%U %S %R'; time \"$@\"", "bash"])
        .arg(program)
        .args(arguments)
        .output()
        .unwrap();
    let times = String::from_utf8_lossy(&output.stderr).into_owned();
    let last = times.lines().last().unwrap_or_default();
    let seconds = last.split(' ').filter_map(|it| it.parse::<f64>().ok());
    let seconds: Vec<f64> = seconds.collect();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let elapsed = seconds.get(2).copied().unwrap_or(f64::NAN);
    (seconds.iter().take(2).sum(), elapsed, text)
}

/// The same models with one thread and with two, in turn: elapsed and CPU seconds.
fn speed_up(models: &Path, own: &Path) {
    println!(
        "threads: elapsed s with 1 and 2, their ratio; CPU s with 1 and 2, their ratio (2 to 1)"
    );
    for (model, states, _, invariant) in MODELS {
        let file = models.join(format!("{model}.asm"));
        let mut all: [Vec<f64>; 6] = Default::default();
        for _ in 0..ROUNDS {
            let arguments = ["--model", file.to_str().unwrap(), invariant];
            let (cpu, elapsed, one) = timed_with(models, own, &arguments, 1);
            let (cpu_two, elapsed_two, two) = timed_with(models, own, &arguments, 2);
            for output in [one, two] {
                assert!(output.starts_with(&format!("{states} ")), "{output}");
            }
            let measured = [
                elapsed,
                elapsed_two,
                elapsed / elapsed_two,
                cpu,
                cpu_two,
                cpu_two / cpu,
            ];
            all.iter_mut()
                .zip(measured)
                .for_each(|(all, it)| all.push(it));
        }
        let shown = all.map(|numbers| format!("{:.2}", median(numbers)));
        println!("{model:6} {}", shown.join("  "));
    }
}

fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Verifies one model; prints states, transitions, packed bytes, the greatest memory of the process in KiB, and that without the pages of
/// files, which are the program and its libraries.
fn child(model: &Path, property: &str, fair: &[String], without_grounding: bool) {
    let mut files = MemoryFiles::new();
    let text = std::fs::read_to_string(model).unwrap();
    let imports = "import StandardLibrary\nimport LTLLibrary";
    files.add("model.asm", text.replace("import StandardLibrary", imports));
    let Ok(specification) = asmotion_lang::open("model.asm", &files) else {
        return;
    };
    let options = Options {
        properties: vec![property.to_owned()],
        fairness: fair
            .iter()
            .map(|name| FairName {
                name: name.clone(),
                is_strong: false,
            })
            .collect(),
        threads: threads(),
        storage: storage(),
        without_grounding,
        ..Options::default()
    };
    let Ok(found) = verify(specification, &options, &mut |_| true) else {
        return;
    };
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let kib = |name: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(name));
        let number = line.and_then(|line| line.split_whitespace().next());
        number.and_then(|it| it.parse::<u64>().ok()).unwrap_or(0)
    };
    let peak = kib("VmHWM:");
    let holds = found
        .properties
        .first()
        .is_some_and(|it| it.verdict.holds());
    println!(
        "{} {} {} {peak} {} {holds}",
        found.states,
        found.transitions,
        found.memory,
        peak.saturating_sub(kib("RssFile:"))
    );
}

/// Compiles a verifier with Spin; `None` if Spin or a C compiler is missing.
fn spin(model: &Path, folder: &Path, flags: &[&str]) -> Option<PathBuf> {
    std::fs::create_dir_all(folder).ok()?;
    let run = |program: &str, arguments: &[&str]| {
        let done = Command::new(program)
            .current_dir(folder)
            .args(arguments)
            .output();
        done.is_ok_and(|output| output.status.success())
    };
    let pan = folder.join("pan");
    let is_made = run("spin", &["-a", model.to_str()?])
        && run(
            "cc",
            &[flags, &["-O3", "-DNOREDUCE", "-w", "-o", "pan", "pan.c"]].concat(),
        );
    is_made.then_some(pan)
}

/// The number before a text in the output of Spin.
fn before(output: &str, text: &str) -> f64 {
    let line = output.lines().find(|line| line.contains(text));
    let word = line.and_then(|line| line.split_whitespace().next());
    word.and_then(|word| word.parse().ok()).unwrap_or(f64::NAN)
}

/// Peterson's lock for five processes under weak fairness of each of them: the first one enters again and again.
fn liveness(models: &Path, own: &Path, scratch: &Path) {
    let folder = scratch.join("live");
    let text = std::fs::read_to_string(models.join("spin/pet.pml")).unwrap();
    let labelled = text.replacen("atomic {", "cs: atomic {", 1) + "\nltl live { []<> (P[0]@cs) }\n";
    std::fs::create_dir_all(&folder).unwrap();
    let model = folder.join("live.pml");
    std::fs::write(&model, labelled).unwrap();
    let pan = spin(&model, &folder, &[]);
    let file = models.join("pet.asm");
    let arguments = ["--model", file.to_str().unwrap(), "g(f(pc(0) = 4))", "Pid"];
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        let (seconds, output) = timed(models, own, &arguments);
        assert!(output.trim_end().ends_with("true"), "{output}");
        ours.push(seconds);
        if let Some(pan) = &pan {
            let (seconds, output) = timed(&folder, pan, &["-a", "-f", "-m1000000"]);
            assert!(output.contains("errors: 0"), "{output}");
            theirs.push(seconds);
        }
    }
    let seconds = median(ours.clone());
    if theirs.is_empty() {
        println!(
            "pet, liveness: {seconds:.3} CPU s; not compared, because Spin or a C compiler is missing"
        );
        return;
    }
    let ratios = theirs.iter().zip(&ours).map(|(theirs, ours)| theirs / ours);
    println!(
        "pet, liveness: {seconds:.3} CPU s, Spin -a -f {:.3}, ratio {:.2}",
        median(theirs.clone()),
        median(ratios.collect())
    );
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let [_, flag, model, property, fair @ ..] = arguments.as_slice()
        && (flag == "--model" || flag == "--machine")
    {
        return child(Path::new(model), property, fair, flag == "--machine");
    }
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/verify");
    if !models.exists() {
        println!("*** SKIPPED: the models are in ../shared/verify, which is missing");
        return;
    }
    let models = models.canonicalize().unwrap();
    let own = std::env::current_exe().unwrap();
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR")).join("spin");
    let mut ratios = Vec::new();
    println!(
        "{:6} {:>10} {:>11} {:>9} {:>9} {:>9} {:>7} {:>7} {:>8} {:>8}",
        "model",
        "states",
        "transitions",
        "CPU s",
        "k/CPU s",
        "Spin CPU",
        "ratio",
        "B/state",
        "process",
        "private"
    );
    for (model, states, transitions, invariant) in MODELS {
        let file = models.join(format!("{model}.asm"));
        let pan = spin(
            &models.join(format!("spin/{model}.pml")),
            &scratch.join(model),
            &["-DSAFETY", "-DBFS"],
        );
        let (mut ours, mut theirs, mut ratio) = (Vec::new(), Vec::new(), Vec::new());
        let mut last = String::new();
        for _ in 0..ROUNDS {
            let file = file.to_str().unwrap();
            let (seconds, output) = timed(&models, &own, &["--model", file, invariant]);
            ours.push(seconds);
            last = output;
            if let Some(pan) = &pan {
                // without counterexamples, so that a deadlock does not end the search
                let (seconds, output) =
                    timed(&scratch.join(model), pan, &["-m1000000", "-E", "-c0"]);
                let found = before(&output, "states, stored");
                assert!(found.is_nan() || found as u64 >= states, "Spin: {output}");
                theirs.push(seconds);
                ratio.push(seconds / ours.last().unwrap());
            }
        }
        let words: Vec<&str> = last.split_whitespace().collect();
        let number = |index: usize| words.get(index).and_then(|it| it.parse::<u64>().ok());
        assert_eq!(number(0), Some(states), "{model}: {last}");
        assert_eq!(number(1), Some(transitions), "{model}: {last}");
        let per_state = |bytes: Option<u64>| bytes.unwrap_or(0) as f64 / states as f64;
        let seconds = median(ours);
        println!(
            "{model:6} {states:>10} {transitions:>11} {seconds:>9.3} {:>9.0} {:>9.3} {:>7.2} {:>7.1} {:>8.1} {:>8.1}  {}",
            states as f64 / seconds / 1000.0,
            median(theirs),
            median(ratio.clone()),
            per_state(number(2)),
            per_state(number(3).map(|it| it * 1024)),
            per_state(number(4).map(|it| it * 1024)),
            words.get(5).unwrap_or(&"")
        );
        ratios.extend(pan.map(|_| median(ratio)));
    }
    speed_up(&models, &own);
    liveness(&models, &own, &scratch);
    counts(&models, &own);
    if ratios.is_empty() {
        println!(
            "*** SKIPPED: the comparison needs Spin and a C compiler (Debian: apt-get install spin gcc)"
        );
        return;
    }
    let product: f64 = ratios.iter().map(|it| it.ln()).sum();
    println!(
        "geometric mean of the ratios: {:.2}",
        (product / ratios.len() as f64).exp()
    );
}
