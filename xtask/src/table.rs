//! Tables in Markdown.

/// The rows of a column: label and value.
pub type Rows = Vec<(String, String)>;

/// Formats the rows of several revisions as a Markdown table. A row that a revision lacks is shown
/// as a dash.
pub fn markdown(columns: &[(String, Rows)]) -> String {
    let mut labels: Vec<&str> = Vec::new();
    for (_, rows) in columns {
        for (position, (label, _)) in rows.iter().enumerate() {
            if !labels.contains(&label.as_str()) {
                // insert after the row that precedes it in its own column
                let before = position.checked_sub(1).and_then(|at| rows.get(at));
                let at = before.and_then(|(before, _)| labels.iter().position(|it| it == before));
                labels.insert(at.map_or(labels.len(), |at| at + 1), label);
            }
        }
    }
    let heads: Vec<&str> = columns.iter().map(|(head, _)| head.as_str()).collect();
    let mut text = format!(
        "| | {} |\n|---|{}\n",
        heads.join(" | "),
        "---:|".repeat(heads.len())
    );
    for label in labels {
        text += &format!("| {label} |");
        for (_, rows) in columns {
            let value = rows.iter().find(|(it, _)| it == label);
            text += &format!(" {} |", value.map_or("–", |(_, value)| value.as_str()));
        }
        text.push('\n');
    }
    text
}
