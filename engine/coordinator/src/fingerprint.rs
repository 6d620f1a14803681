//! Fingerprint of a coordinator, which a frozen state must match.

use crate::binding::Binding;
use crate::watch::Watch;
use asmotion_component::frozen;
use asmotion_lang::Specification;
use asmotion_lang::diagnostics::FileId;

/// Fingerprint of all source texts of the specification, of the binding, and of what is watched.
pub(crate) fn fingerprint(
    specification: &Specification,
    binding: &Binding,
    watch: &Watch,
) -> String {
    let binding = format!("{binding:?} {watch:?}");
    let sources = &specification.sources;
    let files = (0..).map(FileId);
    let files = files.take_while(|file| !sources.path(*file).is_empty());
    let texts = files.map(|file| sources.text(file));
    frozen::fingerprint(texts.chain([binding.as_str()]))
}
