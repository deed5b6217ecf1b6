//! Words of pipeline files that an earlier version took and this one does not.

/// A word that was removed, and what to write in its place.
pub struct RemovedWord {
    /// The key whose value it was.
    key: &'static str,
    word: &'static str,
    pub reason: &'static str,
    pub replacement: &'static str,
}

const REMOVED_WORDS: [RemovedWord; 1] = [RemovedWord {
    key: "coupling",
    word: "splice",
    reason: "it was removed, because its reactions do not balance the loads",
    replacement: "write `coupling: clip`, which passes the linear patch test and conserves momentum and energy",
}];

impl RemovedWord {
    pub fn find(key: &str, word: &str) -> Option<&'static RemovedWord> {
        let is_it = |removed: &&RemovedWord| removed.key == key && removed.word == word;
        REMOVED_WORDS.iter().find(is_it)
    }
}
