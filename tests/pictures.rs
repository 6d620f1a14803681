//! The pictures in the README are drawn from real runs. If a run has changed, its picture must be redrawn
//! (`UPDATE_PICTURES=1 ./test pictures`) and reviewed.

use asmotion::mission::{Mission, MissionOutcome};
use asmotion_messages::{OccupancyGrid, Odometry, Path as Route, Point, Scene};
use asmotion_runtime::Event;
use std::fmt::Write;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

pub fn picture(name: &str, drawn: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("docs")
        .join(name);
    if std::env::var_os("UPDATE_PICTURES").is_some() {
        return std::fs::write(path, drawn).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        kept == drawn,
        "docs/{name} shows another run: UPDATE_PICTURES=1 ./test pictures"
    );
}

#[test]
fn the_terminal_is_what_the_demo_prints() {
    let output = assert_cmd::Command::new(env!("CARGO_BIN_EXE_asmotion"))
        .args(["demo", "--speed", "0", "--color", "always"])
        .output()
        .unwrap();
    let story = String::from_utf8(output.stderr).unwrap();
    let result = String::from_utf8(output.stdout).unwrap();
    // the duration differs each time
    let story = story
        .lines()
        .filter(|line| !line.contains("of wall-clock time"));
    let text = format!(
        "$ asmotion demo --speed 0\n{}{result}",
        story.map(|line| format!("{line}\n")).collect::<String>()
    );
    let terminal = anstyle_svg::Term::new().min_width_px(760).render_svg(&text);
    picture("demo.svg", &terminal);
}

/// The parts of a mission that are drawn.
#[derive(Default)]
struct Seen {
    map: Option<OccupancyGrid>,
    scene: Option<Scene>,
    routes: Vec<Route>,
    track: Vec<Point>,
}

#[test]
fn the_plan_is_what_the_demo_drove() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/navigation");
    let mut mission = Mission::new(
        folder
            .join("navigation.composite.toml")
            .display()
            .to_string(),
    );
    let obstacles = asmotion_datum::json::decode(asmotion::BLOCKED_CORRIDOR).unwrap();
    mission
        .properties
        .push(("World".to_owned(), "obstacles".to_owned(), obstacles));
    let seen = Arc::new(Mutex::new(Seen::default()));
    let watcher = seen.clone();
    let ended = mission
        .run(
            |_, _| (),
            move |_, event, _| watcher.lock().unwrap().see(event),
            &AtomicBool::new(false),
        )
        .unwrap();
    assert_eq!(ended.outcome, MissionOutcome::Reached);
    let seen = seen.lock().unwrap();
    picture("mission.svg", &draw(&seen));
}

impl Seen {
    fn see(&mut self, event: &Event<'_>) {
        match event {
            Event::Published { sample, .. } => {
                if let Some(odometry) = sample.downcast_ref::<Odometry>() {
                    self.track.push(odometry.pose.pose.position);
                }
                if let Some(scene) = sample.downcast_ref::<Scene>() {
                    self.scene = Some(scene.clone());
                }
            }
            Event::Answered {
                result: Ok(sample), ..
            } => {
                if let Some(map) = sample.downcast_ref::<OccupancyGrid>() {
                    self.map = Some(map.clone());
                }
                if let Some(route) = sample.downcast_ref::<Route>() {
                    self.routes.push(route.clone());
                }
            }
            Event::Cycle { .. }
            | Event::Injected { .. }
            | Event::Called { .. }
            | Event::Answered { .. }
            | Event::Replied { .. }
            | Event::LifeCycle { .. }
            | Event::Fault { .. }
            | Event::Overrun { .. }
            | Event::Late { .. }
            | Event::Denied { .. }
            | Event::Dropped { .. }
            | Event::Property { .. }
            | Event::Report { .. }
            | Event::Lost { .. } => {}
        }
    }
}

/// Pixels per metre.
const SCALE: f64 = 30.0;

fn draw(seen: &Seen) -> String {
    let map = seen.map.as_ref().unwrap();
    let (width, height) = (map.info.width as usize, map.info.height as usize);
    let cell = f64::from(map.info.resolution) * SCALE;
    let (across, down) = (width as f64 * cell, height as f64 * cell);
    let at = |point: &Point| {
        let x = (point.x - map.info.origin.position.x) * SCALE;
        let y = down - (point.y - map.info.origin.position.y) * SCALE;
        format!("{x:.1},{y:.1}")
    };
    let line = |points: &mut dyn Iterator<Item = Point>| {
        points.map(|point| at(&point)).collect::<Vec<_>>().join(" ")
    };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {across:.0} {down:.0}\" role=\"img\">\n\
         <title>The demo: the rover's way through the office</title>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n<g fill=\"#3b4252\">\n"
    );
    for (left, bottom, right, top) in rectangles(map, width, height) {
        let (x, y) = (left as f64 * cell, down - top as f64 * cell);
        let (w, h) = ((right - left) as f64 * cell, (top - bottom) as f64 * cell);
        writeln!(
            svg,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" height=\"{h:.1}\"/>"
        )
        .unwrap();
    }
    svg += "</g>\n";
    for disc in &seen.scene.as_ref().unwrap().discs {
        let centre = Point {
            x: disc.x,
            y: disc.y,
            z: 0.0,
        };
        let (x, y) = at(&centre)
            .split_once(',')
            .map(|(x, y)| (x.to_owned(), y.to_owned()))
            .unwrap();
        let radius = disc.radius * SCALE;
        writeln!(
            svg,
            "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius:.1}\" fill=\"#d08770\"/>"
        )
        .unwrap();
    }
    for polygon in &seen.scene.as_ref().unwrap().polygons {
        let mut corners = polygon.vertices.iter().map(|vertex| Point {
            x: vertex.x,
            y: vertex.y,
            z: 0.0,
        });
        writeln!(
            svg,
            "<polygon points=\"{}\" fill=\"#d08770\"/>",
            line(&mut corners)
        )
        .unwrap();
    }
    for route in &seen.routes {
        let mut poses = route.poses.iter().map(|pose| pose.pose.position);
        let dashes = "fill=\"none\" stroke=\"#88c0d0\" stroke-width=\"3\" stroke-dasharray=\"8 6\"";
        writeln!(svg, "<polyline points=\"{}\" {dashes}/>", line(&mut poses)).unwrap();
    }
    // ten points per second suffice
    let mut track = seen.track.iter().step_by(5).copied();
    let solid = "fill=\"none\" stroke=\"#bf616a\" stroke-width=\"4\" stroke-linejoin=\"round\"";
    writeln!(svg, "<polyline points=\"{}\" {solid}/>", line(&mut track)).unwrap();
    for (point, colour) in [
        (seen.track.first(), "#5e81ac"),
        (seen.track.last(), "#a3be8c"),
    ] {
        let place = at(point.unwrap());
        let (x, y) = place.split_once(',').unwrap();
        writeln!(
            svg,
            "<circle cx=\"{x}\" cy=\"{y}\" r=\"9\" fill=\"{colour}\"/>"
        )
        .unwrap();
    }
    svg + "</svg>\n"
}

/// The occupied cells as few rectangles: left, bottom, right, top, in cells.
fn rectangles(
    map: &OccupancyGrid,
    width: usize,
    height: usize,
) -> Vec<(usize, usize, usize, usize)> {
    let mut open: Vec<bool> = map.data.iter().map(|&cell| cell >= 65).collect();
    let mut found = Vec::new();
    for bottom in 0..height {
        for left in 0..width {
            if !open[bottom * width + left] {
                continue;
            }
            let right = (left..width)
                .find(|&x| !open[bottom * width + x])
                .unwrap_or(width);
            let full = |y: usize| {
                open[y * width + left..y * width + right]
                    .iter()
                    .all(|&cell| cell)
            };
            let top = (bottom..height).find(|&y| !full(y)).unwrap_or(height);
            for y in bottom..top {
                open[y * width + left..y * width + right].fill(false);
            }
            found.push((left, bottom, right, top));
        }
    }
    found
}
