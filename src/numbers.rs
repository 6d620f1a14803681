//! Numbers in words.

/// A number with separators, as in `1,745,408`.
pub fn number(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A number with a noun, as in `3 states`. A count of 2^64 - 1 stands for all greater ones.
pub fn counted(count: u64, noun: &str) -> String {
    if count == u64::MAX {
        return format!("more than 10^19 {noun}s");
    }
    let plural = if count == 1 { "" } else { "s" };
    format!("{} {noun}{plural}", number(count))
}
