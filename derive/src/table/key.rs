//! `#[key(…)]`: the key that a field or variant stands for.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};
use syn::{
    Error, Expr, ExprLit, ExprRange, Field, GenericArgument, Ident, Lit, LitStr, PathArguments,
    Result, Type,
};

use crate::word::{doc, snake};

/// The options of `#[key(…)]` on a field or variant.
pub(super) struct KeyDeclaration {
    pub ident: Ident,
    pub kind: Type,
    pub doc: String,
    pub name: String,
    pub example: String,
    pub unit: String,
    pub range: Option<ExprRange>,
    /// From `default`; `Some(None)` stands for the default of the type.
    pub default: Option<Option<Expr>>,
    pub needed: bool,
    pub flatten: bool,
    /// An absent key stands for the default of its type, which the documentation does not show.
    pub or_default: bool,
    /// A name that is prefixed with the path of the enclosing composites when it is resolved.
    pub local: bool,
    /// Omitted from the resolved table if it was not given.
    pub unresolved: bool,
    /// Only in the table as written, not in the resolved one.
    pub written: bool,
    /// A list in which a single element may be written without brackets.
    pub one: bool,
    /// Restricts the key to tables under this key; empty for no restriction.
    pub within: String,
    /// Syntax check for a value that is a name.
    pub form: Option<Ident>,
    /// The field holds the name of the entry in a table of names; with the syntax check of that
    /// name.
    pub entry: Option<Ident>,
}

/// The outermost constructor of a field's type.
pub(super) enum FieldShape<'t> {
    Option(&'t Type),
    Vec(&'t Type),
    One(&'t Type),
}

impl KeyDeclaration {
    pub(super) fn of(ident: &Ident, kind: &Type, attributes: &[syn::Attribute]) -> Result<Self> {
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

    pub(super) fn of_field(field: &Field) -> Result<Self> {
        match &field.ident {
            Some(ident) => Self::of(ident, &field.ty, &field.attrs),
            None => Err(Error::new_spanned(field, "a key has a name")),
        }
    }

    /// Returns `true` if the field's type is this name.
    pub(super) fn is(&self, name: &str) -> bool {
        matches!(&self.kind, Type::Path(path) if path.path.is_ident(name))
    }

    /// Returns `true` for a field that is no key: a span or the name of the entry.
    pub(super) fn is_place(&self) -> bool {
        self.is("FileId") || self.ident == "span" || self.entry.is_some()
    }

    pub(super) fn shape(&self) -> FieldShape<'_> {
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

    pub(super) fn inner(&self) -> &Type {
        match self.shape() {
            FieldShape::Option(inner) | FieldShape::Vec(inner) | FieldShape::One(inner) => inner,
        }
    }

    /// Generates the description of the key.
    pub(super) fn key(&self) -> TokenStream {
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
    pub(super) fn read(&self, key: &TokenStream) -> TokenStream {
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
    pub(super) fn is_unwrapped(&self) -> bool {
        let one = matches!(self.shape(), FieldShape::One(_));
        one && !self.is_place() && !self.or_default && !self.is("bool")
    }

    pub(super) fn resolved_kind(&self) -> TokenStream {
        let inner = self.inner();
        let resolved = quote!(<#inner as crate::table::Resolve>::Resolved);
        match self.shape() {
            FieldShape::Vec(_) => quote!(Vec<#resolved>),
            FieldShape::Option(_) if self.default.is_none() && !self.or_default => {
                quote!(Option<#resolved>)
            }
            FieldShape::One(_) if self.unresolved => quote!(Option<#resolved>),
            FieldShape::Option(_) | FieldShape::One(_) => resolved,
        }
    }

    pub(super) fn default_value(&self) -> TokenStream {
        match &self.default {
            Some(Some(Expr::Lit(ExprLit {
                lit: Lit::Str(text),
                ..
            }))) => quote!(#text.to_owned()),
            Some(Some(value)) => quote!(#value),
            Some(None) | None => quote!(Default::default()),
        }
    }

    /// Returns `true` if the resolved table contains the key.
    pub(super) fn is_resolved(&self) -> bool {
        !self.written && self.ident != "span" && !self.is("FileId")
    }

    /// Returns the variable that holds the value in generated code; the prefix keeps it apart from other names there.
    pub(super) fn variable(&self) -> Ident {
        format_ident!("field_{}", snake(&self.ident.to_string()))
    }

    /// Generates the conversion of the key's variable to the resolved value; with `into`, followed by one to the type of
    /// the field in an existing table.
    pub(super) fn resolve(&self, key: &TokenStream, into: bool) -> TokenStream {
        let variable = self.variable();
        let local = self.local.then(|| quote!(.map(|it| to.local(&it))));
        let into = into.then(|| quote!(.map(Into::into)));
        let one = quote!(crate::table::Resolve::resolve(it, #key, to)#local #into);
        match self.shape() {
            FieldShape::Vec(_) => quote!(#variable.iter().filter_map(|it| #one).collect()),
            FieldShape::Option(_) => {
                let found = quote!(#variable.as_ref().and_then(|it| #one));
                let default = self.default_value();
                match self.default {
                    Some(_) => quote!(#found.unwrap_or_else(|| #default)),
                    None if self.or_default => quote!(#found.unwrap_or_default()),
                    None => found,
                }
            }
            FieldShape::One(_) => {
                let found = quote!({ let it = #variable; #one });
                if self.unresolved {
                    found
                } else {
                    quote!(#found?)
                }
            }
        }
    }

    /// Generates the statement that serialises the key's variable.
    pub(super) fn write(&self) -> TokenStream {
        let (variable, name, within) = (self.variable(), &self.name, &self.within);
        if self.flatten {
            return quote!(keys.append(crate::table::WrittenTable::keys(#variable, within)););
        }
        let value = match (self.one, self.needed && !self.unresolved, self.shape()) {
            (true, _, _) => quote!(crate::table::one_or_many(#variable)),
            // an empty value is written, unlike an absent key
            (false, true, FieldShape::Vec(_)) => quote!(Some(crate::table::list(#variable))),
            (false, true, FieldShape::One(_)) => quote!(Some(crate::table::present(#variable))),
            (false, _, _) => quote!(crate::table::Written::toml(#variable)),
        };
        let write = quote!(keys.put_some(#name, #value););
        if within.is_empty() {
            write
        } else {
            quote!(if within == #within { #write })
        }
    }
}
