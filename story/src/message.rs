//! Formats a message in a few words, depending on its content.

use asmotion_datum::{Datum, Message, Sample};
use asmotion_messages::{OccupancyGrid, Path};

use crate::brief::brief as number;

/// Largest number of numbers that are shown; more of them are data.
const FEW: usize = 8;

/// Number of characters of a text that are shown.
const LONGEST: usize = 200;

/// Formats a message in a few words; `None` if it is empty or too long.
pub(super) fn brief(sample: &dyn Sample) -> Option<String> {
    let untyped = sample.downcast_ref::<Datum>();
    // omitted fields have initial values, so any data could be decoded as a path
    let is = |name: &str, field: &str| match untyped {
        Some(datum) => datum.get(field).is_some(),
        None => sample.type_name() == name,
    };
    if is(Path::NAME, "poses") {
        let path = sample.to_shared().read::<Path>();
        return path.ok().map(|path| describe_path(&path));
    }
    if is(OccupancyGrid::NAME, "info") {
        let map = sample.to_shared().read::<OccupancyGrid>();
        return map.ok().map(|map| describe_map(&map));
    }
    let text = match untyped {
        Some(datum) => describe_datum(datum),
        None => describe_datum(&sample.to_datum().ok()?),
    };
    text.filter(|words| !words.is_empty())
}

/// The content of one field of a message.
pub(super) fn field(sample: &dyn Sample, field: &str) -> Option<String> {
    let datum = sample.to_datum().ok()?;
    Some(one_line(&number(&*datum.get(field)?)))
}

/// A text of a message in one line: anybody who may publish can send control characters and texts of any length, which must
/// neither look like other entries nor fill a log.
pub(super) fn one_line(text: &str) -> String {
    let mut line = String::new();
    let mut characters = text.chars();
    for character in characters.by_ref().take(LONGEST) {
        if character.is_control() {
            line.extend(character.escape_default());
        } else {
            line.push(character);
        }
    }
    match characters.count() {
        0 => line,
        left => format!("{line}… ({left} more characters)"),
    }
}

/// Returns whether a value is a time, which is the identity of another message.
fn is_stamp(value: &Datum) -> bool {
    value.count() == Some(2) && value.get("sec").is_some() && value.get("nanosec").is_some()
}

fn describe_map(map: &OccupancyGrid) -> String {
    let info = &map.info;
    format!(
        "a map of {} × {} cells, {:.2} m each",
        info.width, info.height, info.resolution
    )
}

fn describe_path(path: &Path) -> String {
    let points = path.poses.iter().map(|pose| pose.pose.position);
    let pairs = points.clone().zip(points.skip(1));
    let metres: f64 = pairs.map(|(a, b)| (b.x - a.x).hypot(b.y - a.y)).sum();
    format!("a path of {metres:.1} m in {} poses", path.poses.len())
}

/// Formats a text, a few numbers, a position, or several of these.
fn describe_datum(datum: &Datum) -> Option<String> {
    match datum {
        Datum::Record(fields) => {
            if let Some(place) = describe_position(datum) {
                return Some(place);
            }
            let text = fields
                .iter()
                .filter(|(name, value)| !matches!(&**name, "stamp" | "header") && !is_stamp(value));
            let text: Option<Vec<String>> = text.map(|(_, value)| describe_datum(value)).collect();
            let text: Vec<String> = text?.into_iter().filter(|it| !it.is_empty()).collect();
            Some(text.join(": "))
        }
        Datum::List(_) | Datum::Numbers(_) | Datum::Bytes(_) => {
            (datum.count()? <= FEW).then(|| number(datum))
        }
        Datum::Text(text) => Some(one_line(text)),
        Datum::Null => Some(String::new()),
        Datum::Bool(_) | Datum::Int(_) | Datum::Float(_) => Some(number(datum)),
    }
}

/// Formats a point, or the position of a pose; z only if it is above the ground.
fn describe_position(datum: &Datum) -> Option<String> {
    let at = |path: &str| datum.get(path)?.as_float();
    let of = |prefix: &str| {
        let axis = |name: &str| at(&format!("{prefix}{name}"));
        Some([axis("x")?, axis("y")?, axis("z")?])
    };
    let [x, y, z] = of("pose.position.")
        .or_else(|| of("position."))
        .or_else(|| of(""))?;
    Some(if z == 0.0 {
        format!("({x:.1}, {y:.1})")
    } else {
        format!("({x:.2}, {y:.2}, {z:.2})")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_cannot_look_like_another_entry() {
        let forged = Datum::record([("code", Datum::text("A\n  0.10 s  e-stop\u{1b}[2J"))]);
        let shown = "A\\n  0.10 s  e-stop\\u{1b}[2J";
        assert_eq!(brief(&forged).as_deref(), Some(shown));
        assert_eq!(field(&forged, "code").as_deref(), Some(shown));
        assert_eq!(one_line("größer 5 °C"), "größer 5 °C");
    }

    #[test]
    fn a_long_text_is_cut_off() {
        let long = "é".repeat(LONGEST + 100_000);
        let shown = format!("{}… (100000 more characters)", "é".repeat(LONGEST));
        assert_eq!(brief(&Datum::text(&long)).as_deref(), Some(&*shown));
        assert_eq!(one_line(&"é".repeat(LONGEST)), "é".repeat(LONGEST));
    }
}
