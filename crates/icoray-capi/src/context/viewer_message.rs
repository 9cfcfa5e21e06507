//! The message of rank 0 to the others about viewers of the live page, as bytes.

use std::collections::BTreeMap;

/// Between parts of a word, none of which can have it.
const APART: &str = "\u{1}";

/// What viewers have sent.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct ViewerMessage {
    /// The text of another scene.
    pub scene: Option<String>,
    /// Whether fields of that scene are not up to date: it is drawn by a later call, before which they are wanted.
    pub is_announced: bool,
    /// Milliseconds that a picture of each view may take where the scene is viewers', by the names of views. Empty if it
    /// is the model's own.
    pub budgets_ms: BTreeMap<String, f64>,
    /// Name of a field whose histogram is asked for.
    pub histogram: Option<String>,
    /// A scene, the name of one of its views, and that of another field to show there.
    pub look: Option<[String; 3]>,
    /// A place of a picture whose ray is probed, and the name of the picture's view.
    pub probe: Option<([f64; 2], String)>,
}

impl ViewerMessage {
    /// Whether there is something to do.
    pub fn is_any(&self) -> bool {
        *self != ViewerMessage::default()
    }

    /// The text of a scene whose fields are wanted before it is drawn, or before a look is suggested for them.
    #[cfg(feature = "live")]
    pub fn announced(&self) -> Option<String> {
        let look = self.look.as_ref().filter(|_| self.scene.is_none());
        self.scene.clone().or_else(|| look.map(|[_, _, field]| format!("field = {field:?}\n")))
    }

    /// Words, each with a letter for its kind before it and a NUL behind it, which no word can hold; none where viewers
    /// have sent nothing.
    pub fn bytes(&self) -> Vec<u8> {
        let scene = self.scene.iter().map(|text| format!("{}{text}", if self.is_announced { 'a' } else { 's' }));
        let budgets = self.budgets_ms.iter().map(|(view, ms)| format!("b{ms} {view}"));
        let histogram = self.histogram.iter().map(|field| format!("h{field}"));
        let look = self.look.iter().map(|look| format!("l{}", look.join(APART)));
        let probe = self.probe.iter().map(|([x, y], view)| format!("p{x} {y} {view}"));
        let words = scene.chain(budgets).chain(histogram).chain(look).chain(probe);
        words.flat_map(|word| word.into_bytes().into_iter().filter(|byte| *byte != 0).chain([0])).collect()
    }

    pub fn read(bytes: &[u8]) -> Self {
        let mut message = ViewerMessage::default();
        for word in String::from_utf8_lossy(bytes).split_terminator('\0') {
            let (kind, word) = word.split_at_checked(1).unwrap_or_default();
            match kind {
                "a" | "s" => (message.scene, message.is_announced) = (Some(word.to_owned()), kind == "a"),
                "b" => message.budgets_ms.extend(budget(word)),
                "h" => message.histogram = Some(word.to_owned()),
                "l" => message.look = word.split(APART).map(str::to_owned).collect::<Vec<_>>().try_into().ok(),
                _ => message.probe = probe(word),
            }
        }
        message
    }
}

fn budget(word: &str) -> Option<(String, f64)> {
    let (ms, view) = word.split_once(' ')?;
    Some((view.to_owned(), ms.parse().ok()?))
}

fn probe(word: &str) -> Option<([f64; 2], String)> {
    let mut words = word.splitn(3, ' ');
    let [x, y, view] = [words.next()?, words.next()?, words.next()?];
    Some(([x.parse().ok()?, y.parse().ok()?], view.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_arrive_as_they_were_sent() {
        let scene = || Some("field = \"q\"\n".to_owned());
        let budgets_ms = BTreeMap::from([(String::new(), 0.1 + 0.2), ("ä b".to_owned(), 1e9)]);
        for message in [
            ViewerMessage::default(),
            ViewerMessage { scene: scene(), ..ViewerMessage::default() },
            ViewerMessage { scene: scene(), is_announced: true, ..ViewerMessage::default() },
            ViewerMessage { histogram: Some("ä w".to_owned()), budgets_ms, ..ViewerMessage::default() },
            ViewerMessage {
                look: Some([scene().unwrap(), String::new(), "ä w".to_owned()]),
                ..ViewerMessage::default()
            },
            ViewerMessage {
                scene: scene(),
                probe: Some(([1.0 / 3.0, 1.0], "ä b".to_owned())),
                ..ViewerMessage::default()
            },
        ] {
            assert_eq!(ViewerMessage::read(&message.bytes()), message);
        }
        assert!(ViewerMessage::default().bytes().is_empty());
    }
}
