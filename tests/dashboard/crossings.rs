//! What happens to an open tab: processes and brokers that restart, versions of the composite, many components, long and hostile texts.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use crate::browser::{Browser, Tab};
use crate::mission::RunningMission;
use crate::{WIDE, show, with_text};

/// Counts, and writes a text that looks like markup.
const WORKER: &str = "asm worker
import StandardLibrary
signature:
	controlled n: Integer
	controlled said: String
definitions:
	main rule r_Main =
		par
			n := n + 1
			said := \"<img src=x onerror='window.hacked=true'>\"
		endpar
default init s0:
	function n = 0
	function said = \"\"
";

/// A later version of it, in which lines have moved, a location is gone and another one is there.
const EDITED: &str = "asm worker
import StandardLibrary
signature:
	enum domain Phase = {ODD | EVEN}
	controlled n: Integer
	controlled twice: Integer
	controlled phase: Phase
definitions:
	main rule r_Main =
		par
			n := n + 1
			twice := 2 * n
			if phase = ODD then
				phase := EVEN
			else
				phase := ODD
			endif
		endpar
default init s0:
	function n = 0
	function twice = 7
	function phase = ODD
";

/// A composite of workers.
fn workers(folder: &Path, names: &[String]) -> PathBuf {
    std::fs::write(folder.join("worker.asm"), WORKER).unwrap();
    let composite = folder.join("workers.composite.toml");
    std::fs::write(&composite, composite_of(names)).unwrap();
    composite
}

fn composite_of(names: &[String]) -> String {
    let mut text = "schema = \"composite/1\"\n[composite]\nname = \"workers\"\n".to_owned();
    for name in names {
        let _ = write!(
            text,
            "[components.{name}]\nimplementation = {{ asm = \"worker.asm\" }}\ntask = {{ period_ms = 200 }}\n"
        );
    }
    text
}

fn run(composite: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command
        .arg("run")
        .arg(composite)
        .args(["--clock", "wall", "--for", "600"])
        .args(more);
    command
}

/// Checks that a page is without errors, except that its process may have been away.
pub fn is_clean(tab: &Tab) {
    // a process that is away refuses connections
    let away = |it: &&String| !it.contains("WebSocket") && !it.contains("ERR_CONNECTION");
    let errors: Vec<_> = tab.errors.iter().filter(away).collect();
    assert!(errors.is_empty(), "{errors:?}");
}

#[test]
fn a_tab_follows_a_process_that_restarts_and_does_not_mix_its_runs() {
    let Some(browser) = Browser::start() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let composite = workers(folder.path(), &["One".to_owned()]);
    let first = RunningMission::run(&mut run(
        &composite,
        &["--control", "--dashboard", "127.0.0.1:0"],
    ));
    let mut tab = browser.open(&first.url, WIDE, "light");
    let n = "Number(asmotion.store.states.One?.locations.n?.value ?? 0)";
    tab.wait(&format!("{n} > 15"));
    frozen(&mut tab);
    tab.click(&with_text("#control button", "Arm control"));
    tab.wait("document.querySelector('#armed')");
    let address = first.address().to_owned();
    tab.eval("asmotion.store.stepsOf('One').forEach((it) => { it.isOld = true; })");
    drop(first);
    tab.wait("document.body.classList.contains('lost')");
    // what it may do is not known while nobody answers
    tab.wait("[...document.querySelectorAll('#control button')].every((it) => it.disabled)");
    let second = RunningMission::run(&mut run(
        &composite,
        &["--control", "--dashboard", &address],
    ));
    tab.wait("!document.body.classList.contains('lost') && document.querySelector('#connection').textContent.includes('live')");
    // from the first step on, and none of the old run
    tab.wait("asmotion.store.stepsOf('One').length > 3 && asmotion.store.stepsOf('One').every((it, index) => !it.isOld && it.step.number === index + 1)");
    // it was armed at the old one: it is not any more, and the cookie of the old one is of no use
    assert_eq!(tab.eval("asmotion.control.armed"), false);
    tab.wait("asmotion.store.permission === 'free' && !asmotion.store.known");
    // the new process does not know the token of the old one
    tab.click(&with_text("#control button", "Arm control"));
    tab.wait("document.querySelector('#outcome.bad').textContent.includes('token')");
    tab.wait("document.querySelector('#control').textContent.includes('not logged in')");
    // and its own address gives the new one to the same tab
    tab.call("Page.navigate", serde_json::json!({ "url": second.url }));
    tab.wait("location.hash === '#overview'");
    tab.click(&with_text("#control button", "Arm control"));
    tab.wait("document.querySelector('#armed')");
    // the new cookie has taken the place of the old one
    tab.call("Page.reload", serde_json::json!({}));
    tab.wait("asmotion.store.known && asmotion.control.token === null && asmotion.control.isKnown");
    tab.click(&with_text("#control button", "Arm control"));
    tab.wait("document.querySelector('#armed')");
    is_clean(&tab);
}

/// A tab that stands still for a while continues with the present, not with what it has missed.
fn frozen(tab: &mut Tab) {
    let before = tab.eval("asmotion.store.t").as_f64().unwrap();
    // nothing else runs in the tab meanwhile, also no message arrives
    tab.eval(
        "(() => { const end = performance.now() + 4000; while (performance.now() < end); })()",
    );
    tab.wait(&format!("asmotion.store.t > {before} + 3.5"));
    tab.wait("!document.body.classList.contains('lost') && document.querySelector('#connection').textContent.includes('live')");
    // the steps that it missed follow in one frame, so that the history has no gap
    tab.wait("asmotion.store.stepsOf('One').every((it, index, all) => !index || it.step.number === all[index - 1].step.number + 1)");
}

#[test]
fn fifty_components_with_long_names_and_hostile_values_are_shown() {
    let Some(browser) = Browser::start() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let long = "A".repeat(60);
    let mut names: Vec<String> = (1..50).map(|number| format!("Worker{number}")).collect();
    names.push(long.clone());
    let composite = workers(folder.path(), &names);
    let mission = RunningMission::run(&mut run(&composite, &["--dashboard", "127.0.0.1:0"]));
    let mut wide = browser.open(&mission.url, WIDE, "light");
    let mut narrow = browser.open(&mission.url, (480, 900), "dark");
    for view in crate::VIEWS {
        for (tab, width) in [(&mut wide, WIDE.0), (&mut narrow, 480)] {
            tab.wait("asmotion.store.components.length === 50");
            show(tab, view);
            std::thread::sleep(Duration::from_millis(500));
            let shown = tab
                .eval("document.documentElement.scrollWidth")
                .as_u64()
                .unwrap();
            assert!(shown <= u64::from(width), "{view}: {shown}");
            tab.screenshot(&format!("many_{view}_{width}"));
        }
    }
    for tab in [&mut wide, &mut narrow] {
        show(tab, "components");
        tab.wait("document.querySelectorAll('.graph .node').length === 50");
        tab.wait(&with_text("#components tr", &long));
        show(tab, "overview");
        tab.wait(&with_text(".state-panel td.value", "<img src=x"));
        show(tab, "spec");
        tab.click(&with_text("#updates tbody tr", "said"));
        tab.wait(&with_text(
            "[aria-label=\"History of a location\"] td",
            "<img src=x",
        ));
        show(tab, "time");
        // all lanes can be scrolled to
        tab.wait("document.querySelector('.lanes').clientHeight >= 50 * 20");
        assert_eq!(
            tab.eval("document.querySelector('img') === null && window.hacked === undefined"),
            true
        );
        assert_eq!(tab.errors, Vec::<String>::new());
    }
}

#[test]
fn a_tab_follows_a_new_version_of_the_composite_and_a_broker_that_restarts() {
    let Some(browser) = Browser::start() else {
        return;
    };
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let names = |all: &[&str]| all.iter().map(|it| (*it).to_owned()).collect::<Vec<_>>();
    let composite = workers(folder.path(), &names(&["One", "Two"]));
    let vhost = broker.vhost().unwrap();
    let url = vhost.url();
    let file = folder.path().join("run.mcap");
    let mut command = run(
        &composite,
        &["--bus", &url, "--dashboard", "127.0.0.1:0", "--record"],
    );
    command
        .arg(&file)
        .env("ASMOTION_PASSWORD", broker.password());
    let mut mission = RunningMission::run(&mut command);
    let mut tab = browser.open(&mission.url, WIDE, "light");
    tab.wait("asmotion.store.components.length");
    show(&mut tab, "components");
    let rows = "[...document.querySelectorAll('#components tbody tr')].map((it) => it.children[0].textContent).join()";
    tab.wait(&format!("{rows} === 'One,Two'"));
    tab.wait("asmotion.store.steps.length > 10");
    std::fs::write(&composite, composite_of(&names(&["One", "Three"]))).unwrap();
    let reconfigure = |composite: &Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command
            .arg("reconfigure")
            .arg(composite)
            .args(["--bus", &url])
            .env("ASMOTION_PASSWORD", broker.password());
        let output = command.output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
    };
    reconfigure(&composite);
    tab.wait(&format!("{rows} === 'One,Three'"));
    tab.wait("document.querySelectorAll('.graph .node').length === 2");
    // its steps are shown, and a lane is its own
    tab.wait("asmotion.store.stepsOf('Three').length > 2");
    show(&mut tab, "time");
    std::thread::sleep(Duration::from_millis(300));
    tab.screenshot("reconfigured");
    replaced_text(&mut tab, reconfigure);
    broker.kill().unwrap();
    let before = tab.eval("asmotion.store.steps.length").as_u64().unwrap();
    // coordination goes on without it, and the tab sees that
    tab.wait(&format!("asmotion.store.steps.length > {before} + 5"));
    assert_eq!(tab.eval("document.body.classList.contains('lost')"), false);
    broker.revive().unwrap();
    is_clean(&tab);
    mission.interrupt();
    mission.wait();
    crate::recording::shows_each_version(&browser, &file);
}

/// The text of a specification is replaced while it runs, from a folder as of another machine: the tab shows the text that runs, and
/// counts the updates of its lines alone.
fn replaced_text(tab: &mut Tab, reconfigure: impl Fn(&Path)) {
    let value = |location: &str| {
        format!("Number(asmotion.store.states.One?.locations['{location}']?.value ?? -1)")
    };
    tab.wait(&format!("{} > 25", value("n")));
    let elsewhere = tempfile::tempdir().unwrap();
    let names = ["One", "Three"].map(str::to_owned);
    let composite = workers(elsewhere.path(), &names);
    std::fs::write(elsewhere.path().join("worker.asm"), EDITED).unwrap();
    reconfigure(&composite);
    show(tab, "spec");
    tab.wait("document.querySelector('.source').textContent.includes('twice := 2 * n')");
    tab.wait(&format!("{} > 60", value("twice")));
    // what was counted belongs to the text before it
    let most = "Math.max(...Object.values(asmotion.store.states.One.heat))";
    let counts = tab.eval(&format!(
        "[{most}, {}, asmotion.store.states.One.heat]",
        value("n")
    ));
    let [most, n] = [0, 1].map(|index| counts[index].as_u64().unwrap());
    assert!(most + 20 < n, "{counts}");
    assert_eq!(
        tab.eval("asmotion.store.states.One.locations.said === undefined"),
        true
    );
}
