//! A cursor over the bytes of a text file: blanks, tokens, numbers, lines.
//!
//! `\n` and `\r` both end a line, so `\r\n` reads as a line and an empty one after it; no format here
//! minds. Line numbers are counted only for messages.

use crate::ErrorKind;

/// A place in a text file.
#[derive(Clone, Debug)]
pub(crate) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Whether a backslash at the end of a line joins it to the next, as in OBJ.
    continuations: bool,
}

impl<'a> Cursor<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, continuations: false }
    }

    pub(crate) fn with_continuations(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, continuations: true }
    }

    pub(crate) fn is_end(&self) -> bool {
        self.at >= self.bytes.len()
    }

    pub(crate) fn offset(&self) -> usize {
        self.at
    }

    /// How many bytes are left.
    pub(crate) fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// Goes to a place; one beyond the end is the end.
    pub(crate) fn seek(&mut self, at: usize) {
        self.at = at.min(self.bytes.len());
    }

    #[inline]
    pub(crate) fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    /// Skips spaces, tabs and joined line ends, not the end of a line.
    #[inline]
    pub(crate) fn skip_blanks(&mut self) {
        while let Some(b) = self.peek() {
            match b {
                b' ' | b'\t' | 0x0b | 0x0c => self.at += 1,
                b'\\' if self.continuations => match self.bytes.get(self.at + 1..) {
                    Some([b'\r', b'\n', ..]) => self.at += 3,
                    Some([b'\n' | b'\r', ..]) => self.at += 2,
                    _ => return,
                },
                _ => return,
            }
        }
    }

    /// Skips blanks, line ends, and comments from `#` to the end of their line.
    #[inline]
    pub(crate) fn skip_space(&mut self) {
        loop {
            self.skip_blanks();
            match self.peek() {
                Some(b'\n' | b'\r') => self.at += 1,
                Some(b'#') => self.skip_comment(),
                _ => return,
            }
        }
    }

    /// Whether nothing but a line end, or the end of the file, is here.
    #[inline]
    pub(crate) fn at_line_end(&self) -> bool {
        matches!(self.peek(), None | Some(b'\n' | b'\r'))
    }

    /// Goes to the end of the line, whatever it holds, and leaves the line end.
    pub(crate) fn skip_comment(&mut self) {
        let rest = &self.bytes[self.at..];
        self.at += rest.iter().position(|&b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
    }

    /// Goes past the end of the line, and of those joined to it.
    pub(crate) fn skip_line(&mut self) {
        loop {
            self.skip_comment();
            let joined = self.continuations && self.at > 0 && self.bytes[self.at - 1] == b'\\';
            let crlf = self.bytes[self.at..].starts_with(b"\r\n");
            self.at = (self.at + if crlf { 2 } else { 1 }).min(self.bytes.len());
            if !joined || self.is_end() {
                return;
            }
        }
    }

    /// The rest of the line, without the blanks around it; the line end is left.
    pub(crate) fn rest_of_line(&mut self) -> &'a [u8] {
        self.skip_blanks();
        let start = self.at;
        self.skip_comment();
        self.bytes[start..self.at].trim_ascii()
    }

    /// What stands here up to a blank, a line end or the end: maybe nothing.
    #[inline]
    pub(crate) fn token(&mut self) -> &'a [u8] {
        let start = self.at;
        while self.peek().is_some_and(|b| !is_space(b)) {
            self.at += 1;
        }
        &self.bytes[start..self.at]
    }

    /// A number in f32; the token is left where it is not one.
    #[inline]
    pub(crate) fn f32(&mut self) -> Option<f32> {
        let (value, length) = fast_float2::parse_partial(&self.bytes[self.at..]).ok()?;
        self.take_number(length).then_some(value)
    }

    /// A number in f64; the token is left where it is not one.
    #[inline]
    pub(crate) fn f64(&mut self) -> Option<f64> {
        let (value, length) = fast_float2::parse_partial(&self.bytes[self.at..]).ok()?;
        self.take_number(length).then_some(value)
    }

    fn take_number(&mut self, length: usize) -> bool {
        let end = self.at + length;
        let whole = self.bytes.get(end).is_none_or(|&b| is_space(b));
        if whole {
            self.at = end;
        }
        whole && length > 0
    }

    /// A decimal integer with an optional sign, whatever follows it; `None`, and no step, where there is
    /// none or it exceeds 63 bits.
    #[inline]
    pub(crate) fn integer_prefix(&mut self) -> Option<i64> {
        let mut at = self.at;
        let negative = self.peek() == Some(b'-');
        at += usize::from(negative || self.peek() == Some(b'+'));
        let first = at;
        let mut value = 0i64;
        while let Some(digit) = self.bytes.get(at).map(|b| b.wrapping_sub(b'0')).filter(|&d| d < 10)
        {
            value = value.checked_mul(10)?.checked_add(i64::from(digit))?;
            at += 1;
        }
        if at == first {
            return None;
        }
        self.at = at;
        Some(if negative { -value } else { value })
    }

    /// A decimal integer that is a whole token; else `None`, and no step.
    #[inline]
    pub(crate) fn integer(&mut self) -> Option<i64> {
        let start = self.at;
        let value = self.integer_prefix()?;
        if self.peek().is_none_or(is_space) {
            return Some(value);
        }
        self.at = start;
        None
    }

    /// Takes `word`, in any case, if it is the whole token here.
    pub(crate) fn keyword(&mut self, word: &str) -> bool {
        let start = self.at;
        if self.token().eq_ignore_ascii_case(word.as_bytes()) {
            return true;
        }
        self.at = start;
        false
    }

    /// The number of the line of a place, from 1.
    pub(crate) fn line_of(&self, offset: usize) -> usize {
        let before = &self.bytes[..offset.min(self.bytes.len())];
        let count = |end: u8| before.iter().filter(|&&b| b == end).count();
        // Only files without any `\n` end their lines with `\r` alone.
        let end = if self.bytes.contains(&b'\n') { b'\n' } else { b'\r' };
        1 + count(end)
    }

    /// An error at the line of a place.
    pub(crate) fn error_at(&self, offset: usize, message: impl Into<String>) -> ErrorKind {
        ErrorKind::invalid(format!("line {}", self.line_of(offset)), message)
    }

    /// An error at the line of the cursor.
    pub(crate) fn error(&self, message: impl Into<String>) -> ErrorKind {
        self.error_at(self.at, message)
    }

    /// "expected …, found …" at the cursor.
    pub(crate) fn expected(&self, what: &str) -> ErrorKind {
        let mut ahead = self.clone();
        let found = match ahead.token() {
            [] if ahead.is_end() => "the end of the file".to_owned(),
            [] => "the end of the line".to_owned(),
            token => format!("\"{}\"", quote(token)),
        };
        self.error(format!("expected {what}, found {found}"))
    }
}

#[inline]
fn is_space(b: u8) -> bool {
    matches!(b, b' ' | b'\t' | b'\n' | b'\r' | 0x0b | 0x0c)
}

/// Bytes of a file made fit for a message: at most 40 characters, none of them control codes.
pub(crate) fn quote(bytes: &[u8]) -> String {
    const LIMIT: usize = 40;
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(LIMIT * 4)]);
    let mut out: String = text.chars().take(LIMIT).flat_map(char::escape_default).collect();
    if bytes.len() > LIMIT && text.chars().nth(LIMIT).is_some() {
        out.push('…');
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_every_spelling() {
        let mut c = Cursor::new(b"1 +2 -3. .5 1e2 2.E1 -1e-2 7");
        let mut values = Vec::new();
        while !c.is_end() {
            c.skip_blanks();
            values.push(c.f32().expect("a number"));
        }
        assert_eq!(values, [1.0, 2.0, -3.0, 0.5, 100.0, 20.0, -0.01, 7.0]);
    }

    #[test]
    fn a_number_must_be_a_whole_token() {
        for bad in ["1x", "3.1+e2", "x", "", "1,5", "0x10"] {
            let mut c = Cursor::new(bad.as_bytes());
            assert_eq!(c.f32(), None, "{bad}");
            assert_eq!(c.f64(), None, "{bad}");
            assert_eq!(c.offset(), 0, "{bad}");
        }
    }

    #[test]
    fn integers_stop_at_63_bits() {
        assert_eq!(Cursor::new(b"9223372036854775807").integer(), Some(i64::MAX));
        assert_eq!(Cursor::new(b"9223372036854775808").integer(), None);
        assert_eq!(Cursor::new(b"-12").integer(), Some(-12));
        assert_eq!(Cursor::new(b"-").integer(), None);
        assert_eq!(Cursor::new(b"1.5").integer(), None);
    }

    #[test]
    fn lines_are_joined_only_where_asked() {
        let text = b"a \\\n b\nc \\\r\nd\ne";
        let mut c = Cursor::with_continuations(text);
        assert_eq!(c.token(), b"a");
        c.skip_blanks();
        assert_eq!(c.token(), b"b");
        c.skip_line();
        assert_eq!(c.peek(), Some(b'c'));
        c.skip_line();
        assert_eq!(c.peek(), Some(b'e'));
        let mut c = Cursor::new(text);
        c.skip_line();
        assert_eq!(c.peek(), Some(b' '));
    }

    #[test]
    fn lines_count_with_every_line_end() {
        for text in ["a\nb\nc", "a\r\nb\r\nc", "a\rb\rc"] {
            let c = Cursor::new(text.as_bytes());
            assert_eq!(c.line_of(text.len()), 3, "{text:?}");
        }
    }

    #[test]
    fn quotes_are_short_and_printable() {
        assert_eq!(quote(b"a\x00\n"), "a\\u{0}\\n");
        assert_eq!(quote(&[b'x'; 500]).chars().count(), 41);
    }
}
