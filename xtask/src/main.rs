//! Chores of this repository: `cargo xtask --help`.

#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "tasks print their results"
)]

use clap::{Parser, Subcommand};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use xtask::checkout::Checkout;
use xtask::modules::{self, CrateModules};
use xtask::{build_cost, graph, new_component, report, table, type_names};

/// The lines that enclose the table in docs/house.md.
const TABLE_BEGINS: &str = "<!-- table -->";
const TABLE_ENDS: &str = "<!-- end of table -->";

#[derive(Parser)]
#[command(name = "cargo xtask", about = "Maintenance tasks of this repository")]
struct Arguments {
    #[command(subcommand)]
    chore: Chore,
}

#[derive(Subcommand)]
enum Chore {
    /// Prints the figures of the source: sizes, cycles, names, docs
    House {
        /// Also measure this revision; can be repeated
        #[arg(long, value_name = "REVISION")]
        at: Vec<String>,
        /// Replace the table in docs/house.md instead of printing it
        #[arg(long)]
        write: bool,
    },
    /// Lists the cycles of files and of first-level modules, and the arrows that point up
    Cycles {
        /// Only this package
        package: Option<String>,
    },
    /// Lists the uses of names through `lib.rs` or `main.rs`
    Hubs {
        /// Only this package
        package: Option<String>,
    },
    /// Creates a component in components/NAME and adds it to every list of components
    NewComponent {
        /// Lower-case, words joined by dashes: pan-tilt
        name: String,
    },
    /// Runs `cargo test` with these arguments and accepts changed snapshots
    Bless {
        /// Arguments of `cargo test`
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
    /// Lists the type names with several meanings, the most frequent first
    Names,
    /// Builds sets of Cargo features and fails if one costs more CPU seconds than its budget
    BuildCost(BuildCost),
}

/// Options of `build-cost`.
#[derive(clap::Args)]
struct BuildCost {
    /// Sets to build, in this order: minimal, default, full [default: all three]
    sets: Vec<String>,
    /// Keeps the builds, each in a folder of this one with the name of its set [default: temporary folders]
    #[arg(long, value_name = "DIR")]
    target_dir: Option<PathBuf>,
    /// Writes the figures to docs/build-cost.toml
    #[arg(long)]
    record: bool,
}

fn main() -> ExitCode {
    match run(Arguments::parse().chore) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(chore: Chore) -> Result<(), Box<dyn Error>> {
    let root = root();
    match chore {
        Chore::House { at, write } => house(&root, &at, write),
        Chore::Cycles { package } => cycles(&root, package.as_deref()),
        Chore::Hubs { package } => hubs(&root, package.as_deref()),
        Chore::NewComponent { name } => make_component(&root, &name),
        Chore::Bless { arguments } => bless(&root, &arguments),
        Chore::Names => names(&root),
        Chore::BuildCost(options) => build_costs(&root, &options),
    }
}

/// Returns the root of the repository: the parent folder of this crate.
fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_owned()
}

fn build_costs(root: &Path, options: &BuildCost) -> Result<(), Box<dyn Error>> {
    let all = || build_cost::SETS.iter().map(|set| set.name.to_owned());
    let names = if options.sets.is_empty() {
        all().collect()
    } else {
        options.sets.clone()
    };
    let mut figures = Vec::new();
    for name in &names {
        let set = build_cost::set(name)?;
        let cost = match &options.target_dir {
            Some(folder) => build_cost::measure(root, &folder.join(name), set)?,
            None => build_cost::measure(root, tempfile::tempdir()?.path(), set)?,
        };
        println!(
            "{name}: {:.0} CPU seconds, at most {:.0} ({:.0} here, at speed {:.2})",
            cost.scaled(),
            set.budget,
            cost.seconds,
            cost.speed
        );
        figures.push((set, cost.scaled()));
    }
    if options.record {
        build_cost::record(root, &figures)?;
    }
    let over = figures
        .iter()
        .filter(|(set, seconds)| *seconds > set.budget);
    let over: Vec<&str> = over.map(|(set, _)| set.name).collect();
    if over.is_empty() {
        Ok(())
    } else {
        Err(format!("above the budget: {}", over.join(", ")).into())
    }
}

fn house(root: &Path, revisions: &[String], write: bool) -> Result<(), Box<dyn Error>> {
    let mut columns = Vec::new();
    for revision in revisions {
        columns.push((revision.clone(), report::rows(root, Some(revision))?));
    }
    columns.push(("now".to_owned(), report::rows(root, None)?));
    let table = table::markdown(&columns);
    if !write {
        print!("{table}");
        return Ok(());
    }
    let path = root.join("docs/house.md");
    let text = std::fs::read_to_string(&path)?;
    let (before, rest) = text
        .split_once(TABLE_BEGINS)
        .ok_or("docs/house.md has no table")?;
    let (_, after) = rest
        .split_once(TABLE_ENDS)
        .ok_or("the table in docs/house.md has no end")?;
    std::fs::write(
        path,
        format!("{before}{TABLE_BEGINS}\n{table}{TABLE_ENDS}{after}"),
    )?;
    Ok(())
}

fn names(root: &Path) -> Result<(), Box<dyn Error>> {
    let checkout = Checkout::working_tree(root)?;
    let mut reused: Vec<_> = type_names::definitions(&checkout).into_iter().collect();
    reused.retain(|(_, paths)| paths.len() > 1);
    reused.sort_by_key(|(_, paths)| std::cmp::Reverse(paths.len()));
    for (name, paths) in reused {
        println!("{name} {}", paths.len());
        for path in paths {
            println!("    {path}");
        }
    }
    Ok(())
}

/// Returns the modules of all crates, or of those of one package.
fn crates(root: &Path, package: Option<&str>) -> Result<Vec<CrateModules>, Box<dyn Error>> {
    let mut crates = modules::of(&Checkout::working_tree(root)?);
    crates.retain(|it| package.is_none_or(|package| it.name == package));
    Ok(crates)
}

fn cycles(root: &Path, package: Option<&str>) -> Result<(), Box<dyn Error>> {
    for it in crates(root, package)? {
        let between = it.room_arrows();
        for cycle in graph::cycles(&between) {
            println!(
                "{}: {} first-level modules in a cycle: {}",
                it.name,
                cycle.len(),
                cycle.join(" ")
            );
        }
        for (from, to) in graph::climbing(&between) {
            println!("{}: up: {from} -> {to}", it.name);
        }
        for cycle in graph::cycles(&it.arrows()) {
            println!(
                "{}: {} files in a cycle: {}",
                it.name,
                cycle.len(),
                cycle.join(" ")
            );
            for ((from, to), names) in &it.uses {
                if cycle.contains(from) && cycle.contains(to) {
                    let names: Vec<&str> = names.iter().map(String::as_str).collect();
                    println!("    {from} -> {to}: {}", names.join(" "));
                }
            }
        }
    }
    Ok(())
}

fn hubs(root: &Path, package: Option<&str>) -> Result<(), Box<dyn Error>> {
    for it in crates(root, package)? {
        for hub in it.hub_uses {
            println!("{}:{}: {}", hub.path, hub.line, hub.name);
        }
    }
    Ok(())
}

fn make_component(root: &Path, name: &str) -> Result<(), Box<dyn Error>> {
    let files = new_component::plan(root, name)?;
    new_component::write(root, &files)?;
    for file in files {
        println!(
            "{} {}",
            if file.new { "new    " } else { "changed" },
            file.path
        );
    }
    Ok(())
}

fn bless(root: &Path, arguments: &[String]) -> Result<(), Box<dyn Error>> {
    let status = Command::new("cargo")
        .arg("test")
        .args(arguments)
        .env("INSTA_UPDATE", "always")
        .current_dir(root)
        .status()?;
    if status.success() {
        Ok(())
    } else {
        Err("a test failed for another reason than a snapshot".into())
    }
}
