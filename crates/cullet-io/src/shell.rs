//! Words of a command line, so that what a message tells to type can be typed.

/// A word as a shell takes it: as it is, or quoted where a shell would read something into it; a name
/// that begins with a minus gets `./` before it, so that no program takes it for an option.
///
/// ```
/// # if cfg!(unix) {
/// assert_eq!(cullet_io::shell_word("city:n=3"), "city:n=3");
/// assert_eq!(cullet_io::shell_word("my model.glb"), "'my model.glb'");
/// assert_eq!(cullet_io::shell_word("-a.obj"), "./-a.obj");
/// # }
/// ```
#[must_use]
pub fn shell_word(word: &str) -> String {
    let word = if word.starts_with('-') { format!("./{word}") } else { word.to_owned() };
    let plain = |c: char| c.is_alphanumeric() || "-_.:,=/+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word
    } else if cfg!(windows) {
        // No name has a double quote there.
        format!("\"{word}\"")
    } else {
        // Whatever a quote would end is quoted apart.
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}
