//! Scenes of walls, solids and discs for ray casting and clearance. The only user of parry2d.
//!
//! parry2d computes in 32-bit floats: within a kilometre of the map's origin the error stays below 0.1 mm.

use parry2d::bounding_volume::Aabb;
use parry2d::math::{Pose as Isometry, Vector as Glam};
use parry2d::partitioning::{Bvh, BvhBuildStrategy, BvhNode};
use parry2d::query::{PointQuery, Ray, RayCast};
use parry2d::shape::{Ball, Segment, Shape};
use parry2d::utils::point_in_poly2d;
use serde::{Deserialize, Serialize};

use crate::pose::{Point, Vector};

/// A round obstacle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RoundObstacle {
    /// Centre, map frame, m.
    pub centre: Point,
    /// Radius, m; a disc without a positive radius hits nothing.
    pub radius: f64,
}

/// Segments, solid polygons and discs in the map frame, indexed for fast queries.
///
/// A shape with a coordinate that is not finite, a polygon with less than three corners and a disc without a radius
/// are kept but hit nothing.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(from = "SceneShapes")]
pub struct ObstacleScene {
    segments: Vec<[Point; 2]>,
    polygons: Vec<Vec<Point>>,
    discs: Vec<RoundObstacle>,
    #[serde(skip_serializing)]
    index: SceneIndex,
}

/// Serialised form of a scene: its shapes without the index.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneShapes {
    segments: Vec<[Point; 2]>,
    polygons: Vec<Vec<Point>>,
    discs: Vec<RoundObstacle>,
}

impl From<SceneShapes> for ObstacleScene {
    fn from(shapes: SceneShapes) -> Self {
        Self::new(shapes.segments, shapes.polygons, shapes.discs)
    }
}

impl ObstacleScene {
    /// Creates a scene of thin walls, solid polygons and discs. A polygon's last corner is connected to its first;
    /// orientation and concavity do not matter.
    pub fn new(
        segments: Vec<[Point; 2]>,
        polygons: Vec<Vec<Point>>,
        discs: Vec<RoundObstacle>,
    ) -> Self {
        let index = SceneIndex::new(&segments, &polygons, &discs);
        Self {
            segments,
            polygons,
            discs,
            index,
        }
    }

    /// The thin walls.
    pub fn segments(&self) -> &[[Point; 2]] {
        &self.segments
    }

    /// The solid polygons.
    pub fn polygons(&self) -> &[Vec<Point>] {
        &self.polygons
    }

    /// The discs.
    pub fn discs(&self) -> &[RoundObstacle] {
        &self.discs
    }

    /// Distance in m from `origin` along `direction` (of any positive length) to the first hit; `None` if there is none
    /// within `max` metres, 0 within a solid.
    pub fn raycast(&self, origin: Point, direction: Vector, max: f64) -> Option<f64> {
        let unit = direction.try_normalize(0.0)?;
        if !(finite(&origin) && unit.norm().is_finite() && max > 0.0) {
            return None;
        }
        let at = glam(&origin);
        if self.index.inside(at) {
            return Some(0.0);
        }
        let ray = Ray::new(at, Glam::new(unit.x as f32, unit.y as f32));
        let max = max as f32;
        let hit = self.index.beams.cast_ray(&ray, max, |part, best| {
            self.index.parts.get(part as usize)?.cast(&ray, best)
        });
        hit.map(|(_, distance)| f64::from(distance))
            .filter(|distance| *distance <= f64::from(max))
    }

    /// Distance in m from `point` to the nearest obstacle: 0 within a solid, infinite in an empty scene.
    pub fn clearance(&self, point: Point) -> f64 {
        self.clearance_within(point, f64::INFINITY)
    }

    /// Like [`ObstacleScene::clearance`], but infinite if there is no obstacle within `max` metres; cheaper, for
    /// collision tests.
    pub fn clearance_within(&self, point: Point, max: f64) -> f64 {
        let at = glam(&point);
        if !finite(&point) {
            return f64::INFINITY;
        }
        if self.index.inside(at) {
            return 0.0;
        }
        let max = max.min(f64::from(f32::MAX)) as f32;
        let nearest = self.index.beams.find_best(
            max,
            |node: &BvhNode, _: f32| node.aabb().distance_to_local_point(at, true),
            |part: u32, _: f32| Some(self.index.parts.get(part as usize)?.distance(at)),
        );
        nearest.map_or(f64::INFINITY, |(_, distance)| f64::from(distance))
    }
}

/// The scene in parry2d's terms: all sides in one tree, the solids in another.
#[derive(Clone, Debug, Default)]
struct SceneIndex {
    parts: Vec<ScenePart>,
    beams: Bvh,
    solids: Vec<Vec<Glam>>,
    areas: Bvh,
}

impl SceneIndex {
    fn new(segments: &[[Point; 2]], polygons: &[Vec<Point>], discs: &[RoundObstacle]) -> Self {
        let solids = polygons
            .iter()
            .filter(|polygon| polygon.len() > 2 && polygon.iter().all(finite));
        let solids: Vec<Vec<Glam>> = solids
            .map(|polygon| polygon.iter().map(glam).collect())
            .collect();
        let walls = segments.iter().filter(|ends| ends.iter().all(finite));
        let walls = walls.map(|[a, b]| ScenePart::Side(Segment::new(glam(a), glam(b))));
        let round = discs
            .iter()
            .filter(|disc| finite(&disc.centre) && disc.radius.is_finite() && disc.radius > 0.0);
        let round =
            round.map(|disc| ScenePart::Round(glam(&disc.centre), Ball::new(disc.radius as f32)));
        let parts: Vec<ScenePart> = walls
            .chain(solids.iter().flat_map(|corners| sides(corners)))
            .chain(round)
            .collect();
        let areas: Vec<Aabb> = solids
            .iter()
            .map(|corners| Aabb::from_points(corners.iter().copied()))
            .collect();
        let boxes: Vec<Aabb> = parts.iter().map(ScenePart::bounds).collect();
        Self {
            beams: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes),
            areas: Bvh::from_leaves(BvhBuildStrategy::Binned, &areas),
            parts,
            solids,
        }
    }

    fn inside(&self, at: Glam) -> bool {
        let spot = Aabb::new(at, at);
        let mut nearby = self.areas.intersect_aabb(&spot);
        nearby.any(|solid| {
            let corners = self.solids.get(solid as usize);
            corners.is_some_and(|corners| point_in_poly2d(at, corners))
        })
    }
}

fn sides(corners: &[Glam]) -> impl Iterator<Item = ScenePart> {
    let next = corners.iter().cycle().skip(1);
    let pairs = corners.iter().zip(next);
    pairs.map(|(a, b)| ScenePart::Side(Segment::new(*a, *b)))
}

/// An object that a beam can hit.
#[derive(Clone, Debug)]
enum ScenePart {
    Side(Segment),
    Round(Glam, Ball),
}

impl ScenePart {
    fn bounds(&self) -> Aabb {
        match self {
            Self::Side(segment) => segment.compute_aabb(&Isometry::IDENTITY),
            Self::Round(centre, ball) => ball.compute_aabb(&Isometry::from_translation(*centre)),
        }
    }

    fn cast(&self, ray: &Ray, max: f32) -> Option<f32> {
        match self {
            Self::Side(segment) => segment.cast_local_ray(ray, max, true),
            Self::Round(centre, ball) => {
                ball.cast_local_ray(&ray.translate_by(-*centre), max, true)
            }
        }
    }

    fn distance(&self, at: Glam) -> f32 {
        match self {
            Self::Side(segment) => segment.distance_to_local_point(at, true),
            Self::Round(centre, ball) => ball.distance_to_local_point(at - *centre, true),
        }
    }
}

fn glam(point: &Point) -> Glam {
    Glam::new(point.x as f32, point.y as f32)
}

fn finite(point: &Point) -> bool {
    glam(point).is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point(x: f64, y: f64) -> Point {
        Point::new(x, y)
    }

    /// A room of 4 m × 3 m with a pillar and an L-shaped desk.
    fn room() -> ObstacleScene {
        let corners = [
            point(0.0, 0.0),
            point(4.0, 0.0),
            point(4.0, 3.0),
            point(0.0, 3.0),
        ];
        let walls = (0..4)
            .map(|at| [corners[at], corners[(at + 1) % 4]])
            .collect();
        let desk = [
            (0.0, 2.0),
            (2.0, 2.0),
            (2.0, 2.5),
            (0.5, 2.5),
            (0.5, 3.0),
            (0.0, 3.0),
        ];
        let desk = desk.map(|(x, y)| point(x, y)).to_vec();
        let pillar = RoundObstacle {
            centre: point(3.0, 1.0),
            radius: 0.25,
        };
        ObstacleScene::new(walls, vec![desk], vec![pillar])
    }

    fn cast(x: f64, y: f64, direction: (f64, f64)) -> Option<f64> {
        room().raycast(point(x, y), Vector::new(direction.0, direction.1), 10.0)
    }

    #[test]
    fn a_beam_hits_the_nearest_thing() {
        for (x, y, direction, expected) in [
            (1.0, 1.0, (1.0, 0.0), 1.75),
            (1.0, 1.0, (7.0, 0.0), 1.75),
            (1.0, 1.0, (0.0, 1.0), 1.0),
            (1.0, 1.0, (0.0, -1.0), 1.0),
            (3.0, 2.25, (-1.0, 0.0), 1.0),
            (1.0, 2.75, (-1.0, 0.0), 0.5),
        ] {
            let distance = cast(x, y, direction).unwrap();
            assert!((distance - expected).abs() < 1e-5, "{distance} {expected}");
        }
    }

    #[test]
    fn a_beam_ends_within_a_solid_where_it_starts() {
        assert_eq!(cast(1.0, 2.25, (1.0, 0.0)), Some(0.0));
        assert_eq!(cast(3.0, 1.1, (1.0, 0.0)), Some(0.0));
    }

    #[test]
    fn a_beam_reaches_no_further_than_it_can() {
        let short = room().raycast(point(1.0, 1.0), Vector::x(), 1.7);
        assert_eq!(short, None);
        assert_eq!(cast(1.0, 1.0, (0.0, 0.0)), None);
        assert_eq!(cast(f64::NAN, 1.0, (1.0, 0.0)), None);
    }

    #[test]
    fn it_knows_the_clearance() {
        let clearance = |x, y| room().clearance(point(x, y));
        assert!((clearance(3.0, 2.0) - 0.75).abs() < 1e-5);
        assert!((clearance(0.3, 1.0) - 0.3).abs() < 1e-5);
        assert_eq!((clearance(1.0, 2.2), clearance(3.1, 1.1)), (0.0, 0.0));
        assert_eq!(room().clearance_within(point(3.0, 2.0), 0.5), f64::INFINITY);
        assert_eq!(
            ObstacleScene::default().clearance(point(0.0, 0.0)),
            f64::INFINITY
        );
    }

    #[test]
    fn a_lone_wall_is_a_scene() {
        let wall = [point(1.0, -1.0), point(1.0, 1.0)];
        let scene = ObstacleScene::new(vec![wall], Vec::new(), Vec::new());
        assert_eq!(scene.raycast(Point::origin(), Vector::x(), 5.0), Some(1.0));
        assert_eq!(scene.raycast(Point::origin(), -Vector::x(), 5.0), None);
    }

    proptest! {
        #[test]
        fn it_takes_any_numbers(n in prop::collection::vec(prop::num::f64::ANY, 12)) {
            let at = |index: usize| point(n[index], n[index + 1]);
            let disc = RoundObstacle { centre: at(6), radius: n[8] };
            let scene = ObstacleScene::new(vec![[at(0), at(1)]], vec![vec![at(2), at(3), at(4)]], vec![disc]);
            scene.raycast(at(9), Vector::new(n[10], n[11]), n[5]);
            scene.clearance(at(10));
        }
    }
}
