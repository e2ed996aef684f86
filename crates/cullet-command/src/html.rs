//! Pieces of HTML: escaping, and pictures as data.

/// Text made safe between tags and in quoted attributes. Names come from files, so they are
/// hostile.
pub fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            // Control characters are not allowed in HTML at all, and marks that turn the direction
            // of writing could make a name spill over its neighbours.
            c if c.is_control() && c != '\n' => safe.push('\u{fffd}'),
            '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => safe.push('\u{fffd}'),
            c => safe.push(c),
        }
    }
    safe
}

/// The address of a file by its path from the page, made safe in an attribute: names hold blanks,
/// `#`, `?` and percent signs.
pub fn link(path: &str) -> String {
    let mut address = String::with_capacity(path.len());
    for &byte in path.as_bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte) {
            address.push(byte as char);
        } else {
            address += &format!("%{byte:02X}");
        }
    }
    // The first part must not read as a scheme or as another host.
    format!("./{address}")
}

/// Text with what stands between two backticks as code, made safe.
pub fn with_code(text: &str) -> String {
    let mut parts = text.split('`');
    let mut html = escape(parts.next().unwrap_or_default());
    while let Some(code) = parts.next() {
        match parts.next() {
            Some(after) => {
                html += &format!("<code>{}</code>{}", escape(code), escape(after));
            }
            // It has no end: a name may hold one.
            None => html += &escape(&format!("`{code}")),
        }
    }
    html
}

/// A PNG as a `data:` address, so that the page needs no second file.
pub fn data_uri(png: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(22 + png.len().div_ceil(3) * 4);
    text.push_str("data:image/png;base64,");
    for three in png.chunks(3) {
        let byte = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for i in 0..4 {
            if i > three.len() {
                text.push('=');
            } else {
                text.push(DIGITS[(bits >> (18 - 6 * i) & 63) as usize] as char);
            }
        }
    }
    text
}

/// `#rrggbb`
pub fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hostile_names_become_text() {
        let safe = escape("<img src=x onerror='alert(1)'>\"&\u{202e}\0");
        assert_eq!(safe, "&lt;img src=x onerror=&#39;alert(1)&#39;&gt;&quot;&amp;\u{fffd}\u{fffd}");
    }

    #[test]
    fn links_lead_to_files_of_any_name() {
        assert_eq!(link("a b/50%#1?.html"), "./a%20b/50%25%231%3F.html");
        assert_eq!(link("//x\"'é"), ".///x%22%27%C3%A9");
        assert_eq!(link("javascript:alert(1)"), "./javascript%3Aalert%281%29");
    }

    #[test]
    fn what_backticks_hold_is_code() {
        assert_eq!(
            with_code("try `a <b>`, or `c`."),
            "try <code>a &lt;b&gt;</code>, or <code>c</code>."
        );
        assert_eq!(with_code("an end` is missing <"), "an end` is missing &lt;");
        assert_eq!(with_code(""), "");
    }

    #[test]
    fn base64_as_the_standard_has_it() {
        let encode = |b: &[u8]| data_uri(b).split_off("data:image/png;base64,".len());
        assert_eq!(encode(b""), "");
        assert_eq!(encode(b"f"), "Zg==");
        assert_eq!(encode(b"fo"), "Zm8=");
        assert_eq!(encode(b"foo"), "Zm9v");
        assert_eq!(encode(b"foobar"), "Zm9vYmFy");
        assert_eq!(encode(&[0xff, 0xfe, 0xfd]), "//79");
    }
}
