//! The page: its files, which are part of the program.

/// Builds the table of files; a missing one does not compile.
macro_rules! files {
    ($($path:literal: $kind:literal,)+) => {
        &[$((concat!("/", $path), $kind, include_str!(concat!("page/", $path))),)+]
    };
}

/// The files of the page: path, type and content.
pub(crate) const FILES: &[(&str, &str, &str)] = files! {
    "chart.js": "text/javascript; charset=utf-8",
    "components.js": "text/javascript; charset=utf-8",
    "control.js": "text/javascript; charset=utf-8",
    "diagram.js": "text/javascript; charset=utf-8",
    "dom.js": "text/javascript; charset=utf-8",
    "findings.js": "text/javascript; charset=utf-8",
    "folding.js": "text/javascript; charset=utf-8",
    "graph.js": "text/javascript; charset=utf-8",
    "guards.js": "text/javascript; charset=utf-8",
    "help.js": "text/javascript; charset=utf-8",
    "icon.svg": "image/svg+xml",
    "index.html": "text/html; charset=utf-8",
    "joints.js": "text/javascript; charset=utf-8",
    "layers.js": "text/javascript; charset=utf-8",
    "link.js": "text/javascript; charset=utf-8",
    "location_history.js": "text/javascript; charset=utf-8",
    "log_list.js": "text/javascript; charset=utf-8",
    "log_rows.js": "text/javascript; charset=utf-8",
    "logs.js": "text/javascript; charset=utf-8",
    "main.js": "text/javascript; charset=utf-8",
    "map.js": "text/javascript; charset=utf-8",
    "overview.js": "text/javascript; charset=utf-8",
    "playback.js": "text/javascript; charset=utf-8",
    "properties.js": "text/javascript; charset=utf-8",
    "spec.js": "text/javascript; charset=utf-8",
    "state_table.js": "text/javascript; charset=utf-8",
    "store.js": "text/javascript; charset=utf-8",
    "style.css": "text/css; charset=utf-8",
    "time.js": "text/javascript; charset=utf-8",
    "values.js": "text/javascript; charset=utf-8",
    "vendor/LICENSE.uPlot": "text/plain; charset=utf-8",
    "vendor/uPlot.esm.js": "text/javascript; charset=utf-8",
    "vendor/uPlot.min.css": "text/css; charset=utf-8",
};

/// The file at a path; `/` is the page itself.
pub(crate) fn find(path: &str) -> Option<(&'static str, &'static str)> {
    let path = if path == "/" { "/index.html" } else { path };
    let found = FILES.iter().find(|(known, _, _)| *known == path)?;
    Some((found.1, found.2))
}
