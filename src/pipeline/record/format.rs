//! The format of frames and checkpoints: they begin with a word and a number, so that files of another
//! version are told apart from damaged ones.

/// Number of the format that this version writes. Version 0.1 wrote 1, which had no number in it.
pub const FORMAT: u8 = 2;

const WORD: &[u8] = b"peristitch";

/// A file's content with the format before it.
pub(crate) fn with_format(content: &[u8]) -> Vec<u8> {
    [WORD, &[FORMAT], content].concat()
}

/// The content of a file of this format.
///
/// # Errors
/// The number of another format.
pub(crate) fn without_format(file: &[u8]) -> Result<&[u8], u8> {
    match file.strip_prefix(WORD) {
        Some([FORMAT, content @ ..]) => Ok(content),
        Some([other, ..]) => Err(*other),
        _ => Err(1),
    }
}

/// Why a file of another format is refused.
pub(crate) fn other_format(found: u8) -> String {
    let whose = match found {
        1 => "peristitch 0.1 wrote it, or it is damaged".to_owned(),
        other => format!("another version of peristitch wrote it, in format {other}"),
    };
    format!("{whose}; this version reads format {FORMAT}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_of_another_format_is_told_with_its_number() {
        let file = with_format(b"content");
        assert_eq!(without_format(&file), Ok(&b"content"[..]));
        let mut newer = file.clone();
        newer[WORD.len()] = 3;
        assert_eq!(without_format(&newer), Err(3));
        assert_eq!(without_format(b"content"), Err(1));
        assert!(other_format(1).contains("0.1") && other_format(3).contains("format 3"));
    }
}
