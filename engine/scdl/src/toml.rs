//! Writes a completed composite as the text of a composite file.

mod promotions;

use crate::codes::x005::PasswordInScdl;
use crate::codes::x006::UnknownScdlName;
use crate::codes::x007::WrongAttributeValue;
use crate::codes::x012::UndirectedTopic;
use crate::codes::x013::SeveralPromoted;
use std::collections::BTreeMap;

use asmotion_composite::model::Scalar;
use asmotion_composite::{At, Catalogue};
use asmotion_diagnostics::{Finding, Report};
use toml_edit::{ArrayOfTables, DocumentMut, InlineTable, Item, Table, Value, value as item};

use self::promotions::{listening, word};
use crate::model::{
    ScdlComponent, ScdlComposite, ScdlContract, ScdlImplementation, ScdlProperty, ScdlTarget,
    ScdlTransport,
};
use crate::tca::{self, TcaTask, TcaTime};
use crate::{name, value};

/// Timeout of calls in imported wires, in milliseconds, because SCDL has no deadlines.
pub(crate) const TIMEOUT_MS: u64 = 1000;

/// The text of a composite file. `nested` contains the composites completed before.
pub(crate) fn document(
    composite: &ScdlComposite,
    nested: &BTreeMap<String, ScdlComposite>,
    catalogue: &dyn Catalogue,
    report: &mut Report,
) -> String {
    let mut writer = TomlWriter {
        composite,
        nested,
        catalogue,
        report,
        brokers: Vec::new(),
        gateways: listening(composite),
    };
    let mut components = Table::new();
    components.set_implicit(true);
    for component in &composite.components {
        let table = writer.component(component.clone());
        components.insert(&component.name, Item::Table(table));
    }
    let wires = writer.wires();
    let promotions = writer.promotions();
    let mut document = DocumentMut::new();
    document.insert("schema", item("composite/1"));
    document.insert("composite", Item::Table(head(composite)));
    let properties = writer.properties();
    if !properties.is_empty() {
        document.insert("properties", Item::Table(properties));
    }
    if !writer.brokers.is_empty() {
        document.insert("brokers", Item::Table(brokers(&writer.brokers)));
    }
    if !writer.gateways.is_empty() {
        document.insert("gateways", Item::Table(gateways(&writer.gateways)));
    }
    document.insert("components", Item::Table(components));
    if !wires.is_empty() {
        document.insert("wires", Item::ArrayOfTables(wires));
    }
    if !promotions.is_empty() {
        document.insert("promote", Item::ArrayOfTables(promotions));
    }
    document.to_string()
}

fn head(composite: &ScdlComposite) -> Table {
    let mut head = table(&composite.notes);
    head.insert("name", item(&composite.name.value));
    if let Some(namespace) = &composite.namespace {
        head.insert("namespace", item(&namespace.value));
    }
    if let Some(doc) = &composite.doc {
        head.insert("doc", item(doc));
    }
    head
}

/// Creates a table with comments above it.
fn table<'n>(notes: impl IntoIterator<Item = &'n String>) -> Table {
    let mut table = Table::new();
    let lines = notes.into_iter().flat_map(|note| note.lines());
    let comments: String = lines
        .map(|line| {
            // TOML allows no control characters in comments
            let line = line.replace(|it: char| it.is_control() && it != '\t', "\u{fffd}");
            format!("# no counterpart: {line}\n")
        })
        .collect();
    table.decor_mut().set_prefix(format!("\n{comments}"));
    table
}

fn gateways(listen: &[String]) -> Table {
    let mut gateways = Table::new();
    gateways.set_implicit(true);
    for (index, listen) in listen.iter().enumerate() {
        let mut gateway = table([]);
        gateway.insert("listen", item(listen));
        gateways.insert(&broker_name(index), Item::Table(gateway));
    }
    gateways
}

fn brokers(urls: &[String]) -> Table {
    let mut brokers = Table::new();
    brokers.set_implicit(true);
    for (index, url) in urls.iter().enumerate() {
        let mut broker = table([]);
        broker.insert("url", item(url));
        brokers.insert(&broker_name(index), Item::Table(broker));
    }
    brokers
}

fn broker_name(index: usize) -> String {
    match index {
        0 => "main".to_owned(),
        more => format!("main{}", more + 1),
    }
}

fn inline(entries: impl IntoIterator<Item = (String, Value)>) -> Item {
    item(entries.into_iter().collect::<InlineTable>())
}

/// `Component.name`.
fn end(target: &ScdlTarget) -> String {
    let name = target.name.as_ref().map_or("", |name| name.value.as_str());
    format!("{}.{name}", target.component.value)
}

struct TomlWriter<'w> {
    composite: &'w ScdlComposite,
    nested: &'w BTreeMap<String, ScdlComposite>,
    catalogue: &'w dyn Catalogue,
    report: &'w mut Report,
    /// Addresses of the brokers that were needed so far; the position determines the name.
    brokers: Vec<String>,
    /// Addresses of the gateways that were needed so far; the position determines the name.
    gateways: Vec<String>,
}

impl<'w> TomlWriter<'w> {
    fn component(&mut self, mut component: ScdlComponent) -> Table {
        let task = tca::take(&mut component, self.report);
        let contracts = component.services.iter().chain(&component.references);
        let inner = contracts.map(|it| &it.notes);
        let inner = inner
            .chain(component.properties.iter().map(|it| &it.notes))
            .flatten();
        let mut table = table(component.notes.iter().chain(inner));
        if let Some(implementation) = &component.implementation {
            table.insert("implementation", implementation_item(implementation));
        }
        if let Some(doc) = &component.doc {
            table.insert("doc", item(doc));
        }
        if let Some(task) = task {
            self.task(&component, task, &mut table);
        }
        // a nested composite declares these in its own file
        if !matches!(
            component.implementation,
            Some(ScdlImplementation::Composite(_))
        ) {
            contracts_item("services", &component.services, &mut table);
            contracts_item("references", &component.references, &mut table);
        }
        let settings = component.properties.iter();
        let settings: Vec<_> = settings
            .filter_map(|it| self.setting(&component, it))
            .collect();
        if !settings.is_empty() {
            table.insert("properties", inline(settings));
        }
        table
    }

    fn task(&mut self, component: &ScdlComponent, task: TcaTask, table: &mut Table) {
        let mut keys = vec![
            ("id".to_owned(), Value::from(task.id)),
            ("period_ms".to_owned(), self.time(&task.period)),
            ("delay_ms".to_owned(), self.time(&task.delay)),
            ("run_on_startup".to_owned(), task.run_on_startup.into()),
            (
                "may_interrupt_if_running".to_owned(),
                task.may_interrupt_if_running.into(),
            ),
        ];
        if let Some(url) = task.broker {
            keys.push(("broker".to_owned(), self.broker(url).into()));
        }
        table.insert("task", inline(keys));
        if task.rename.is_empty() {
            return;
        }
        self.topics(component, &task.rename, table);
        let rename = task.rename.into_iter();
        table.insert("rename", inline(rename.map(|(from, to)| (from, to.into()))));
    }

    fn time(&mut self, time: &TcaTime) -> Value {
        match time {
            TcaTime::Milliseconds(number) => (*number).into(),
            TcaTime::Property(source) => self.source(source),
        }
    }

    /// Writes renamed topics as ports. Only the declaration of a built-in component tells their direction and type.
    fn topics(
        &mut self,
        component: &ScdlComponent,
        rename: &[(String, String)],
        table: &mut Table,
    ) {
        let declaration = match &component.implementation {
            Some(ScdlImplementation::Java(class)) => {
                self.catalogue.declaration(&name::component(class))
            }
            _ => None,
        };
        let (mut subscribe, mut publish) = (Vec::new(), Vec::new());
        for (from, _) in rename {
            let declared = declaration.as_ref();
            if let Some(port) = declared.and_then(|it| it.input(from)) {
                subscribe.push((from.clone(), Value::from(port.schema.to_string())));
            } else if let Some(port) = declared.and_then(|it| it.output(from)) {
                publish.push((from.clone(), Value::from(port.schema.to_string())));
            } else {
                let (of, topic) = (component.name.value.clone(), from.clone());
                let at = component.name.span;
                self.report
                    .push(UndirectedTopic { of, topic, at }.diagnostic());
            }
        }
        for (key, topics) in [("subscribe", subscribe), ("publish", publish)] {
            if !topics.is_empty() {
                table.insert(key, inline(topics));
            }
        }
    }

    /// Name of the broker with this address, which is added if need be.
    fn broker(&mut self, url: String) -> String {
        let known = self.brokers.iter().position(|known| *known == url);
        broker_name(known.unwrap_or_else(|| {
            self.brokers.push(url);
            self.brokers.len() - 1
        }))
    }

    fn setting(
        &mut self,
        component: &ScdlComponent,
        property: &ScdlProperty,
    ) -> Option<(String, Value)> {
        let name = property.name.value.clone();
        if let Some(source) = &property.source {
            return Some((name, self.source(source)));
        }
        let kind = self.kind(component, property);
        let values = property.values.iter();
        let values: Vec<Value> = values
            .map(|it| self.value(&component.name, property, kind, it))
            .collect();
        let value = match values.as_slice() {
            [] if !property.many => return None,
            [only] if !property.many => only.clone(),
            several => value::list(several.iter().cloned()),
        };
        Some((name, value))
    }

    /// Writes `source="$x"` as a reference to a property of the composite.
    fn source(&mut self, source: &At<String>) -> Value {
        let value = Value::from(format!("${{properties.{}}}", source.value));
        let mut known = self.composite.properties.iter().map(|it| &it.name);
        if known.clone().any(|name| name.value == source.value) {
            return value;
        }
        let names: Vec<&String> = known.clone().map(|name| &name.value).collect();
        let suggestion = asmotion_diagnostics::similar(&source.value, &names).copied();
        let finding = UnknownScdlName {
            what: "property",
            name: source.value.clone(),
            nearest: suggestion
                .and_then(|near| known.find(|it| it.value == *near))
                .cloned(),
            at: source.span,
        };
        self.report.push(finding.diagnostic());
        value
    }

    /// The type of a component's property, from the property itself or from the nested composite.
    fn kind(&self, component: &ScdlComponent, property: &ScdlProperty) -> Option<Scalar> {
        if let Some(kind) = &property.kind {
            return value::scalar(kind);
        }
        let Some(ScdlImplementation::Composite(name)) = &component.implementation else {
            return None;
        };
        let mut declared = self.nested.get(&name.value)?.properties.iter();
        let declared = declared.find(|it| it.name.value == property.name.value)?;
        value::scalar(declared.kind.as_ref()?)
    }

    fn value(
        &mut self,
        owner: &str,
        property: &ScdlProperty,
        kind: Option<Scalar>,
        text: &At<String>,
    ) -> Value {
        let name = &property.name.value;
        if is_secret(name) && !value::names_variable(text) {
            let of = format!("{owner}.{name}");
            let variable = name::password_variable(owner);
            let hidden = format!("${{{variable}}}");
            let at = text.span;
            self.report
                .push(PasswordInScdl { of, variable, at }.diagnostic());
            return hidden.into();
        }
        let Some(kind) = kind else {
            return value::guessed(text);
        };
        value::typed(text, kind).unwrap_or_else(|| {
            let finding = WrongAttributeValue {
                name: name.clone(),
                value: text.value.clone(),
                expected: value::expected(kind),
                at: text.span,
            };
            self.report.push(finding.diagnostic());
            text.value.as_str().into()
        })
    }

    fn properties(&mut self) -> Table {
        let composite = self.composite;
        let owner = &composite.name.value;
        let mut properties = table(composite.properties.iter().flat_map(|it| &it.notes));
        for property in &composite.properties {
            let kind = property.kind.as_ref().and_then(|kind| value::scalar(kind));
            let kind = kind.unwrap_or(Scalar::Text);
            let kind = if is_secret(&property.name) {
                Scalar::Secret
            } else {
                kind
            };
            let list = if property.many { "[]" } else { "" };
            let mut keys = vec![("type".to_owned(), Value::from(format!("{kind}{list}")))];
            let values = property.values.iter();
            let values: Vec<Value> = values
                .map(|it| self.value(owner, property, Some(kind), it))
                .collect();
            if property.many && !property.must_supply {
                keys.push(("default".to_owned(), value::list(values)));
            } else if let Some(default) = values.into_iter().next() {
                keys.push(("default".to_owned(), default));
            }
            properties.insert(&property.name, inline(keys));
        }
        properties
    }

    fn wires(&mut self) -> ArrayOfTables {
        let mut wires = ArrayOfTables::new();
        let mut done: Vec<&ScdlTarget> = Vec::new();
        for wire in &self.composite.wires {
            if done.contains(&&wire.source) {
                continue;
            }
            let same = self
                .composite
                .wires
                .iter()
                .filter(|it| it.source == wire.source);
            let services: Vec<Value> = same.map(|it| end(&it.target).into()).collect();
            done.push(&wire.source);
            if let Some(url) = self.url_of(&wire.source) {
                wires.push(self.wire_to_url(&wire.source, url));
                continue;
            }
            let mut table = table([]);
            table.insert("reference", item(end(&wire.source)));
            table.insert(
                "service",
                match services.as_slice() {
                    [only] => item(only.clone()),
                    several => item(value::list(several.iter().cloned())),
                },
            );
            let ends = [(&wire.source, true), (&wire.target, false)];
            let remote = ends
                .into_iter()
                .find_map(|(end, calls)| self.binding(end, calls));
            if let Some(word) = remote.and_then(word) {
                table.insert("binding", item(word));
                self.over_broker(word, &mut table);
            }
            match services.len() {
                1 => table.insert("timeout_ms", item(TIMEOUT_MS.cast_signed())),
                _ => table.insert("oneway", item(true)),
            };
            wires.push(table);
        }
        for component in &self.composite.components {
            for reference in &component.references {
                let source = ScdlTarget {
                    component: component.name.clone(),
                    name: Some(reference.name.clone()),
                };
                let is_wired = self.composite.wires.iter().any(|it| it.source == source);
                if let Some(url) = self.url_of(&source).filter(|_| !is_wired) {
                    wires.push(self.wire_to_url(&source, url));
                }
            }
        }
        wires
    }

    /// The table of a wire to a service of another system or robot.
    fn wire_to_url(&mut self, source: &ScdlTarget, (over, url): (ScdlTransport, &str)) -> Table {
        let mut wire = table([]);
        wire.insert("reference", item(end(source)));
        if let Some(word) = word(over) {
            wire.insert("binding", item(word));
            self.over_broker(word, &mut wire);
        }
        wire.insert("url", item(url));
        wire.insert("timeout_ms", item(TIMEOUT_MS.cast_signed()));
        wire
    }

    /// The URL that a reference calls and its transport, if its binding has one.
    fn url_of(&self, source: &ScdlTarget) -> Option<(ScdlTransport, &'w str)> {
        let composite: &'w ScdlComposite = self.composite;
        let mut components = composite.components.iter();
        let component = components.find(|it| it.name.value == source.component.value)?;
        let name = source.name.as_ref()?;
        let mut references = component.references.iter();
        let reference = references.find(|it| it.name.value == name.value)?;
        reference.url()
    }

    /// The transport that an end of a wire specifies, if any.
    fn binding(&self, end: &ScdlTarget, calls: bool) -> Option<ScdlTransport> {
        let mut components = self.composite.components.iter();
        let component = components.find(|it| it.name.value == end.component.value)?;
        let listed = if calls {
            &component.references
        } else {
            &component.services
        };
        let name = end.name.as_ref()?;
        let listed = listed.iter().find(|it| it.name.value == name.value)?;
        // HTTP without a URL is for clients outside
        let mut bound = listed.bindings.iter().map(|bound| bound.over);
        bound.find(|over| *over != ScdlTransport::Http)
    }

    fn promotions(&mut self) -> ArrayOfTables {
        let mut promotions = ArrayOfTables::new();
        let services = self.composite.services.iter().map(|it| ("service", it));
        let references = self.composite.references.iter().map(|it| ("reference", it));
        for (kind, promotion) in services.chain(references) {
            for (index, inside) in promotion.promote.iter().enumerate() {
                let mut table = table(promotion.notes.iter().filter(|_| index == 0));
                table.insert(kind, item(end(inside)));
                // one promotion per service or reference
                let name = match index {
                    0 => promotion.name.value.clone(),
                    more => format!("{}{}", promotion.name.value, more + 1),
                };
                if index > 0 {
                    let (at, name) = (inside.component.span, name.clone());
                    let (of, promoted) = (promotion.name.value.clone(), inside.to_string());
                    let finding = SeveralPromoted {
                        of,
                        promoted,
                        name,
                        at,
                    };
                    self.report.push(finding.diagnostic());
                }
                table.insert("as", item(&name));
                self.bind(promotion, &mut table);
                if kind == "service" {
                    self.gateway(promotion, &name, &mut table);
                }
                if kind == "reference" && promotion.multiplicity.optional {
                    table.insert("optional", item(true));
                }
                promotions.push(table);
            }
        }
        promotions
    }
}

/// Returns whether the name of a property suggests a secret.
fn is_secret(property: &str) -> bool {
    let name = property.to_lowercase();
    ["password", "passwd", "secret", "token"]
        .iter()
        .any(|word| name.contains(word))
}

fn implementation_item(implementation: &ScdlImplementation) -> Item {
    let one = |key: &str, value: String| inline([(key.to_owned(), Value::from(value))]);
    match implementation {
        ScdlImplementation::Java(class) => one("rust", name::component(class)),
        ScdlImplementation::Composite(composite) => one("composite", name::file(composite)),
        ScdlImplementation::Asm(file) => one("asm", file.value.clone()),
        ScdlImplementation::Python(script) => {
            let words = ["python3".into(), script.value.as_str().into()];
            inline([("process".to_owned(), value::list(words))])
        }
    }
}

fn contracts_item(key: &str, contracts: &[ScdlContract], table: &mut Table) {
    if contracts.is_empty() {
        return;
    }
    let entries = contracts.iter().map(|contract| {
        let interface = contract.interface.as_ref();
        let interface = interface.map_or("", |interface| &interface.name.value);
        let value = if key == "references" && contract.multiplicity.optional {
            let keys = [
                ("interface", Value::from(interface)),
                ("optional", true.into()),
            ];
            Value::InlineTable(keys.into_iter().collect::<InlineTable>())
        } else {
            interface.into()
        };
        (contract.name.value.clone(), value)
    });
    table.insert(key, inline(entries));
}
