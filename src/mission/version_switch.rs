//! Reconfiguration of a running mission: a new version of the composite arrives over the bus, is checked like the first
//! one, compared with the running system, and applied completely or refused.

use std::sync::Arc;

use asmotion_assembly::reconfigure::{Clients, Version, changes};
use asmotion_bus::{BusError, IncomingCall, Notifier, Payload, Refusal, ServedAddress};
use asmotion_datum::{Datum, DatumError};
use asmotion_lang::{Loader, Style, render_all};
use asmotion_network::{RobotService, RunningNetwork};
use asmotion_plan::{Opened, Part, Plan};
use asmotion_runtime::{Change, Run};
use serde::{Deserialize, Serialize};

use super::Mission;
use super::connected_broker::ConnectedBroker;
use crate::files::{DiskLoader, SentFiles};
use crate::programs::RunningPrograms;

/// Maximum number of versions waiting.
const WAITING: usize = 4;

/// Address at which a process receives new versions: `reconfigure.onboard`.
pub fn reconfigure_address(process: &str) -> String {
    format!("reconfigure.{process}")
}

/// A version of a composite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CompositeVersion {
    /// The composite and all files it names: paths relative to its folder, and texts.
    pub files: Vec<(String, String)>,
    /// Path of the composite among the files.
    pub composite: String,
    /// Report the changes without applying them.
    pub only_try: bool,
}

/// Applies new versions to a running part of a composite.
pub(super) struct VersionSwitch<'m> {
    mission: &'m Mission,
    /// Resolved path of the composite at the start of the process.
    path: &'m str,
    /// The running version.
    running: Version,
    /// The files of the running version, if it is not the first one.
    opened: Option<Opened>,
    calls: Vec<ServedAddress>,
    /// The buses of the running system.
    network: RunningNetwork,
    /// Names of the buses in the composite; `None` for the only one.
    bus_names: Vec<Option<String>>,
    /// The clients of other systems.
    clients: Option<Clients>,
}

impl<'m> VersionSwitch<'m> {
    /// Serves the reconfigure address on these buses.
    pub(super) fn new(
        mission: &'m Mission,
        path: &'m str,
        plan: &Arc<Plan>,
        part: &Part,
        buses: &'m [ConnectedBroker],
    ) -> Result<Self, BusError> {
        let process = mission.process.as_deref().unwrap_or(&plan.name);
        let address = reconfigure_address(process);
        let serve =
            |it: &ConnectedBroker| it.bus.serve(&address, WAITING, Arc::new(Notifier::new()));
        Ok(Self {
            mission,
            path,
            running: version_of(mission, plan, part.clone(), Arc::new(DiskLoader)),
            opened: None,
            calls: buses.iter().map(serve).collect::<Result<_, _>>()?,
            network: RunningNetwork::default(),
            bus_names: buses.iter().map(|it| it.name.clone()).collect(),
            clients: None,
        })
    }

    /// Sets the buses that the ends of later versions use, and the clients of other systems.
    pub(super) fn set_network(&mut self, network: RunningNetwork, clients: Clients) {
        self.network = network;
        self.clients = Some(clients);
    }

    /// Takes the services of other robots to which later versions have wired references: for each bus, in the order in which the
    /// process is connected to them.
    pub(super) fn new_robot_services(&self) -> Vec<Vec<Arc<RobotService>>> {
        let names = self.bus_names.iter();
        names
            .map(|name| self.network.new_robot_services(name.as_deref()))
            .collect()
    }

    /// Returns the running version.
    pub(super) fn running(&self) -> &Version {
        &self.running
    }

    /// Returns the files of the running version; `None` if it is the first one.
    pub(super) fn opened(&self) -> Option<&Opened> {
        self.opened.as_ref()
    }

    /// Applies the versions that have arrived. Returns whether another version runs now.
    pub(super) fn process_requests(&mut self, run: &mut dyn Run) -> bool {
        let calls = self.calls.iter();
        let calls: Vec<IncomingCall> = calls.filter_map(ServedAddress::try_next).collect();
        let mut has_changed = false;
        for call in calls {
            let answer = self.handle_request(&call, &mut has_changed, run);
            call.reply(answer.map(Payload::of));
        }
        has_changed
    }

    fn handle_request(
        &mut self,
        call: &IncomingCall,
        has_changed: &mut bool,
        run: &mut dyn Run,
    ) -> Result<Datum, Refusal> {
        let bad_request = |error: DatumError| refusal("BAD_REQUEST", error);
        let version: CompositeVersion = call
            .argument
            .to_datum()
            .and_then(|version| version.to())
            .map_err(bad_request)?;
        let (opened, wanted) = self.open(&version)?;
        self.verify(&version, &wanted)?;
        let mut changes = changes(&self.running, &wanted, &*run).map_err(|fixed| {
            let fixed: Vec<_> = fixed.iter().map(ToString::to_string).collect();
            refusal("NEEDS_START", fixed.join("; "))
        })?;
        self.keep_command_line_properties(&mut changes);
        let notes = if version.only_try {
            run.check_change(&changes)
        } else {
            run.change(&changes)
        };
        let notes = notes.map_err(|error| refusal("REFUSED", error))?;
        if !version.only_try {
            self.running = wanted;
            self.opened = Some(opened);
            *has_changed = true;
        }
        let words = changes.iter().map(ToString::to_string);
        let words: Vec<_> = words.chain(counted(notes)).collect();
        Datum::of(&words).map_err(bad_request)
    }

    /// Verifies a version before it is applied, as before a start.
    fn verify(&self, version: &CompositeVersion, wanted: &Version) -> Result<(), Refusal> {
        let sent = SentFiles::in_folder_of(self.path, &version.files);
        let verified = self
            .mission
            .verify_before_start(&wanted.plan, &wanted.part, &sent);
        verified.map_err(|error| refusal("NOT_VERIFIED", error))
    }

    /// Returns a version as this process would run it from the start.
    fn open(&self, version: &CompositeVersion) -> Result<(Opened, Version), Refusal> {
        let sent = SentFiles::in_folder_of(self.path, &version.files);
        let programs = RunningPrograms(&self.running.plan);
        let path = sent.path(&version.composite);
        let opened = self.mission.open(&path, &sent, &programs);
        if opened.report.has_errors() {
            let findings = render_all(&opened.report, &opened.sources, Style::Plain);
            return Err(refusal("BAD_COMPOSITE", findings));
        }
        match opened.plan(self.mission.profile.as_deref()) {
            None => {
                let profile = self.mission.profile.as_deref();
                let detail = other_profiles(profile, &version.composite, &opened.profiles);
                Err(refusal("BAD_COMPOSITE", detail))
            }
            Some(plan) if !plan.missing.is_empty() => {
                let missing = plan.missing.join(", ");
                let detail = format!("environment variables not set: {missing}");
                Err(refusal("BAD_COMPOSITE", detail))
            }
            Some(plan) => {
                let part = self.mission.part(plan);
                let part = part.map_err(|error| refusal("BAD_COMPOSITE", error))?;
                let reached = self.mission.check_outside(plan);
                reached.map_err(|error| refusal("NEEDS_START", error))?;
                let version = version_of(self.mission, plan, part, Arc::new(sent));
                let mut version = version.on_buses(self.network.clone());
                if let Some(clients) = &self.clients {
                    version = version.with_clients(Arc::clone(clients));
                }
                Ok((opened, version))
            }
        }
    }

    /// Removes changes of properties that were set on the command line, which keep their values. New components have them,
    /// too.
    fn keep_command_line_properties(&self, changes: &mut Vec<Change>) {
        let set = |of: &str, name: &str| {
            let mut set = self.mission.properties.iter();
            set.any(|(component, property, _)| component == of && property == name)
        };
        for change in &mut *changes {
            if let Change::Set { component, values } = change {
                values.retain(|(name, _)| !set(component, name));
            }
            if let Change::Add { component, by } = change {
                let of_this = self
                    .mission
                    .properties
                    .iter()
                    .filter(|it| it.0 == *component);
                for (_, property, value) in of_this {
                    *by = by.clone().property(property, value.clone());
                }
            }
        }
        changes.retain(|it| !matches!(it, Change::Set { values, .. } if values.is_empty()));
    }
}

fn version_of(
    mission: &Mission,
    plan: &Arc<Plan>,
    part: Part,
    loader: Arc<dyn Loader + Send + Sync>,
) -> Version {
    let catalogue = mission.build.shared_catalogue();
    let options = mission.coordinator_options(plan);
    Version::new(Arc::clone(plan), part, catalogue, loader, options)
}

/// Why a composite with these profiles is not a version of what runs, and what to do.
fn other_profiles(running: Option<&str>, composite: &str, available: &[String]) -> String {
    let listed = available.join("`, `");
    let Some(running) = running else {
        return format!(
            "this process runs without a profile, but `{composite}` has the profiles `{listed}`: remove `profile` \
             from its elements, or restart the process with one of them (`--profile`)"
        );
    };
    let (known, restart) = if available.is_empty() {
        ("it has none".to_owned(), "without `--profile`")
    } else {
        (format!("it has `{listed}`"), "with another one")
    };
    format!(
        "this process runs profile `{running}`, which `{composite}` does not have ({known}): keep an element with \
         `profile = \"{running}\"`, or restart the process {restart}"
    )
}

fn refusal(code: &str, detail: impl ToString) -> Refusal {
    Refusal {
        code: code.to_owned(),
        detail: detail.to_string(),
    }
}

/// Notes about components, each once: versions of a specification that several components run have the same ones.
fn counted(notes: Vec<String>) -> impl Iterator<Item = String> {
    let mut known: Vec<(String, usize)> = Vec::new();
    for note in notes {
        match known.iter_mut().find(|(text, _)| *text == note) {
            Some((_, count)) => *count += 1,
            None => known.push((note, 1)),
        }
    }
    known.into_iter().map(|(text, count)| match count {
        1 => text,
        count => format!("{text} ({count} components)"),
    })
}
