//! Ends presumably meant by misspelled names. Such an end is not reported as unconnected, too: one mistake is one finding.

use super::scene::{CheckedComponent, CheckedComposite};
use crate::model::End;
use crate::nearest::nearest_name;

/// Returns the component and the member presumably meant by an end that does not exist: the end with the most similar names, or
/// the only member of the component.
pub(crate) fn meant<'s>(
    scene: &'s CheckedComposite<'_>,
    end: &End,
    members: impl Fn(&'s CheckedComponent<'_>) -> Vec<&'s str>,
) -> Option<(String, String)> {
    let component = &end.component.value;
    let known = scene
        .parts
        .iter()
        .map(|it| it.component.name.value.as_str());
    let part = match scene.parts.named(component) {
        Some(part) => part,
        None => scene.parts.named(&nearest_name(component, known)?.name)?,
    };
    let members = members(part);
    let name = end.name.value.as_str();
    let meant = match (members.contains(&name), &*members) {
        (true, _) => name.to_owned(),
        (false, [only]) => (*only).to_owned(),
        (false, _) => nearest_name(name, members.iter().copied())?.name,
    };
    Some((part.component.name.value.clone(), meant))
}
