//! JSON, read where it lies: checked once as a whole, then split only as far as a reader asks.
//!
//! No tree of values is built, so that huge arrays cost what is made of them, and members that
//! nobody asks for cost nothing.

use std::borrow::Cow;

use serde_json::value::RawValue;

/// A value, as its text, which is valid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Json<'a>(&'a str);

/// The members of an object, in the order of the text.
#[derive(Clone, Debug, Default)]
pub struct Object<'a>(Vec<(Cow<'a, str>, Json<'a>)>);

/// Types that can be read from JSON.
///
/// Messages begin with the defect; the caller knows the item. A struct reads an [`Object`] and asks
/// for its members by name.
pub trait FromJson<'a>: Sized {
    /// Reads a value.
    ///
    /// # Errors
    /// Says what was expected, and what is there.
    fn from_json(json: Json<'a>) -> Result<Self, String>;
}

impl<'a> Json<'a> {
    /// The value that a text is, with blanks around it.
    ///
    /// # Errors
    /// If the text is not JSON: the defect, with its line and column.
    pub fn parse(text: &'a str) -> Result<Self, String> {
        let raw: &RawValue = serde_json::from_str(text).map_err(|e| e.to_string())?;
        Ok(Self(raw.get()))
    }

    /// Returns the text of the value, without blanks around it.
    #[must_use]
    pub fn text(self) -> &'a str {
        self.0
    }

    /// The items of an array.
    ///
    /// # Errors
    /// If it is none; `expected` says what it should be.
    fn items(self, expected: &str) -> Result<Items<'a>, String> {
        self.0.strip_prefix('[').map(Items).ok_or_else(|| self.unexpected(expected))
    }

    /// Returns the number, from 1, of the line of `whole` on which the value begins, if it is part
    /// of it.
    #[must_use]
    pub fn line_in(self, whole: &str) -> usize {
        let at = (self.0.as_ptr() as usize).saturating_sub(whole.as_ptr() as usize);
        1 + whole.bytes().take(at).filter(|&b| b == b'\n').count()
    }

    /// Returns the message of a value that is of another type than `expected`.
    #[must_use]
    pub fn unexpected(self, expected: &str) -> String {
        let text = start(self.0);
        let found = match self.0.as_bytes().first() {
            Some(b'"') => format!("string {text}"),
            Some(b't' | b'f') => format!("boolean `{text}`"),
            Some(b'[') => "sequence".to_owned(),
            Some(b'{') => "map".to_owned(),
            Some(b'n') | None => "null".to_owned(),
            _ if self.0.contains(['.', 'e', 'E']) => format!("floating point `{text}`"),
            _ => format!("integer `{text}`"),
        };
        format!("invalid type: {found}, expected {expected}")
    }
}

/// The rest of an array or object behind some of its items.
struct Items<'a>(&'a str);

impl<'a> Iterator for Items<'a> {
    type Item = Json<'a>;

    fn next(&mut self) -> Option<Json<'a>> {
        let (item, rest) = split(self.0);
        self.0 = rest;
        (!item.is_empty()).then_some(Json(item))
    }
}

/// The value at the front of a text, and what follows the comma, colon or bracket behind it.
fn split(text: &str) -> (&str, &str) {
    let bytes = text.as_bytes();
    let (mut at, mut depth) = (0, 0u32);
    while let Some(&byte) = bytes.get(at) {
        match byte {
            b'"' => {
                at += 1;
                while bytes.get(at).is_some_and(|&b| b != b'"') {
                    at += if bytes[at] == b'\\' { 2 } else { 1 };
                }
            }
            b'{' | b'[' => depth += 1,
            b',' | b':' | b'}' | b']' if depth == 0 => break,
            b'}' | b']' => depth -= 1,
            _ => {}
        }
        at += 1;
    }
    (text[..at].trim_ascii(), text.get(at + 1..).unwrap_or_default())
}

impl<'a> Object<'a> {
    /// Returns the member `name`; `None` where there is none.
    fn find(&self, name: &str) -> Result<Option<Json<'a>>, String> {
        let mut found = self.0.iter().filter(|(n, _)| n == name);
        match (found.next(), found.next()) {
            (_, Some(_)) => Err(format!("duplicate field `{name}`")),
            (found, None) => Ok(found.map(|&(_, json)| json)),
        }
    }

    /// Reads the member `name`; `None` where there is none, or `null`.
    ///
    /// # Errors
    /// If it is of another type, or there twice.
    pub fn get<T: FromJson<'a>>(&self, name: &str) -> Result<Option<T>, String> {
        let json = self.find(name)?.filter(|json| json.0 != "null");
        json.map(T::from_json).transpose()
    }

    /// Reads the member `name`, which must be there.
    ///
    /// # Errors
    /// If it is not, is of another type, or there twice.
    pub fn need<T: FromJson<'a>>(&self, name: &str) -> Result<T, String> {
        T::from_json(self.find(name)?.ok_or_else(|| format!("missing field `{name}`"))?)
    }

    /// Reads the member `name`; the default where there is none.
    ///
    /// # Errors
    /// If it is of another type, or there twice.
    pub fn or_default<T: FromJson<'a> + Default>(&self, name: &str) -> Result<T, String> {
        self.find(name)?.map_or_else(|| Ok(T::default()), T::from_json)
    }

    /// The member `name` as an object; one without members where there is none, or `null`.
    ///
    /// # Errors
    /// If it is no object, or there twice.
    pub fn inner(&self, name: &str) -> Result<Self, String> {
        Ok(self.get(name)?.unwrap_or_default())
    }

    /// Reads the member `name` of the member `extensions`; `None` where there is none, or `null`.
    ///
    /// # Errors
    /// If it is of another type, or there twice.
    pub fn extension<T: FromJson<'a>>(&self, name: &str) -> Result<Option<T>, String> {
        self.inner("extensions")?.get(name)
    }

    /// Checks that there are no members but those of some names.
    ///
    /// # Errors
    /// Names one that is unknown, and those that are known.
    pub fn only(&self, names: &[&str]) -> Result<(), String> {
        match self.0.iter().find(|(name, _)| !names.contains(&&**name)) {
            None => Ok(()),
            Some((name, _)) => {
                let known = names.join("`, `");
                Err(format!("unknown field `{name}`, expected one of `{known}`"))
            }
        }
    }

    /// Names and values of all members.
    pub fn members(&self) -> impl Iterator<Item = &(Cow<'a, str>, Json<'a>)> {
        self.0.iter()
    }
}

/// Declares structs that are read from objects: for each member the method of [`Object`] that reads
/// it, and its name there.
#[macro_export]
macro_rules! from_json {
    ($($(#[$meta:meta])* $seen:vis struct $name:ident $(<$life:lifetime>)? {
        $($(#[$doc:meta])* $member:ident: $type:ty = $read:ident($key:expr),)*
    })*) => {$(
        $(#[$meta])*
        #[derive(Debug)]
        $seen struct $name $(<$life>)? {
            $($(#[$doc])* $seen $member: $type,)*
        }

        impl<'json $(: $life, $life)?> $crate::reader::FromJson<'json> for $name $(<$life>)? {
            fn from_json(json: $crate::reader::Json<'json>) -> Result<Self, String> {
                let all = $crate::reader::Object::from_json(json)?;
                Ok(Self { $($member: all.$read($key)?,)* })
            }
        }
    )*};
}

/// A whole number that may be written with a fraction or exponent, as glTF allows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Integer(pub u64);

impl Integer {
    /// Returns the number as an index; more than memory can address stays out of every range.
    #[must_use]
    pub fn index(self) -> usize {
        usize::try_from(self.0).unwrap_or(usize::MAX)
    }
}

impl<'a> FromJson<'a> for Json<'a> {
    fn from_json(json: Self) -> Result<Self, String> {
        Ok(json)
    }
}

impl<'a> FromJson<'a> for Object<'a> {
    fn from_json(json: Json<'a>) -> Result<Self, String> {
        let Some(inner) = json.0.strip_prefix('{') else {
            return Err(format!("expected an object, found {}", start(json.0)));
        };
        let (mut members, mut items) = (Vec::new(), Items(inner));
        while let (Some(name), Some(value)) = (items.next(), items.next()) {
            members.push((Cow::from_json(name)?, value));
        }
        Ok(Self(members))
    }
}

impl<'a> FromJson<'a> for Cow<'a, str> {
    fn from_json(json: Json<'a>) -> Result<Self, String> {
        let inner = json.0.strip_prefix('"').and_then(|text| text.strip_suffix('"'));
        match inner.ok_or_else(|| json.unexpected("a string"))? {
            plain if !plain.contains('\\') => Ok(Cow::Borrowed(plain)),
            _ => serde_json::from_str(json.0).map(Cow::Owned).map_err(|e| {
                // The position is relative to the string, which would mislead.
                let message = e.to_string();
                message.split(" at line ").next().unwrap_or_default().to_owned()
            }),
        }
    }
}

impl FromJson<'_> for String {
    fn from_json(json: Json<'_>) -> Result<Self, String> {
        Cow::from_json(json).map(Cow::into_owned)
    }
}

impl FromJson<'_> for bool {
    fn from_json(json: Json<'_>) -> Result<Self, String> {
        json.0.parse().map_err(|_| json.unexpected("a boolean"))
    }
}

/// A number beyond f64 is infinite: a parser of JSON would refuse the whole file, but one such
/// transform should not cost the user the rest.
impl FromJson<'_> for f64 {
    fn from_json(json: Json<'_>) -> Result<Self, String> {
        json.0.parse().map_err(|_| format!("expected a number, found {}", start(json.0)))
    }
}

impl FromJson<'_> for f32 {
    fn from_json(json: Json<'_>) -> Result<Self, String> {
        match json.0.parse::<Self>() {
            Ok(number) if number.is_finite() => Ok(number),
            Ok(_) => Err("number out of range".to_owned()),
            Err(_) => Err(json.unexpected("f32")),
        }
    }
}

impl FromJson<'_> for u32 {
    fn from_json(json: Json<'_>) -> Result<Self, String> {
        let Integer(number) = Integer::from_json(json)?;
        number.try_into().map_err(|_| format!("invalid value: integer `{number}`, expected u32"))
    }
}

impl FromJson<'_> for Integer {
    fn from_json(json: Json<'_>) -> Result<Self, String> {
        if let Ok(number) = json.0.parse() {
            return Ok(Self(number));
        }
        let expected = "a whole number from 0 to 2^53";
        match json.0.parse::<f64>() {
            // Beyond 2^53 an f64 no longer tells whole numbers apart.
            Ok(v) if v.fract() == 0.0 && (0.0..=9_007_199_254_740_992.0).contains(&v) => {
                Ok(Self(v as u64))
            }
            Ok(_) if json.0.contains(['.', 'e', 'E']) => {
                let text = start(json.0);
                Err(format!("invalid value: floating point `{text}`, expected {expected}"))
            }
            _ => Err(json.unexpected(expected)),
        }
    }
}

impl<'a, T: FromJson<'a>> FromJson<'a> for Vec<T> {
    fn from_json(json: Json<'a>) -> Result<Self, String> {
        let mut all = Self::new();
        for item in json.items("a sequence")? {
            all.push(T::from_json(item)?);
        }
        Ok(all)
    }
}

impl<'a, T: FromJson<'a> + Copy + Default, const N: usize> FromJson<'a> for [T; N] {
    fn from_json(json: Json<'a>) -> Result<Self, String> {
        let (mut all, mut count) = ([T::default(); N], 0);
        for item in json.items("an array")? {
            if let Some(place) = all.get_mut(count) {
                *place = T::from_json(item)?;
            }
            count += 1;
        }
        match count == N {
            true => Ok(all),
            false => Err(format!("invalid length {count}, expected an array of length {N}")),
        }
    }
}

/// The start of a JSON text on one line, for a message.
pub(crate) fn start(text: &str) -> String {
    let mut line = String::new();
    for c in text.trim_start().chars().take(100) {
        match c.is_whitespace() {
            true if line.ends_with(' ') => {}
            true => line.push(' '),
            false => line.push(c),
        }
    }
    line.trim_end().chars().take(24).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read<'a, T: FromJson<'a>>(text: &'a str) -> Result<T, String> {
        T::from_json(Json::parse(text)?)
    }

    #[test]
    fn whole_numbers_may_have_a_fraction_of_zero() {
        for text in ["3", "3.0", "30e-1", "0.3e1"] {
            assert_eq!(read(text), Ok(Integer(3)), "{text}");
        }
        assert_eq!(read("-0"), Ok(Integer(0)));
        for text in ["-1", "0.5", "1e300", "\"3\"", "null", "-1.0"] {
            assert!(read::<Integer>(text).is_err(), "{text}");
        }
    }

    #[test]
    fn numbers_beyond_f64_are_infinite() {
        let all = read::<[f64; 3]>("[1e309, -1e309, 2.5]");
        assert_eq!(all, Ok([f64::INFINITY, f64::NEG_INFINITY, 2.5]));
        assert!(read::<f64>("\"inf\"").is_err() && read::<f64>("true").is_err());
        assert_eq!(read::<f32>("1e39"), Err("number out of range".to_owned()));
    }

    #[test]
    fn values_are_split_where_they_end() {
        let text =
            r#" { "a" : [ 1 ,2,[ ] , {"b,]":"}\\\"{"} ] , "\u00e9\"" : " x " , "c":{},"d":null } "#;
        let all: Object<'_> = read(text).unwrap();
        let names: Vec<&str> = all.members().map(|(name, _)| &**name).collect();
        assert_eq!(names, ["a", "é\"", "c", "d"]);
        let items: Vec<Json<'_>> = all.need("a").unwrap();
        let texts: Vec<&str> = items.iter().map(|item| item.text()).collect();
        assert_eq!(texts, ["1", "2", "[ ]", r#"{"b,]":"}\\\"{"}"#]);
        let inner: Object<'_> = Object::from_json(items[3]).unwrap();
        assert_eq!(inner.need::<String>("b,]").unwrap(), "}\\\"{");
        assert_eq!(all.need::<Cow<'_, str>>("é\"").unwrap(), " x ");
        assert_eq!(all.inner("c").unwrap().members().count(), 0);
        assert_eq!(all.get::<bool>("d"), Ok(None));
        assert_eq!(read::<Vec<Json<'_>>>("[ ]"), Ok(Vec::new()));
    }

    #[test]
    fn defects_are_named() {
        let all: Object<'_> = read(r#"{"a":1,"a":2,"b":"x","c":[1],"d":null,"e":-1}"#).unwrap();
        for (found, expected) in [
            (all.get::<Integer>("a").map(|_| ()), "duplicate field `a`"),
            (all.need::<bool>("z").map(|_| ()), "missing field `z`"),
            (all.need::<bool>("b").map(|_| ()), "invalid type: string \"x\", expected a boolean"),
            (
                all.get::<[f64; 2]>("c").map(|_| ()),
                "invalid length 1, expected an array of length 2",
            ),
            (all.need::<String>("d").map(|_| ()), "invalid type: null, expected a string"),
            (
                all.need::<Vec<f64>>("e").map(|_| ()),
                "invalid type: integer `-1`, expected a sequence",
            ),
            (all.inner("c").map(|_| ()), "expected an object, found [1]"),
            (read::<f64>("{}").map(|_| ()), "expected a number, found {}"),
            (read::<String>(r#""\ud800""#).map(|_| ()), "unexpected end of hex escape"),
        ] {
            assert_eq!(found, Err(expected.to_owned()));
        }
        assert_eq!(Json::parse("{\n\"a\":}"), Err("expected value at line 2 column 5".to_owned()));
    }
}
