//! Texts in XML, for JUnit reports.

use std::fmt::{self, Display, Write};

/// Escapes a text for XML 1.0 content or attributes. Control characters, which XML 1.0 does not allow, are left out.
pub struct Escaped<'a>(pub &'a str);

impl Display for Escaped<'_> {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        for letter in self.0.chars() {
            match letter {
                '&' => to.write_str("&amp;")?,
                '<' => to.write_str("&lt;")?,
                '>' => to.write_str("&gt;")?,
                '"' => to.write_str("&quot;")?,
                '\t' | '\n' | '\r' => to.write_char(letter)?,
                '\0'..' ' | '\u{fffe}' | '\u{ffff}' => {}
                _ => to.write_char(letter)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_text_can_stand_in_xml() {
        let text = "a < b && c > \"d\"\n\u{1b}[1mbold\u{0}é";
        let escaped = "a &lt; b &amp;&amp; c &gt; &quot;d&quot;\n[1mboldé";
        assert_eq!(Escaped(text).to_string(), escaped);
    }
}
