//! Several robots of one kind in one process.

use std::path::Path;
use std::process::Command;

use crate::browser::{Browser, Tab};
use crate::mission::RunningMission;
use crate::{WIDE, set_period, show, with_text};

/// A composite of this many arms and rovers, from one component with `for` each.
fn composite(folder: &Path) -> std::path::PathBuf {
    let specs = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs");
    let path = folder.join("several.composite.toml");
    let text = format!(
        r#"schema = "composite/1"
[composite]
name = "several"
[components.Arm]
for = "$a in 1..2"
implementation = {{ composite = "{specs}/youbot/youbot.composite.toml" }}
[components.Rover]
for = "$r in 1..2"
implementation = {{ composite = "{specs}/navigation/navigation.composite.toml" }}
"#,
        specs = specs.display()
    );
    std::fs::write(&path, text).unwrap();
    path
}

/// The interval between the samples of an arm as the server measures it, in ms.
fn interval(arm: u32) -> String {
    format!("1000 / asmotion.store.output.get('Arm{arm}/Driver/youBotDriver.jointStatus').hz")
}

#[test]
fn each_of_two_arms_has_its_joints_and_each_of_two_rovers_its_way() {
    let Some(browser) = Browser::start() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("run").arg(composite(folder.path())).args([
        "--clock",
        "wall",
        "--for",
        "600",
        "--control",
        "--dashboard",
        "127.0.0.1:0",
    ]);
    let mission = RunningMission::run(&mut command);
    let mut tab = browser.open(&mission.url, WIDE, "light");
    tab.wait("asmotion.store.components.length > 20");
    show(&mut tab, "components");
    for name in [
        "Arm1/Locomotor",
        "Arm2/Locomotor",
        "Rover1/RoverDriver",
        "Rover2/RoverDriver",
    ] {
        tab.wait(&with_text("#components tbody tr", name));
    }
    tab.screenshot("several_components");
    show(&mut tab, "overview");
    tab.wait("asmotion.store.samples.get('Rover1/RoverDriver.odom') && asmotion.store.samples.get('Rover2/RoverDriver.odom')");
    tab.screenshot("several_overview");
    joints(&mut tab);
    assert_eq!(tab.errors, Vec::<String>::new());
}

fn joints(tab: &mut Tab) {
    show(tab, "joints");
    tab.wait("document.querySelectorAll('#joints tbody tr').length === 5");
    tab.wait("[...document.querySelectorAll('#arm option')].map((it) => it.textContent).join() === 'Arm1/Driver/youBotDriver,Arm2/Driver/youBotDriver'");
    tab.click(&with_text("#control button", "Arm control"));
    tab.wait("asmotion.control.armed");
    tab.eval("(() => { const it = document.querySelector('#arm'); it.value = 'Arm2/Driver/youBotDriver.jointStatus'; it.dispatchEvent(new Event('change')); })()");
    tab.wait("document.querySelectorAll('.chart').length === 5 && document.querySelector('#apply').disabled === false");
    set_period(tab, 250);
    // the period of this arm, and not that of the other one
    tab.wait("Math.abs(parseFloat(document.querySelector('#measured').textContent) - 250) < 40");
    tab.wait(&format!(
        "Math.abs({} - 250) < 40 && Math.abs({} - 100) < 30",
        interval(2),
        interval(1)
    ));
    tab.screenshot("several_joints");
    tab.eval("(() => { const it = document.querySelector('#arm'); it.value = 'Arm1/Driver/youBotDriver.jointStatus'; it.dispatchEvent(new Event('change')); })()");
    tab.wait("Math.abs(parseFloat(document.querySelector('#measured').textContent) - 100) < 30");
}
