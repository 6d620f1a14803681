//! Tables from messages with several lists of equal length, such as joint states: a column for each list.

use asmotion_datum::Datum;

use asmotion_story::brief::{MOST, brief};

/// A table of lists.
#[derive(Debug, PartialEq)]
pub struct ListTable {
    /// Names of the fields.
    pub names: Vec<String>,
    /// Rows of elements.
    pub rows: Vec<Vec<String>>,
}

/// Returns the lists of a message, if it has at least two of equal length.
pub fn joints(message: &Datum) -> Option<ListTable> {
    let Datum::Record(fields) = message else {
        return None;
    };
    let length = |value: &Datum| match value {
        Datum::List(_) | Datum::Numbers(_) | Datum::Bytes(_) => value.count(),
        Datum::Null
        | Datum::Bool(_)
        | Datum::Int(_)
        | Datum::Float(_)
        | Datum::Text(_)
        | Datum::Record(_) => None,
    };
    let lengths: Vec<usize> = fields.iter().filter_map(|(_, it)| length(it)).collect();
    let lists_of = |length: usize| lengths.iter().filter(|it| **it == length).count();
    let common_length = (2..=MOST)
        .filter(|it| lists_of(*it) >= 2)
        .max_by_key(|it| lists_of(*it))?;
    let lists = || {
        fields
            .iter()
            .filter(|(_, it)| length(it) == Some(common_length))
    };
    let row = |index: usize| {
        let elements = lists().map(|(_, list)| list.element(index));
        let shown = elements.map(|it| it.map_or_else(String::new, |it| brief(&it)));
        shown.collect()
    };
    Some(ListTable {
        names: lists().map(|(name, _)| name.to_string()).collect(),
        rows: (0..common_length).map(row).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::joints;
    use asmotion_datum::{Datum, Numbers};

    #[test]
    fn lists_of_one_length_are_columns() {
        let numbers = |numbers: &[f64]| Datum::Numbers(Numbers::F64(numbers.into()));
        let message = Datum::record([
            ("stamp", Datum::Int(3)),
            ("position", numbers(&[0.5, -0.00001])),
            ("limits", numbers(&[1.0, 2.0, 3.0])),
            ("error", Datum::List(vec![Datum::Int(0), Datum::Int(7)])),
        ]);
        let joints = joints(&message).unwrap();
        assert_eq!(joints.names, ["position", "error"]);
        assert_eq!(joints.rows, [["0.5", "0"], ["0", "7"]]);
    }

    #[test]
    fn one_list_is_no_table() {
        let list = Datum::List(vec![Datum::Int(1), Datum::Int(2)]);
        assert_eq!(joints(&Datum::record([("one", list.clone())])), None);
        assert_eq!(joints(&list), None);
    }
}
