//! Publishers and servers of one node of ROS 2, made by the declared types.
//!
//! Must never do: know what is said over them.

use crate::Ros2Error;
use crate::interfaces::{Interface, Service};
use crate::quality;
use ros2_client::{
    Context, MessageTypeName, Name, Node, NodeName, NodeOptions, Publisher, QosProfile, Server, ServiceMapping,
    ServiceTypeName, Subscription, WriteError,
};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A node with its namespace.
pub struct Place {
    /// The node.
    pub node: Node,
    namespace: String,
    dropped: Arc<AtomicU64>,
}

/// What is said over one topic.
pub struct Voice<M: Interface> {
    publisher: Publisher<M>,
    topic: String,
    dropped: Arc<AtomicU64>,
}

impl<M: Interface> Voice<M> {
    /// Says it. What there is no room for is dropped and counted, because somebody does not listen fast enough.
    pub fn say(&self, message: M) {
        match self.publisher.publish(message) {
            Ok(()) => {}
            Err(WriteError::WouldBlock { .. }) => drop(self.dropped.fetch_add(1, Ordering::Relaxed)),
            Err(error) => tracing::warn!("{} cannot be said: {error}", self.topic),
        }
    }

    /// The topic's whole name.
    #[must_use]
    pub fn topic(&self) -> &str {
        &self.topic
    }
}

impl Place {
    /// A node of this name in this namespace; what is dropped is counted there.
    ///
    /// # Errors
    /// When DDS refuses.
    pub fn new(context: &Context, namespace: &str, name: &str, dropped: Arc<AtomicU64>) -> Result<Self, Ros2Error> {
        let options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
        let full = NodeName::new(namespace, name).map_err(|e| Ros2Error::of(namespace, &e))?;
        let node = context
            .new_node(full, options)
            .map_err(|e| Ros2Error::of(namespace, &e))?;
        Ok(Self {
            node,
            namespace: namespace.to_owned(),
            dropped,
        })
    }

    /// A topic, relative to the namespace unless it begins with `/`.
    fn name(&self, topic: &str) -> Result<Name, Ros2Error> {
        Name::parse(&self.full(topic)).map_err(|e| Ros2Error::of(topic, &e))
    }

    fn full(&self, topic: &str) -> String {
        if topic.starts_with('/') {
            topic.to_owned()
        } else {
            format!("{}/{topic}", self.namespace)
        }
    }

    /// A publisher.
    ///
    /// # Errors
    /// When DDS refuses.
    pub fn voice<M: Interface>(&mut self, topic: &str, quality: &QosProfile) -> Result<Voice<M>, Ros2Error> {
        let of = |error: &dyn std::fmt::Display| Ros2Error::of(topic, error);
        let dds = self
            .node
            .create_topic(&self.name(topic)?, MessageTypeName::new(M::PACKAGE, M::NAME), quality);
        let publisher = self
            .node
            .create_publisher(&dds.map_err(|e| of(&e))?, Some(quality.clone()));
        Ok(Voice {
            publisher: publisher.map_err(|e| of(&e))?,
            topic: self.full(topic),
            dropped: self.dropped.clone(),
        })
    }

    /// A subscription.
    ///
    /// # Errors
    /// When DDS refuses.
    pub fn ear<M: Interface>(&mut self, topic: &str, quality: &QosProfile) -> Result<Subscription<M>, Ros2Error> {
        let of = |error: &dyn std::fmt::Display| Ros2Error::of(topic, error);
        let dds = self
            .node
            .create_topic(&self.name(topic)?, MessageTypeName::new(M::PACKAGE, M::NAME), quality);
        let subscription = self
            .node
            .create_subscription(&dds.map_err(|e| of(&e))?, Some(quality.clone()));
        subscription.map_err(|e| of(&e))
    }

    /// A server.
    ///
    /// # Errors
    /// When DDS refuses.
    pub fn server<S: Service>(&mut self, service: &str) -> Result<Server<S::Request, S::Response>, Ros2Error> {
        let kind = ServiceTypeName::new(S::PACKAGE, S::NAME);
        let name = self.name(service)?;
        let server = self.node.create_server(
            ServiceMapping::Enhanced,
            &name,
            &kind,
            quality::services(),
            quality::services(),
        );
        server.map_err(|e| Ros2Error::of(service, &e))
    }

    /// Whether anybody listens to a topic.
    #[must_use]
    pub fn is_heard<M: Interface>(&self, voice: &Voice<M>) -> bool {
        self.node.subscription_count(voice.topic()) > 0
    }
}
