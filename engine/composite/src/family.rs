//! Loads a composite together with its nested composites, message types and specifications.

mod layers;
mod properties;
mod removal;

use crate::codes::c002::UnreadableComposite;
use crate::codes::c080::CircularInclusion;
use crate::codes::c081::{CompositesTooDeep, MAX_DEPTH};
use crate::codes::c175::WrongRosDefinition;
use crate::codes::c190::NoCertificate;
use crate::codes::c210::InvalidInstances;
use std::borrow::Cow;
use std::cell::LazyCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;

use asmotion_component::Declaration;
use asmotion_component::declaration::OperationDeclaration;
use asmotion_diagnostics::{Report, Sources, Span};
use asmotion_program::ProgramError;

use crate::at::At;
use crate::catalogue::{Catalogue, RosFolderProblem, RosMessages};
use crate::context::Context;
use crate::discovery;
use crate::finding::Findings;
use crate::model::binding::Bind;
use crate::model::{Bridge, Component, ComponentBrokers, Composite, Implementation, Process};
use crate::pattern;
use crate::programs::{
    ExtendedCatalogue, ProgramAnswer, command_of, directory_of, robot_component,
    split_robot_component,
};
use crate::provider::{NamedInterfaces, ServiceScope};
use crate::read;
use crate::signature::Signature;
use crate::types::{TypeFile, Types};

/// All files of a composite, keyed by resolved path.
pub struct Family {
    /// Path of the outermost composite.
    pub root: String,
    members: BTreeMap<String, Member>,
    types: BTreeMap<String, TypeFile>,
    specifications: BTreeMap<String, Box<dyn Signature>>,
    /// Places of the elements that stand for several instances.
    repeated: Vec<Span>,
}

/// A composite file and the resolved paths of the files it names.
pub struct Member {
    /// Model of the file, not yet checked.
    pub composite: Composite,
    /// Resolved path by file name as written; names that were not found or would form a cycle are absent.
    paths: BTreeMap<String, String>,
    /// Declarations of the programs that implement components, by component; those that were not asked are absent.
    programs: BTreeMap<String, ProgramAnswer>,
    /// Names of the components that only processes elsewhere run.
    elsewhere: BTreeSet<String>,
    /// Types of ROS of the bridges that name folders with definitions, by bridge.
    ros: BTreeMap<String, Rc<dyn RosMessages>>,
    /// Those of them some of whose definitions are wrong, which has been reported.
    wrong_ros: BTreeSet<String>,
    /// The brokers of its components.
    brokers: ComponentBrokers,
    /// Positions of the components by name; of several with one name, that of the first.
    positions: BTreeMap<String, usize>,
    /// Entries of tables of names that could not be read: the key of the table, and the name.
    unread: Vec<(&'static str, String)>,
}

impl Family {
    /// Reads a composite and all files it refers to.
    pub fn read(
        path: &str,
        context: &Context<'_>,
        sources: &mut Sources,
        report: &mut Report,
    ) -> Self {
        let root = context
            .loader
            .resolve("", path)
            .unwrap_or_else(|| path.to_owned());
        let mut visit = Visit {
            context,
            sources,
            report,
            members: BTreeMap::new(),
            types: BTreeMap::new(),
            specifications: BTreeMap::new(),
            promoted: BTreeMap::new(),
            broken: Vec::new(),
            chain: Vec::new(),
            is_elsewhere: false,
            repeated: Vec::new(),
            counting: BTreeMap::new(),
        };
        visit.composite(&root, None);
        let Visit {
            members,
            types,
            specifications,
            repeated,
            ..
        } = visit;
        Self {
            root,
            members,
            types,
            specifications,
            repeated,
        }
    }

    /// Returns the composite at a path.
    pub fn member(&self, path: &str) -> Option<&Member> {
        self.members.get(path)
    }

    /// The model of the outermost composite; `None` if it could not be read.
    pub fn into_root(mut self) -> Option<Composite> {
        self.members.remove(&self.root).map(|it| it.composite)
    }

    /// Iterates over the composite files in order of their paths.
    pub fn members(&self) -> impl Iterator<Item = (&str, &Member)> {
        self.members
            .iter()
            .map(|(path, member)| (path.as_str(), member))
    }

    /// Iterates over the composites in order of their paths.
    pub(crate) fn composites(&self) -> impl Iterator<Item = &Composite> {
        self.members.values().map(|member| &member.composite)
    }

    /// Returns the nested composite that `member` names as `file`.
    pub fn nested<'f>(&'f self, member: &'f Member, file: &str) -> Option<(&'f str, &'f Member)> {
        let path = member.path(file)?;
        Some((path, self.members.get(path)?))
    }

    /// Returns the bindings of a component of `member`, one for each location.
    pub fn bind<'c>(&self, member: &Member, component: &'c Component) -> Cow<'c, Bind> {
        let signature = match &component.implementation {
            Some(Implementation::Asm { file, .. }) => self.specification(member, file),
            _ => None,
        };
        pattern::expand(&component.bind, signature)
    }

    /// Returns the specification that `member` names as `file`.
    pub(crate) fn specification(&self, member: &Member, file: &str) -> Option<&dyn Signature> {
        self.specifications.get(member.path(file)?).map(Box::as_ref)
    }

    /// Returns the message types visible in each composite, by file path. A type file may be named by several
    /// composites; its diagnostics are reported once.
    pub fn all_types<'f>(
        &'f self,
        catalogue: &'f dyn Catalogue,
        report: &mut Report,
    ) -> BTreeMap<&'f str, Types<'f>> {
        let mut found = Report::new();
        let types = self.members().map(|(path, member)| {
            let files = self.types(member);
            (path, Types::new(files, catalogue, &mut found))
        });
        let types = types.collect();
        report.extend(found.finish());
        types
    }

    /// Completes the declarations of programs with types of the catalogue and of type files, and checks them.
    pub fn complete_programs(&mut self, catalogue: &dyn Catalogue) {
        if self
            .members
            .values()
            .all(|member| member.programs.is_empty())
        {
            return;
        }
        let catalogue = &ExtendedCatalogue::new(catalogue, self.folders(), std::iter::empty());
        // problems of type files are reported with those of all types
        let types = self.all_types(catalogue, &mut Report::new());
        let completed = self.members().map(|(path, member)| {
            let known = |name: &str| types.get(path).and_then(|types| types.schema(name));
            let complete = |(component, answer): (&String, &ProgramAnswer)| {
                let answer = answer.clone().and_then(|it| it.complete(&known));
                (component.clone(), answer)
            };
            (
                path.to_owned(),
                member.programs.iter().map(complete).collect(),
            )
        });
        let completed: Vec<(String, BTreeMap<String, ProgramAnswer>)> = completed.collect();
        for (path, programs) in completed {
            if let Some(member) = self.members.get_mut(&path) {
                member.programs = programs;
            }
        }
    }

    /// Returns a catalogue extended by the types and interfaces of programs, and of folders with definitions of ROS.
    pub fn extend<'c>(&self, catalogue: &'c dyn Catalogue) -> ExtendedCatalogue<'c> {
        let programs = self.members.values().flat_map(|it| it.programs.values());
        let programs = programs.filter_map(|it| it.as_ref().ok());
        ExtendedCatalogue::new(catalogue, self.folders(), programs)
    }

    /// Returns the operations of a service interface that a folder with definitions of ROS has; `None` if none has it.
    pub fn ros_interface(&self, name: &str) -> Option<Vec<OperationDeclaration>> {
        let mut folders = self.folders().into_iter();
        folders.find_map(|it| it.operations()?.interface(name))
    }

    /// The types of ROS with those of folders, of each bridge that names some.
    fn folders(&self) -> Vec<Rc<dyn RosMessages>> {
        let bridges = self.members.values().flat_map(|it| it.ros.values());
        bridges.cloned().collect()
    }

    /// Combines the diagnostics about instances of one element at one place: the first remains, with the number of the others.
    pub fn combine_instances(&self, report: Report) -> Report {
        let is_within = |at: &Span, place: &Span| {
            at.file == place.file && place.start <= at.start && at.end <= place.end
        };
        let mut combined = Report::new();
        let mut others: BTreeMap<(&str, Span), (usize, usize)> = BTreeMap::new();
        for diagnostic in report.diagnostics {
            let at = diagnostic.primary.as_ref().map(|label| label.span);
            let at = at.filter(|at| self.repeated.iter().any(|place| is_within(at, place)));
            let position = combined.diagnostics.len();
            let Some(at) = at else {
                combined.push(diagnostic);
                continue;
            };
            let (_, count) = others
                .entry((diagnostic.code.name, at))
                .or_insert((position, 0));
            *count += 1;
            if *count == 1 {
                combined.push(diagnostic);
            }
        }
        for (position, count) in others.into_values().filter(|(_, count)| *count > 1) {
            let note = match count - 1 {
                1 => "the same is true of another instance".to_owned(),
                others => format!("the same is true of {others} other instances"),
            };
            combined.diagnostics[position].notes.push(note);
        }
        combined
    }

    /// Iterates over the type files named by a composite.
    pub(crate) fn types<'f>(&'f self, member: &'f Member) -> impl Iterator<Item = &'f TypeFile> {
        let files = member.composite.head.types.iter();
        files.filter_map(|file| self.types.get(member.path(file)?))
    }
}

impl Member {
    /// Returns the component of this name.
    pub(crate) fn component(&self, name: &str) -> Option<&Component> {
        self.composite.components.get(*self.positions.get(name)?)
    }

    /// Returns the broker of a component, if components name their brokers.
    pub fn broker_of<'m>(&'m self, component: &'m Component) -> Option<&'m At<String>> {
        self.brokers.broker(component)
    }

    /// Returns the resolved path of a file named in this composite.
    pub fn path(&self, file: &str) -> Option<&str> {
        self.paths.get(file).map(String::as_str)
    }

    /// Iterates over the entries of the tables of names with a key that could not be read.
    pub(crate) fn unread<'m>(&'m self, table: &'m str) -> impl Iterator<Item = &'m str> {
        let of_table = self.unread.iter().filter(move |(key, _)| *key == table);
        of_table.map(|(_, name)| name.as_str())
    }

    /// Returns the types of ROS of a bridge that names folders with definitions; `None` for another bridge.
    pub(crate) fn ros(&self, bridge: &str) -> Option<&dyn RosMessages> {
        self.ros.get(bridge).map(|it| &**it)
    }

    /// Returns whether some definitions of a bridge are wrong, which has been reported.
    pub(crate) fn has_wrong_ros(&self, bridge: &str) -> bool {
        self.wrong_ros.contains(bridge)
    }

    /// Returns whether only processes elsewhere run a component.
    pub fn is_elsewhere(&self, component: &str) -> bool {
        self.elsewhere.contains(component)
    }

    /// Returns the declaration of the program that implements a component; `None` if it was not asked.
    pub fn program(&self, component: &str) -> Option<&ProgramAnswer> {
        self.programs.get(component)
    }

    /// Returns the declaration of a component of the executable or of a program; `None` if it is not known.
    pub fn declaration(
        &self,
        component: &Component,
        catalogue: &dyn Catalogue,
    ) -> Option<Arc<Declaration>> {
        declaration(component, &self.programs, catalogue)
    }
}

/// Returns the declaration of a component of the executable or of a program; `None` if it is not known.
fn declaration(
    component: &Component,
    programs: &BTreeMap<String, ProgramAnswer>,
    catalogue: &dyn Catalogue,
) -> Option<Arc<Declaration>> {
    match component.implementation.as_ref()? {
        Implementation::Rust(name) => catalogue.declaration(name),
        Implementation::Process { .. } | Implementation::Builtin { .. } => {
            let program = programs.get(&component.name.value)?.as_ref().ok()?;
            Some(Arc::new(program.declaration.clone()))
        }
        Implementation::Asm { .. }
        | Implementation::Composite(_)
        | Implementation::Ros { .. }
        | Implementation::Orocos { .. } => None,
    }
}

struct Visit<'v, 'c> {
    context: &'v Context<'c>,
    sources: &'v mut Sources,
    report: &'v mut Report,
    members: BTreeMap<String, Member>,
    types: BTreeMap<String, TypeFile>,
    specifications: BTreeMap<String, Box<dyn Signature>>,
    /// Services that each composite promotes.
    promoted: BTreeMap<String, NamedInterfaces>,
    /// Files that failed to load; not read again.
    broken: Vec<String>,
    /// Composites being read, outermost first, each with the location that includes the next.
    chain: Vec<(String, Option<Span>)>,
    /// The composite being read is part of a component that runs elsewhere.
    is_elsewhere: bool,
    /// Places of the elements that stand for several instances.
    repeated: Vec<Span>,
    /// Properties of each composite on which numbers of instances depend.
    counting: BTreeMap<String, BTreeSet<String>>,
}

impl Visit<'_, '_> {
    fn composite(&mut self, path: &str, at: Option<Span>) {
        if self.members.contains_key(path) || self.broken.iter().any(|broken| broken == path) {
            return;
        }
        let tree = self.tree(path, at);
        let read = tree.zip(self.sources.find(path)).and_then(|(tree, file)| {
            // those of the outermost composite
            let settings = if self.chain.is_empty() {
                self.context.settings
            } else {
                &[]
            };
            let read = read::composite(file, self.sources.text(file), &tree, settings);
            self.counting.insert(path.to_owned(), read.counting);
            self.report.extend(read.report);
            self.repeated.extend(read.repeated);
            if let Some(composite) = &read.composite {
                properties::check(composite, &tree, self.report);
            }
            Some((read.composite?, read.unread))
        });
        let Some((mut composite, unread)) = read else {
            self.broken.push(path.to_owned());
            return;
        };
        self.chain.push((path.to_owned(), None));
        let mut paths = BTreeMap::new();
        for file in &composite.head.types {
            if let Some(found) = self.resolve(file) {
                self.types(&found, file.span);
                paths.insert(file.value.clone(), found);
            }
        }
        for file in composite.wires.iter().filter_map(|wire| wire.ca.as_ref()) {
            if let Some(found) = self.resolve(file) {
                self.authorities(&found, file.span);
                paths.insert(file.value.clone(), found);
            }
        }
        let (ros, wrong_ros) = self.ros_folders(&composite, path, &mut paths);
        let elsewhere = self.elsewhere(&composite);
        // a file that is nested here and elsewhere is read as one that is nested here
        let mut components: Vec<&Component> = composite.components.iter().collect();
        components.sort_by_key(|it| elsewhere.contains(&it.name.value));
        for component in components {
            if let Some(file) = &component.special.protocol
                && let Some(found) = self.resolve(file)
            {
                self.specification(&found);
                paths.insert(file.value.clone(), found);
            }
            match &component.implementation {
                Some(Implementation::Asm { file, .. }) => {
                    if let Some(found) = self.resolve(file) {
                        self.specification(&found);
                        paths.insert(file.value.clone(), found);
                    }
                }
                Some(Implementation::Composite(file)) => {
                    let outer = self.is_elsewhere;
                    self.is_elsewhere = elsewhere.contains(&component.name.value);
                    if let Some(found) = self.resolve(file)
                        && self.nest(&found, file.span)
                    {
                        self.check_counts(component, &found);
                        paths.insert(file.value.clone(), found);
                    }
                    self.is_elsewhere = outer;
                }
                _ => {}
            }
        }
        self.chain.pop();
        let programs = self.programs(&composite, path);
        let declared =
            |component: &Component| declaration(component, &programs, self.context.catalogue);
        let folders = ros.values().cloned().collect();
        let catalogue =
            &ExtendedCatalogue::new(self.context.catalogue, folders, std::iter::empty());
        discovery::complete(&mut composite, catalogue, &declared, self.report);
        let promoted = |file: &str| {
            let promoted = paths.get(file).and_then(|path| self.promoted.get(path));
            promoted.cloned().unwrap_or_default()
        };
        let services = ServiceScope {
            promoted: &promoted,
            declared: &declared,
        };
        services.resolve(&mut composite, self.report);
        let promoted = services.promoted_by(&composite);
        self.promoted.insert(path.to_owned(), promoted);
        let mut positions = BTreeMap::new();
        for (position, component) in composite.components.iter().enumerate() {
            let name = component.name.value.clone();
            positions.entry(name).or_insert(position);
        }
        self.members.insert(
            path.to_owned(),
            Member {
                brokers: ComponentBrokers::of(&composite),
                composite,
                paths,
                programs,
                elsewhere,
                ros,
                wrong_ros,
                positions,
                unread,
            },
        );
    }

    /// Reports properties of a nested composite that are set here and on which its numbers of instances depend: they are
    /// determined when the file is read, which it is once for all components.
    fn check_counts(&mut self, component: &Component, nested: &str) {
        let Some(counting) = self.counting.get(nested) else {
            return;
        };
        for setting in &component.properties {
            if counting.contains(&setting.name.value) {
                self.report.found(InvalidInstances {
                    reason: format!(
                        "`{}` says how many instances there are in `{nested}`, and can be set for the outermost composite only",
                        setting.name.value
                    ),
                    at: setting.name.span,
                    is_malformed: false,
                    earlier: None,
                });
            }
        }
    }

    /// Reads the folders with definitions that the bridges of a composite name, and notes their paths. Returns the types by bridge,
    /// and the bridges some of whose definitions are wrong.
    fn ros_folders(
        &mut self,
        composite: &Composite,
        path: &str,
        paths: &mut BTreeMap<String, String>,
    ) -> (BTreeMap<String, Rc<dyn RosMessages>>, BTreeSet<String>) {
        let (mut ros, mut wrong) = (BTreeMap::new(), BTreeSet::new());
        for bridge in &composite.bridges {
            let written = bridge.definitions.iter();
            let folders: Vec<PathBuf> = written
                .map(|folder| directory_of(Some(folder.as_str()), path))
                .collect();
            for (written, folder) in bridge.definitions.iter().zip(&folders) {
                paths.insert(written.value.clone(), folder.to_string_lossy().into_owned());
            }
            if folders.is_empty() {
                continue;
            }
            let (catalogue, loader) = (self.context.catalogue, self.context.loader);
            // a bridge that the executable cannot connect is reported later
            if let Some(read) = catalogue.ros_with(bridge.kind.value, &folders, loader) {
                if !read.problems.is_empty() {
                    wrong.insert(bridge.name.value.clone());
                }
                for problem in read.problems {
                    self.ros_problem(bridge, problem);
                }
                ros.insert(bridge.name.value.clone(), read.messages);
            }
        }
        (ros, wrong)
    }

    /// Reports a wrong folder with definitions, at the line of the definition if there is one.
    fn ros_problem(&mut self, bridge: &Bridge, problem: RosFolderProblem) {
        let Some(folder) = bridge.definitions.get(problem.folder) else {
            return;
        };
        let text = problem.file.as_ref();
        let text = text.and_then(|path| Some((path, self.context.loader.read(path).ok()?)));
        let line = text.map(|(path, text)| {
            let (start, length) = line_of(&text, problem.line);
            let file = self.sources.find(path);
            let file = file.unwrap_or_else(|| self.sources.add(path, text));
            Span::new(file, start, start + length)
        });
        self.report.found(WrongRosDefinition {
            reason: problem.reason,
            folder: folder.value.clone(),
            at: folder.span,
            line,
        });
    }

    /// Returns the names of the components that only processes elsewhere run. The processes are those of the outermost
    /// composite.
    fn elsewhere(&self, composite: &Composite) -> BTreeSet<String> {
        if self.is_elsewhere {
            let components = composite.components.iter();
            return components.map(|it| it.name.value.clone()).collect();
        }
        if self.chain.len() > 1 {
            return BTreeSet::new();
        }
        let deployed = composite.deploy.iter().flat_map(|it| &it.processes);
        let (here, elsewhere): (Vec<_>, Vec<_>) =
            deployed.partition(|it| self.context.programs.runs(it));
        let names = |of: Vec<&Process>| -> BTreeSet<String> {
            let names = of.into_iter().flat_map(|it| &it.components);
            names.map(|it| it.value.clone()).collect()
        };
        &names(elsewhere) - &names(here)
    }

    /// Asks the programs of a composite, and the other robots whose components it names, for declarations.
    fn programs(&self, composite: &Composite, path: &str) -> BTreeMap<String, ProgramAnswer> {
        let brokers = LazyCell::new(|| ComponentBrokers::of(composite));
        let components = composite.components.iter();
        let answers = components.filter_map(|component| {
            let implementation = component.implementation.as_ref()?;
            let name = &component.name.value;
            let answer = match robot_component(implementation) {
                Some(address) => self.robot(&brokers, component, address)?,
                None => {
                    let command = command_of(implementation, path)?;
                    self.context.programs.ask(&command, name)?
                }
            };
            Some((name.clone(), answer))
        });
        answers.collect()
    }

    /// Asks another robot for the declaration of a component.
    fn robot(
        &self,
        brokers: &ComponentBrokers,
        component: &Component,
        address: &str,
    ) -> Option<ProgramAnswer> {
        if let Err(reason) = split_robot_component(address) {
            return Some(Err(ProgramError::Fault {
                code: String::new(),
                text: format!("the address {reason}"),
            }));
        }
        let broker = brokers.broker(component).map(|it| it.value.as_str());
        self.context.programs.ask_robot(address, broker)
    }

    /// Reads a nested composite; reports a cycle or excessive depth instead.
    fn nest(&mut self, path: &str, at: Span) -> bool {
        if let Some(innermost) = self.chain.last_mut() {
            innermost.1 = Some(at);
        }
        if let Some(first) = self.chain.iter().position(|(open, _)| open == path) {
            let circle = &self.chain[first..];
            let mut chain: Vec<String> = circle.iter().map(|(path, _)| path.clone()).collect();
            chain.push(path.to_owned());
            let places = circle.iter().filter_map(|(_, place)| *place).collect();
            self.report.found(CircularInclusion::Composite {
                path: path.to_owned(),
                chain,
                places,
            });
            return false;
        }
        if self.chain.len() >= MAX_DEPTH {
            self.report.found(CompositesTooDeep { at });
            return false;
        }
        self.composite(path, Some(at));
        true
    }

    fn types(&mut self, path: &str, at: Span) {
        if self.types.contains_key(path) || self.broken.iter().any(|broken| broken == path) {
            return;
        }
        let read = self.load(path, Some(at)).and_then(|(file, text)| {
            let (types, report) = crate::types::read(file, path, &text);
            self.report.extend(report);
            types
        });
        match read {
            Some(types) => {
                self.types.insert(path.to_owned(), types);
            }
            None => self.broken.push(path.to_owned()),
        }
    }

    /// Checks that a file contains certificates. The run reads them.
    fn authorities(&mut self, path: &str, at: Span) {
        match self.context.loader.read(path) {
            Ok(text) if has_certificate(&text) => {}
            Ok(_) => self.report.found(NoCertificate {
                path: path.to_owned(),
                at,
            }),
            Err(error) => self.report.found(UnreadableComposite {
                path: error.path,
                reason: error.reason,
                at: Some(at),
            }),
        }
    }

    fn specification(&mut self, path: &str) {
        if self.specifications.contains_key(path) || self.broken.iter().any(|it| it == path) {
            return;
        }
        match self.context.specifications.open(path, self.sources) {
            Ok(Some(signature)) => {
                self.report.extend(signature.warnings());
                self.specifications.insert(path.to_owned(), signature);
            }
            Ok(None) => self.broken.push(path.to_owned()),
            Err(report) => {
                self.report.extend(report);
                self.broken.push(path.to_owned());
            }
        }
    }

    /// Resolves a file name relative to the file that contains it.
    fn resolve(&mut self, file: &At<String>) -> Option<String> {
        let from = self.sources.path(file.span.file);
        let found = self.context.loader.resolve(from, file);
        if found.is_none() {
            self.report.found(UnreadableComposite {
                path: file.value.clone(),
                reason: format!("not found beside `{from}`"),
                at: Some(file.span),
            });
        }
        found
    }

    fn load(
        &mut self,
        path: &str,
        at: Option<Span>,
    ) -> Option<(asmotion_diagnostics::FileId, Arc<str>)> {
        match self.context.loader.read(path) {
            Ok(text) => Some((self.sources.add(path, text.clone()), text)),
            Err(error) => {
                let (path, reason) = (error.path, error.reason);
                self.report.found(UnreadableComposite { path, reason, at });
                None
            }
        }
    }
}

/// Returns the offset and the length of a line of a text, counted from 1; of the first one without a number.
fn line_of(text: &str, number: Option<usize>) -> (usize, usize) {
    let mut lines = text.split_inclusive('\n');
    let before = number.unwrap_or(1).saturating_sub(1);
    let start = lines.by_ref().take(before).map(str::len).sum();
    (start, lines.next().map_or(0, |line| line.trim_end().len()))
}

/// Returns whether a text has a certificate in PEM (RFC 7468).
fn has_certificate(text: &str) -> bool {
    let begun = text.split_once("-----BEGIN CERTIFICATE-----");
    begun.is_some_and(|(_, rest)| rest.contains("-----END CERTIFICATE-----"))
}
