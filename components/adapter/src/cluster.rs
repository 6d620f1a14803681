//! Groups connected points.

use asmotion_geometry::Point;

/// Points closer than this distance in m are connected.
pub const GAP: f64 = 0.15;

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

#[cfg(test)]
mod tests {
    use super::*;

    fn points(all: &[(f64, f64)]) -> Vec<Point> {
        all.iter().map(|(x, y)| Point::new(*x, *y)).collect()
    }

    #[test]
    fn what_is_connected_belongs_together() {
        let chain = points(&[(0.0, 0.0), (1.0, 0.0), (0.1, 0.0), (0.2, 0.05), (1.0, 0.1)]);
        let groups = clusters(&chain);
        assert_eq!(groups.iter().map(Vec::len).collect::<Vec<_>>(), [3, 2]);
    }
}
