//! `asmotion check --connections`: the connections of a composite, and whether they are real-time capable; the threads of its
//! components.

use crate::build::Build;
use crate::files::DiskLoader;
use crate::table;
use crate::terminal::TerminalOutput;
use asmotion_plan::{ComponentThread, Plan};

/// Prints the connections of a composite for each of its profiles; prints nothing for other files.
pub fn show(build: &Build, path: &str, terminal: &mut TerminalOutput) {
    if !path.ends_with(".toml") {
        return;
    }
    let opened = build.open(path, &[], &DiskLoader);
    let profiles: Vec<Option<&str>> = if opened.profiles.is_empty() {
        vec![None]
    } else {
        opened.profiles.iter().map(|it| Some(&**it)).collect()
    };
    for plan in profiles.into_iter().filter_map(|it| opened.plan(it)) {
        of_plan(plan, terminal);
    }
}

fn of_plan(plan: &Plan, terminal: &mut TerminalOutput) {
    let routes = plan.connection_routes();
    let in_real_time = routes
        .iter()
        .filter(|route| route.over.is_real_time())
        .count();
    let profile = plan.profile.as_ref();
    let profile = profile.map_or_else(String::new, |it| format!(" in profile `{it}`"));
    terminal.result(format_args!(
        "{}{profile}: {} connections, {in_real_time} in real time",
        plan.name,
        routes.len()
    ));
    let rows = routes.iter().map(|route| {
        let real_time = if route.over.is_real_time() {
            "real time"
        } else {
            "not real time"
        };
        vec![
            route.from.to_string(),
            route.to.to_string(),
            route.topic.clone().unwrap_or_else(|| "-".to_owned()),
            route.over.to_string(),
            real_time.to_owned(),
        ]
    });
    for line in table::lines(&["from", "to", "topic", "path", "timing"], rows) {
        terminal.result(line);
    }
    threads(plan, terminal);
}

/// Prints the components with a thread of their own; the others share the executor threads.
fn threads(plan: &Plan, terminal: &mut TerminalOutput) {
    let mut rows = Vec::new();
    let mut shared = 0;
    for (component, thread) in plan.threads() {
        match thread {
            ComponentThread::Executor => shared += 1,
            ComponentThread::Own(_) | ComponentThread::Master(_) => {
                rows.push(vec![component.name.clone(), thread.to_string()]);
            }
        }
    }
    terminal.result(format_args!(
        "threads in real time: {shared} of {} components share executor threads",
        plan.components.len()
    ));
    if !rows.is_empty() {
        for line in table::lines(&["component", "thread"], rows.into_iter()) {
            terminal.result(line);
        }
    }
}
