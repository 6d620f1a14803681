//! Fields of messages.

use asmotion_datum::Datum;

use crate::motion::Vector3;

/// The name of a frame: tf of ROS 1 wrote a slash before it.
pub(crate) fn frame_name(text: &str) -> &str {
    text.strip_prefix('/').unwrap_or(text)
}

/// Changes what is at a path, in every element of a list on the way and at its end.
pub(crate) fn change(data: &mut Datum, path: &str, how: &mut dyn FnMut(&mut Datum)) {
    if let Datum::List(elements) = data {
        for element in elements {
            change(element, path, how);
        }
        return;
    }
    if path.is_empty() {
        return how(data);
    }
    let (step, rest) = path.split_once('.').unwrap_or((path, ""));
    if let Some(value) = field_mut(data, step) {
        change(value, rest, how);
    }
}

pub(crate) fn field_mut<'d>(record: &'d mut Datum, name: &str) -> Option<&'d mut Datum> {
    let Datum::Record(fields) = record else {
        return None;
    };
    let found = fields.iter_mut().find(|(field, _)| **field == *name);
    found.map(|(_, value)| value)
}

/// Nanoseconds of a `builtin_interfaces/Time`, or of a time of ROS 1.
pub(crate) fn nanoseconds(time: &Datum) -> Option<i64> {
    let part = |name| time.get(name)?.as_int();
    let seconds = part("sec")?.checked_mul(1_000_000_000)?;
    seconds.checked_add(part("nanosec")?)
}

pub(crate) fn text(message: &Datum, path: &str) -> Option<String> {
    message.get(path)?.as_text().map(str::to_owned)
}

fn coordinate(value: &Datum, name: &str) -> Option<f64> {
    value.get(name)?.as_float()
}

pub(crate) fn vector(value: &Datum) -> Option<Vector3> {
    let of = |name| coordinate(value, name);
    Some(Vector3::new(of("x")?, of("y")?, of("z")?))
}

pub(crate) fn quaternion(value: &Datum) -> Option<[f64; 4]> {
    let of = |name| coordinate(value, name);
    Some([of("x")?, of("y")?, of("z")?, of("w")?])
}
