//! Draws polygons, strokes and discs in map coordinates on a grid. Parts outside the grid are cut off.

use crate::grid::Grid;
use crate::layout::GridLayout;
use crate::pose::{Point, Vector};

impl Grid {
    /// Sets every cell whose centre is inside an odd number of rings: a polygon with holes, or several polygons. A
    /// ring's last corner is connected to its first.
    pub fn fill(&mut self, rings: &[Vec<Point>], value: i8) {
        let layout = *self.layout();
        let mut edges = edges(&layout, rings);
        edges.sort_by(|(one, _), (other, _)| one.y.total_cmp(&other.y));
        let lowest = edges.first().map_or(f64::MAX, |(from, _)| from.y);
        let highest = edges.iter().map(|(_, to)| to.y).fold(f64::MIN, f64::max);
        let mut coming = edges.into_iter().peekable();
        let mut active: Vec<PolygonEdge> = Vec::new();
        let mut crossings = Vec::new();
        for row in centres(lowest, highest, layout.height()) {
            let y = f64::from(row) + 0.5;
            while let Some(edge) = coming.next_if(|(from, _)| from.y <= y) {
                active.push(edge);
            }
            // the upper end of an edge does not belong to it, so that a corner counts once
            active.retain(|(_, to)| y < to.y);
            crossings.clear();
            crossings.extend(active.iter().map(|edge| crossing(edge, y)));
            crossings.sort_by(f64::total_cmp);
            for span in crossings.chunks_exact(2) {
                self.fill_row(row, span[0], span[1], value);
            }
        }
    }

    /// Sets every cell that a line through `points` touches, and every cell whose centre is at most half of `width`
    /// metres from the line. A wall without width is closed, and a wide one has round ends.
    pub fn stroke(&mut self, points: &[Point], width: f64, value: i8) {
        for pair in points.windows(2) {
            self.trace(pair[0], pair[1], value);
            if width > 0.0 {
                self.fill(&[band(pair[0], pair[1], width)], value);
            }
        }
        for point in points {
            self.disc(*point, width / 2.0, value);
        }
    }

    /// Sets the cell that contains `centre`, and every cell whose centre is at most `radius` metres from it.
    pub fn disc(&mut self, centre: Point, radius: f64, value: i8) {
        let layout = *self.layout();
        if let Some(cell) = layout.cell(centre) {
            self.set(cell, value);
        }
        let (centre, radius) = (layout.to_cells(centre), radius / layout.resolution());
        if !(radius > 0.0 && centre.coords.iter().all(|value| value.is_finite())) {
            return;
        }
        for row in centres(centre.y - radius, centre.y + radius, layout.height()) {
            let dy = f64::from(row) + 0.5 - centre.y;
            let half = (radius * radius - dy * dy).max(0.0).sqrt();
            self.fill_row(row, centre.x - half, centre.x + half, value);
        }
    }

    /// Sets the cells that the line between two points touches within the grid.
    fn trace(&mut self, from: Point, to: Point, value: i8) {
        let layout = *self.layout();
        let Some((from, to)) = clip(&layout, layout.to_cells(from), layout.to_cells(to)) else {
            return;
        };
        layout.line(layout.to_map(from), layout.to_map(to), |index| {
            self.cells_mut()[index] = value;
            true
        });
    }

    /// Sets the cells of a row whose centres are between `from` and `to`, in cells.
    fn fill_row(&mut self, row: u32, from: f64, to: f64, value: i8) {
        let width = self.layout().width();
        let columns = centres(from, to, width);
        let start = row as usize * width as usize;
        let (first, last) = (columns.start as usize, columns.end as usize);
        if let Some(cells) = self.cells_mut().get_mut(start + first..start + last) {
            cells.fill(value);
        }
    }
}

/// The cells along one axis whose centres are in `from..=to`.
fn centres(from: f64, to: f64, size: u32) -> std::ops::Range<u32> {
    // casts saturate and turn NaN into 0, which gives an empty range
    let first = (from - 0.5).ceil().max(0.0).min(f64::from(size)) as u32;
    let end = ((to - 0.5).floor() + 1.0).max(0.0).min(f64::from(size)) as u32;
    first..end.max(first)
}

/// An edge from its lower to its higher point, in cells.
type PolygonEdge = (Point, Point);

/// The sides of the rings, without horizontal and infinite ones.
fn edges(layout: &GridLayout, rings: &[Vec<Point>]) -> Vec<PolygonEdge> {
    let sides = rings.iter().flat_map(|ring| {
        let next = ring.iter().cycle().skip(1);
        ring.iter().zip(next)
    });
    sides
        .map(|(from, to)| (layout.to_cells(*from), layout.to_cells(*to)))
        .filter(|(from, to)| from.y != to.y && (to - from).norm().is_finite())
        .map(|(from, to)| {
            if from.y < to.y {
                (from, to)
            } else {
                (to, from)
            }
        })
        .collect()
}

/// The x at which an edge crosses a height between its ends.
fn crossing((from, to): &PolygonEdge, y: f64) -> f64 {
    from.x + (to.x - from.x) * (y - from.y) / (to.y - from.y)
}

/// The rectangle around a line.
fn band(from: Point, to: Point, width: f64) -> Vec<Point> {
    let along = to - from;
    let side = match along.try_normalize(0.0) {
        Some(unit) => Vector::new(-unit.y, unit.x) * (width / 2.0),
        None => Vector::zeros(),
    };
    vec![from + side, to + side, to - side, from - side]
}

/// The part of a line, in cells, that is slightly within the rim of the grid (Liang and Barsky, 1984).
fn clip(layout: &GridLayout, from: Point, to: Point) -> Option<(Point, Point)> {
    const RIM: f64 = 1e-6;
    let way = to - from;
    if !(way.norm().is_finite() && from.coords.norm().is_finite()) {
        return None;
    }
    let high = [
        f64::from(layout.width()) - RIM,
        f64::from(layout.height()) - RIM,
    ];
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        if way[axis] == 0.0 {
            if !(0.0..=high[axis]).contains(&from[axis]) {
                return None;
            }
            continue;
        }
        let first = (RIM - from[axis]) / way[axis];
        let second = (high[axis] - from[axis]) / way[axis];
        enter = enter.max(first.min(second));
        leave = leave.min(first.max(second));
    }
    (enter <= leave).then(|| (from + way * enter, from + way * leave))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{FREE, OCCUPIED};
    use crate::pose::{Pose, heading};
    use proptest::prelude::*;

    fn grid(width: u32, height: u32) -> Grid {
        Grid::new(
            GridLayout::new(1.0, width, height, Pose::identity()).unwrap(),
            FREE,
        )
    }

    /// Rows from top to bottom, as in a picture.
    fn picture(grid: &Grid) -> Vec<String> {
        let rows = grid.cells().chunks(grid.layout().width() as usize).rev();
        rows.map(|row| {
            row.iter()
                .map(|value| if *value == OCCUPIED { '#' } else { '.' })
                .collect()
        })
        .collect()
    }

    fn points(numbers: &[(f64, f64)]) -> Vec<Point> {
        numbers.iter().map(|(x, y)| Point::new(*x, *y)).collect()
    }

    #[test]
    fn it_fills_a_ring_with_a_hole() {
        let mut grid = grid(6, 6);
        let outer = points(&[(0.0, 0.0), (5.0, 0.0), (5.0, 5.0), (0.0, 5.0)]);
        let inner = points(&[(2.0, 2.0), (3.0, 2.0), (3.0, 3.0), (2.0, 3.0)]);
        grid.fill(&[outer, inner], OCCUPIED);
        assert_eq!(
            picture(&grid),
            ["......", "#####.", "#####.", "##.##.", "#####.", "#####."]
        );
    }

    #[test]
    fn a_wall_without_width_is_closed() {
        let mut grid = grid(6, 4);
        grid.stroke(&points(&[(0.2, 0.3), (5.7, 3.6)]), 0.0, OCCUPIED);
        assert_eq!(picture(&grid), ["....##", "...##.", ".###..", "##...."]);
    }

    #[test]
    fn a_stroke_has_the_width_it_was_given_and_round_ends() {
        let mut grid = grid(9, 7);
        grid.stroke(&points(&[(2.5, 3.5), (6.5, 3.5)]), 5.0, OCCUPIED);
        assert_eq!(
            picture(&grid),
            [
                ".........",
                ".#######.",
                "#########",
                "#########",
                "#########",
                ".#######.",
                "........."
            ]
            .map(|row| row.to_owned())
        );
    }

    #[test]
    fn it_cuts_off_what_lies_outside() {
        let mut grid = grid(4, 2);
        grid.stroke(&points(&[(-1e9, 0.5), (1e9, 0.5)]), 0.0, OCCUPIED);
        assert_eq!(picture(&grid), ["....", "####"]);
        grid.fill(
            &[points(&[
                (-1e9, -1e9),
                (1e9, -1e9),
                (1e9, 1e9),
                (-1e9, 1e9),
            ])],
            OCCUPIED,
        );
        assert_eq!(picture(&grid), ["####", "####"]);
    }

    #[test]
    fn it_draws_in_map_coordinates() {
        let origin = heading(Point::new(3.0, 0.0), std::f64::consts::FRAC_PI_2);
        let mut grid = Grid::new(GridLayout::new(1.0, 2, 3, origin).unwrap(), FREE);
        grid.disc(Point::new(0.5, 1.5), 0.0, OCCUPIED);
        assert_eq!(picture(&grid), [".#", "..", ".."]);
    }

    proptest! {
        #[test]
        fn it_takes_any_numbers(numbers in prop::collection::vec((prop::num::f64::ANY, prop::num::f64::ANY), 0..6), width in prop::num::f64::ANY) {
            let mut grid = grid(5, 5);
            let line = points(&numbers);
            grid.stroke(&line, width, OCCUPIED);
            grid.fill(&[line], OCCUPIED);
        }
    }
}
