use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unknown direction of a renamed topic
///
/// `topicRename` of the Task Component Architecture names topics. Whether the component publishes or
/// subscribes to them, and their type, is defined in its class. It is known only for components of this
/// build.
///
/// ```xml wrong
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <component name="Planner">
///     <implementation.java class="nav.Planner"/>
///     <property name="id">planner</property>
///     <property name="period">100</property>
///     <property name="delay">0</property>
///     <property name="runOnStartup">true</property>
///     <property name="mayInterruptIfRunning">false</property>
///     <property name="useJMS">false</property>
///     <property name="topicRename" many="true"><value>trajectory=plan</value></property>
///   </component>
/// </composite>
/// ```
///
/// Corrected:
///
/// ```xml corrected
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <component name="Planner">
///     <implementation.java class="nav.Planner"/>
///     <property name="id">planner</property>
///     <property name="period">100</property>
///     <property name="delay">0</property>
///     <property name="runOnStartup">true</property>
///     <property name="mayInterruptIfRunning">false</property>
///     <property name="useJMS">false</property>
///   </component>
/// </composite>
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(X012, warning)]
#[error("unknown direction of topic `{topic}` of `{of}`")]
pub(crate) struct UndirectedTopic {
    pub of: String,
    pub topic: String,
    pub at: Span,
}

impl Finding for UndirectedTopic {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { topic, .. } = self;
        diagnostic.label(self.at, "renamed here").help(format!(
            "list `{topic}` under `publish` or `subscribe` of the composite file, with its type"
        ))
    }
}
