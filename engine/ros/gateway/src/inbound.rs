//! A mapping of a topic from ROS.

use std::time::{Duration, Instant};

use asmotion_bridge::{Conversion, Use};
use asmotion_component::{Cycle, Interface, Losses, Out};
use asmotion_datum::{Datum, Schema, Shape};
use asmotion_transform::TransformBuffer;

use crate::echo::Echoes;
use crate::frames::FrameQueue;
use crate::mapped::MappedTopic;
use crate::misfits::Misfits;
use crate::open_connection::sum;
use crate::traffic::Traffic;
use crate::transport::{MessageReceiver, RosMessage};

/// A mapping of a topic from ROS.
pub(crate) struct Inbound {
    pub(crate) mapped: MappedTopic,
    port: Out<Datum>,
    conversion: Conversion,
    /// A message, as it was decoded, is a sample.
    is_alike: bool,
    pub(crate) traffic: Traffic,
    /// Messages that wait for transforms; `None` if their frame stays.
    frames: Option<FrameQueue>,
    /// Messages that did not fit.
    misfits: u64,
    /// Losses of connections that were replaced.
    before: Losses,
}

impl Inbound {
    /// Declares the port.
    ///
    /// # Errors
    /// The reason that the messages cannot be converted or transformed.
    pub(crate) fn declare(
        mapped: MappedTopic,
        ros_schema: &Schema,
        interface: &mut Interface,
    ) -> Result<Self, String> {
        let frames = mapped.transform.as_ref();
        let frames = frames.map(|it| FrameQueue::new(&mapped, it)).transpose()?;
        let schema = &mapped.schema;
        let converters = mapped.converters.iter();
        let converted = converters.fold(schema.clone(), |schema, converter| {
            converter.converted(schema, ros_schema)
        });
        let conversion = Conversion::between(ros_schema, &converted, Use::Fill);
        let conversion = conversion
            .ok_or_else(|| format!("`{}` of ROS does not become `{schema}`", mapped.kind))?;
        let is_alike = mapped.converters.is_empty()
            && mapped.transform.is_none()
            && is_alike(schema, ros_schema);
        let doc = format!("from the ROS topic `{}`", mapped.ros);
        let port = interface.output_of(&mapped.port, schema.clone(), &doc);
        Ok(Self {
            mapped,
            port,
            conversion,
            is_alike,
            traffic: Traffic::default(),
            frames,
            misfits: 0,
            before: Losses::default(),
        })
    }

    /// Writes the messages of ROS to the output.
    pub(crate) fn write(
        &mut self,
        receiver: &mut dyn MessageReceiver,
        mut echoes: Option<&mut Echoes>,
        buffer: &TransformBuffer,
        misfits: &mut Misfits,
        cycle: &mut Cycle<'_>,
    ) {
        let arrived = receiver.take();
        let Some(frames) = &mut self.frames else {
            for message in arrived {
                self.write_one(message, echoes.as_deref_mut(), misfits, cycle);
            }
            return;
        };
        let now = Instant::now();
        for message in arrived {
            frames.push(message, now);
        }
        for outcome in frames.take(buffer, now) {
            match outcome {
                Ok(message) => self.write_one(message, echoes.as_deref_mut(), misfits, cycle),
                Err(misfit) => {
                    let (reason, details) = misfit.texts();
                    self.count_misfit((&reason, &details), misfits, cycle);
                }
            }
        }
    }

    fn count_misfit(&mut self, texts: (&str, &str), misfits: &mut Misfits, cycle: &mut Cycle<'_>) {
        self.misfits += 1;
        let at = (&self.mapped.port, &self.mapped.ros);
        misfits.count_with_details(at, texts, cycle);
    }

    fn write_one(
        &mut self,
        message: RosMessage,
        echoes: Option<&mut Echoes>,
        misfits: &mut Misfits,
        cycle: &mut Cycle<'_>,
    ) {
        match self.sample(message.content) {
            Ok(sample) => {
                if let Some(echoes) = echoes {
                    echoes.written(&sample);
                }
                cycle.write_aged(self.port, sample, message.age);
                self.traffic.pass(1, Instant::now());
            }
            Err(reason) => self.count_misfit((&reason, ""), misfits, cycle),
        }
    }

    /// The sample for a message of ROS.
    fn sample(&self, message: Datum) -> Result<Datum, String> {
        if self.is_alike {
            return Ok(message);
        }
        let converted = self.conversion.convert(message);
        let mut converters = self.mapped.converters.iter();
        let sample = converters.try_fold(converted, |sample, it| it.to_here(sample))?;
        let complete = self.mapped.schema.complete(sample);
        complete.map_err(|error| error.to_string())
    }

    /// Adds the losses of a connection that ends.
    pub(crate) fn keep_losses(&mut self, losses: Losses) {
        self.before = sum(self.before, losses);
    }

    /// Losses that the present connection does not know, without misfits.
    pub(crate) fn losses(&self) -> Losses {
        let waiting = self.frames.as_ref().map(FrameQueue::losses);
        sum(self.before, waiting.unwrap_or_default())
    }

    /// Messages that did not fit.
    pub(crate) fn misfits(&self) -> u64 {
        self.misfits
    }

    /// Time until a message has waited for long enough.
    pub(crate) fn patience(&self, now: Instant) -> Option<Duration> {
        self.frames.as_ref()?.patience(now)
    }
}

/// Returns whether what is decoded with one schema is complete for the other: the same fields in the same order.
fn is_alike(one: &Schema, other: &Schema) -> bool {
    match (&one.shape, &other.shape) {
        (Shape::Record(one), Shape::Record(other)) => {
            let mut pairs = one.iter().zip(other);
            one.len() == other.len()
                && pairs.all(|(one, other)| {
                    one.name == other.name && is_alike(&one.schema, &other.schema)
                })
        }
        (Shape::List(one), Shape::List(other)) | (Shape::Option(one), Shape::Option(other)) => {
            is_alike(one, other)
        }
        (Shape::Array(one, count), Shape::Array(other, number)) => {
            count == number && is_alike(one, other)
        }
        (one, other) => one == other,
    }
}

#[cfg(test)]
mod tests {
    use asmotion_datum::OutlineKey;
    use asmotion_ros_interface::{Catalogue, Distribution};

    use super::*;
    use crate::mapped::RosDirection;

    #[test]
    fn schemas_are_alike_if_they_differ_in_descriptions_alone() {
        let schema = |fields: &[(&'static str, &'static str, Shape)]| {
            let fields = fields.iter().map(|(name, doc, shape)| {
                OutlineKey::new(*name, *doc, Schema::plain(shape.clone()))
            });
            Schema::record("example/Point", fields.collect::<Vec<_>>())
        };
        let point = schema(&[("x", "m", Shape::F64), ("y", "m", Shape::F64)]);
        let of_ros = schema(&[("x", "", Shape::F64), ("y", "", Shape::F64)]);
        assert!(is_alike(&point, &of_ros));
        for other in [
            schema(&[("y", "", Shape::F64), ("x", "", Shape::F64)]),
            schema(&[("x", "", Shape::F64), ("y", "", Shape::F32)]),
            schema(&[("x", "", Shape::F64)]),
            Schema::plain(Shape::Any),
        ] {
            assert!(!is_alike(&point, &other), "{other}");
        }
        let list = |of: &Schema| Schema::plain(Shape::List(Box::new(of.clone())));
        assert!(is_alike(&list(&point), &list(&of_ros)));
    }

    /// Commands, which are urgent, need no conversion.
    #[test]
    fn a_twist_of_ros_is_a_sample_as_it_was_decoded() {
        let schema = |of| {
            let twist = "geometry_msgs/msg/Twist".parse().unwrap();
            Catalogue::included(of).schema(&twist).unwrap()
        };
        let (ros1, ros2) = (schema(Distribution::Ros1), schema(Distribution::Ros2));
        let mut interface = Interface::default();
        for (port, of_ros) in [("from_ros1", &ros1), ("from_ros2", &ros2)] {
            let mapped = MappedTopic {
                port: port.to_owned(),
                topic: None,
                schema: ros2.clone(),
                ros: "/cmd_vel".to_owned(),
                kind: "geometry_msgs/Twist".to_owned(),
                queue: 1,
                is_latched: false,
                is_best_effort: false,
                deadline: None,
                lifespan: None,
                converters: Vec::new(),
                transform: None,
                direction: RosDirection::FromRos,
            };
            let inbound = Inbound::declare(mapped, of_ros, &mut interface).unwrap();
            assert!(inbound.is_alike);
        }
    }
}
