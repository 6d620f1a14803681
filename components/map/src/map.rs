//! A loaded map.

use asmotion_geometry::{Grid, ObstacleScene, Pose};

/// A map: the grid, and further contents of its file.
#[derive(Clone, Debug)]
pub struct Map {
    /// Occupancy grid, map frame.
    pub grid: Grid,
    /// Named places, in the order of the file.
    pub points: Vec<NamedPoint>,
    /// Position of the map frame's origin on Earth; `None` for maps in metres.
    pub origin: Option<LonLat>,
    /// Notes for the user about features that were left out.
    pub notes: Vec<String>,
}

/// A named place, such as a dock or a kitchen.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedPoint {
    /// Name as in the file.
    pub name: String,
    /// Position and heading, map frame; the heading is 0 unless the file specifies one.
    pub pose: Pose,
}

/// A position on Earth, WGS 84.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LonLat {
    /// Longitude, degrees east.
    pub longitude: f64,
    /// Latitude, degrees north.
    pub latitude: f64,
}

impl Map {
    /// A map that consists of a grid only.
    pub fn of(grid: Grid) -> Self {
        Self {
            grid,
            points: Vec::new(),
            origin: None,
            notes: Vec::new(),
        }
    }

    /// The place with this name.
    pub fn point(&self, name: &str) -> Option<&NamedPoint> {
        self.points.iter().find(|point| point.name == name)
    }

    /// The borders of the occupied cells, as a scene.
    pub fn scene(&self) -> ObstacleScene {
        ObstacleScene::around(&self.grid)
    }
}
