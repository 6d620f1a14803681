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
