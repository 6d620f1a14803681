//! The ten properties of a component of the Task Component Architecture, and the task that they describe.
//!
//! Six are required: `id`, `period`, `delay`, `runOnStartup`, `mayInterruptIfRunning`, `useJMS`. With `useJMS`, `user`,
//! `password` and `url` describe the broker; `topicRename` contains pairs of names.

use crate::codes::x005::PasswordInScdl;
use crate::codes::x007::WrongAttributeValue;
use asmotion_composite::At;
use asmotion_diagnostics::{Finding, Report, Span};

use crate::model::{ScdlComponent, ScdlProperty};
use crate::name;
use crate::value::names_variable;

/// The properties that mark a component as a task.
const REQUIRED: [&str; 6] = [
    "id",
    "period",
    "delay",
    "runOnStartup",
    "mayInterruptIfRunning",
    "useJMS",
];

/// The broker of a task that specifies no `url`.
pub(crate) const BROKER: &str = "${ASMOTION_BUS:-amqp://guest:guest@127.0.0.1:5672/%2f}";

/// A time in milliseconds, or the property of the composite that supplies it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum TcaTime {
    Milliseconds(i64),
    Property(At<String>),
}

/// The contents of the ten properties.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TcaTask {
    pub id: String,
    pub period: TcaTime,
    pub delay: TcaTime,
    pub run_on_startup: bool,
    pub may_interrupt_if_running: bool,
    /// Address of the broker as in composite files; `None` without `useJMS`.
    pub broker: Option<String>,
    /// `topicRename`: pairs of a name in the component and a topic.
    pub rename: Vec<(String, String)>,
}

/// Removes the ten properties from a component that has the required ones.
pub(crate) fn take(component: &mut ScdlComponent, report: &mut Report) -> Option<TcaTask> {
    let has = |name: &&str| {
        component
            .properties
            .iter()
            .any(|it| it.name.value == **name)
    };
    if !REQUIRED.iter().all(has) {
        return None;
    }
    let mut ten = TcaProperties { component, report };
    let id = ten.text("id").map_or_else(String::new, |id| id.value);
    let (period, delay) = (ten.time("period"), ten.time("delay"));
    let (run_on_startup, may_interrupt_if_running) =
        (ten.flag("runOnStartup"), ten.flag("mayInterruptIfRunning"));
    let uses_broker = ten.flag("useJMS");
    Some(TcaTask {
        id,
        period,
        delay,
        run_on_startup,
        may_interrupt_if_running,
        // without a broker, its properties remain in the component, so that nothing is lost
        broker: uses_broker.then(|| ten.broker()),
        rename: ten.rename(),
    })
}

struct TcaProperties<'t> {
    component: &'t mut ScdlComponent,
    report: &'t mut Report,
}

impl TcaProperties<'_> {
    fn take(&mut self, name: &str) -> Option<ScdlProperty> {
        let properties = &mut self.component.properties;
        let index = properties.iter().position(|it| it.name.value == name)?;
        Some(properties.remove(index))
    }

    fn text(&mut self, name: &str) -> Option<At<String>> {
        let property = self.take(name)?;
        let mut values = property.values.into_iter();
        values.next().filter(|value| !value.is_empty())
    }

    fn time(&mut self, name: &str) -> TcaTime {
        let Some(mut property) = self.take(name) else {
            return TcaTime::Milliseconds(0);
        };
        if let Some(source) = property.source {
            return TcaTime::Property(source);
        }
        let Some(text) = property.values.pop() else {
            return TcaTime::Milliseconds(0);
        };
        let number = text.parse().ok().filter(|number| *number >= 0);
        let expected = "a number of milliseconds";
        TcaTime::Milliseconds(number.unwrap_or_else(|| self.report_invalid(name, &text, expected)))
    }

    fn flag(&mut self, name: &str) -> bool {
        let Some(text) = self.text(name) else {
            return false;
        };
        let truth = text.parse().ok();
        truth.unwrap_or_else(|| self.report_invalid(name, &text, "`true` or `false`"))
    }

    fn report_invalid<T: Default>(
        &mut self,
        name: &str,
        value: &At<String>,
        expected: &'static str,
    ) -> T {
        let finding = WrongAttributeValue {
            name: name.to_owned(),
            value: value.value.clone(),
            expected,
            at: value.span,
        };
        self.report.push(finding.diagnostic());
        T::default()
    }

    /// Combines `user`, `password` and `url` into one address; a literal password becomes an environment variable.
    fn broker(&mut self) -> String {
        let Some(url) = self.text("url") else {
            return BROKER.to_owned();
        };
        let (user, password) = (self.text("user"), self.text("password"));
        let password = password.map(|password| {
            if names_variable(&password) {
                password.value
            } else {
                self.hide(password.span)
            }
        });
        address(
            &url,
            user.as_ref().map(|user| user.value.as_str()),
            password.as_deref(),
        )
    }

    /// Reports a literal password and returns the variable that replaces it.
    fn hide(&mut self, at: Span) -> String {
        let of = self.component.name.value.clone();
        let variable = name::password_variable(&of);
        let shown = format!("${{{variable}}}");
        let finding = PasswordInScdl { of, variable, at };
        self.report.push(finding.diagnostic());
        shown
    }

    /// Reads `trajectory=plan` values, or lists in which both names follow each other.
    fn rename(&mut self) -> Vec<(String, String)> {
        let Some(property) = self.take("topicRename") else {
            return Vec::new();
        };
        let words = property.values.iter().flat_map(|value| {
            let words = value.split(|letter: char| letter.is_whitespace() || letter == ';');
            words.filter(|word| !word.is_empty()).map(str::to_owned)
        });
        let words: Vec<String> = words.collect();
        let separated = |word: &String| {
            let (from, to) = word.split_once(['=', ',', ':'])?;
            Some((from.to_owned(), to.to_owned()))
        };
        if let Some(pairs) = words.iter().map(separated).collect() {
            return pairs;
        }
        let pairs = words.chunks(2).map(|pair| match pair {
            [from, to] => Some((from.clone(), to.clone())),
            _ => None,
        });
        pairs.collect::<Option<_>>().unwrap_or_else(|| {
            let text = words.join(" ");
            let expected = "pairs of names, as in `trajectory=plan`";
            self.report_invalid("topicRename", &At::new(text, property.name.span), expected)
        })
    }
}

/// Builds `scheme://user:password@host`.
fn address(url: &str, user: Option<&str>, password: Option<&str>) -> String {
    let Some((scheme, host)) = url.split_once("://") else {
        return url.to_owned();
    };
    match (user, password) {
        (Some(user), Some(password)) => format!("{scheme}://{user}:{password}@{host}"),
        (Some(user), None) => format!("{scheme}://{user}@{host}"),
        (None, Some(password)) => format!("{scheme}://:{password}@{host}"),
        (None, None) => url.to_owned(),
    }
}

/// Splits an address into `url`, `user` and `password`. A literal password is left out.
fn split_address(address: &str) -> [(&'static str, Option<String>); 3] {
    let parts = || {
        let (scheme, rest) = address.split_once("://")?;
        let (who, host) = rest.rsplit_once('@')?;
        let (user, password) = match colon(who) {
            Some(colon) => (&who[..colon], Some(&who[colon + 1..])),
            None => (who, None),
        };
        Some((format!("{scheme}://{host}"), user, password))
    };
    let Some((url, user, password)) = parts() else {
        return [
            ("user", None),
            ("password", None),
            ("url", Some(address.to_owned())),
        ];
    };
    let user = (!user.is_empty()).then(|| user.to_owned());
    let password = password.filter(|it| names_variable(it)).map(str::to_owned);
    [("user", user), ("password", password), ("url", Some(url))]
}

/// Position of the colon between user and password; colons in the default of a variable do not count.
fn colon(who: &str) -> Option<usize> {
    let mut depth = 0_u32;
    let colon = who.char_indices().find(|(_, letter)| {
        match letter {
            '{' => depth += 1,
            '}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        *letter == ':' && depth == 0
    });
    colon.map(|(at, _)| at)
}

/// Returns whether an address contains a literal password.
pub(crate) fn has_password(address: &str) -> bool {
    let who = address
        .split_once("://")
        .and_then(|(_, rest)| rest.rsplit_once('@'));
    let password = who.and_then(|(who, _)| Some(&who[colon(who)? + 1..]));
    password.is_some_and(|password| !names_variable(password))
}

/// The ten properties of a task, in the order of the paper.
pub(crate) fn properties(task: &TcaTask, at: Span) -> Vec<ScdlProperty> {
    let one = |name: &str, value: &str| property(name, vec![value.to_owned()], at);
    let time = |name: &str, time: &TcaTime| match time {
        TcaTime::Milliseconds(number) => one(name, &number.to_string()),
        TcaTime::Property(source) => ScdlProperty {
            source: Some(source.clone()),
            ..property(name, Vec::new(), at)
        },
    };
    let flag = |name: &str, truth: bool| one(name, if truth { "true" } else { "false" });
    let mut properties = vec![
        one("id", &task.id),
        time("period", &task.period),
        time("delay", &task.delay),
        flag("runOnStartup", task.run_on_startup),
        flag("mayInterruptIfRunning", task.may_interrupt_if_running),
        flag("useJMS", task.broker.is_some()),
    ];
    let named = task.broker.as_deref().filter(|address| *address != BROKER);
    for (name, value) in named.into_iter().flat_map(split_address) {
        properties.extend(value.map(|value| one(name, &value)));
    }
    if !task.rename.is_empty() {
        let pairs = task.rename.iter();
        let pairs = pairs.map(|(from, to)| format!("{from}={to}")).collect();
        properties.push(ScdlProperty {
            many: true,
            ..property("topicRename", pairs, at)
        });
    }
    properties
}

fn property(name: &str, values: Vec<String>, at: Span) -> ScdlProperty {
    ScdlProperty {
        name: At::new(name.to_owned(), at),
        kind: None,
        values: values.into_iter().map(|value| At::new(value, at)).collect(),
        many: false,
        source: None,
        must_supply: false,
        notes: Vec::new(),
    }
}
