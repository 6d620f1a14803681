//! A loaded map.

use asmotion_geometry::{Grid, ObstacleScene, Pose};

/// A map: the grid, and what else its file contains.
#[derive(Clone, Debug)]
pub struct Map {
    /// Occupancy, map frame.
    pub grid: Grid,
    /// Places with a name, in the order of the file.
    pub points: Vec<NamedPoint>,
    /// Position of the map frame's origin on Earth; none for maps in metres.
    pub origin: Option<LonLat>,
    /// Features that were left out, for people.
    pub notes: Vec<String>,
}

/// A place with a name: a dock, a kitchen.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedPoint {
    /// Its name.
    pub name: String,
    /// Where, and where to look, map frame; along x if the file does not say.
    pub pose: Pose,
}

/// A place on Earth, WGS 84.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LonLat {
    /// Degrees east.
    pub longitude: f64,
    /// Degrees north.
    pub latitude: f64,
}

impl Map {
    /// A map that is nothing but a grid.
    pub fn of(grid: Grid) -> Self {
        Self {
            grid,
            points: Vec::new(),
            origin: None,
            notes: Vec::new(),
        }
    }

    /// The place called `name`.
    pub fn point(&self, name: &str) -> Option<&NamedPoint> {
        self.points.iter().find(|point| point.name == name)
    }

    /// Scene of the map: the borders of its occupied cells.
    pub fn scene(&self) -> ObstacleScene {
        ObstacleScene::around(&self.grid)
    }
}
