//! Parsing of `#[table(…)]`.

use syn::{DeriveInput, Error, Expr, LitStr, Result};

use super::resolved::Twin;

/// The options of `#[table(…)]`.
pub(super) struct TableOptions {
    /// Phrase for the table in messages: "a wire".
    pub of: String,
    /// A key and the phrase for the table under that key: `elsewhere("activity", "an activity")`.
    pub elsewhere: Option<(LitStr, LitStr)>,
    /// An example of the table in TOML, for messages.
    pub example: String,
    /// Message that explains why only one variant of an enum may be given.
    pub reason: String,
    /// The table without spans: `resolved = Name` declares it, `into = path` names an existing type.
    pub twin: Option<Twin>,
    /// A function that checks or completes the table after its keys were read.
    pub after: Option<Expr>,
    /// The key that is meant when a plain value stands in place of the table.
    pub short: Option<String>,
}

impl TableOptions {
    pub(super) fn of(input: &DeriveInput) -> Result<Self> {
        let mut options = Self {
            of: String::new(),
            elsewhere: None,
            example: "{ }".to_owned(),
            reason: String::new(),
            twin: None,
            after: None,
            short: None,
        };
        for attribute in input.attrs.iter().filter(|it| it.path().is_ident("table")) {
            attribute.parse_nested_meta(|meta| {
                let name = meta.path.require_ident()?.to_string();
                if name == "elsewhere" {
                    let content;
                    syn::parenthesized!(content in meta.input);
                    let key = content.parse()?;
                    content.parse::<syn::Token![,]>()?;
                    options.elsewhere = Some((key, content.parse()?));
                    return Ok(());
                }
                let value = meta.value()?;
                match name.as_str() {
                    "of" => options.of = value.parse::<LitStr>()?.value(),
                    "example" => options.example = value.parse::<LitStr>()?.value(),
                    "reason" => options.reason = value.parse::<LitStr>()?.value(),
                    "short" => options.short = Some(value.parse::<LitStr>()?.value()),
                    "resolved" => options.twin = Some(Twin::New(value.parse()?)),
                    "into" => options.twin = Some(Twin::Existing(value.parse()?)),
                    "after" => options.after = Some(value.parse()?),
                    _ => return Err(meta.error("not an attribute of a table")),
                }
                Ok(())
            })?;
        }
        if options.of.is_empty() {
            Err(Error::new_spanned(
                &input.ident,
                "say what it is: `#[table(of = \"a wire\")]`",
            ))
        } else {
            Ok(options)
        }
    }
}
