//! `world`: obstacles of the simulated world, in the ground plane of the map frame, in metres.

use asmotion_datum::DatumError;

use crate::plausible::{LARGEST_POSITION, bounded, positive};

asmotion_datum::message! {
    /// A point of the ground plane.
    #[derive(Copy)]
    pub struct Vertex = "world/Vertex", check = check_vertex {
        /// x coordinate, m.
        pub x: f64,
        /// y coordinate, m.
        pub y: f64,
    }

    /// A thin wall.
    #[derive(Copy)]
    pub struct Segment = "world/Segment" {
        /// First end of the wall.
        pub a: Vertex,
        /// Second end of the wall.
        pub b: Vertex,
    }

    /// A round obstacle.
    #[derive(Copy)]
    pub struct Disc = "world/Disc", check = check_disc {
        /// x coordinate of the centre, m.
        pub x: f64,
        /// y coordinate of the centre, m.
        pub y: f64,
        /// Radius, m.
        pub radius: f64,
    }

    /// The place that a rover takes.
    pub struct RoverDisc = "world/RoverDisc" {
        /// Name of the rover among those of its world.
        pub rover: String,
        /// Disc that covers the rover.
        pub disc: Disc,
    }

    /// The places of all rovers of a world.
    pub struct RoverDiscs = "world/RoverDiscs" {
        /// One for each rover, in the order of their names.
        pub rovers: Vec<RoverDisc>,
    }

    /// A solid obstacle with straight sides.
    pub struct Polygon = "world/Polygon" {
        /// Corners in order, in either orientation; the last is connected to the first.
        pub vertices: Vec<Vertex>,
    }

    /// All obstacles of the world at one time.
    pub struct Scene = "world/Scene" {
        /// Incremented by every change of the scene.
        pub revision: u64,
        /// Thin walls.
        pub segments: Vec<Segment>,
        /// Round obstacles.
        pub discs: Vec<Disc>,
        /// Polygonal obstacles and solid walls.
        pub polygons: Vec<Polygon>,
    }
}

fn check_vertex(vertex: &Vertex) -> Result<(), DatumError> {
    bounded("x", vertex.x, LARGEST_POSITION)?;
    bounded("y", vertex.y, LARGEST_POSITION)
}

fn check_disc(disc: &Disc) -> Result<(), DatumError> {
    bounded("x", disc.x, LARGEST_POSITION)?;
    bounded("y", disc.y, LARGEST_POSITION)?;
    positive("radius", disc.radius, LARGEST_POSITION)
}
