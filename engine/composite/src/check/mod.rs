//! Static checks of a composite.
//!
//! Each profile is checked separately. Nested composites are checked first; their promotions define the ports and
//! services of the enclosing component.

mod across;
mod annotation;
mod binding;
mod brokers;
mod builtin;
mod codec;
mod component;
mod connection;
mod declared;
mod deploy;
mod endpoint;
pub mod endpoints;
mod external;
mod fan_out;
mod gateway;
mod literal;
mod meant;
mod operations;
mod policy;
mod profile;
mod promote;
mod protocol;
mod proxy;
mod queue;
mod ros_bridge;
mod ros_component;
mod ros_loop;
mod ros_operation;
mod ros_words;
mod scene;
mod schedule;
mod topic;
mod verify;
mod wire;

use std::collections::BTreeMap;
use std::rc::Rc;

use asmotion_diagnostics::Report;

pub use self::binding::chosen_field;
pub use self::component::topic;
use self::endpoints::Endpoints;
pub use self::profile::{profiles, takes_part};
use self::scene::CheckedComposite;
pub use self::scene::nested;
pub use self::wire::waits;
use crate::catalogue::Catalogue;
use crate::family::{Family, Member};
use crate::named_list::NamedList;
use crate::types::Types;

/// Ports and services of the components of a composite, by component name.
pub type Faces = BTreeMap<String, Endpoints>;

/// Checks a composite and all nested composites in one profile; returns the ports and services of the components by
/// file path.
pub fn check(
    family: &Family,
    types: &BTreeMap<&str, Types<'_>>,
    catalogue: &dyn Catalogue,
    profile: Option<&str>,
    report: &mut Report,
) -> BTreeMap<String, Faces> {
    let mut checker = Checker {
        family,
        types,
        catalogue,
        profile,
        promoted: BTreeMap::new(),
        faces: BTreeMap::new(),
        report,
    };
    if let Some(member) = family.member(&family.root) {
        checker.composite(&family.root, member);
    }
    checker.faces
}

struct Checker<'c> {
    family: &'c Family,
    types: &'c BTreeMap<&'c str, Types<'c>>,
    catalogue: &'c dyn Catalogue,
    profile: Option<&'c str>,
    /// Promoted ports and services of each composite, by file path.
    promoted: BTreeMap<String, Rc<Endpoints>>,
    faces: BTreeMap<String, Faces>,
    report: &'c mut Report,
}

impl<'c> Checker<'c> {
    /// Checks a composite and returns its promoted ports and services.
    fn composite(&mut self, path: &str, member: &'c Member) -> Rc<Endpoints> {
        if let Some(face) = self.promoted.get(path) {
            return face.clone();
        }
        let Some(types) = self.types.get(path) else {
            return Rc::new(Endpoints {
                blank: true,
                ..Endpoints::default()
            });
        };
        let mut nested = BTreeMap::new();
        for component in &member.composite.components {
            if let Some(file) = scene::nested(component)
                && let Some((path, member)) = self.family.nested(member, file)
            {
                nested.insert(file.to_owned(), self.composite(path, member));
            }
        }
        let mut scene = CheckedComposite {
            family: self.family,
            path,
            member,
            composite: &member.composite,
            profile: self.profile,
            types,
            catalogue: self.catalogue,
            processes: member.composite.deploy.as_ref().map(scene::processes),
            parts: NamedList::default(),
        };
        let report = &mut *self.report;
        endpoint::check(&scene, report);
        brokers::check(&scene, report);
        scene.parts = component::parts(&scene, &nested, report);
        builtin::check(&mut scene, report);
        ros_loop::check(&scene, report);
        wire::check(&scene, report);
        let links = connection::check(&scene, report);
        let topics = topic::check(&scene, &links, report);
        deploy::check(&scene, &topics, report);
        across::check(&scene, &topics, report);
        binding::check(&scene, report);
        ros_words::check(&scene, report);
        protocol::check(&scene, report);
        gateway::check(&scene, report);
        let face = Rc::new(promote::check(&scene, &topics, report));
        let parts = scene.parts.into_items().into_iter();
        let faces = parts
            .map(|part| (part.component.name.value.clone(), part.face))
            .collect();
        self.faces.insert(path.to_owned(), faces);
        self.promoted.insert(path.to_owned(), face.clone());
        face
    }
}
