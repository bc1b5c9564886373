//! Blanks beside quotes and before comments, which the rules of CSV do not know and which people write: they are moved to where they do
//! no harm, so that every byte after them keeps its place.

/// What is wrong with the quotes of a text: the byte at which the quoted cell begins or ends, and a sentence.
pub(super) type QuoteFault = (usize, &'static str);

const UNCLOSED: &str = "the quote is not closed";
const FOLLOWED: &str = "a separator must follow the quoted text";

/// True for a byte after which a cell may begin.
fn ends_cell(byte: u8) -> bool {
    matches!(byte, b',' | b';' | b'\t' | b'\n' | b'\r')
}

/// The text, if it changes, with ` "x" ,` as `" x " ,` would be written, and indented comments at the beginning of their lines.
///
/// # Errors
/// If a quote is not closed, or if text follows a closing quote.
pub(super) fn tidied(text: &str) -> Result<Option<String>, QuoteFault> {
    if !text.contains('"') && !text.contains(" #") && !text.contains("\t#") {
        return Ok(None);
    }
    let mut bytes = text.as_bytes().to_vec();
    let mut at = 0;
    let mut begins_line = true;
    while at < bytes.len() {
        let blanks = bytes[at..].iter().take_while(|byte| **byte == b' ').count();
        let first = bytes.get(at + blanks).copied();
        if begins_line && let Some(comment) = comment_start(&bytes, at) {
            bytes.swap(at, comment);
            at = end_of_line(&bytes, at);
        } else if first == Some(b'"') {
            bytes.swap(at, at + blanks);
            at = end_of_quoted(&mut bytes, at, blanks)?;
        } else {
            at += bytes[at..].iter().take_while(|byte| !ends_cell(**byte)).count();
        }
        begins_line = bytes.get(at).is_some_and(|byte| matches!(byte, b'\n' | b'\r'));
        at += 1;
    }
    // Only bytes of ASCII were exchanged.
    String::from_utf8(bytes).map(Some).map_err(|_| (0, UNCLOSED))
}

/// Where the `#` of a comment is that begins at `at` but for blanks.
fn comment_start(bytes: &[u8], at: usize) -> Option<usize> {
    let blanks = bytes[at..].iter().take_while(|byte| matches!(byte, b' ' | b'\t')).count();
    (bytes.get(at + blanks) == Some(&b'#')).then_some(at + blanks)
}

fn end_of_line(bytes: &[u8], at: usize) -> usize {
    at + bytes[at..].iter().take_while(|byte| !matches!(byte, b'\n' | b'\r')).count()
}

/// Where a cell ends whose quote opens at `start`, with `blanks` that were moved behind the quote; blanks after the closing quote are
/// moved before it.
fn end_of_quoted(bytes: &mut [u8], start: usize, blanks: usize) -> Result<usize, QuoteFault> {
    let mut at = start + 1 + blanks;
    loop {
        match (bytes.get(at), bytes.get(at + 1)) {
            (None, _) => return Err((start, UNCLOSED)),
            (Some(b'"'), Some(b'"')) => at += 2,
            (Some(b'"'), _) => break,
            _ => at += 1,
        }
    }
    let after = bytes[at + 1..].iter().take_while(|byte| **byte == b' ').count();
    let end = at + 1 + after;
    if bytes.get(end).is_some_and(|byte| !ends_cell(*byte)) {
        return Err((end, FOLLOWED));
    }
    bytes.swap(at, end - 1);
    Ok(end)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tidy(text: &str) -> Result<String, QuoteFault> {
        Ok(tidied(text)?.unwrap_or_else(|| text.to_string()))
    }

    #[test]
    fn blanks_go_into_quotes_and_comments_to_the_beginning() {
        assert_eq!(tidy("a,  \"b, c\" ,d\n  # x, \"y\n1").unwrap(), "a,\"  b, c \",d\n#   x, \"y\n1");
        assert_eq!(tidy("\"a\"\"b\" \r\n2\" tube;\"x\ny\"").unwrap(), "\"a\"\"b \"\r\n2\" tube;\"x\ny\"");
        assert_eq!(tidy("a;b\n").unwrap(), "a;b\n");
    }

    #[test]
    fn quotes_that_are_not_closed_are_refused() {
        assert_eq!(tidy("a,b\n1,\"x\n").unwrap_err(), (6, UNCLOSED));
        assert_eq!(tidy("\"x\"y,1\n").unwrap_err(), (3, FOLLOWED));
    }
}
