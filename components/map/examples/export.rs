//! Saves a map in ROS's format, like map_saver: `cargo run -p asmotion-map --example export -- plan.geojson folder`.

use std::error::Error;
use std::path::Path;

use asmotion_map::{DiskFiles, MapSettings, load, ros};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, folder] = &arguments[..] else {
        return Err("expected a map and a folder".into());
    };
    let map = load(&DiskFiles, file, &MapSettings::default())?;
    let name = Path::new(file).file_stem().and_then(|stem| stem.to_str());
    let name = name.ok_or("the map's name is not text")?;
    let (yaml, png) = ros::save(&map.grid, &format!("{name}.png"))?;
    std::fs::write(Path::new(folder).join(format!("{name}.yaml")), yaml)?;
    std::fs::write(Path::new(folder).join(format!("{name}.png")), png)?;
    Ok(())
}
