//! Converts points to discs: groups connected points, and covers each group with few discs.

use asmotion_geometry::{Point, RoundObstacle, Vector};

/// Points closer than this distance in m are connected.
const GAP: f64 = 0.15;

/// Margin in m added to every disc, because the laser sees only surfaces.
const SKIN: f64 = 0.02;

/// Groups points that are connected by steps of less than [`GAP`]. Groups and points keep their order.
pub fn clusters(points: &[Point]) -> Vec<Vec<Point>> {
    let mut groups = Vec::new();
    let mut remaining: Vec<Point> = points.to_vec();
    while !remaining.is_empty() {
        let mut group = vec![remaining.remove(0)];
        let mut grown = 0;
        while grown < group.len() {
            let member = group[grown];
            remaining.retain(|point| {
                let joins = (point - member).norm_squared() < GAP * GAP;
                if joins {
                    group.push(*point);
                }
                !joins
            });
            grown += 1;
        }
        groups.push(group);
    }
    groups
}

/// Covers points with discs of at most `radius` metres (plus [`SKIN`]): halves the set across its longer side until
/// each part fits one disc.
pub fn cover(mut points: Vec<Point>, radius: f64, discs: &mut Vec<RoundObstacle>) {
    let Some(first) = points.first() else {
        return;
    };
    let (low, high) = points.iter().fold((*first, *first), |(low, high), point| {
        (low.inf(point), high.sup(point))
    });
    let centre = middle(low, high);
    let reach = points
        .iter()
        .map(|point| (point - centre).norm())
        .fold(0.0, f64::max);
    if reach <= radius || points.len() == 1 {
        discs.push(RoundObstacle {
            centre,
            radius: reach + SKIN,
        });
        return;
    }
    let size: Vector = high - low;
    let along = |point: &Point| {
        if size.x >= size.y {
            point.x - centre.x
        } else {
            point.y - centre.y
        }
    };
    let upper = points.extract_if(.., |point| along(point) > 0.0).collect();
    cover(points, radius, discs);
    cover(upper, radius, discs);
}

fn middle(low: Point, high: Point) -> Point {
    low + (high - low) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn points(all: &[(f64, f64)]) -> Vec<Point> {
        all.iter().map(|(x, y)| Point::new(*x, *y)).collect()
    }

    #[test]
    fn what_is_connected_belongs_together() {
        let chain = points(&[(0.0, 0.0), (1.0, 0.0), (0.1, 0.0), (0.2, 0.05), (1.0, 0.1)]);
        let groups = clusters(&chain);
        assert_eq!(groups.iter().map(Vec::len).collect::<Vec<_>>(), [3, 2]);
    }

    #[test]
    fn a_small_thing_is_one_disc_and_a_long_one_several() {
        let mut discs = Vec::new();
        cover(points(&[(0.0, 0.0), (0.2, 0.0)]), 0.25, &mut discs);
        assert_eq!(discs.len(), 1);
        assert!((discs[0].radius - 0.12).abs() < 1e-9);
        discs.clear();
        let wall: Vec<Point> = (0..=20)
            .map(|step| Point::new(3.0, f64::from(step) * 0.1))
            .collect();
        cover(wall, 0.25, &mut discs);
        assert_eq!(discs.len(), 4);
    }

    proptest! {
        #[test]
        fn every_point_is_covered_and_no_disc_is_too_large(all in prop::collection::vec((-3.0..3.0, -3.0..3.0), 0..120)) {
            let all = points(&all);
            let mut discs = Vec::new();
            for cluster in clusters(&all) {
                cover(cluster, 0.25, &mut discs);
            }
            prop_assert!(discs.iter().all(|disc| disc.radius <= 0.25 + SKIN));
            prop_assert!(all.iter().all(|point| discs.iter().any(|disc| (point - disc.centre).norm() <= disc.radius)));
        }
    }
}
