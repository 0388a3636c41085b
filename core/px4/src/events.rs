//! Events of one link until the vehicle actor takes them. Status texts are bounded, the oldest go first; others never go.

use skein_domain::link::LinkEvent;

/// Status texts kept at most.
const TEXTS_MAX: usize = 64;

/// The queue.
#[derive(Debug, Default)]
pub struct EventQueue {
    events: Vec<LinkEvent>,
    texts: usize,
}

impl EventQueue {
    /// Adds one.
    pub fn push(&mut self, event: LinkEvent) {
        if matches!(event, LinkEvent::StatusText { .. }) {
            if self.texts >= TEXTS_MAX {
                if let Some(oldest) = self
                    .events
                    .iter()
                    .position(|e| matches!(e, LinkEvent::StatusText { .. }))
                {
                    self.events.remove(oldest);
                }
            } else {
                self.texts += 1;
            }
        }
        self.events.push(event);
    }

    /// Takes all, oldest first.
    pub fn take(&mut self) -> Vec<LinkEvent> {
        self.texts = 0;
        std::mem::take(&mut self.events)
    }
}

#[cfg(test)]
mod tests {
    //! What is dropped, and what never is.

    use super::*;

    #[test]
    fn only_the_oldest_texts_are_dropped() {
        let mut queue = EventQueue::default();
        queue.push(LinkEvent::Lost);
        for i in 0..TEXTS_MAX + 5 {
            queue.push(LinkEvent::StatusText {
                severity: 6,
                text: i.to_string(),
            });
            queue.push(LinkEvent::ArmedChanged { armed: true });
        }
        let events = queue.take();
        let texts: Vec<_> = events
            .iter()
            .filter(|e| matches!(e, LinkEvent::StatusText { .. }))
            .collect();
        assert_eq!(texts.len(), TEXTS_MAX);
        assert_eq!(
            texts[0],
            &LinkEvent::StatusText {
                severity: 6,
                text: "5".into()
            }
        );
        assert_eq!(events[0], LinkEvent::Lost);
        assert_eq!(events.len(), 1 + TEXTS_MAX + TEXTS_MAX + 5);
        assert!(queue.take().is_empty());
    }
}
