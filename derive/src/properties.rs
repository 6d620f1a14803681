//! `#[derive(Properties)]`: turns a struct into the declaration, the handles and the snapshot of
//! properties.

use proc_macro2::{Span, TokenStream};
use quote::quote;
use syn::meta::ParseNestedMeta;
use syn::{DeriveInput, Error, Field, Ident, LitStr, PathArguments, Result, Type};

use crate::duration;
use crate::field::{documentation, each, named, plain, range, text, value};

/// One field and its `#[property(…)]` attribute.
struct PropertyField<'a> {
    field: &'a Field,
    name: &'a Ident,
    options: Options,
    /// For a `Duration`, the number of its units in a second: composites write it as a number.
    per_second: Option<f64>,
}

#[derive(Default)]
struct Options {
    unit: Option<LitStr>,
    /// Least and greatest value, inclusive.
    range: Option<(TokenStream, TokenStream)>,
    default: Option<TokenStream>,
    /// An expression for an iterator over all permitted values.
    choices: Option<TokenStream>,
    /// The type implements `Word`, and its words are the permitted values.
    words: bool,
    /// The field is itself a struct of properties, whose fields are declared in its place.
    flatten: bool,
}

pub fn derive(input: &DeriveInput) -> Result<TokenStream> {
    let properties = each(named(input, "Properties")?, PropertyField::parse)?;
    let of = &input.ident;
    let names: Vec<_> = properties.iter().map(|it| it.name).collect();
    let handles = properties.iter().map(PropertyField::handle);
    let reads = properties.iter().map(PropertyField::read);
    let defaults = properties.iter().map(PropertyField::default);
    let defaults = defaults.collect::<Result<Vec<_>>>()?;
    let declares = properties.iter().map(PropertyField::declare);
    let declares = declares.collect::<Result<Vec<_>>>()?;
    let plain_names: Vec<_> = names.iter().map(|name| plain(name)).collect();
    let writes = properties.iter().map(PropertyField::write);
    let restores = properties.iter().map(PropertyField::restore);
    Ok(quote! {
        const _: () = {
            use ::asmotion_component as component;

            #[doc(hidden)]
            #[derive(Clone, Copy)]
            pub struct Handles {
                #(#names: #handles,)*
            }

            #[automatically_derived]
            impl component::Properties for #of {
                type Handles = Handles;

                fn declare(interface: &mut component::Interface) -> Handles {
                    let default = <Self as ::core::default::Default>::default();
                    Handles { #(#names: #declares,)* }
                }

                fn read(handles: &Handles, from: &impl component::PropertySource) -> Self {
                    Self { #(#names: #reads,)* }
                }

                fn to_datum(&self) -> ::core::result::Result<component::frozen::Datum, component::frozen::DatumError> {
                    ::core::result::Result::Ok(component::frozen::Datum::record([#((#plain_names, #writes)),*]))
                }

                fn of_datum(
                    datum: &component::frozen::Datum,
                ) -> ::core::result::Result<Self, component::frozen::DatumError> {
                    let fields = component::frozen::entries(datum)?;
                    component::frozen::refuse_unknown(fields, &[#(#plain_names),*])?;
                    ::core::result::Result::Ok(Self { #(#names: #restores,)* })
                }
            }

            #[automatically_derived]
            impl ::core::default::Default for #of {
                fn default() -> Self {
                    Self { #(#names: #defaults,)* }
                }
            }
        };
    })
}

impl<'a> PropertyField<'a> {
    fn parse(field: &'a Field, name: &'a Ident) -> Result<Self> {
        let mut options = Options::default();
        for attribute in &field.attrs {
            if attribute.path().is_ident("property") {
                attribute.parse_nested_meta(|meta| options.parse(&meta))?;
            }
        }
        let mut property = Self {
            field,
            name,
            options,
            per_second: None,
        };
        property.check()?;
        Ok(property)
    }

    /// Rejects combinations of options of which one would silently have no effect.
    fn check(&mut self) -> Result<()> {
        let Options {
            unit,
            range,
            default,
            choices,
            words,
            flatten,
        } = &mut self.options;
        let says_more =
            unit.is_some() || range.is_some() || default.is_some() || choices.is_some() || *words;
        if *flatten && says_more {
            let message = "`flatten` stands alone: the struct's own fields say the rest";
            return Err(Error::new_spanned(self.name, message));
        }
        if is_duration(&self.field.ty) {
            let unit = unit.get_or_insert_with(|| LitStr::new("s", Span::call_site()));
            let per_second = duration::per_second(&unit.value());
            let unknown = || Error::new(unit.span(), "the unit of a duration is `s`, `ms` or `us`");
            self.per_second = Some(per_second.ok_or_else(unknown)?);
            if range.is_none() {
                let message = "a duration needs a range: `range = \"0s\"..=\"10s\"`";
                return Err(Error::new_spanned(self.name, message));
            }
        }
        Ok(())
    }

    fn handle(&self) -> TokenStream {
        let of = &self.field.ty;
        match self.per_second {
            _ if self.options.flatten => quote!(<#of as component::Properties>::Handles),
            Some(_) => quote!(component::Property<f64>),
            None if self.options.words => {
                quote!(component::Property<::std::string::String>)
            }
            None => quote!(component::Property<#of>),
        }
    }

    fn read(&self) -> TokenStream {
        let (name, of) = (self.name, &self.field.ty);
        let value = quote!(component::PropertySource::property(from, handles.#name));
        match self.per_second {
            _ if self.options.flatten => {
                quote!(<#of as component::Properties>::read(&handles.#name, from))
            }
            // cannot fail: the mandatory range has excluded everything that is no valid duration
            Some(per_second) => quote! {
                ::core::time::Duration::try_from_secs_f64(#value / #per_second).unwrap_or_default()
            },
            // cannot fail: the choices have excluded everything that is no word
            None if self.options.words => {
                quote!(<#of as component::Word>::of_word(&#value).unwrap_or_default())
            }
            None => value,
        }
    }

    /// The value as a datum.
    fn write(&self) -> TokenStream {
        let name = self.name;
        if self.options.flatten {
            quote!(component::Properties::to_datum(&self.#name)?)
        } else if self.options.words {
            quote!(component::frozen::Datum::text(component::Word::word(self.#name)))
        } else {
            quote!(component::frozen::StateField::to_datum(&self.#name)?)
        }
    }

    /// The value from the entries of a record.
    fn restore(&self) -> TokenStream {
        let (name, of) = (plain(self.name), &self.field.ty);
        if self.options.flatten {
            quote!(component::frozen::nested::<#of>(fields, #name)?)
        } else if self.options.words {
            quote!(component::frozen::word::<#of>(fields, #name)?)
        } else {
            quote!(component::frozen::field::<#of>(fields, #name)?)
        }
    }

    fn default(&self) -> Result<TokenStream> {
        let Some(default) = &self.options.default else {
            return Ok(quote!(::core::default::Default::default()));
        };
        Ok(match (text(default), self.per_second) {
            (Some(text), Some(_)) => {
                let nanos = duration::nanos(&text)?;
                quote!(::core::time::Duration::from_nanos(#nanos))
            }
            (Some(text), None) => quote!(::core::convert::From::from(#text)),
            (None, _) => default.clone(),
        })
    }

    fn declare(&self) -> Result<TokenStream> {
        let (field, of, name) = (self.name, &self.field.ty, plain(self.name));
        if self.options.flatten {
            return Ok(quote!(<#of as component::Properties>::declare(interface)));
        }
        let doc = documentation(self.field)?;
        let default = match self.per_second {
            Some(per_second) => quote!(default.#field.as_secs_f64() * #per_second),
            None if self.options.words => {
                quote!(component::Word::word(default.#field).to_owned())
            }
            None => quote!(default.#field),
        };
        let Options {
            unit,
            range,
            choices,
            words,
            ..
        } = &self.options;
        let range = range.as_ref().map(|(least, greatest)| {
            Ok::<_, Error>(match self.per_second {
                Some(scale) => {
                    let (least, greatest) = (number(least, scale)?, number(greatest, scale)?);
                    quote!(.range(#least..=#greatest))
                }
                None => quote!(.range((#least)..=(#greatest))),
            })
        });
        let range = range.transpose()?;
        let unit = unit.as_ref().map(|unit| quote!(.unit(#unit)));
        let choices = choices.as_ref().map(|choices| quote!(.choices(#choices)));
        let words = words.then(|| {
            quote! {
                .choices(<#of as component::Word>::words())
            }
        });
        Ok(quote! {
            interface.setting(#name, #default, #doc) #range #unit #choices #words .declare()
        })
    }
}

impl Options {
    fn parse(&mut self, meta: &ParseNestedMeta<'_>) -> Result<()> {
        if meta.path.is_ident("unit") {
            self.unit = Some(meta.value()?.parse()?);
        } else if meta.path.is_ident("range") {
            self.range = Some(range(meta.value()?)?);
        } else if meta.path.is_ident("default") {
            self.default = Some(value(meta.value()?)?);
        } else if meta.path.is_ident("choices") {
            self.choices = Some(value(meta.value()?)?);
        } else if meta.path.is_ident("words") {
            self.words = true;
        } else if meta.path.is_ident("flatten") {
            self.flatten = true;
        } else {
            let known =
                "a property has `unit`, `range`, `default`, `choices`, `words` or `flatten`";
            return Err(meta.error(known));
        }
        Ok(())
    }
}

/// Returns `true` if a type is written as `Duration`.
fn is_duration(of: &Type) -> bool {
    let Type::Path(path) = of else {
        return false;
    };
    let last = path.path.segments.last();
    last.is_some_and(|last| {
        last.ident == "Duration" && matches!(last.arguments, PathArguments::None)
    })
}

/// Converts a duration literal to a number of the property's unit.
fn number(written: &TokenStream, per_second: f64) -> Result<f64> {
    let text = text(written).ok_or_else(|| {
        let message = "the range of a duration is written `\"0s\"..=\"10s\"`";
        Error::new_spanned(written, message)
    })?;
    Ok(duration::nanos(&text)? as f64 / 1e9 * per_second)
}
