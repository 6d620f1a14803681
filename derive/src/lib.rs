//! Derive macros: a fact about a field is written once, on the field, and each list that repeats it
//! is generated.
//!
//! The macros are used through the crates whose traits they implement, where they are documented with examples.

mod duration;
mod field;
mod freeze;
mod ports;
mod properties;
mod table;
mod word;

use proc_macro::TokenStream;
use syn::{DeriveInput, Error, Result, parse_macro_input};

/// Declares each field of a struct as a property, described by its doc comment.
///
/// `#[property(unit = "m/s", range = 0.0..=5.0, default = 0.5)]` adds the optional unit, range and
/// default. The default is otherwise that of the type (`0`, `false`, empty). See the trait for an
/// example and for the types that a field may have.
#[proc_macro_derive(Properties, attributes(property))]
pub fn properties(input: TokenStream) -> TokenStream {
    expand(&parse_macro_input!(input), properties::derive)
}

/// Declares each field of a struct of `In`, `Out`, `Provided` and `Required` handles as a port,
/// described by its doc comment. The port has the field's name unless `#[port(name = "…")]` gives
/// another.
///
/// `#[port(optional)]` marks an input or a reference that may stay unconnected. `#[port(safe)]` marks an output to which
/// the engine writes the default of its type after the component's last cycle. `#[port(command)]` marks an input
/// whose samples are discarded when the component starts, if they arrived before.
#[proc_macro_derive(Ports, attributes(port))]
pub fn ports(input: TokenStream) -> TokenStream {
    expand(&parse_macro_input!(input), ports::derive)
}

/// Implements `Freeze` for a component's struct: every unmarked field is state and is converted by
/// serde.
///
/// `#[freeze(component = "nav::Follower", version = 1)]` on the struct gives the name of the type
/// and the version of its layout. The option `check = "Self::is_idle"` names a function
/// `fn(&self) -> Result<(), FreezeProblem>` that is called before freezing. When a state is thawed,
/// a field marked `#[freeze(skip)]` keeps its value, and one marked `#[freeze(reset)]` is set to its
/// `Default`.
#[proc_macro_derive(Freeze, attributes(freeze))]
pub fn freeze(input: TokenStream) -> TokenStream {
    expand(&parse_macro_input!(input), freeze::derive)
}

/// Implements `asmotion_datum::Word` and `Display` for an enum without fields: each variant is a
/// keyword of a file, explained by its doc comment. `InPlace` is written `in_place`, unless
/// `#[word("other")]` gives another spelling.
#[proc_macro_derive(Word, attributes(word))]
pub fn word(input: TokenStream) -> TokenStream {
    expand(&parse_macro_input!(input), word::derive)
}

/// Declares a struct or an enum as a table of the composite dialect. Its fields, their doc comments
/// and `#[key(…)]` generate the reader, the schema with its hover texts, the rows of the reference
/// page and, with `#[table(resolved = Name)]` or `#[table(into = path)]`, the same table without
/// source spans together with its writer. Usable only in the crate that has the module `table`.
#[proc_macro_derive(Table, attributes(table, key))]
pub fn table(input: TokenStream) -> TokenStream {
    expand(&parse_macro_input!(input), table::derive)
}

/// Runs a derive and turns its errors into compile errors at their spans.
fn expand(
    input: &DeriveInput,
    derive: fn(&DeriveInput) -> Result<proc_macro2::TokenStream>,
) -> TokenStream {
    derive(input)
        .unwrap_or_else(Error::into_compile_error)
        .into()
}

#[cfg(test)]
mod tests {
    use syn::parse_quote;

    use super::*;

    /// Returns the error messages of a derive for a faulty input, one a line.
    fn refusal(
        derive: fn(&DeriveInput) -> Result<proc_macro2::TokenStream>,
        input: &DeriveInput,
    ) -> String {
        derive(input).err().map_or_else(String::new, |error| {
            let lines: Vec<_> = error.into_iter().map(|one| one.to_string()).collect();
            lines.join("\n")
        })
    }

    #[test]
    fn every_mistake_in_properties_is_reported_at_once() {
        let input = parse_quote! {
            struct Wrong {
                max_speed: f64,
                /// A duration.
                timeout: Duration,
                /// Another one.
                #[property(unit = "h", range = "0s"..="1s")]
                rest: Duration,
                /// With a misspelt part.
                #[property(maximum = 3)]
                count: u32,
                /// A struct, and more.
                #[property(flatten, unit = "m")]
                limits: Limits,
            }
        };
        let refusal = refusal(properties::derive, &input);
        let lines: Vec<_> = refusal.lines().collect();
        assert_eq!(
            lines,
            [
                "a duration needs a range: `range = \"0s\"..=\"10s\"`",
                "the unit of a duration is `s`, `ms` or `us`",
                "a property has `unit`, `range`, `default`, `choices`, `words` or `flatten`",
                "`flatten` stands alone: the struct's own fields say the rest",
            ]
        );
    }

    #[test]
    fn a_field_without_a_doc_comment_is_refused() {
        let input = parse_quote!(
            struct Wrong {
                max_speed: f64,
            }
        );
        assert!(refusal(properties::derive, &input).contains("needs a doc comment"));
        let input = parse_quote!(
            struct Wrong {
                path: In<Path>,
            }
        );
        assert!(refusal(ports::derive, &input).contains("needs a doc comment"));
    }

    #[test]
    fn a_port_is_one_of_four_handles_and_no_output_is_optional() {
        let input = parse_quote! {
            struct Wrong {
                /// A number.
                count: u32,
                /// An output.
                #[port(optional)]
                path: Out<Path>,
            }
        };
        let refusal = refusal(ports::derive, &input);
        assert!(refusal.starts_with("a port is an `In<T>`"), "{refusal}");
        assert!(
            refusal.ends_with("an output `safe`, and a reference `optional`"),
            "{refusal}"
        );
    }

    #[test]
    fn a_frozen_struct_names_its_type_and_its_version() {
        let input = parse_quote!(
            struct Wrong {
                count: u32,
            }
        );
        assert!(refusal(freeze::derive, &input).contains("version = 1"));
        let input = parse_quote!(
            #[freeze(component = "test::Wrong", version = 1)]
            struct Wrong {
                #[freeze(forget)]
                count: u32,
            }
        );
        assert_eq!(
            refusal(freeze::derive, &input),
            "a field is state, or marked `skip` or `reset`"
        );
    }

    #[test]
    fn a_word_carries_nothing() {
        let input = parse_quote!(
            enum Wrong {
                Plain,
                Carrying(u32),
            }
        );
        assert!(refusal(word::derive, &input).contains("no fields"));
    }

    #[test]
    fn a_table_says_what_it_is_and_its_ranges_include_their_ends() {
        let input = parse_quote!(
            struct Wrong {}
        );
        assert!(refusal(table::derive, &input).contains("say what it is"));
        let input = parse_quote!(
            #[table(of = "a lamp")]
            struct Wrong {
                #[key(range = 1..9)]
                watt: u64,
            }
        );
        assert!(refusal(table::derive, &input).contains("a range includes its end"));
        let input = parse_quote!(
            #[table(of = "a lamp")]
            struct Wrong {
                #[key(rage = 1)]
                watt: u64,
            }
        );
        assert_eq!(refusal(table::derive, &input), "not an attribute of a key");
    }
}
