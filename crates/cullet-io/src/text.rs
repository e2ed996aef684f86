//! A cursor over a text file that is read in blocks: blanks, tokens, numbers, lines.
//!
//! `\n` and `\r` both end a line, so `\r\n` reads as a line and an empty one after it; no format
//! here minds. Line numbers are counted only for messages, by reading the file once more.
//!
//! The cursor holds whole lines, and everything but [`Cursor::more`] and [`Cursor::skip_space`]
//! stays among those that are held. So a reader calls `more` wherever a line may begin, and looks
//! at a line as if the file were all there. A line may have any length.

use crate::ErrorKind;
use crate::blocks::{Source, Window};
use crate::positions::FAR;

/// A place in a text file.
#[derive(Debug)]
pub(crate) struct Cursor<'a> {
    window: Window<'a>,
    /// Where the whole lines end among the bytes held.
    lines: usize,
    /// The place, among the bytes held.
    at: usize,
    /// Whether a backslash at the end of a line joins it to the next, as in OBJ.
    continuations: bool,
}

impl<'a> Cursor<'a> {
    pub(crate) fn new(source: Source<'a>) -> Self {
        Self { window: Window::new(source), lines: 0, at: 0, continuations: false }
    }

    pub(crate) fn with_continuations(source: Source<'a>) -> Self {
        Self { continuations: true, ..Self::new(source) }
    }

    pub(crate) fn into_source(self) -> Source<'a> {
        self.window.into_source()
    }

    /// At the begin of a line: makes sure that it is held. False at the end of the file.
    #[inline]
    pub(crate) fn more(&mut self) -> Result<bool, ErrorKind> {
        if self.at < self.lines { Ok(true) } else { self.fill() }
    }

    #[cold]
    fn fill(&mut self) -> Result<bool, ErrorKind> {
        self.window.forget(self.at);
        (self.at, self.lines) = (0, 0);
        while self.lines == 0 && !self.window.is_last() {
            self.window.extend()?;
            self.lines = self.whole_lines();
        }
        Ok(self.lines > 0)
    }

    /// Where the last line ends that is held as a whole, with all that are joined to it.
    fn whole_lines(&self) -> usize {
        let held = self.window.held();
        if self.window.is_last() {
            return held.len();
        }
        let mut end = held.len();
        while let Some(at) = held[..end].iter().rposition(|&b| matches!(b, b'\n' | b'\r')) {
            let line = &held[..at];
            // A line feed may follow, which belongs to the same line end.
            let split = held[at] == b'\r' && at + 1 == held.len();
            let before = if held[at] == b'\n' { line.strip_suffix(b"\r") } else { None };
            if !split && !before.unwrap_or(line).ends_with(b"\\") {
                return at + 1;
            }
            end = at;
        }
        0
    }

    /// Goes to any place of the file; one beyond the end is the end.
    pub(crate) fn go_to(&mut self, offset: u64) -> Result<(), ErrorKind> {
        self.window.go_to(offset);
        (self.at, self.lines) = (0, 0);
        self.fill().map(|_| ())
    }

    /// Skips the mark of UTF-8 at the begin of a file.
    pub(crate) fn skip_mark(&mut self) -> Result<(), ErrorKind> {
        if self.more()? && self.rest().starts_with(b"\xef\xbb\xbf") {
            self.at += 3;
        }
        Ok(())
    }

    /// The whole lines that are held.
    #[inline]
    fn held(&self) -> &[u8] {
        &self.window.held()[..self.lines]
    }

    /// The bytes that are held from here on.
    #[inline]
    pub(crate) fn rest(&self) -> &[u8] {
        &self.held()[self.at..]
    }

    /// Whether the file ends here.
    pub(crate) fn is_end(&self) -> bool {
        self.at >= self.lines && self.lines == self.window.held().len() && self.window.is_last()
    }

    #[inline]
    pub(crate) fn offset(&self) -> u64 {
        self.window.base() + self.at as u64
    }

    /// How many bytes are left in the file.
    pub(crate) fn left(&self) -> u64 {
        self.window.source().size() - self.offset()
    }

    /// Goes to a place among the lines held, such as one in this line.
    #[inline]
    pub(crate) fn seek(&mut self, offset: u64) {
        debug_assert!(offset >= self.window.base(), "{offset} is no longer held");
        self.at = ((offset.saturating_sub(self.window.base())) as usize).min(self.lines);
    }

    /// Goes on by a byte, if there is one.
    #[inline]
    pub(crate) fn step(&mut self) {
        self.at = (self.at + 1).min(self.lines);
    }

    #[inline]
    pub(crate) fn peek(&self) -> Option<u8> {
        self.held().get(self.at).copied()
    }

    /// Skips spaces, tabs and joined line ends, not the end of a line.
    #[inline]
    pub(crate) fn skip_blanks(&mut self) {
        while let Some(b) = self.peek() {
            match b {
                b' ' | b'\t' | 0x0b | 0x0c => self.at += 1,
                b'\\' if self.continuations => match self.held().get(self.at + 1..) {
                    Some([b'\r', b'\n', ..]) => self.at += 3,
                    Some([b'\n' | b'\r', ..]) => self.at += 2,
                    _ => return,
                },
                _ => return,
            }
        }
    }

    /// Skips blanks, line ends, and comments from `#` to the end of their line, to where the next
    /// line begins if need be.
    #[inline]
    pub(crate) fn skip_space(&mut self) -> Result<(), ErrorKind> {
        loop {
            self.skip_blanks();
            match self.peek() {
                Some(b'\n' | b'\r') => self.at += 1,
                Some(b'#') => self.skip_comment(),
                None if self.more()? => {}
                _ => return Ok(()),
            }
        }
    }

    /// Skips blanks and line ends, as [`Self::skip_space`].
    #[inline]
    pub(crate) fn skip_lines(&mut self) -> Result<(), ErrorKind> {
        loop {
            self.skip_blanks();
            match self.peek() {
                Some(b'\n' | b'\r') => self.at += 1,
                None if self.more()? => {}
                _ => return Ok(()),
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
        let rest = self.rest();
        self.at += rest.iter().position(|&b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
    }

    /// Goes past the end of the line, and of those joined to it.
    pub(crate) fn skip_line(&mut self) {
        loop {
            self.skip_comment();
            let joined = self.continuations && self.held()[..self.at].ends_with(b"\\");
            let crlf = self.rest().starts_with(b"\r\n");
            self.at = (self.at + if crlf { 2 } else { 1 }).min(self.lines);
            if !joined || self.at == self.lines {
                return;
            }
        }
    }

    /// The rest of the line, and of those joined to it, without the blanks around it; the line end
    /// is left.
    pub(crate) fn rest_of_line(&mut self) -> Vec<u8> {
        let mut text = Vec::new();
        loop {
            let start = self.at;
            self.skip_comment();
            let line = &self.held()[start..self.at];
            let joined = self.continuations && !self.at_end() && line.ends_with(b"\\");
            text.extend_from_slice(&line[..line.len() - usize::from(joined)]);
            if !joined {
                return text.trim_ascii().to_vec();
            }
            text.push(b' ');
            self.at -= 1;
            self.skip_blanks();
        }
    }

    /// Whether the lines that are held end here.
    fn at_end(&self) -> bool {
        self.at == self.lines
    }

    /// The bytes from here up to a blank, a line end or the end; may be empty.
    #[inline]
    pub(crate) fn token(&mut self) -> &[u8] {
        let start = self.at;
        self.at += self.token_here().len();
        &self.held()[start..self.at]
    }

    /// The token that begins here: a backslash that joins the next line is not part of it.
    #[inline]
    fn token_here(&self) -> &[u8] {
        let rest = self.rest();
        let token = &rest[..rest.iter().position(|&b| is_space(b)).unwrap_or(rest.len())];
        let joins = self.continuations && token.ends_with(b"\\") && token.len() < rest.len();
        if joins && self.joins(self.at + token.len() - 1) {
            return &token[..token.len() - 1];
        }
        token
    }

    /// Whether a backslash that joins the next line is at a place among the bytes held.
    fn joins(&self, at: usize) -> bool {
        self.continuations && matches!(self.held().get(at..), Some([b'\\', b'\n' | b'\r', ..]))
    }

    /// A coordinate, in f64 where f32 has steps that can be seen; the token is left where it is not
    /// a number.
    #[inline]
    pub(crate) fn coordinate(&mut self) -> Option<f64> {
        let start = self.at;
        let value = self.f32()?;
        if f64::from(value.abs()) < FAR {
            return Some(f64::from(value));
        }
        self.at = start;
        self.f64()
    }

    /// A number in f32; the token is left where it is not one.
    #[inline]
    pub(crate) fn f32(&mut self) -> Option<f32> {
        let (value, length) = fast_float2::parse_partial(self.rest()).ok()?;
        self.take_number(length).then_some(value)
    }

    /// A number in f64; the token is left where it is not one.
    #[inline]
    pub(crate) fn f64(&mut self) -> Option<f64> {
        let (value, length) = fast_float2::parse_partial(self.rest()).ok()?;
        self.take_number(length).then_some(value)
    }

    fn take_number(&mut self, length: usize) -> bool {
        let end = self.at + length;
        let whole = self.held().get(end).is_none_or(|&b| is_space(b)) || self.joins(end);
        if whole {
            self.at = end;
        }
        whole && length > 0
    }

    /// A decimal integer with an optional sign, whatever follows it; `None`, and no step, where
    /// there is none or it exceeds 63 bits.
    #[inline]
    pub(crate) fn integer_prefix(&mut self) -> Option<i64> {
        let rest = self.rest();
        let negative = rest.first() == Some(&b'-');
        let first = usize::from(negative || rest.first() == Some(&b'+'));
        let mut length = first;
        let mut value = 0i64;
        while let Some(digit) = rest.get(length).map(|b| b.wrapping_sub(b'0')).filter(|&d| d < 10) {
            value = value.checked_mul(10)?.checked_add(i64::from(digit))?;
            length += 1;
        }
        if length == first {
            return None;
        }
        self.at += length;
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

    /// Hands the whole file to `visit`, block by block.
    pub(crate) fn scan(&self, visit: impl FnMut(&[u8])) {
        self.window.source().scan(u64::MAX, visit);
    }

    /// The number of the line of a place, from 1. Reads the file once more.
    pub(crate) fn line_of(&self, offset: u64) -> u64 {
        let source = self.window.source();
        let count = |bytes: &[u8], end: u8| bytes.iter().filter(|&&b| b == end).count() as u64;
        let (mut feeds, mut returns) = (0, 0);
        source.scan(offset, |block| {
            feeds += count(block, b'\n');
            returns += count(block, b'\r');
        });
        if feeds > 0 || returns == 0 {
            return 1 + feeds;
        }
        // Only files without any `\n` end their lines with `\r` alone.
        let mut other = false;
        source.scan(u64::MAX, |block| other |= block.contains(&b'\n'));
        1 + if other { 0 } else { returns }
    }

    /// An error at the line of a place.
    pub(crate) fn error_at(&self, offset: u64, message: impl Into<String>) -> ErrorKind {
        ErrorKind::invalid(format!("line {}", self.line_of(offset)), message)
    }

    /// An error at the line of the cursor.
    pub(crate) fn error(&self, message: impl Into<String>) -> ErrorKind {
        self.error_at(self.offset(), message)
    }

    /// "expected …, found …" at the cursor.
    pub(crate) fn expected(&self, what: &str) -> ErrorKind {
        let found = match self.token_here() {
            [] if self.is_end() => "the end of the file".to_owned(),
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
pub fn quote(bytes: &[u8]) -> String {
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

    /// A cursor whose lines are all held.
    fn over(text: &[u8]) -> Cursor<'_> {
        let mut c = Cursor::with_continuations(Source::memory(text));
        c.more().unwrap();
        c
    }

    #[test]
    fn numbers_of_every_spelling() {
        let mut c = over(b"1 +2 -3. .5 1e2 2.E1 -1e-2 7");
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
            let mut c = over(bad.as_bytes());
            assert_eq!(c.f32(), None, "{bad}");
            assert_eq!(c.f64(), None, "{bad}");
            assert_eq!(c.offset(), 0, "{bad}");
        }
    }

    #[test]
    fn integers_stop_at_63_bits() {
        assert_eq!(over(b"9223372036854775807").integer(), Some(i64::MAX));
        assert_eq!(over(b"9223372036854775808").integer(), None);
        assert_eq!(over(b"-12").integer(), Some(-12));
        assert_eq!(over(b"-").integer(), None);
        assert_eq!(over(b"1.5").integer(), None);
    }

    #[test]
    fn lines_are_joined_only_on_request() {
        let text = b"a \\\n b\nc \\\r\nd\ne";
        let mut c = over(text);
        assert_eq!(c.token(), b"a");
        c.skip_blanks();
        assert_eq!(c.token(), b"b");
        c.skip_line();
        assert_eq!(c.peek(), Some(b'c'));
        c.skip_line();
        assert_eq!(c.peek(), Some(b'e'));
        let mut c = Cursor::new(Source::memory(text));
        c.more().unwrap();
        c.skip_line();
        assert_eq!(c.peek(), Some(b' '));
    }

    #[test]
    fn a_line_may_be_joined_without_a_blank() {
        for end in ["\n", "\r\n", "\r"] {
            let text = format!(
                "f 1\\{end}2/3\\{end}\\{end}4.5\\{end} 5\\{end}{end}g a\\{end}b \\{end} c{end}d\\"
            );
            let mut c = over(text.as_bytes());
            let mut tokens = Vec::new();
            for _ in 0..3 {
                c.skip_blanks();
                tokens.push(String::from_utf8(c.token().to_vec()).unwrap());
            }
            assert_eq!(tokens, ["f", "1", "2/3"]);
            c.skip_blanks();
            assert_eq!(c.f32(), Some(4.5));
            c.skip_blanks();
            assert_eq!(c.f64(), Some(5.0));
            c.skip_line();
            c.skip_lines().unwrap();
            assert_eq!(c.token(), b"g");
            assert_eq!(c.rest_of_line(), b"a b  c");
            c.skip_lines().unwrap();
            assert_eq!(c.token(), b"d\\");
        }
    }

    #[test]
    fn lines_count_with_every_line_end() {
        for text in ["a\nb\nc", "a\r\nb\r\nc", "a\rb\rc"] {
            let c = over(text.as_bytes());
            assert_eq!(c.line_of(text.len() as u64), 3, "{text:?}");
        }
    }

    #[test]
    fn quotes_are_short_and_printable() {
        assert_eq!(quote(b"a\x00\n"), "a\\u{0}\\n");
        assert_eq!(quote(&[b'x'; 500]).chars().count(), 41);
    }

    #[test]
    fn lines_are_the_same_in_blocks_of_every_size() {
        let text = b"v 1 2 \\\n3\r\nf 1 \\\r\n2 \\\r3\n\r\r\n# c\\d\na long line of words\rend";
        let words = |block: usize| {
            let mut c = Cursor::with_continuations(Source::in_blocks(text, block));
            let mut words = Vec::new();
            while c.more().unwrap() {
                c.skip_blanks();
                while !c.at_line_end() {
                    words.push((c.offset(), c.token().to_vec()));
                    c.skip_blanks();
                }
                words.push((0, Vec::new()));
                c.step();
            }
            assert!(c.is_end());
            words.dedup();
            words
        };
        let expected = words(1000);
        assert_eq!(expected.iter().filter(|w| w.1.is_empty()).count(), 5);
        for block in 1..text.len() {
            assert_eq!(words(block), expected, "blocks of {block}");
        }
    }
}
