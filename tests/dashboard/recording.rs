//! The dashboard of a recording: each view at any time of a run that is over.

use std::io::{BufRead, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use asmotion_recording::{RecordingItem, RunReader};
use serde_json::Value;

use crate::browser::{Browser, Tab};
use crate::{WIDE, show, with_text};

const ROVER: &str = "Rover/ASMCoordinator";

/// The rover and the arm.
fn both() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/dashboard/both.composite.toml")
}

/// Records the rover and the arm in virtual time.
fn recorded(folder: &Path) -> PathBuf {
    let composite = both();
    let file = folder.join("run.mcap");
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command
        .arg("run")
        .arg(composite)
        .args(["--for", "40", "--until", "tries=3", "--unless", "tries=3"]);
    let output = command.arg("--record").arg(&file).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(file.exists(), "{said}");
    file
}

/// `asmotion dash`. Dropping this ends it.
pub struct Shown {
    process: Child,
    /// The printed address.
    pub url: String,
}

impl Shown {
    pub fn start(file: &Path) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command
            .arg("dash")
            .arg(file)
            .args(["--listen", "127.0.0.1:0"]);
        let mut process = command.stderr(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(process.stderr.take().unwrap()).lines();
        let url = loop {
            let line = lines.next().unwrap().unwrap();
            if line.trim_start().starts_with("Dashboard") {
                break line.split_whitespace().last().unwrap().to_owned();
            }
        };
        std::thread::spawn(move || lines.for_each(drop));
        Self { process, url }
    }
}

impl Drop for Shown {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The control state before and after a step that changes it.
type ModeUpdate = Option<(String, String)>;

/// What a file says, read without the dashboard.
struct Truth {
    /// Steps of the rover's coordinator: number, time in s, and the update of its control state.
    steps: Vec<(u64, f64, ModeUpdate)>,
    /// Odometry of the rover: time in s, and x.
    odometry: Vec<(f64, f64)>,
}

impl Truth {
    fn read(file: &Path) -> Self {
        let (mut steps, mut odometry) = (Vec::new(), Vec::new());
        for item in RunReader::open(file).unwrap() {
            match item {
                RecordingItem::Step { component, step } if component == ROVER => {
                    let cycle = step.cycle;
                    let mut updates = cycle.updates.into_iter();
                    let mode = updates.find(|it| it.location == "mode" && it.before != it.after);
                    let mode = mode.map(|it| (it.before, it.after));
                    steps.push((cycle.number, cycle.time_ns as f64 / 1e9, mode));
                }
                RecordingItem::Message { channel, at, data }
                    if channel.starts_with("topic/Rover/odom")
                        || channel == "port/Rover/RoverDriver.odom" =>
                {
                    let message: Value = serde_json::from_str(&data.json().unwrap()).unwrap();
                    let x = &message["pose"]["pose"]["position"]["x"];
                    odometry.push((at.seconds(), x.as_f64().unwrap()));
                }
                RecordingItem::Cut(reason) => panic!("{reason}"),
                RecordingItem::Step { .. }
                | RecordingItem::Message { .. }
                | RecordingItem::Text { .. }
                | RecordingItem::End(_) => {}
            }
        }
        Self { steps, odometry }
    }

    fn x_at(&self, t: f64) -> f64 {
        self.odometry
            .iter()
            .rfind(|(at, _)| *at <= t + 1e-9)
            .unwrap()
            .1
    }

    fn mode_at(&self, t: f64) -> &str {
        let until = self.steps.iter().take_while(|(_, at, _)| *at <= t + 1e-9);
        let mode = until.filter_map(|(_, _, mode)| mode.as_ref()).last();
        mode.map_or("IDLE", |(_, after)| after)
    }
}

/// Moves the line of time, as a hand does. The page adds it with the first frame that it draws after the recording has been received.
fn seek(tab: &mut Tab, t: f64) {
    tab.wait("document.querySelector('#moment') !== null");
    tab.eval(&format!(
        "(() => {{ const it = document.querySelector('#moment'); it.value = '{t}'; it.dispatchEvent(new Event('input')); }})()"
    ));
}

fn shows_mode(tab: &mut Tab, mode: &str) {
    tab.wait(&format!(
        "{}?.children[1].firstChild.textContent.replace(/[●○] /, '') === '{mode}'",
        "[...document.querySelectorAll('.state-panel tbody tr')].find((it) => it.textContent.startsWith('mode'))"
    ));
}

#[test]
fn each_view_shows_a_recording_at_any_time() {
    let Some(browser) = Browser::start() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let file = recorded(folder.path());
    let truth = Truth::read(&file);
    assert!(truth.steps.len() > 500 && truth.odometry.len() > 500);
    let mut shown = Shown::start(&file);
    let mut tab = browser.open(&shown.url, WIDE, "light");
    overview(&mut tab, &truth);
    specification(&mut tab, &truth);
    components(&mut tab, &truth);
    time(&mut tab);
    joints(&mut tab);
    logs(&mut tab);
    playing(&mut tab, &truth);
    reading_only(&mut tab);
    let address = shown
        .url
        .trim_start_matches("http://")
        .trim_end_matches('/')
        .to_owned();
    let mut dark = browser.open(&shown.url, WIDE, "dark");
    let mut narrow = browser.open(&shown.url, (480, 900), "light");
    for view in crate::VIEWS {
        for (tab, name) in [(&mut dark, "dark"), (&mut narrow, "narrow")] {
            tab.wait("asmotion.store.recording");
            show(tab, view);
            tab.wait("asmotion.store.samples.size > 0 && asmotion.store.steps.length > 0");
            seek(tab, 14.0);
            std::thread::sleep(std::time::Duration::from_millis(500));
            tab.screenshot(&format!("recording_{name}_{view}"));
        }
        let width = narrow.eval("document.documentElement.scrollWidth");
        assert!(width.as_u64().unwrap() <= 480, "{view}: {width}");
    }
    // the address has the view and the time
    assert_eq!(
        dark.wait("location.hash.endsWith('@14') && location.hash"),
        "#logs@14"
    );
    let mut again = browser.open(&format!("{}#spec@7.25", shown.url), WIDE, "light");
    again.wait("asmotion.store.cursor === 7.25 && document.querySelector('nav [aria-selected=true]').textContent.includes('Spec')");
    drop(again);
    let id = shown.process.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-INT", &id])
            .status()
            .unwrap()
            .success()
    );
    assert_eq!(shown.process.wait().unwrap().code(), Some(0));
    tab.wait("document.querySelector('#connection').textContent.includes('no connection')");
    for tab in [tab, dark, narrow] {
        let lost =
            |it: &&String| !it.contains("WebSocket") && !it.contains("ERR_CONNECTION_REFUSED");
        let errors: Vec<_> = tab.errors.iter().filter(lost).collect();
        assert!(errors.is_empty(), "{errors:?}");
        let own = ["http://", "ws://"].map(|scheme| format!("{scheme}{address}/"));
        let foreign =
            |it: &&String| !own.iter().any(|own| it.starts_with(own)) && *it != "about:blank";
        let foreign: Vec<_> = tab.requests.iter().filter(foreign).collect();
        assert!(foreign.is_empty(), "{foreign:?}");
    }
}

/// The map and the state at the end, in the middle and at the beginning.
fn overview(tab: &mut Tab, truth: &Truth) {
    tab.wait("asmotion.store.recording && asmotion.store.samples.get('Rover/MapServer.map')?.data.data.length > 1000");
    assert_eq!(
        tab.eval("document.querySelector('#connection').textContent"),
        "■ recording"
    );
    assert_eq!(tab.eval("document.querySelector('#banner').hidden"), true);
    shows_mode(tab, truth.mode_at(40.0));
    tab.screenshot("recording_end");
    for t in [20.0, 7.25, 31.5] {
        seek(tab, t);
        let x = truth.x_at(t);
        tab.wait(&format!("Math.abs(asmotion.store.samples.get('Rover/RoverDriver.odom').data.pose.pose.position.x - {x}) < 1e-6"));
        tab.wait(&format!(
            "document.querySelector('.twin').textContent.includes('{x:.2}, ')"
        ));
        shows_mode(tab, truth.mode_at(t));
        // the path ends where the rover is
        tab.wait("(() => { const [robot] = asmotion.map.robots(); const last = robot.trail.at(-1); return Math.hypot(last[1] - robot.pose[0], last[2] - robot.pose[1]) < 0.2; })()");
        assert_eq!(
            tab.eval("asmotion.store.samples.has('Rover/LaserDriver.scan')"),
            true
        );
    }
    tab.screenshot("recording_overview");
    // before anything happened
    tab.key("Home");
    tab.wait("asmotion.store.cursor === 0");
    shows_mode(tab, "IDLE");
}

/// The update set of any step, back and forth.
fn specification(tab: &mut Tab, truth: &Truth) {
    show(tab, "spec");
    for (number, t, mode) in truth.steps.iter().filter(|it| it.2.is_some()) {
        let (before, after) = mode.clone().unwrap();
        seek(tab, *t);
        tab.wait(&format!(
            "document.querySelector('#step').textContent === 'step {number} at {t:.2} s'"
        ));
        let row = with_text("#updates tbody tr", "mode");
        tab.wait(&format!("{row}?.children[1].textContent === '{before}'"));
        assert_eq!(
            tab.eval(&format!("{row}.children[2].textContent")),
            format!("● {after}")
        );
        tab.wait(&format!(
            "document.querySelector('.diagram .node.now text').textContent === '{after}'"
        ));
        // each of them can be repeated, with the reported updates
        tab.wait(&format!(
            "document.querySelector('section[aria-label^=Guards] h3').textContent === 'guards of step {number}' && [...document.querySelectorAll('#guards tbody tr')].some((it) => it.textContent.includes('mode'))"
        ));
    }
    tab.screenshot("recording_spec");
    // single steps, also over the end of what the tab has
    let middle = truth.steps.len() / 2;
    let (number, t, _) = truth.steps[middle];
    seek(tab, t);
    let is = |number: u64| {
        format!("document.querySelector('#step').textContent.startsWith('step {number} at')")
    };
    tab.wait(&is(number));
    for by in 1..=3 {
        tab.click(&with_text(".update-panel button", "◀ step"));
        tab.wait(&is(number - by));
    }
    tab.click(&with_text(".update-panel button", "step ▶"));
    tab.wait(&is(number - 2));
    let values = "JSON.stringify(asmotion.store.locationsAt('Rover/ASMCoordinator'))";
    let before = tab.eval(values);
    seek(tab, 1.0);
    tab.wait("asmotion.store.cursor === 1 && asmotion.store.stepAt('Rover/ASMCoordinator').t <= 1");
    seek(tab, truth.steps[middle - 2].1);
    tab.wait(&is(number - 2));
    tab.wait(&format!("{values} === {before}"));
}

/// Rates and ages of the shown time, what is not connected, and nothing to change.
fn components(tab: &mut Tab, truth: &Truth) {
    show(tab, "components");
    let odometry = "asmotion.store.output.get('Rover/RoverDriver.odom')";
    for t in [20.0, 33.37] {
        seek(tab, t);
        let until = |t: f64| truth.odometry.iter().filter(move |(at, _)| *at <= t + 1e-9);
        let (count, last) = (until(t).count(), until(t).next_back().unwrap().0);
        tab.wait(&format!("{odometry}.n === {count}"));
        let age = ((t - last) * 1000.0).round();
        assert_eq!(tab.eval(&format!("{odometry}.age_ms")).as_f64(), Some(age));
        let recent: Vec<f64> = until(t).rev().take(32).map(|(at, _)| *at).collect();
        let rate = 31.0 / (recent[0] - recent[31]);
        let shown = tab.eval(&format!("{odometry}.hz")).as_f64().unwrap();
        assert!((shown - rate).abs() < 1e-6, "{shown} {rate}");
    }
    tab.wait("document.querySelectorAll('#components tbody tr').length === 15");
    tab.wait("document.querySelectorAll('.graph .node').length === 15");
    let first = "document.querySelector('#components tbody tr').children[0].textContent";
    assert_eq!(tab.eval(first), "Rover/Operator");
    let row = with_text("#components tbody tr", ROVER);
    // the period that the composite asks for, and the measured one
    tab.wait(&format!(
        "{row}.children[2].textContent === '50' && {row}.children[3].textContent === '50.0'"
    ));
    assert_eq!(
        tab.eval(&format!("{row}.children[1].textContent")),
        "Running"
    );
    let edge = with_text(
        ".graph .edge title",
        "Rover/LaserDriver → Rover/CollisionMonitor",
    );
    // a scan has four bytes for each beam, and a header
    tab.wait(&format!(
        "/scan 20 Hz, [1-9]\\d kB\\/s, 0\\.\\d s ago/.test({edge}?.textContent)"
    ));
    tab.click(&with_text(
        "#components tbody tr",
        "Rover/TrajectoryFollower",
    ));
    tab.wait(
        "document.querySelector('.detail-panel strong').textContent === 'Rover/TrajectoryFollower'",
    );
    tab.wait(&with_text(".detail code", "deceleration"));
    assert_eq!(tab.eval("[...document.querySelectorAll('.detail button, .detail input')].every((it) => it.disabled)"), true);
    tab.click(&with_text(".detail tr", "odom"));
    tab.wait("document.querySelector('#sample').textContent.includes('orientation')");
    tab.screenshot("recording_components");
    // before the first message, nothing has come and nothing runs
    seek(tab, 0.0);
    tab.wait(&format!("{odometry}.n <= 1"));
    // after the last one of the arm's command, which is no regular output, nothing is stale
    seek(tab, 30.0);
    tab.wait(&with_text("#findings p.fine, #findings p.hint", " "));
    assert_eq!(
        tab.eval("document.querySelectorAll('#findings p.bad').length"),
        0
    );
}

fn time(tab: &mut Tab) {
    show(tab, "time");
    seek(tab, 12.0);
    tab.wait(
        "document.querySelector('.lanes canvas').width > 0 && asmotion.store.steps.length > 10",
    );
    std::thread::sleep(std::time::Duration::from_millis(400));
    tab.screenshot("recording_time");
    let place = tab.eval("(() => { const box = document.querySelector('.lanes').getBoundingClientRect(); return [box.left + box.width * 0.5, box.top + 200]; })()");
    let (x, y) = (place[0].as_f64().unwrap(), place[1].as_f64().unwrap());
    tab.mouse("mousePressed", x, y);
    tab.mouse("mouseReleased", x, y);
    tab.wait("asmotion.store.cursor !== 12");
    folded(tab);
}

/// Time at which a click into the lanes at this share of their width leads.
fn clicked(tab: &mut Tab, share: f64) -> f64 {
    let place = format!(
        "(() => {{ const box = document.querySelector('.lanes canvas').getBoundingClientRect(); return [box.left + 190 + (box.width - 208) * {share}, box.top + 120]; }})()"
    );
    let place = tab.eval(&place);
    let (x, y) = (place[0].as_f64().unwrap(), place[1].as_f64().unwrap());
    tab.mouse("mousePressed", x, y);
    tab.mouse("mouseReleased", x, y);
    tab.eval("asmotion.store.cursor").as_f64().unwrap()
}

/// Long stretches in which nothing happened take little room, and a click leads to the time that is shown there.
fn folded(tab: &mut Tab) {
    tab.eval("import('/folding.js').then((it) => { window.Folding = it.Folding; })");
    tab.wait("window.Folding");
    // two events, ten seconds, two events, the rest: of 100 s, the 46 s between the margins take 4 % of what is shown
    let folding = "(() => { const it = new Folding(0, 100).fold([1, 2, 12, 60, 61]); return [it.folds.length, it.length, it.to(12), it.from(it.to(40)), it.from(it.to(99)), it.hides(40), it.hides(61)]; })()";
    let expected = serde_json::json!([1, 56.25, 12.0, 40.0, 99.0, true, false]);
    let close = |(one, other): (&Value, &Value)| match (one.as_f64(), other.as_f64()) {
        (Some(one), Some(other)) => (one - other).abs() < 1e-6,
        _ => one == other,
    };
    let found = tab.eval(folding);
    let pairs = found
        .as_array()
        .unwrap()
        .iter()
        .zip(expected.as_array().unwrap());
    assert!(pairs.clone().all(close), "{found}");
    // the whole run, in which the rover drives for long without a change of its coordinator
    tab.eval("asmotion.zoom([0, asmotion.store.recording.end])");
    tab.wait("document.querySelector('#banner').textContent.includes('Showing 0.00 s')");
    tab.eval("document.querySelector('#fold').click()");
    std::thread::sleep(std::time::Duration::from_millis(600));
    tab.screenshot("recording_folded");
    let times: Vec<f64> = (0..20)
        .map(|tick| clicked(tab, f64::from(tick) / 20.0 + 0.01))
        .collect();
    let ways: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(ways.iter().all(|way| *way > 0.0), "{times:?}");
    let (least, most) = (
        ways.iter().copied().fold(f64::MAX, f64::min),
        ways.iter().copied().fold(0.0, f64::max),
    );
    assert!(most > 2.0 * least, "{times:?}");
    tab.eval("document.querySelector('#fold').click()");
    tab.eval("asmotion.zoom(null)");
}

fn joints(tab: &mut Tab) {
    show(tab, "joints");
    seek(tab, 15.0);
    tab.wait("document.querySelectorAll('#joints tbody tr').length === 5");
    tab.wait("(asmotion.store.series.get('Arm/Driver/youBotDriver.jointStatus') ?? []).some((it) => Math.abs(it.t - 15) < 0.2)");
    std::thread::sleep(std::time::Duration::from_millis(300));
    tab.screenshot("recording_joints");
}

fn logs(tab: &mut Tab) {
    show(tab, "logs");
    tab.wait("document.querySelectorAll('.log .row').length > 10");
    tab.wait(&with_text(".log .row", "planner.plan"));
    tab.screenshot("recording_logs");
    // a click moves all views
    tab.click(&with_text(".log .row", "planner.plan"));
    tab.wait("asmotion.store.cursor < 15");
    // the filter searches the whole run
    let filter = |tab: &mut Tab, words: &str| {
        tab.eval(&format!("(() => {{ const it = document.querySelector('.log-panel input[type=search]'); it.value = '{words}'; it.dispatchEvent(new Event('input')); }})()"));
    };
    seek(tab, 38.0);
    // an answer that was under way when the filter changed is not taken for one to the filter
    tab.eval("(() => { const { store } = asmotion; store.filter(['reply', 'planner.plan'], 'info'); store.window({ valid: [0, 1e6], filter: null, states: {}, history: [], log: [], calls: [], series: {} }); })()");
    filter(tab, "reply planner.plan");
    tab.wait("asmotion.store.found?.isKnown && asmotion.store.found.entries.length > 0 && asmotion.store.found.entries.every((it) => it.kind === 'reply' && it.text.startsWith('planner.plan'))");
    tab.wait("[...document.querySelectorAll('.log .row')].some((it) => it.textContent.includes('planner.plan'))");
    filter(tab, "");
    tab.wait(
        "asmotion.store.found === null && asmotion.store.log.some((it) => it.kind !== 'reply')",
    );
}

fn playing(tab: &mut Tab, truth: &Truth) {
    show(tab, "overview");
    seek(tab, 10.0);
    tab.wait("asmotion.store.cursor === 10");
    tab.eval("document.activeElement.blur()");
    tab.key(" ");
    tab.wait("asmotion.store.cursor > 11 && asmotion.store.cursor < 30");
    tab.key(" ");
    let t = tab
        .wait("document.querySelector('#play').textContent === '▶ Play' && asmotion.store.cursor");
    let x = truth.x_at(t.as_f64().unwrap());
    tab.wait(&format!("Math.abs(asmotion.store.samples.get('Rover/RoverDriver.odom').data.pose.pose.position.x - {x}) < 1e-6"));
    tab.key("End");
    tab.wait("asmotion.store.cursor === asmotion.store.recording.end");
}

fn reading_only(tab: &mut Tab) {
    assert_eq!(
        tab.eval(
            "document.querySelector('#stop').hidden && document.querySelector('#cancel').hidden"
        ),
        true
    );
    let problem = tab.eval(
        "asmotion.link.order({ type: 'publish', topic: 'Rover/estop', value: { data: true } })",
    );
    assert!(
        problem.as_str().unwrap().contains("shows the system only"),
        "{problem}"
    );
}

/// Of a run in which the driver of the arm was silent at a time: it is stale at that time, and was not before.
pub fn shows_what_was_silent(browser: &Browser, file: &Path, silent_at: f64) {
    let shown = Shown::start(file);
    let mut tab = browser.open(&shown.url, WIDE, "light");
    tab.wait("asmotion.store.recording");
    show(&mut tab, "components");
    seek(&mut tab, silent_at);
    tab.wait(&with_text(
        "#findings p.bad",
        "Arm/Driver/youBotDriver.jointStatus has been silent for",
    ));
    tab.wait(&with_text("#components .badge.stale", "stale"));
    tab.wait("document.querySelectorAll('.graph .edge.broken').length > 0");
    tab.screenshot("recording_stale");
    // what was set during the run has its value from then on
    tab.click(&with_text(
        "#components tbody tr",
        "Rover/TrajectoryFollower",
    ));
    let row = with_text(".detail tr", "max_speed");
    tab.wait(&format!("{row}?.querySelector('input').value === '0.45'"));
    seek(&mut tab, 3.0);
    tab.wait(&format!(
        "!{row} || {row}.querySelector('input').value !== '0.45'"
    ));
    tab.wait("document.querySelectorAll('#findings p.bad').length === 0");
    assert_eq!(tab.errors, Vec::<String>::new());
}

/// Of a run in which `Three` has replaced `Two`.
pub fn shows_each_version(browser: &Browser, file: &Path) {
    let shown = Shown::start(file);
    let mut tab = browser.open(&shown.url, WIDE, "light");
    tab.wait("asmotion.store.recording");
    show(&mut tab, "components");
    let rows = "[...document.querySelectorAll('#components tbody tr')].map((it) => it.children[0].textContent).join()";
    tab.wait(&format!("{rows} === 'One,Three'"));
    seek(&mut tab, 0.5);
    tab.wait(&format!("{rows} === 'One,Two'"));
    // the text, the locations and the control state of each time are those of the version that ran
    show(&mut tab, "spec");
    tab.eval("(() => { const it = document.querySelector('.source-panel select'); it.value = 'One'; it.dispatchEvent(new Event('change')); })()");
    let title = "document.querySelector('.source-panel .faint').textContent";
    tab.wait(&format!("{title}.includes('version 1 of 2, from 0.00 s')"));
    tab.wait("document.querySelector('.source').textContent.includes('said :=')");
    tab.wait("Object.keys(asmotion.store.locationsAt('One')).join() === 'n,said'");
    // its rules have no conditions
    let guards = "[...document.querySelectorAll('#guards tbody tr')].map((it) => it.textContent)";
    assert_eq!(
        tab.eval(&format!("{guards}.some((it) => it.includes('phase'))")),
        false
    );
    let end = tab.eval("asmotion.store.recording.end").as_f64().unwrap();
    seek(&mut tab, end);
    tab.wait(&format!("{title}.includes('version 2 of 2')"));
    tab.wait("document.querySelector('.source').textContent.includes('twice := 2 * n')");
    tab.wait("Object.keys(asmotion.store.locationsAt('One')).sort().join() === 'n,phase,twice'");
    // the guards of a step are those of the version that made it
    tab.wait(&format!(
        "{guards}.some((it) => it.includes('phase = ODD'))"
    ));
    // and the values before the replacement follow from the state in which it took place
    let from =
        "asmotion.store.system.specifications.filter((it) => it.component === 'One')[1].from";
    assert_eq!(tab.eval(&format!("asmotion.store.recording.changes.One.every(([t, before, after]) => t >= {from} && before !== after)")), true);
    let before = tab.eval(&format!(
        "Object.keys(asmotion.store.locationsAt('One', {from} - 0.05)).join()"
    ));
    assert_eq!(before, "n,said");
    show(&mut tab, "time");
    tab.screenshot("versions");
    assert_eq!(tab.errors, Vec::<String>::new());
}

#[test]
fn a_file_that_is_none_or_was_cut_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let dash = |file: &Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        let output = command.arg("dash").arg(file).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        (output.status.code(), said)
    };
    let (code, said) = dash(&folder.path().join("none.mcap"));
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("none.mcap` cannot be read"), "{said}");
    let text = folder.path().join("text.mcap");
    std::fs::write(&text, "no recording").unwrap();
    let (code, said) = dash(&text);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("this is no recording"), "{said}");
    // one without its end is shown up to there
    let Some(browser) = Browser::start() else {
        return;
    };
    let file = recorded(folder.path());
    let whole = std::fs::read(&file).unwrap();
    std::fs::write(&file, &whole[..whole.len() / 2]).unwrap();
    let shown = Shown::start(&file);
    let mut tab = browser.open(&shown.url, WIDE, "light");
    tab.wait("document.querySelector('#banner').textContent.startsWith('The recording is INCOMPLETE: the file is cut')");
    tab.wait("asmotion.store.recording.end > 1 && asmotion.store.recording.end < 39");
}

/// A recording opens where a property was violated.
#[test]
fn a_recording_opens_at_the_first_violation() {
    let Some(browser) = Browser::start() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let (composite, file) = (
        folder.path().join("counts.composite.toml"),
        folder.path().join("run.mcap"),
    );
    let specification = "asm counts\nimport StandardLibrary\nimport CTLLibrary\nsignature:\n  controlled n: Integer\n\
                         definitions:\n  main rule r_Main = n := n + 1\n  CTLSPEC ag(n < 20)\n\
                         default init s0:\n  function n = 0\n";
    std::fs::write(folder.path().join("counts.asm"), specification).unwrap();
    let text = "schema = \"composite/1\"\n[composite]\nname = \"counts\"\n[components.One]\n\
                implementation = { asm = \"counts.asm\" }\ntask = { period_ms = 100 }\n";
    std::fs::write(&composite, text).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("run").arg(&composite);
    let output = command
        .args(["--for", "10", "--record"])
        .arg(&file)
        .output();
    assert!(file.exists(), "{output:?}");
    let shown = Shown::start(&file);
    let mut tab = browser.open(&shown.url, WIDE, "light");
    // the step that makes it 20
    tab.wait("asmotion.store.cursor === 1.9");
    tab.wait(&with_text("#step, .state-panel td.value", "20"));
    tab.wait(&with_text(
        ".log .row.error",
        "violates CTLSPEC `ag(n < 20)`",
    ));
    // and is told to those who do not see it
    tab.wait("document.querySelector('#announcer').textContent.includes('violates CTLSPEC')");
    show(&mut tab, "spec");
    let property = with_text("#properties p.bad", "ag(n < 20)");
    tab.wait(&format!(
        "{property}?.textContent.startsWith('violated, first at 1.90 s')"
    ));
    tab.click("document.querySelector('#next-mark')");
    tab.wait("asmotion.store.cursor === 1.9");
    seek(&mut tab, 1.0);
    tab.wait("document.querySelectorAll('#properties p.fine').length === 1");
    assert_eq!(tab.errors, Vec::<String>::new());
}

/// The description of a recording that its dashboard serves.
fn description(file: &Path) -> Value {
    let shown = Shown::start(file);
    let address = shown
        .url
        .trim_start_matches("http://")
        .trim_end_matches('/');
    let mut stream = TcpStream::connect(address).unwrap();
    let request =
        format!("GET /api/system HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let (_, body) = answer.split_once("\r\n\r\n").unwrap();
    serde_json::from_str(body).unwrap()
}

#[test]
fn a_recording_for_ros_and_one_in_parts_are_shown_as_any_other() {
    let folder = tempfile::tempdir().unwrap();
    let record = |composite: &Path, more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command
            .arg("run")
            .arg(composite)
            .args(["--for", "20", "--json"]);
        let output = command.args(more).output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        let last: Value = serde_json::from_str(text.lines().last().unwrap()).unwrap();
        let paths = last["recording"]["paths"].as_array().unwrap().clone();
        let paths = paths
            .iter()
            .map(|path| PathBuf::from(path.as_str().unwrap()));
        paths.collect::<Vec<_>>()
    };
    let named = |name: &str| folder.path().join(name).display().to_string();
    let whole = record(&both(), &["--record", &named("run.mcap")]);
    let bag = record(
        &both(),
        &["--record", &named("bag.mcap"), "--record-for", "ros2"],
    );
    let text = format!(
        "schema = \"composite/1\"\nbase = \"{}\"\n[deploy]\nrecord = {{ dir = \"runs\", rotate_mb = 1 }}\n\
         processes = [{{ name = \"all\", components = [\"Rover\", \"Arm\"] }}]\n",
        both().display()
    );
    let divided = folder.path().join("divided.composite.toml");
    std::fs::write(&divided, text).unwrap();
    let parts = record(&divided, &[]);
    assert!(parts.len() > 2, "{parts:?}");
    let content = |file: &Path| {
        let mut system = description(file);
        let recording = system["recording"].as_object_mut().unwrap();
        recording.remove("file");
        system.as_object_mut().unwrap().remove("clock");
        system
    };
    let expected = content(&whole[0]);
    assert_eq!(expected["recording"]["end"], 20.0);
    assert_eq!(expected["recording"]["problem"], Value::Null);
    let trail = &expected["recording"]["trails"]["Rover/RoverDriver.odom"];
    assert!(trail.as_array().unwrap().len() > 50, "{trail}");
    let changes = &expected["recording"]["changes"][ROVER];
    assert_eq!(changes.as_array().unwrap().last().unwrap()[2], "FOLLOWING");
    assert!(content(&bag[0]) == expected, "the one for ROS differs");
    assert!(content(&parts[0]) == expected, "the one in parts differs");
    // a part that is missing is said, and what was before it is shown
    std::fs::remove_file(&parts[2]).unwrap();
    let cut = content(&parts[0]);
    let problem = cut["recording"]["problem"].as_str().unwrap();
    assert!(problem.contains(".part3.mcap` cannot be read"), "{problem}");
    assert!(cut["recording"]["end"].as_f64().unwrap() < 20.0);
    let later = content(&parts[1]);
    let problem = later["recording"]["problem"].as_str().unwrap();
    assert!(problem.starts_with("it begins with part 2"), "{problem}");
    // no specification began there, but their texts are in each part
    let rover = |system: &Value| {
        let all = system["specifications"].as_array().unwrap().clone();
        all.into_iter().find(|it| it["component"] == ROVER).unwrap()
    };
    assert_eq!(rover(&later), rover(&expected));
}
