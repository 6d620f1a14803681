//! `#[derive(Table)]`: declares a struct or an enum as a table of the composite dialect.
//!
//! The struct mirrors the file: `At<T>` for a value with its span, `Option` for an optional key,
//! `Vec` for a key that may occur several times. The derive generates the reader, the rows of the
//! schema and of the reference page, and, with `resolved = Name`, the same table without spans and
//! with its defaults filled in, together with its writer.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};
use syn::{
    Data, DataEnum, DataStruct, DeriveInput, Error, Expr, ExprLit, ExprRange, Field, Fields,
    GenericArgument, Ident, Lit, LitStr, PathArguments, RangeLimits, Result, Type, Variant,
};

use crate::word::{doc, snake};

/// The options of `#[table(…)]`.
struct TableOptions {
    /// Phrase for the table in messages: "a wire".
    of: String,
    /// A key and the phrase for the table under that key: `elsewhere("activity", "an activity")`.
    elsewhere: Option<(LitStr, LitStr)>,
    /// An example of the table in TOML, for messages.
    example: String,
    /// Message that explains why only one variant of an enum may be given.
    reason: String,
    /// Name of the generated table without spans.
    resolved: Option<Ident>,
    /// A function that checks or completes the table after its keys were read.
    after: Option<Expr>,
    /// The key that is meant when a plain value stands in place of the table.
    short: Option<String>,
}

/// The options of `#[key(…)]` on a field or variant.
struct KeyDeclaration {
    ident: Ident,
    kind: Type,
    doc: String,
    name: String,
    example: String,
    unit: String,
    range: Option<ExprRange>,
    /// From `default`; `Some(None)` stands for the default of the type.
    default: Option<Option<Expr>>,
    needed: bool,
    flatten: bool,
    or_default: bool,
    /// A name that is prefixed with the path of the enclosing composites when it is resolved.
    local: bool,
    /// Omitted from the resolved table if it was not given.
    unresolved: bool,
    /// Only in the table as written, not in the resolved one.
    written: bool,
    /// A list in which a single element may be written without brackets.
    one: bool,
    /// Restricts the key to tables under this key; empty for no restriction.
    within: String,
    /// Syntax check for a value that is a name.
    form: Option<Ident>,
    /// The field holds the name of the entry in a table of names; with the syntax check of that
    /// name.
    entry: Option<Ident>,
}

/// The outermost constructor of a field's type.
enum FieldShape<'t> {
    Option(&'t Type),
    Vec(&'t Type),
    One(&'t Type),
}

pub(crate) fn derive(input: &DeriveInput) -> Result<TokenStream> {
    let options = TableOptions::of(input)?;
    match &input.data {
        Data::Struct(data) => of_struct(input, data, &options),
        Data::Enum(data) => of_enum(input, data, &options),
        Data::Union(_) => Err(Error::new_spanned(input, "a union is no table")),
    }
}

impl TableOptions {
    fn of(input: &DeriveInput) -> Result<Self> {
        let mut options = Self {
            of: String::new(),
            elsewhere: None,
            example: "{ }".to_owned(),
            reason: String::new(),
            resolved: None,
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
                    "resolved" => options.resolved = Some(value.parse()?),
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

impl KeyDeclaration {
    fn of(ident: &Ident, kind: &Type, attributes: &[syn::Attribute]) -> Result<Self> {
        let mut row = Self {
            ident: ident.clone(),
            kind: kind.clone(),
            doc: doc(attributes),
            name: snake(&ident.to_string()),
            example: String::new(),
            unit: String::new(),
            range: None,
            default: None,
            needed: false,
            flatten: false,
            or_default: false,
            local: false,
            unresolved: false,
            written: false,
            one: false,
            within: String::new(),
            form: None,
            entry: None,
        };
        for attribute in attributes.iter().filter(|it| it.path().is_ident("key")) {
            attribute.parse_nested_meta(|meta| {
                let name = meta.path.require_ident()?.to_string();
                match name.as_str() {
                    "name" => row.name = meta.value()?.parse::<LitStr>()?.value(),
                    "example" => row.example = meta.value()?.parse::<LitStr>()?.value(),
                    "unit" => row.unit = meta.value()?.parse::<LitStr>()?.value(),
                    "within" => row.within = meta.value()?.parse::<LitStr>()?.value(),
                    "range" => row.range = Some(meta.value()?.parse()?),
                    "form" => row.form = Some(meta.value()?.parse()?),
                    "entry" => row.entry = Some(meta.value()?.parse()?),
                    "default" if meta.input.peek(syn::Token![=]) => {
                        row.default = Some(Some(meta.value()?.parse()?));
                    }
                    "default" => row.default = Some(None),
                    "needed" => row.needed = true,
                    "flatten" => row.flatten = true,
                    "or_default" => row.or_default = true,
                    "local" => row.local = true,
                    "unresolved" => row.unresolved = true,
                    "written" => row.written = true,
                    "one" => row.one = true,
                    _ => return Err(meta.error("not an attribute of a key")),
                }
                Ok(())
            })?;
        }
        if matches!(row.shape(), FieldShape::One(_)) && !row.or_default && !row.is("bool") {
            row.needed = true;
        }
        Ok(row)
    }

    fn of_field(field: &Field) -> Result<Self> {
        match &field.ident {
            Some(ident) => Self::of(ident, &field.ty, &field.attrs),
            None => Err(Error::new_spanned(field, "a key has a name")),
        }
    }

    /// Returns `true` if the field's type is this name.
    fn is(&self, name: &str) -> bool {
        matches!(&self.kind, Type::Path(path) if path.path.is_ident(name))
    }

    /// Returns `true` for a field that is no key: a span or the name of the entry.
    fn is_place(&self) -> bool {
        self.is("FileId") || self.ident == "span" || self.entry.is_some()
    }

    fn shape(&self) -> FieldShape<'_> {
        let Type::Path(path) = &self.kind else {
            return FieldShape::One(&self.kind);
        };
        let last = path.path.segments.last();
        let inner = last.and_then(|segment| match &segment.arguments {
            PathArguments::AngleBracketed(arguments) => match arguments.args.first() {
                Some(GenericArgument::Type(inner)) => Some((segment.ident.to_string(), inner)),
                _ => None,
            },
            PathArguments::None | PathArguments::Parenthesized(_) => None,
        });
        match inner {
            Some((name, inner)) if name == "Option" => FieldShape::Option(inner),
            Some((name, inner)) if name == "Vec" => FieldShape::Vec(inner),
            _ => FieldShape::One(&self.kind),
        }
    }

    fn inner(&self) -> &Type {
        match self.shape() {
            FieldShape::Option(inner) | FieldShape::Vec(inner) | FieldShape::One(inner) => inner,
        }
    }

    /// Generates the description of the key.
    fn key(&self) -> TokenStream {
        let Self {
            name,
            doc,
            example,
            unit,
            needed,
            within,
            ..
        } = self;
        let inner = self.inner();
        let bound = |bound: Option<&Expr>, none: TokenStream| match bound {
            Some(Expr::Lit(ExprLit {
                lit: lit @ Lit::Float(_),
                ..
            })) => quote!(#lit),
            Some(bound) => quote!((#bound) as f64),
            None => none,
        };
        let range = self.range.as_ref();
        let least = bound(
            range.and_then(|it| it.start.as_deref()),
            quote!(f64::NEG_INFINITY),
        );
        let greatest = bound(
            range.and_then(|it| it.end.as_deref()),
            quote!(f64::INFINITY),
        );
        let default = match &self.default {
            Some(_) => {
                let (kind, value) = (self.resolved_kind(), self.default_value());
                quote!(Some(|| {
                    let value: #kind = #value;
                    crate::table::Written::toml(&value)
                }))
            }
            None => quote!(None),
        };
        let many = match self.shape() {
            FieldShape::Vec(_) => quote!(Some(<#inner as crate::table::Value>::MANY)),
            FieldShape::Option(_) | FieldShape::One(_) => quote!(None),
        };
        quote!(crate::table::Key {
            name: #name,
            doc: #doc,
            example: #example,
            unit: #unit,
            needed: #needed,
            least: #least,
            greatest: #greatest,
            within: #within,
            default: #default,
            many: #many,
            schema: <#inner as crate::table::Value>::schema,
            table: <#inner as crate::table::Value>::table,
        })
    }

    /// Generates the expression that reads the key, an `Option` if the key is mandatory.
    fn read(&self, key: &TokenStream) -> TokenStream {
        let inner = self.inner();
        if self.is("FileId") {
            return quote!(keys.span.file);
        }
        if self.ident == "span" {
            return quote!(keys.span);
        }
        if self.entry.is_some() {
            return quote!(name.clone());
        }
        if self.flatten {
            return quote!(<#inner as crate::table::Table>::read_keys(keys, name));
        }
        let read = match self.shape() {
            FieldShape::Vec(_) => quote!(keys.many::<#inner>(#key)),
            FieldShape::Option(_) => quote!(keys.optional::<#inner>(#key)),
            FieldShape::One(_) if self.or_default || self.is("bool") => {
                quote!(keys.optional::<#inner>(#key).unwrap_or_default())
            }
            FieldShape::One(_) => quote!(keys.optional::<#inner>(#key)),
        };
        let read = match &self.form {
            Some(form) => {
                quote!(#read.and_then(|it| crate::table::derived::name::#form(keys.reader, &it)))
            }
            None => read,
        };
        let within = &self.within;
        if within.is_empty() {
            read
        } else {
            quote!(if keys.within == #within { #read } else { Default::default() })
        }
    }

    /// Returns `true` if the table cannot be built without this key.
    fn is_unwrapped(&self) -> bool {
        let one = matches!(self.shape(), FieldShape::One(_));
        one && !self.is_place() && !self.or_default && !self.is("bool")
    }

    fn resolved_kind(&self) -> TokenStream {
        let inner = self.inner();
        let resolved = quote!(<#inner as crate::table::Resolve>::Resolved);
        match self.shape() {
            FieldShape::Vec(_) => quote!(Vec<#resolved>),
            FieldShape::Option(_) if self.default.is_none() => quote!(Option<#resolved>),
            FieldShape::One(_) if self.unresolved => quote!(Option<#resolved>),
            FieldShape::Option(_) | FieldShape::One(_) => resolved,
        }
    }

    fn default_value(&self) -> TokenStream {
        match &self.default {
            Some(Some(Expr::Lit(ExprLit {
                lit: Lit::Str(text),
                ..
            }))) => quote!(#text.to_owned()),
            Some(Some(value)) => quote!(#value),
            Some(None) | None => quote!(Default::default()),
        }
    }

    /// Generates the conversion to the value without its span.
    fn resolve(&self, key: &TokenStream) -> TokenStream {
        let ident = &self.ident;
        let local = if self.local {
            quote!(.map(|it| to.local(&it)))
        } else {
            quote!()
        };
        let one = quote!(it.resolve(#key, to)#local);
        match self.shape() {
            FieldShape::Vec(_) => quote!(self.#ident.iter().filter_map(|it| #one).collect()),
            FieldShape::Option(_) => {
                let found = quote!(self.#ident.as_ref().and_then(|it| #one));
                let default = self.default_value();
                match self.default {
                    Some(_) => quote!(#found.unwrap_or_else(|| #default)),
                    None => found,
                }
            }
            FieldShape::One(_) => {
                let found = quote!({ let it = &self.#ident; #one });
                if self.unresolved {
                    found
                } else {
                    quote!(#found?)
                }
            }
        }
    }

    fn write(&self) -> TokenStream {
        let (ident, name, within) = (&self.ident, &self.name, &self.within);
        let value = match (self.one, self.needed, self.shape()) {
            (true, _, _) => quote!(crate::table::one_or_many(&self.#ident)),
            // an empty list is written, unlike an absent key
            (false, true, FieldShape::Vec(_)) => quote!(Some(crate::table::list(&self.#ident))),
            (false, _, _) => quote!(crate::table::Written::toml(&self.#ident)),
        };
        let write = quote!(keys.put_some(#name, #value););
        if within.is_empty() {
            write
        } else {
            quote!(if within == #within { #write })
        }
    }
}

fn of_struct(
    input: &DeriveInput,
    data: &DataStruct,
    options: &TableOptions,
) -> Result<TokenStream> {
    let Fields::Named(fields) = &data.fields else {
        return Err(Error::new_spanned(input, "a table has named fields"));
    };
    let rows = fields
        .named
        .iter()
        .map(KeyDeclaration::of_field)
        .collect::<Result<Vec<_>>>()?;
    for row in &rows {
        if let Some(ExprRange {
            limits: RangeLimits::HalfOpen(_),
            ..
        }) = &row.range
        {
            return Err(Error::new(
                row.ident.span(),
                "a range includes its end: `1..=9`",
            ));
        }
    }
    let name = &input.ident;
    let keys: Vec<&KeyDeclaration> = rows
        .iter()
        .filter(|it| !it.is_place() && !it.flatten)
        .collect();
    let index = |row: &KeyDeclaration| {
        let at = keys
            .iter()
            .position(|it| it.ident == row.ident)
            .unwrap_or_default();
        quote!(&Self::KEYS[#at])
    };
    let consts = keys.iter().map(|row| row.key());
    let outline = rows.iter().filter(|it| !it.is_place()).map(|row| {
        if row.flatten {
            let inner = row.inner();
            quote!(outline.append(<#inner as crate::table::Table>::outline());)
        } else {
            let key = index(row);
            quote!(outline.add(#key);)
        }
    });
    let reads = rows.iter().map(|row| {
        let (ident, read) = (&row.ident, row.read(&index(row)));
        quote!(let #ident = #read;)
    });
    let made = rows.iter().map(|row| {
        let ident = &row.ident;
        if row.is_unwrapped() {
            quote!(#ident: #ident?)
        } else {
            quote!(#ident)
        }
    });
    let after = options.after.iter();
    let common = common(input, options, rows.iter().find_map(|it| it.entry.as_ref()));
    let resolved = resolved(input, options, &rows, &index);
    Ok(quote! {
        impl #name {
            const KEYS: &'static [crate::table::Key] = &[#(#consts),*];
        }

        impl crate::table::Table for #name {
            fn outline() -> crate::table::Outline {
                let mut outline = Self::blank();
                #(#outline)*
                outline
            }

            fn read_keys(keys: &mut crate::table::derived::Keys<'_, '_, '_>, name: &crate::table::derived::At<String>) -> Option<Self> {
                #(#reads)*
                #[allow(unused_mut, reason = "only some tables are looked at again")]
                let mut table = Self { #(#made),* };
                #(#after(&mut table, keys);)*
                Some(table)
            }
        }

        #common
        #resolved
    })
}

/// Generates the items that do not depend on the fields.
fn common(input: &DeriveInput, options: &TableOptions, entry: Option<&Ident>) -> TokenStream {
    let (name, doc) = (&input.ident, doc(&input.attrs));
    let TableOptions {
        of, example, short, ..
    } = options;
    let of_here = match &options.elsewhere {
        Some((key, of_there)) => quote!(if spec.name == #key { #of_there } else { #of }),
        None => quote!(#of),
    };
    let many = match entry {
        Some(_) => quote!(crate::table::Many::Names),
        None => quote!(crate::table::Many::Tables),
    };
    let entry_name = match entry {
        Some(check) => quote!(crate::table::derived::name::#check(reader, key)?),
        None => quote!(key.clone()),
    };
    let place = entry.map(|_| quote!(keys.span = name.span;));
    let short_read = short.as_ref().map(|short| {
        quote! {
            if !matches!(node.value, crate::table::derived::Branch::Table(_)) {
                let table = crate::table::derived::Tree::short(#short, node);
                let mut keys = reader.keys(&table, #of, node.span);
                return <Self as crate::table::Table>::read_keys(&mut keys, &name);
            }
        }
    });
    let short_schema = short.as_ref().map(|short| {
        quote!(let schema = crate::table::or_short(schema, <Self as crate::table::Table>::outline(), #short);)
    });
    quote! {
        impl #name {
            fn blank() -> crate::table::Outline {
                crate::table::Outline::new(#of, #doc)
            }
        }

        impl crate::table::Value for #name {
            const MANY: crate::table::Many = #many;

            fn schema(key: &crate::table::Key) -> serde_json::Value {
                let schema = <Self as crate::table::Table>::outline().within(key.name).schema();
                #short_schema
                schema
            }

            fn table(key: &crate::table::Key) -> Option<crate::table::Outline> {
                Some(<Self as crate::table::Table>::outline().within(key.name))
            }

            fn read(
                reader: &mut crate::table::derived::Reader<'_>,
                key: &crate::table::derived::At<String>,
                spec: &crate::table::Key,
                node: &crate::table::derived::Node,
            ) -> Option<Self> {
                let name = #entry_name;
                #short_read
                let mut keys = reader.keys_of(node, key, #of_here, #example)?;
                keys.within = spec.name;
                #place
                <Self as crate::table::Table>::read_keys(&mut keys, &name)
            }
        }
    }
}

/// Generates the table without spans.
fn resolved(
    input: &DeriveInput,
    options: &TableOptions,
    rows: &[KeyDeclaration],
    index: &dyn Fn(&KeyDeclaration) -> TokenStream,
) -> TokenStream {
    let Some(twin) = &options.resolved else {
        return quote!();
    };
    let name = &input.ident;
    let doc = format!(
        "{} As it holds in a plan: without places, substituted, with defaults.",
        doc(&input.attrs)
    );
    let kept: Vec<&KeyDeclaration> = rows
        .iter()
        .filter(|it| !it.written && it.ident != "span" && !it.is("FileId"))
        .collect();
    let fields = kept.iter().map(|row| {
        let (ident, kind, doc) = (&row.ident, row.resolved_kind(), &row.doc);
        quote!(#[doc = #doc] pub #ident: #kind)
    });
    let values = kept.iter().map(|row| {
        let key = match row.entry {
            Some(_) => quote!(&crate::table::Key::NAME),
            None => index(row),
        };
        let (ident, value) = (&row.ident, row.resolve(&key));
        quote!(#ident: #value)
    });
    let writes = kept
        .iter()
        .filter(|it| it.entry.is_none())
        .map(|row| row.write());
    let is_open =
        |row: &&KeyDeclaration| row.default.is_some() || !matches!(row.shape(), FieldShape::One(_));
    let default = kept.iter().all(is_open).then(|| {
        let values = kept.iter().map(|row| {
            let (ident, value) = (&row.ident, row.default_value());
            quote!(#ident: #value)
        });
        quote! {
            impl Default for #twin {
                fn default() -> Self {
                    Self { #(#values),* }
                }
            }
        }
    });
    quote! {
        #[doc = #doc]
        #[derive(Clone, Debug, PartialEq)]
        pub struct #twin { #(#fields),* }

        impl crate::table::Resolve for #name {
            type Resolved = #twin;

            fn resolve(&self, _: &crate::table::Key, to: &mut crate::table::Resolver<'_>) -> Option<#twin> {
                Some(#twin { #(#values),* })
            }
        }

        #default

        impl crate::table::WrittenTable for #twin {
            fn keys(&self, within: &str) -> crate::table::Lines {
                let mut keys = crate::table::Lines::new();
                #(#writes)*
                keys
            }
        }

        impl crate::table::Written for #twin {
            fn toml(&self) -> Option<toml_edit::Value> {
                crate::table::WrittenTable::keys(self, "").inline()
            }

            fn list(items: &[Self]) -> Option<toml_edit::Value> {
                crate::table::tables_of(items)
            }
        }
    }
}

/// A variant and its keys; the first key selects the variant.
struct VariantKeys {
    rows: Vec<KeyDeclaration>,
    /// The table wrapped by a variant with one unnamed field, which provides the keys.
    inner: Option<Type>,
    /// The variant has named fields.
    named: bool,
    ident: Ident,
}

impl VariantKeys {
    fn of(variant: &Variant) -> Result<Self> {
        let ident = variant.ident.clone();
        match &variant.fields {
            Fields::Named(fields) => Ok(Self {
                rows: fields
                    .named
                    .iter()
                    .map(KeyDeclaration::of_field)
                    .collect::<Result<_>>()?,
                inner: None,
                named: true,
                ident,
            }),
            Fields::Unnamed(fields) if fields.unnamed.len() == 1 => {
                let kind = &fields.unnamed[0].ty;
                let row = KeyDeclaration::of(&ident, kind, &variant.attrs)?;
                let inner = row.flatten.then(|| kind.clone());
                Ok(Self {
                    rows: vec![row],
                    inner,
                    named: false,
                    ident,
                })
            }
            Fields::Unnamed(_) | Fields::Unit => Err(Error::new_spanned(
                variant,
                "a variant has named fields, or one",
            )),
        }
    }
}

fn of_enum(input: &DeriveInput, data: &DataEnum, options: &TableOptions) -> Result<TokenStream> {
    let name = &input.ident;
    let choices = data
        .variants
        .iter()
        .map(VariantKeys::of)
        .collect::<Result<Vec<_>>>()?;
    let reason = &options.reason;
    let constants = choices
        .iter()
        .filter(|it| it.inner.is_none())
        .map(|choice| {
            let keys = choice.rows.iter().map(KeyDeclaration::key);
            let constant = constant(&choice.ident);
            quote!(const #constant: &'static [crate::table::Key] = &[#(#keys),*];)
        });
    let chosen_by = choices.iter().map(|choice| match &choice.inner {
        Some(inner) => quote!(<#inner as crate::table::Table>::first()),
        None => {
            let constant = constant(&choice.ident);
            quote!(&Self::#constant[0])
        }
    });
    let outline = choices.iter().map(|choice| match &choice.inner {
        Some(inner) => quote!(outline.choice(<#inner as crate::table::Table>::outline().all());),
        None => {
            let constant = constant(&choice.ident);
            quote!(outline.choice(Self::#constant.iter().collect());)
        }
    });
    let arms = choices.iter().enumerate().map(|(at, choice)| {
        let (variant, constant) = (&choice.ident, constant(&choice.ident));
        if let Some(inner) = &choice.inner {
            return quote!(Some(#at) => Self::#variant(<#inner as crate::table::Table>::read_keys(keys, name)?));
        }
        let bindings: Vec<Ident> = (0..choice.rows.len()).map(|at| format_ident!("field{at}")).collect();
        let reads = choice.rows.iter().enumerate().map(|(at, row)| {
            let (binding, read) = (&bindings[at], row.read(&quote!(&Self::#constant[#at])));
            quote!(let #binding = #read;)
        });
        let made = choice.rows.iter().enumerate().map(|(at, row)| {
            let (binding, ident) = (&bindings[at], &row.ident);
            let value = if row.is_unwrapped() { quote!(#binding?) } else { quote!(#binding) };
            if choice.named { quote!(#ident: #value) } else { value }
        });
        let made = if choice.named { quote!(Self::#variant { #(#made),* }) } else { quote!(Self::#variant(#(#made),*)) };
        quote!(Some(#at) => { #(#reads)* #made })
    });
    let common = common(input, options, None);
    Ok(quote! {
        impl #name {
            #(#constants)*
        }

        impl crate::table::Table for #name {
            fn outline() -> crate::table::Outline {
                let mut outline = Self::blank();
                #(#outline)*
                outline
            }

            fn read_keys(keys: &mut crate::table::derived::Keys<'_, '_, '_>, name: &crate::table::derived::At<String>) -> Option<Self> {
                let _ = name;
                Some(match keys.one_of(&[#(#chosen_by),*], #reason) {
                    #(#arms,)*
                    _ => {
                        keys.know(&Self::outline());
                        return None;
                    }
                })
            }
        }

        #common
    })
}

/// Returns the name of the constant with the keys of a variant.
fn constant(variant: &Ident) -> Ident {
    format_ident!("{}_KEYS", snake(&variant.to_string()).to_uppercase())
}
