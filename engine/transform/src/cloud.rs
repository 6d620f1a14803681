//! The points of a `sensor_msgs/PointCloud2`, which are bytes with a layout in the message.

use asmotion_datum::Datum;

use crate::failure::TransformFailure;
use crate::fields::field_mut;
use crate::motion::{RigidMotion, Vector3};

/// Type of a coordinate, by its number in `sensor_msgs/PointField`.
#[derive(Clone, Copy, PartialEq)]
enum Coordinate {
    Float32,
    Float64,
}

impl Coordinate {
    fn of(number: i64) -> Option<Self> {
        match number {
            7 => Some(Self::Float32),
            8 => Some(Self::Float64),
            _ => None,
        }
    }
}

/// The layout of the points.
struct CloudLayout {
    /// Offsets of `x`, `y` and `z` in a point.
    offsets: [usize; 3],
    coordinate: Coordinate,
    is_big_endian: bool,
    width: usize,
    height: usize,
    point_step: usize,
    row_step: usize,
}

/// Moves all points of a cloud. Other fields, such as colours, stay.
pub(crate) fn transform(cloud: &mut Datum, motion: RigidMotion) -> Result<(), TransformFailure> {
    let layout = CloudLayout::read(cloud).ok_or(TransformFailure::Cloud)?;
    let Some(Datum::Bytes(bytes)) = cloud.get("data").map(|it| it.into_owned()) else {
        return Err(TransformFailure::Cloud);
    };
    let mut bytes = bytes.to_vec();
    let moved = layout.move_points(&mut bytes, motion);
    moved.ok_or(TransformFailure::Cloud)?;
    if let Some(data) = field_mut(cloud, "data") {
        *data = Datum::Bytes(bytes.as_slice().into());
    }
    Ok(())
}

impl CloudLayout {
    fn read(cloud: &Datum) -> Option<Self> {
        let number = |name: &str| {
            let found = cloud.get(name)?.as_int()?;
            usize::try_from(found).ok()
        };
        let (mut offsets, mut types) = ([0; 3], [None; 3]);
        let names = ["x", "y", "z"].into_iter();
        for ((name, offset), kind) in names.zip(&mut offsets).zip(&mut types) {
            (*offset, *kind) = field(cloud, name)?;
        }
        let [coordinate, y, z] = types;
        let is_same = coordinate == y && y == z;
        Some(Self {
            offsets,
            coordinate: coordinate.filter(|_| is_same)?,
            is_big_endian: cloud.get("is_bigendian")?.as_bool()?,
            width: number("width")?,
            height: number("height")?,
            point_step: number("point_step")?,
            row_step: number("row_step")?,
        })
    }

    /// `None` if a point is not within the bytes.
    fn move_points(&self, bytes: &mut [u8], motion: RigidMotion) -> Option<()> {
        if self.width == 0 {
            return Some(());
        }
        // every point has bytes of its own, which also limits their number
        let points = self.width.checked_mul(self.height)?;
        if self.point_step == 0 || points.checked_mul(self.point_step)? > bytes.len() {
            return (points == 0).then_some(());
        }
        for row in 0..self.height {
            for column in 0..self.width {
                let start = row.checked_mul(self.row_step)?;
                let start = start.checked_add(column.checked_mul(self.point_step)?)?;
                let point = bytes.get_mut(start..start.checked_add(self.point_step)?)?;
                self.move_point(point, motion)?;
            }
        }
        Some(())
    }

    fn move_point(&self, point: &mut [u8], motion: RigidMotion) -> Option<()> {
        let [x, y, z] = self.offsets;
        let before = Vector3::new(
            self.number(point, x)?,
            self.number(point, y)?,
            self.number(point, z)?,
        );
        let after = motion.apply(before);
        for (offset, number) in [(x, after.x), (y, after.y), (z, after.z)] {
            self.write(point, offset, number)?;
        }
        Some(())
    }

    fn number(&self, point: &[u8], offset: usize) -> Option<f64> {
        let rest = point.get(offset..)?;
        Some(match (self.coordinate, self.is_big_endian) {
            (Coordinate::Float32, false) => f32::from_le_bytes(*rest.first_chunk()?).into(),
            (Coordinate::Float32, true) => f32::from_be_bytes(*rest.first_chunk()?).into(),
            (Coordinate::Float64, false) => f64::from_le_bytes(*rest.first_chunk()?),
            (Coordinate::Float64, true) => f64::from_be_bytes(*rest.first_chunk()?),
        })
    }

    fn write(&self, point: &mut [u8], offset: usize, number: f64) -> Option<()> {
        let rest = point.get_mut(offset..)?;
        match (self.coordinate, self.is_big_endian) {
            (Coordinate::Float32, false) => {
                *rest.first_chunk_mut()? = (number as f32).to_le_bytes()
            }
            (Coordinate::Float32, true) => *rest.first_chunk_mut()? = (number as f32).to_be_bytes(),
            (Coordinate::Float64, false) => *rest.first_chunk_mut()? = number.to_le_bytes(),
            (Coordinate::Float64, true) => *rest.first_chunk_mut()? = number.to_be_bytes(),
        }
        Some(())
    }
}

/// Offset and type of a field; the type is `None` if it is no floating-point number.
fn field(cloud: &Datum, name: &str) -> Option<(usize, Option<Coordinate>)> {
    let Datum::List(fields) = cloud.get("fields")?.into_owned() else {
        return None;
    };
    let mut fields = fields.iter();
    let found = fields.find(|it| it.get("name").is_some_and(|it| it.as_text() == Some(name)))?;
    let offset = usize::try_from(found.get("offset")?.as_int()?).ok()?;
    let kind = found.get("datatype")?.as_int()?;
    Some((offset, Coordinate::of(kind)))
}
