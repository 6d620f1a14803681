//! Everything that can be said before anything starts.
//!
//! A composite is looked at once in every profile. A nested composite is looked at first; what it
//! promotes is then what its component shows.

mod binding;
mod builtin;
mod component;
mod connection;
mod deploy;
mod endpoint;
pub(crate) mod face;
mod promote;
mod scene;
mod topic;
mod wire;

use std::collections::BTreeMap;
use std::rc::Rc;

use source::Report;

use self::face::Face;
use self::scene::Scene;
use crate::catalogue::Catalogue;
use crate::family::{Family, Member};
use crate::types::Types;

/// Checks a composite and all it nests in one profile.
pub(crate) fn check(
    family: &Family,
    types: &BTreeMap<&str, Types<'_>>,
    catalogue: &dyn Catalogue,
    profile: Option<&str>,
) -> Report {
    let report = Report::new();
    let mut checker = Checker { family, types, catalogue, profile, faces: BTreeMap::new(), report };
    if let Some(member) = family.member(&family.root) {
        checker.composite(&family.root, member);
    }
    checker.report
}

struct Checker<'c> {
    family: &'c Family,
    types: &'c BTreeMap<&'c str, Types<'c>>,
    catalogue: &'c dyn Catalogue,
    profile: Option<&'c str>,
    faces: BTreeMap<String, Rc<Face>>,
    report: Report,
}

impl<'c> Checker<'c> {
    /// Checks a composite and returns what it promotes.
    fn composite(&mut self, path: &str, member: &'c Member) -> Rc<Face> {
        if let Some(face) = self.faces.get(path) {
            return face.clone();
        }
        let Some(types) = self.types.get(path) else {
            return Rc::new(Face { blank: true, ..Face::default() });
        };
        let mut nested = BTreeMap::new();
        for component in &member.composite.components {
            if let Some(file) = scene::nested(component)
                && let Some((path, member)) = self.family.nested(member, file)
            {
                nested.insert(file.to_owned(), self.composite(path, member));
            }
        }
        let mut scene = Scene {
            family: self.family,
            member,
            composite: &member.composite,
            profile: self.profile,
            types,
            catalogue: self.catalogue,
            parts: Vec::new(),
        };
        let report = &mut self.report;
        endpoint::check(&scene, report);
        scene.parts = component::parts(&scene, &nested, report);
        builtin::check(&mut scene, report);
        wire::check(&scene, report);
        let links = connection::check(&scene, report);
        let topics = topic::check(&scene, &links, report);
        deploy::check(&scene, &topics, report);
        binding::check(&scene, report);
        let face = Rc::new(promote::check(&scene, &topics, report));
        self.faces.insert(path.to_owned(), face.clone());
        face
    }
}
