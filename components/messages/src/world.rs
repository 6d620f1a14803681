//! `world`: what stands in the simulated world, in the ground plane of the map frame, metres.

asmotion_datum::message! {
    /// A point of the ground plane.
    #[derive(Copy)]
    pub struct Vertex = "world/Vertex" {
        /// m.
        pub x: f64,
        /// m.
        pub y: f64,
    }

    /// A thin wall.
    #[derive(Copy)]
    pub struct Segment = "world/Segment" {
        /// One end.
        pub a: Vertex,
        /// The other end.
        pub b: Vertex,
    }

    /// A round thing.
    #[derive(Copy)]
    pub struct Disc = "world/Disc" {
        /// m, of the centre.
        pub x: f64,
        /// m, of the centre.
        pub y: f64,
        /// m.
        pub radius: f64,
    }

    /// A solid thing with straight sides.
    pub struct Polygon = "world/Polygon" {
        /// The corners in order, either way round; the last joins the first.
        pub vertices: Vec<Vertex>,
    }

    /// Everything a beam or a body can hit at one time.
    pub struct Scene = "world/Scene" {
        /// Grows whenever the rest changes.
        pub revision: u64,
        /// Walls.
        pub segments: Vec<Segment>,
        /// Round obstacles.
        pub discs: Vec<Disc>,
        /// Cornered obstacles and solid walls.
        pub polygons: Vec<Polygon>,
    }
}
