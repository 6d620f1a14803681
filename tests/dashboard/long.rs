//! Much that waits or has happened: a log of nearly a hundred thousand entries, and full queues.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use serde_json::json;

use crate::browser::{Browser, Tab};
use crate::mission::RunningMission;
use crate::recording::Shown;
use crate::{WIDE, show, with_text};

/// Writes a number on a topic, 200 times a second.
const SOURCE: &str = "asm source
import StandardLibrary
signature:
	out n: Integer
definitions:
	main rule r_Main = n := n + 1
default init s0:
	function n = 0
";

/// Reads all of them, 20 a second.
const SINK: &str = "asm sink
import StandardLibrary
signature:
	monitored tick: Integer
	controlled seen: Integer
definitions:
	main rule r_Main = if tick > 0 then seen := seen + 1 endif
default init s0:
	function seen = 0
";

fn queues(folder: &Path) -> PathBuf {
    std::fs::write(folder.join("source.asm"), SOURCE).unwrap();
    std::fs::write(folder.join("sink.asm"), SINK).unwrap();
    let text = r#"schema = "composite/1"
[composite]
name = "queues"
[components.Source]
implementation = { asm = "source.asm" }
activity = { period_ms = 5 }
publish = { tick = "builtin_interfaces/Time" }
[components.Source.bind.out]
n = { topic = "tick", field = "sec", publish = "on_update" }
[components.Sink]
implementation = { asm = "sink.asm" }
activity = { period_ms = 50 }
ports.in = { tick = "builtin_interfaces/Time" }
[components.Sink.bind.monitored]
tick = { topic = "tick", receive = "all", field = "sec", none = 0 }
[[connections]]
from = "topic:tick"
to = "Sink.tick"
policy = { type = "buffer", size = 100000 }
"#;
    let path = folder.join("queues.composite.toml");
    std::fs::write(&path, text).unwrap();
    path
}

fn run(composite: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("run").arg(composite);
    command.args([
        "--clock",
        "wall",
        "--for",
        "600",
        "--dashboard",
        "127.0.0.1:0",
    ]);
    command
}

/// The text of the row at the upper edge of the log.
const TOP: &str = "(() => { const box = document.querySelector('.log').getBoundingClientRect(); \
                   return document.elementFromPoint(box.left + 200, box.top + 4).closest('.row').querySelector('.text').textContent; })()";

/// Adds entries to the log, as if the server had sent them.
fn add(tab: &mut Tab, from: u32, count: u32) {
    tab.eval(&format!(
        "(() => {{ const log = []; for (let at = {from}; at < {from} + {count}; at++) log.push({{ t: asmotion.store.t, level: at % 2 ? 'notice' : 'warning', \
         kind: 'notice', component: `Worker${{at % 7}}`, text: `entry ${{at}} ${{at === 5 ? 'needle' : ''}}` }}); asmotion.store.note({{ log }}); asmotion.redraw(); }})()"
    ));
}

#[test]
fn a_long_log_has_the_rows_that_can_be_seen() {
    let Some(browser) = Browser::start() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let mission = RunningMission::run(&mut run(&queues(folder.path())));
    let mut tab = browser.open(&mission.url, WIDE, "light");
    tab.wait("asmotion.store.components.length");
    show(&mut tab, "logs");
    // fewer than the limit on rows, beyond which the oldest ones go, because the mission itself adds some
    add(&mut tab, 0, 95_000);
    tab.wait("parseInt(document.querySelector('.log-panel .head .faint').textContent) >= 95000");
    tab.wait("document.querySelector('.log').scrollHeight > 1.9e6");
    let rows = "document.querySelectorAll('.log .row').length";
    let few = |tab: &mut Tab| {
        let rows = tab.eval(rows).as_u64().unwrap();
        assert!((20..80).contains(&rows), "{rows}");
    };
    few(&mut tab);
    scrolls(&mut tab);
    few(&mut tab);
    keys(&mut tab);
    few(&mut tab);
    // the filter finds what the server does not keep any more
    tab.eval("document.activeElement.blur()");
    tab.key("/");
    tab.call("Input.insertText", json!({ "text": "needle" }));
    tab.wait(&format!(
        "{rows} === 1 && document.querySelector('.log .row').textContent.includes('entry 5 needle')"
    ));
    tab.screenshot("log_filtered");
    tab.eval("(() => { const it = document.querySelector('.log-panel input[type=search]'); it.value = ''; it.dispatchEvent(new Event('input')); it.blur(); })()");
    tab.wait("document.querySelector('.log').scrollHeight > 1.8e6");
    // new entries do not make it slow
    let share = tab.main_thread_share(Duration::from_secs(3));
    println!(
        "log of 95,000 entries: {:.1} % of the main thread",
        share * 100.0
    );
    assert!(share < 0.5, "{share}");
    // in a narrow window, each entry has two lines
    let mut narrow = browser.open(&mission.url, (480, 900), "dark");
    narrow.wait("asmotion.store.components.length");
    show(&mut narrow, "logs");
    add(&mut narrow, 0, 1000);
    narrow.wait("document.querySelector('.log').scrollHeight > 38000");
    narrow.screenshot("log_narrow");
    assert!(
        narrow
            .eval("document.documentElement.scrollWidth")
            .as_u64()
            .unwrap()
            <= 480
    );
    for tab in [&tab, &narrow] {
        assert_eq!(tab.errors, Vec::<String>::new());
    }
}

/// The wheel scrolls, and rows stay where they are while others come.
fn scrolls(tab: &mut Tab) {
    let place = tab.eval("(() => { const box = document.querySelector('.log').getBoundingClientRect(); return [box.left + 300, box.top + 200]; })()");
    tab.call(
        "Input.dispatchMouseEvent",
        json!({ "type": "mouseWheel", "x": place[0], "y": place[1], "deltaX": 0, "deltaY": 420_000 }),
    );
    tab.wait("document.querySelector('.log').scrollTop > 200000");
    let top = tab.wait(TOP);
    let number: u64 = top
        .as_str()
        .unwrap()
        .split(' ')
        .nth(1)
        .unwrap()
        .parse()
        .unwrap();
    assert!((70_000..95_000).contains(&number), "{top}");
    add(tab, 100_000, 500);
    std::thread::sleep(Duration::from_millis(600));
    assert_eq!(tab.wait(TOP), top);
    tab.screenshot("log_scrolled");
}

/// The keys go through the log, and show the time of an entry.
fn keys(tab: &mut Tab) {
    tab.eval("document.querySelector('.log').focus()");
    let focused = "document.activeElement.closest('.log .row')";
    tab.key("Home");
    tab.wait("document.querySelector('.log').scrollTop < 200");
    // repetitions of the newest entry take its place, and leave the focus there
    let steps = tab.eval("asmotion.store.stepCount").as_u64().unwrap();
    tab.wait(&format!("asmotion.store.stepCount > {steps} + 10"));
    assert_eq!(tab.eval(&format!("{focused} !== null")), true);
    tab.key("PageDown");
    tab.key("ArrowDown");
    tab.key("End");
    let after =
        format!("{focused}.getAttribute('aria-setsize') - {focused}.getAttribute('aria-posinset')");
    tab.wait(&format!("{after} === 0"));
    tab.key("ArrowUp");
    tab.wait(&format!("{after} === 1"));
    // more entries do not take the focus
    let words = tab.eval(&format!("{focused}.title"));
    add(tab, 101_000, 10);
    std::thread::sleep(Duration::from_millis(400));
    tab.wait(&format!("{focused}.title === {words}"));
    tab.key("Enter");
    tab.wait("asmotion.store.cursor !== null && document.querySelector('#banner').textContent.startsWith('Showing')");
    tab.wait(&format!(
        "document.querySelector('.log-detail').textContent === {words}"
    ));
    tab.screenshot("log_row");
    tab.key("Escape");
    tab.wait("asmotion.store.cursor === null");
}

#[test]
fn what_waits_is_on_the_connections_of_the_graph_live_and_in_a_recording() {
    let Some(browser) = Browser::start() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let mut command = run(&queues(folder.path()));
    command.arg("--control").arg("--record").arg(&file);
    let mut mission = RunningMission::run(&mut command);
    let mut tab = browser.open(&mission.url, WIDE, "light");
    tab.wait("asmotion.store.components.length === 2");
    show(&mut tab, "components");
    // the coordinator takes one message in each step, and keeps the others
    let inside = "/▤ [0-9]+ for later steps/.test(document.querySelector('.graph').textContent)";
    tab.wait(inside);
    tab.wait(&with_text(
        "#findings p.note",
        "events wait in Sink for a later step",
    ));
    tab.click(&with_text("#control button", "Arm control"));
    tab.wait("asmotion.control.armed");
    tab.eval("asmotion.control.wish('Sink', 'stop', 'stop Sink')");
    // while it does not run, they wait on the way to it
    let edge = "[...document.querySelectorAll('.graph .edge.waits .queue')].find((it) => Number(it.textContent.split('▤ ')[1]) > 100)";
    tab.wait(edge);
    tab.wait("[...document.querySelectorAll('.graph .edge title')].some((it) => /[0-9]+ waiting at Sink.tick/.test(it.textContent))");
    tab.wait(&with_text("#findings p.note", "wait at Sink.tick"));
    tab.click(&with_text("#components tbody tr", "Sink"));
    tab.wait(&with_text(".detail tr", "▤"));
    tab.screenshot("queues");
    let t = tab.eval("asmotion.store.t").as_f64().unwrap();
    assert_eq!(tab.errors, Vec::<String>::new());
    mission.interrupt();
    mission.wait();
    let shown = Shown::start(&file);
    let mut tab = browser.open(&shown.url, WIDE, "dark");
    tab.wait("asmotion.store.components.length === 2");
    show(&mut tab, "components");
    tab.eval(&format!("asmotion.seek({t})"));
    tab.wait(edge);
    tab.wait(inside);
    tab.screenshot("recording_queues");
    tab.eval("asmotion.seek(0)");
    tab.wait("document.querySelectorAll('.graph .edge').length === 1 && document.querySelectorAll('.graph .edge.waits').length === 0");
    // who stopped it is in its log
    show(&mut tab, "logs");
    tab.eval("asmotion.seek(null)");
    tab.wait(&with_text(".log .row.notice", "done: stop Sink"));
    tab.screenshot("recording_commands");
    assert_eq!(tab.errors, Vec::<String>::new());
}
