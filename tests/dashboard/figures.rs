//! What the page costs a browser.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use crate::browser::Browser;
use crate::mission::RunningMission;
use crate::{WIDE, show};

/// Time over which a view is measured.
const SPAN: Duration = Duration::from_secs(10);

/// Without a graphics processor, the Overview of the demo's mission takes at most a quarter of the time of the page's main thread. Its
/// processor time is counted, so that other processes matter little.
#[test]
fn the_overview_leaves_three_quarters_of_the_main_thread() {
    let Some(browser) = Browser::start() else {
        return;
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let composite = root.join("specs/navigation/navigation.composite.toml");
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
    let mission = RunningMission::run(&mut command);
    let mut tab = browser.open(&mission.url, WIDE, "light");
    tab.wait("asmotion.store.states.ASMCoordinator?.locations.mode?.value === 'FOLLOWING'");
    let mut shares = Vec::new();
    for view in crate::VIEWS {
        show(&mut tab, view);
        std::thread::sleep(Duration::from_secs(1));
        let share = tab.main_thread_share(if *view == "overview" { SPAN } else { SPAN / 3 });
        println!("{view}: {:.1} % of the main thread", share * 100.0);
        shares.push(share);
    }
    assert!(shares[0] > 0.01 && shares[0] < 0.25, "{shares:?}");
    assert_eq!(tab.errors, Vec::<String>::new());
}
