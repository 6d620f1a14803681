//! `#[derive(Ports)]`: turns a struct of handles into the declaration of ports, services and
//! references.

use proc_macro2::TokenStream;
use quote::quote;
use syn::{DeriveInput, Error, Field, GenericArgument, Ident, LitStr, PathArguments, Result, Type};

use crate::field::{documentation, each, named, plain};

/// One field and its `#[port(…)]` attribute.
struct PortField<'a> {
    field: &'a Field,
    handle: &'a Ident,
    /// Type argument of the handle: the data type of a port or the operation of a service.
    of: &'a Type,
    name: &'a Ident,
    /// Name used in composites, if it differs from the field's.
    renamed: Option<LitStr>,
    /// The reference may stay unconnected.
    optional: bool,
    /// The output has a safe sample, the default of its type.
    safe: bool,
    /// The samples of the input are commands.
    command: bool,
}

pub fn derive(input: &DeriveInput) -> Result<TokenStream> {
    let ports = each(named(input, "Ports")?, PortField::parse)?;
    let of = &input.ident;
    let names = ports.iter().map(|it| it.name);
    let declares = ports.iter().map(PortField::declare);
    let declares = declares.collect::<Result<Vec<_>>>()?;
    Ok(quote! {
        const _: () = {
            use ::asmotion_component as component;

            #[automatically_derived]
            impl component::Ports for #of {
                fn declare(interface: &mut component::Interface) -> Self {
                    Self { #(#names: #declares,)* }
                }
            }
        };
    })
}

impl<'a> PortField<'a> {
    fn parse(field: &'a Field, name: &'a Ident) -> Result<Self> {
        let (handle, of) = handle(&field.ty)?;
        let mut port = Self {
            field,
            handle,
            of,
            name,
            renamed: None,
            optional: false,
            safe: false,
            command: false,
        };
        for attribute in &field.attrs {
            if attribute.path().is_ident("port") {
                attribute.parse_nested_meta(|meta| {
                    if meta.path.is_ident("name") {
                        port.renamed = Some(meta.value()?.parse()?);
                    } else if meta.path.is_ident("optional") && (handle == "Required" || handle == "In") {
                        port.optional = true;
                    } else if meta.path.is_ident("safe") && handle == "Out" {
                        port.safe = true;
                    } else if meta.path.is_ident("command") && handle == "In" {
                        port.command = true;
                    } else {
                        let known = "a port has `name`, an input may be a `command` or `optional`, an output `safe`, and a reference `optional`";
                        return Err(meta.error(known));
                    }
                    Ok(())
                })?;
            }
        }
        Ok(port)
    }

    fn declare(&self) -> Result<TokenStream> {
        let Self { handle, of, .. } = self;
        let renamed = self.renamed.as_ref().map(LitStr::value);
        let name = renamed.unwrap_or_else(|| plain(self.name));
        let doc = documentation(self.field)?;
        Ok(if self.command && self.optional {
            quote!({
                let input = interface.input::<#of>(#name, #doc);
                let input = interface.command(input);
                interface.optional_input(input)
            })
        } else if self.command {
            quote!({
                let input = interface.input::<#of>(#name, #doc);
                interface.command(input)
            })
        } else if *handle == "In" && self.optional {
            quote!({
                let input = interface.input::<#of>(#name, #doc);
                interface.optional_input(input)
            })
        } else if *handle == "In" {
            quote!(interface.input::<#of>(#name, #doc))
        } else if self.safe {
            quote!({
                let output = interface.output::<#of>(#name, #doc);
                interface.safe(output, ::core::default::Default::default())
            })
        } else if *handle == "Out" {
            quote!(interface.output::<#of>(#name, #doc))
        } else if *handle == "Provided" {
            quote!(interface.serve::<#of>(#name, #doc))
        } else if self.optional {
            quote!({
                let required = interface.require::<#of>(#name, #doc);
                interface.optional(required)
            })
        } else {
            quote!(interface.require::<#of>(#name, #doc))
        })
    }
}

/// Returns the kind of a handle and its type argument.
fn handle(written: &Type) -> Result<(&Ident, &Type)> {
    if let Type::Path(path) = written
        && let Some(last) = path.path.segments.last()
        && ["In", "Out", "Provided", "Required"]
            .iter()
            .any(|known| last.ident == known)
        && let PathArguments::AngleBracketed(arguments) = &last.arguments
        && let Some(GenericArgument::Type(of)) = arguments.args.first()
    {
        return Ok((&last.ident, of));
    }
    let message = "a port is an `In<T>`, `Out<T>`, `Provided<Operation>` or `Required<Operation>`";
    Err(Error::new_spanned(written, message))
}
