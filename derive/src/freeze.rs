//! `#[derive(Freeze)]`: converts the state fields of a component to a record and back.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{DeriveInput, Error, Expr, Field, Ident, LitInt, LitStr, Result};

use crate::field::{each, named, plain};

/// The options of `#[freeze(…)]` on the struct.
#[derive(Default)]
struct FreezeAttributes {
    component: Option<LitStr>,
    version: Option<LitInt>,
    /// A function that may refuse to freeze; called before the fields are read.
    check: Option<Expr>,
}

/// A field, with its `#[freeze(…)]` attribute as a role.
struct FrozenField<'a> {
    field: &'a Field,
    name: &'a Ident,
    role: FieldRole,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum FieldRole {
    State,
    Skip,
    Reset,
}

pub fn derive(input: &DeriveInput) -> Result<TokenStream> {
    let header = FreezeAttributes::parse(input)?;
    let fields = each(named(input, "Freeze")?, FrozenField::parse)?;
    let (Some(component), Some(version)) = (&header.component, &header.version) else {
        let message = "say what it is: `#[freeze(component = \"nav::Follower\", version = 1)]`";
        return Err(Error::new_spanned(&input.ident, message));
    };
    let check = header.check.iter();
    let of = &input.ident;
    let with = |role| fields.iter().filter(move |it| it.role == role);
    let names: Vec<_> = with(FieldRole::State).map(|it| it.name).collect();
    let plain_names: Vec<_> = names.iter().map(|name| plain(name)).collect();
    let types = with(FieldRole::State).map(|it| &it.field.ty);
    let reset = with(FieldRole::Reset).map(|it| it.name);
    Ok(quote! {
        const _: () = {
            use ::asmotion_component as component;
            use component::frozen::{Datum, DatumError, FieldName};

            #[automatically_derived]
            impl component::Freeze for #of {
                const COMPONENT: &'static str = #component;
                const VERSION: u32 = #version;

                fn fields(
                    &self,
                ) -> ::core::result::Result<::std::vec::Vec<(FieldName, Datum)>, component::FreezeProblem> {
                    #((#check)(self)?;)*
                    ::core::result::Result::Ok(::std::vec![
                        #(component::frozen::entry(#plain_names, &self.#names)?,)*
                    ])
                }

                fn set_fields(
                    &mut self,
                    fields: &[(FieldName, Datum)],
                ) -> ::core::result::Result<(), DatumError> {
                    component::frozen::refuse_unknown(fields, &[#(#plain_names),*])?;
                    #(let #names = component::frozen::field::<#types>(fields, #plain_names)?;)*
                    #(component::frozen::StateField::set(&mut self.#names, #names);)*
                    #(self.#reset = ::core::default::Default::default();)*
                    ::core::result::Result::Ok(())
                }
            }
        };
    })
}

impl FreezeAttributes {
    fn parse(input: &DeriveInput) -> Result<Self> {
        let mut header = Self::default();
        for attribute in &input.attrs {
            if attribute.path().is_ident("freeze") {
                attribute.parse_nested_meta(|meta| {
                    if meta.path.is_ident("component") {
                        header.component = Some(meta.value()?.parse()?);
                    } else if meta.path.is_ident("version") {
                        header.version = Some(meta.value()?.parse()?);
                    } else if meta.path.is_ident("check") {
                        let check: LitStr = meta.value()?.parse()?;
                        header.check = Some(check.parse()?);
                    } else {
                        return Err(meta.error("it has `component`, `version` and `check`"));
                    }
                    Ok(())
                })?;
            }
        }
        Ok(header)
    }
}

impl<'a> FrozenField<'a> {
    fn parse(field: &'a Field, name: &'a Ident) -> Result<Self> {
        let mut role = FieldRole::State;
        for attribute in &field.attrs {
            if attribute.path().is_ident("freeze") {
                attribute.parse_nested_meta(|meta| {
                    role = if meta.path.is_ident("skip") {
                        FieldRole::Skip
                    } else if meta.path.is_ident("reset") {
                        FieldRole::Reset
                    } else {
                        return Err(meta.error("a field is state, or marked `skip` or `reset`"));
                    };
                    Ok(())
                })?;
            }
        }
        Ok(Self { field, name, role })
    }
}
