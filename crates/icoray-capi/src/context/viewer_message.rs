//! The message of rank 0 to the others about viewers of the live page, as bytes.

/// What viewers have sent.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct ViewerMessage {
    /// The text of another scene.
    pub scene: Option<String>,
    /// Names of fields whose histograms are asked for.
    pub histograms: Vec<String>,
}

impl ViewerMessage {
    /// Whether there is something to do.
    pub fn is_any(&self) -> bool {
        self.scene.is_some() || !self.histograms.is_empty()
    }

    /// Text and names, each ended by a NUL, which neither can hold; none where viewers have sent nothing.
    pub fn bytes(&self) -> Vec<u8> {
        if !self.is_any() {
            return Vec::new();
        }
        let words = [self.scene.as_deref().unwrap_or_default()].into_iter();
        let words = words.chain(self.histograms.iter().map(String::as_str));
        words.flat_map(|word| word.bytes().filter(|byte| *byte != 0).chain([0])).collect()
    }

    pub fn read(bytes: &[u8]) -> Self {
        let text = String::from_utf8_lossy(bytes);
        let mut words = text.split_terminator('\0').map(str::to_owned);
        ViewerMessage { scene: words.next().filter(|text| !text.is_empty()), histograms: words.collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_arrive_as_they_were_sent() {
        let names = || vec!["theta".to_owned(), "ä w".to_owned()];
        for (scene, histograms) in [
            (None, Vec::new()),
            (Some("field = \"q\"\n".to_owned()), Vec::new()),
            (None, names()),
            (Some("field = \"q\"".to_owned()), names()),
        ] {
            let message = ViewerMessage { scene, histograms };
            assert_eq!(ViewerMessage::read(&message.bytes()), message);
        }
        assert!(ViewerMessage::default().bytes().is_empty());
    }
}
