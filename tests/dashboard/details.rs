//! What can be looked into: ranges of charts and lanes, values and histories of locations, properties, samples, keys.

use crate::browser::Tab;
use crate::{show, with_text};

/// Presses at one place of an element, given as shares of its width and height, and releases at another.
fn drag(tab: &mut Tab, element: &str, (from, to): (f64, f64), row: f64) {
    let place = tab.wait(&format!(
        "(() => {{ const box = {element}.getBoundingClientRect(); return [box.left, box.top, box.width, box.height]; }})()"
    ));
    let number = |index: usize| place[index].as_f64().unwrap();
    let (y, x) = (number(1) + number(3) * row, |share: f64| {
        number(0) + number(2) * share
    });
    tab.mouse("mousePressed", x(from), y);
    tab.mouse("mouseMoved", x(f64::midpoint(from, to)), y);
    tab.mouse("mouseMoved", x(to), y);
    tab.mouse("mouseReleased", x(to), y);
}

/// A drag over a chart shows a range in all charts and in the lanes; a click moves the time that all views show.
pub fn chart_range(tab: &mut Tab) {
    show(tab, "joints");
    tab.wait("document.querySelectorAll('.chart .uplot').length > 3");
    // the line is drawn: the canvas has more colours than the grid
    tab.wait("(() => { const canvas = document.querySelector('.chart canvas'); const data = canvas.getContext('2d')\
              .getImageData(0, 0, canvas.width, canvas.height).data; for (let at = 0; at < data.length; at += 4) \
              if (data[at] === 0x1f && data[at + 1] === 0x5f && data[at + 2] === 0xbf) return true; })()");
    drag(
        tab,
        "document.querySelector('.chart .u-over')",
        (0.3, 0.6),
        0.5,
    );
    tab.wait(
        "document.querySelector('#banner').textContent.startsWith('Showing') && asmotion.range",
    );
    let range = tab
        .eval("asmotion.range[1] - asmotion.range[0]")
        .as_f64()
        .unwrap();
    assert!((range - 9.0).abs() < 1.0, "{range}");
    tab.screenshot("range");
    show(tab, "time");
    tab.wait("asmotion.shown(30)[0] === asmotion.range[0]");
    tab.key("Escape");
    tab.wait("asmotion.range === null && asmotion.store.cursor === null");
    show(tab, "joints");
    drag(
        tab,
        "document.querySelector('.chart .u-over')",
        (0.5, 0.5),
        0.5,
    );
    tab.wait("asmotion.store.cursor !== null && asmotion.range === null");
    let before = tab.eval("asmotion.store.cursor").as_f64().unwrap();
    // by keyboard, from sample to sample
    tab.eval("document.querySelector('.chart .plot').focus()");
    tab.key("ArrowLeft");
    tab.wait(&format!("asmotion.store.cursor < {before}"));
    tab.key("Escape");
    tab.wait("asmotion.store.cursor === null");
    tab.eval("document.activeElement.blur()");
}

/// The values of a location beneath the lanes.
pub fn values(tab: &mut Tab) {
    show(tab, "time");
    let choose = "(() => { const it = document.querySelector('#values'); it.value = 'Rover/ASMCoordinator mode'; it.dispatchEvent(new Event('change')); })()";
    tab.wait("[...document.querySelectorAll('#values option')].some((it) => it.value === 'Rover/ASMCoordinator mode')");
    tab.eval(choose);
    tab.wait("document.querySelector('.values .chart .now').textContent.length > 3");
    tab.screenshot("values");
    drag(tab, "document.querySelector('.lanes')", (0.4, 0.5), 0.5);
    tab.wait("asmotion.range !== null");
    tab.key("Escape");
    tab.wait("asmotion.range === null");
    tab.click("document.querySelector('.values .chart button')");
    tab.wait("document.querySelectorAll('.values .chart').length === 0");
}

/// Properties in words, and who has written a location.
pub fn properties_and_history(tab: &mut Tab) {
    show(tab, "spec");
    tab.wait("document.querySelectorAll('#properties p').length >= 5");
    tab.wait(&format!(
        "{}?.className.includes('fine')",
        with_text("#properties p", "ag(estop implies")
    ));
    // one run cannot show that something is impossible
    tab.wait(&format!(
        "{}?.textContent.startsWith('not watched')",
        with_text("#properties p", "ef(mode = ARRIVED)")
    ));
    tab.wait("document.querySelector('#coverage').textContent.includes('updates made')");
    tab.click(&with_text("#updates tbody tr", "mode"));
    tab.wait("document.querySelector('#history').textContent === 'history of mode'");
    let rows = "[...document.querySelectorAll('[aria-label=\"History of a location\"] tbody tr')]";
    tab.wait(&format!(
        "{rows}.length >= 3 && {rows}.at(-1).textContent.includes('IDLE')"
    ));
    tab.screenshot("history");
    // a row is a time
    tab.click(&format!("{rows}.at(-1)"));
    tab.wait("asmotion.store.cursor !== null && document.querySelector('#banner').textContent.startsWith('Showing')");
    // why it was made: the guards of that step, with the values that they had
    let guards = "[...document.querySelectorAll('#guards tbody tr')].map((it) => [...it.children].map((cell) => cell.textContent).join('; ')).join()";
    let all = "estop; ✗ false; estop = false; ,cancelArrived; ✗ false; cancelArrived = false; ,goalArrived; ✓ true; goalArrived = true; ,moving; ✗ false; moving = false; ";
    tab.wait(&format!(
        "{guards}.replace(/(command|mode|tries|, )+/g, '') === '{all}'"
    ));
    let step = tab.eval("document.querySelector('#step').textContent.split(' ')[1]");
    assert_eq!(
        tab.eval(
            "document.querySelector('section[aria-label^=Guards] h3').textContent.split(' ').at(-1)"
        ),
        step
    );
    tab.eval("document.querySelector('#guards').scrollIntoView({ block: 'center' })");
    tab.screenshot("guards");
    let first = tab.eval("asmotion.store.cursor").as_f64().unwrap();
    tab.eval("document.activeElement.blur()");
    tab.key("}");
    tab.wait(&format!("asmotion.store.cursor > {first}"));
    tab.key("{");
    tab.wait(&format!("asmotion.store.cursor === {first}"));
    tab.key("Escape");
    tab.wait("asmotion.store.cursor === null");
}

/// The newest sample of a port, and the filter of the graph.
pub fn samples(tab: &mut Tab) {
    show(tab, "components");
    tab.click(&with_text("#components tbody tr", "Rover/RoverDriver"));
    tab.wait("document.querySelector('.detail-panel strong').textContent === 'Rover/RoverDriver'");
    tab.click(&with_text(".detail tr", "odom"));
    tab.wait("document.querySelector('#sample').textContent.includes('orientation')");
    let filter = |tab: &mut Tab, words: &str| {
        tab.eval(&format!("(() => {{ const it = document.querySelector('.graph-panel input'); it.value = '{words}'; it.dispatchEvent(new Event('input')); }})()"));
    };
    filter(tab, "Arm !Operator");
    tab.wait("document.querySelectorAll('.graph .node').length === 4 && document.querySelectorAll('#components tbody tr').length === 4");
    filter(tab, "");
    tab.wait("document.querySelectorAll('.graph .node').length === 15");
}

/// Keys are listed, and are those of the list while it is open.
pub fn keys(tab: &mut Tab) {
    tab.eval("document.activeElement.blur()");
    tab.key("?");
    tab.wait("document.querySelector('#keys').open && document.querySelectorAll('#keys kbd').length > 12");
    tab.screenshot("keys");
    tab.key("1");
    std::thread::sleep(std::time::Duration::from_millis(200));
    assert_eq!(tab.eval("location.hash"), "#components");
    tab.key("?");
    tab.wait("!document.querySelector('#keys').open");
    tab.key("1");
    tab.wait("location.hash === '#overview'");
}

/// A distance on the map.
pub fn measure(tab: &mut Tab) {
    show(tab, "overview");
    tab.key("m");
    drag(
        tab,
        "document.querySelector('.map canvas')",
        (0.4, 0.6),
        0.5,
    );
    let measured = tab.wait("asmotion.map.measured && Math.hypot(asmotion.map.measured[1][0] - asmotion.map.measured[0][0], asmotion.map.measured[1][1] - asmotion.map.measured[0][1])");
    let expected =
        tab.eval("document.querySelector('.map canvas').clientWidth * 0.2 / asmotion.map.scale");
    let (measured, expected) = (measured.as_f64().unwrap(), expected.as_f64().unwrap());
    assert!((measured - expected).abs() < 0.1, "{measured} {expected}");
    tab.screenshot("measured");
    tab.key("Escape");
    tab.wait("asmotion.map.measured === null");
    // what is pinned comes first
    let first = "document.querySelector('.state-panel tbody tr:nth-child(2)')";
    let tries = with_text(".state-panel tbody tr", "tries");
    tab.click(&tries);
    tab.wait(&format!("{first}.textContent.startsWith('tries ★')"));
    tab.click(&tries);
    tab.wait(&format!("{first}.textContent.startsWith('mode')"));
}

/// Connections say how much goes over them.
pub fn traffic(tab: &mut Tab) {
    show(tab, "components");
    let odometry = "asmotion.store.output.get('Rover/RoverDriver.odom')";
    let amount = tab.wait(&format!(
        "{odometry}?.bytes > 100 && {odometry}.hz > 0 && [{odometry}.bytes, {odometry}.hz]"
    ));
    let [bytes, hz] = [0, 1].map(|index| amount[index].as_f64().unwrap());
    // position, orientation, velocities and two covariances of 36 numbers
    assert!(bytes > 300.0 && bytes < 3000.0 && hz < 200.0, "{amount}");
    tab.wait("[...document.querySelectorAll('.graph .edge text.bytes')].filter((it) => /^[\\d.]+ (k|M)?B\\/s$/.test(it.textContent)).length > 4");
    let edge = "[...document.querySelectorAll('.graph .edge title')].find((it) => it.textContent.startsWith('Rover/RoverDriver → ') && it.textContent.includes('odom'))";
    tab.wait(&format!(
        "/odom [\\d.]+ Hz, [\\d.]+ kB\\/s, [\\d.]+ s ago/.test({edge}?.textContent)"
    ));
    tab.screenshot("traffic");
}

/// Limits of a signal are bands in its charts, and what is beyond them is marked.
pub fn limits(tab: &mut Tab) {
    show(tab, "joints");
    let set = |tab: &mut Tab, limits: &str| {
        let wish = format!(
            "asmotion.control.wish('Arm/Driver/youBotDriver', {{ set: [['position_limits', {limits}]] }}, 'limits')"
        );
        assert_eq!(tab.eval(&wish), true);
    };
    tab.wait("document.querySelectorAll('.chart').length === 5");
    // a reading of the motor: those of the arm by default
    tab.wait("document.querySelector('#joints tbody tr').children[1].title.startsWith('fine from -2.950 to 2.950')");
    set(tab, "[[-0.001, 0.001]]");
    tab.wait("[...document.querySelectorAll('#joints tbody tr')].some((it) => it.children[1].textContent.startsWith('⚠'))");
    let band = "(() => { const canvas = document.querySelector('.chart canvas'); const data = canvas.getContext('2d')\
                .getImageData(0, 0, canvas.width, canvas.height).data; let count = 0; for (let at = 0; at < data.length; at += 4) \
                if (data[at] === 0xfb && data[at + 1] === 0xe4 && data[at + 2] === 0xe2) count++; return count; })()";
    tab.wait(&format!("{band} > 1000"));
    tab.screenshot("limits");
    set(tab, "[[-3, 3]]");
    tab.wait(&format!("{band} === 0"));
    tab.wait("[...document.querySelectorAll('#joints tbody tr')].every((it) => !it.children[1].textContent.startsWith('⚠'))");
}

/// A chart has every sample, whatever the rate of frames, also of a tab that nobody sees.
pub fn every_sample(tab: &mut Tab) {
    let name = "Arm/Driver/youBotDriver.jointStatus";
    crate::set_period(tab, 10);
    tab.wait("Math.abs(parseFloat(document.querySelector('#measured').textContent) - 10) < 5");
    let counts = format!(
        "[asmotion.store.samples.get('{name}').n, asmotion.store.series.get('{name}').length, asmotion.frames ?? 0, performance.now()]"
    );
    let read = |tab: &mut Tab| {
        let counts = tab.eval(&counts);
        [0, 1, 2, 3].map(|index| counts[index].as_f64().unwrap())
    };
    tab.eval("(() => { const take = asmotion.store.frame; asmotion.frames = 0; asmotion.store.frame = function (frame) { asmotion.frames++; take.call(this, frame); }; })()");
    let begin = read(tab);
    tab.wait(&format!(
        "asmotion.store.samples.get('{name}').n > {} + 150",
        begin[0]
    ));
    let shown = read(tab);
    assert_eq!(shown[0] - begin[0], shown[1] - begin[1]);
    let rate = |from: [f64; 4], to: [f64; 4]| (to[2] - from[2]) / (to[3] - from[3]) * 1e3;
    assert!(rate(begin, shown) < 21.0, "{shown:?} after {begin:?}");
    let hide = |tab: &mut Tab, hidden: bool| {
        tab.eval(&format!("Object.defineProperty(document, 'hidden', {{ get: () => {hidden}, configurable: true }})"));
        tab.eval("document.dispatchEvent(new Event('visibilitychange'))");
    };
    hide(tab, true);
    let begin = read(tab);
    tab.wait(&format!("asmotion.frames >= {} + 4", begin[2]));
    let hidden = read(tab);
    assert_eq!(hidden[0] - begin[0], hidden[1] - begin[1]);
    // those that were under way when it was hidden are among them
    assert!(hidden[3] - begin[3] > 1500.0, "{hidden:?} after {begin:?}");
    assert_eq!(tab.eval("asmotion.store.missed.samples"), 0);
    hide(tab, false);
    tab.eval("delete asmotion.store.frame");
    crate::set_period(tab, 40);
    tab.wait("Math.abs(parseFloat(document.querySelector('#measured').textContent) - 40) < 8");
}

/// A panel can stand still while the others go on.
pub fn still_panel(tab: &mut Tab) {
    show(tab, "overview");
    tab.click("document.querySelector('[aria-label=\"Pause Map\"]')");
    tab.wait("document.querySelectorAll('.map-panel .picture').length === 2");
    let (picture, twin) = (
        "document.querySelector('.map-panel dl.picture').textContent",
        "document.querySelector('.map-panel dl:not(.picture)').textContent",
    );
    let shown = tab.eval(picture);
    tab.wait(&format!("{twin} !== {picture}"));
    assert_eq!(tab.eval(picture), shown);
    tab.screenshot("still");
    tab.click("document.querySelector('[aria-label=\"Pause Map\"]')");
    tab.wait("document.querySelectorAll('.picture').length === 0");
}
