//! Checks services promoted over HTTP: each uses exactly one gateway.

use crate::codes::c009::InvalidName;
use crate::codes::c010::ExclusiveKeys;
use crate::codes::c020::UnknownName;
use crate::codes::c048::IdleKey;
use crate::codes::c063::NoGateway;
use crate::codes::c066::GatewayInTwoProcesses;
use std::borrow::Cow;
use std::collections::BTreeMap;

use asmotion_diagnostics::{Report, Span};

use super::scene::{CheckedComposite, processes};
use crate::at::At;
use crate::finding::Findings;
use crate::model::{Promoted, Promotion, Transport};
use crate::nearest::nearest;

pub(crate) fn check(scene: &CheckedComposite<'_>, report: &mut Report) {
    let mut gateways = Gateways {
        scene,
        processes: scene.composite.deploy.as_ref().map(processes),
        homes: BTreeMap::new(),
        report,
    };
    for promotion in &scene.composite.promotions {
        if scene.active(&promotion.profiles) {
            gateways.promotion(promotion);
        }
    }
    unused(scene, report);
}

/// Reports gateways through which no service is promoted, in any profile.
fn unused(scene: &CheckedComposite<'_>, report: &mut Report) {
    let gateways = &scene.composite.gateways;
    let promotions = scene.composite.promotions.iter();
    let over_http = promotions.filter(|it| it.over(Transport::Http).is_some());
    let over_http: Vec<&Promotion> = over_http.collect();
    for gateway in gateways {
        let is_its = |it: &&&Promotion| match &it.gateway {
            Some(name) => name.value == gateway.name.value,
            // a gateway is missing or ambiguous, which is an error of its own
            None => true,
        };
        if !over_http.iter().any(|it| is_its(&it)) {
            report.found(IdleKey {
                key: Cow::Owned(format!("gateways.{}", gateway.name.value)),
                at: gateway.name.span,
                reason: "no service is promoted through it with `binding = \"http\"`",
            });
        }
    }
}

struct Gateways<'s, 'r> {
    scene: &'s CheckedComposite<'s>,
    /// Process name by component; `None` if the composite has no deployment.
    processes: Option<BTreeMap<&'s str, &'s str>>,
    /// Process of each gateway and the promotion that determined it.
    homes: BTreeMap<&'s str, (&'s str, Span)>,
    report: &'r mut Report,
}

impl<'s> Gateways<'s, '_> {
    fn promotion(&mut self, promotion: &'s Promotion) {
        let kind = promotion.what.kind();
        let Some(binding) = promotion.over(Transport::Http) else {
            let reason = "only promotions over HTTP have a gateway";
            let gateway = promotion.gateway.as_ref().map(|it| ("gateway", it.span));
            let timeout = promotion
                .timeout_ms
                .as_ref()
                .map(|it| ("timeout_ms", it.span));
            for (key, at) in [gateway, timeout].into_iter().flatten() {
                self.excluded(kind, promotion, key, at, reason);
            }
            return;
        };
        let end = match &promotion.what {
            Promoted::Service(end) => end,
            // a gateway only accepts calls; it makes none
            Promoted::Reference(_) => return self.scene.transport(Some(binding), self.report),
            Promoted::Property(_) | Promoted::Port(_) | Promoted::Topic(_) => {
                let reason = "only services can be promoted over HTTP";
                return self.excluded(kind, promotion, "binding", binding.span, reason);
            }
        };
        self.name(&promotion.name);
        let Some(gateway) = self.gateway(promotion, binding.span) else {
            return;
        };
        let processes = self.processes.as_ref();
        let process = processes.and_then(|it| it.get(end.component.value.as_str()).copied());
        let Some(process) = process else {
            return;
        };
        let (home, first) = *self
            .homes
            .entry(gateway)
            .or_insert((process, end.component.span));
        if home != process {
            self.report.found(GatewayInTwoProcesses {
                gateway: gateway.to_owned(),
                processes: (home.to_owned(), process.to_owned()),
                at: end.component.span,
                first,
            });
        }
    }

    /// Returns the gateway of a promotion; reports an error if it is missing or ambiguous.
    fn gateway(&mut self, promotion: &'s Promotion, binding: Span) -> Option<&'s str> {
        let gateways = &self.scene.composite.gateways;
        let Some(name) = &promotion.gateway else {
            if let [only] = gateways.as_slice() {
                return Some(&only.name.value);
            }
            self.report.found(NoGateway {
                several: !gateways.is_empty(),
                at: binding,
            });
            return None;
        };
        let found = gateways.iter().find(|it| it.name.value == name.value);
        if found.is_none() {
            let known = gateways
                .iter()
                .map(|it| (it.name.value.as_str(), Some(it.name.span)));
            self.report.found(UnknownName {
                what: "gateway",
                name: name.value.clone(),
                at: name.span,
                nearest: nearest(name, known),
                left_out: None,
            });
        }
        found.map(|it| it.name.value.as_str())
    }

    /// Checks the promoted name, which becomes part of the URL.
    fn name(&mut self, name: &At<String>) {
        let plain =
            |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '_' | '-' | '.');
        if !name.chars().all(plain) {
            self.report.found(InvalidName {
                text: name.value.clone(),
                what: "a service over HTTP",
                rule: "use ASCII letters, digits, `_`, `-` and `.`, as in `/services/NAME`",
                at: name.span,
                variable: None,
            });
        }
    }

    fn excluded(
        &mut self,
        kind: &str,
        promotion: &Promotion,
        key: &str,
        at: Span,
        reason: &'static str,
    ) {
        self.report.found(ExclusiveKeys {
            first: kind.to_owned(),
            first_at: promotion.name.span,
            second: key.to_owned(),
            at,
            reason,
        });
    }
}
