//! JSON of which a few members are changed, and all others stay as they are, byte for byte: numbers
//! keep their digits, and members their order.

use std::borrow::Cow;

use crate::ErrorKind;
use crate::json::{self, FromJson, Integer, Json};

/// An object: names, and the JSON of their values.
#[derive(Debug, Default)]
pub(super) struct Object<'a>(Vec<(Cow<'a, str>, Cow<'a, str>)>);

impl<'a> Object<'a> {
    /// The object that is written in a text; `item` names it where it is none.
    pub(super) fn parse(text: &'a str, item: &str) -> Result<Self, ErrorKind> {
        let all = Json::parse(text).and_then(json::Object::from_json);
        let all = all.map_err(|message| ErrorKind::invalid(item, message))?;
        let members = all.members().map(|(name, json)| (name.clone(), json.text().into()));
        Ok(Self(members.collect()))
    }

    /// The JSON of a member.
    pub(super) fn get(&self, name: &str) -> Option<&str> {
        self.0.iter().find(|(n, _)| n == name).map(|(_, text)| &**text)
    }

    /// A member that is a whole number from 0 to 2⁵³, as glTF's are: `3` or `3.0`.
    pub(super) fn number(&self, name: &str) -> Option<usize> {
        let number = Integer::from_json(Json::parse(self.get(name)?).ok()?).ok()?;
        // As a u64: on 32 bits all that memory can address is below.
        Some(number.index()).filter(|&number| number as u64 <= 1 << 53)
    }

    /// A member that is a string.
    pub(super) fn string(&self, name: &str) -> Option<String> {
        String::from_json(Json::parse(self.get(name)?).ok()?).ok()
    }

    /// Puts the JSON of a member in the place of what is there, or behind all others.
    pub(super) fn set(&mut self, name: &str, text: impl Into<String>) {
        let text = Cow::Owned(text.into());
        match self.0.iter_mut().find(|(n, _)| n == name) {
            Some(member) => member.1 = text,
            None => self.0.push((Cow::Owned(name.to_owned()), text)),
        }
    }

    /// Takes a member out; whether it was there.
    pub(super) fn remove(&mut self, name: &str) -> bool {
        let before = self.0.len();
        self.0.retain(|(n, _)| n != name);
        self.0.len() < before
    }

    /// Puts a list in the place of a member, and nothing where it is empty, as glTF demands.
    pub(super) fn set_list(&mut self, name: &str, items: &[Cow<'_, str>]) {
        if items.is_empty() {
            self.remove(name);
        } else {
            self.set(name, format!("[{}]", items.join(",")));
        }
    }

    /// A member that is an object, changed by `change`; there is none of it where it is left empty.
    pub(super) fn change(
        &mut self,
        name: &str,
        change: &mut dyn FnMut(&mut Object<'_>) -> Result<(), ErrorKind>,
    ) -> Result<(), ErrorKind> {
        let text = self.get(name).unwrap_or("{}").to_owned();
        let mut inner = Object::parse(&text, name)?;
        change(&mut inner)?;
        if inner.0.is_empty() {
            self.remove(name);
        } else {
            self.set(name, inner.to_text());
        }
        Ok(())
    }

    /// Names and JSON of all members.
    pub(super) fn members(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().map(|(name, text)| (&**name, &**text))
    }

    /// Its JSON.
    pub(super) fn to_text(&self) -> String {
        let mut text = "{".to_owned();
        for (name, value) in self.members() {
            let comma = if text.len() > 1 { "," } else { "" };
            text += &format!("{comma}{}:{value}", serde_json::Value::String(name.to_owned()));
        }
        text + "}"
    }
}

/// The JSON of each item of a member that is a list; none where there is no such member.
pub(super) fn list(of: &Object<'_>, name: &str) -> Result<Vec<Cow<'static, str>>, ErrorKind> {
    let Some(text) = of.get(name) else { return Ok(Vec::new()) };
    let items = Json::parse(text).and_then(Vec::<Json<'_>>::from_json);
    let items = items.map_err(|message| ErrorKind::invalid(name, message))?;
    Ok(items.into_iter().map(|item| Cow::Owned(item.text().to_owned())).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_changed_stays_as_it_is_written() {
        let text = r#"{"b":1.50e0,"a":{ "x" : [1, 2] },"é\"":"\u0041","c":[]}"#;
        let mut object = Object::parse(text, "it").expect("valid");
        assert_eq!(object.to_text(), text);
        assert_eq!((object.number("b"), object.string("é\"")), (None, Some("A".to_owned())));
        object.set("b", "2.0");
        assert_eq!(object.number("b"), Some(2));
        object.set_list("c", &["{}".into(), "1e0".into()]);
        let add = |inner: &mut Object<'_>| {
            inner.set("y", "3");
            Ok(())
        };
        object.change("a", &mut { add }).expect("an object");
        object.change("d", &mut |_| Ok(())).expect("nothing of nothing");
        let changed = r#"{"b":2.0,"a":{"x":[1, 2],"y":3},"é\"":"\u0041","c":[{},1e0]}"#;
        assert_eq!(object.to_text(), changed);
        object.set_list("c", &[]);
        let empty = |inner: &mut Object<'_>| {
            assert!(inner.remove("x") && inner.remove("y") && !inner.remove("z"));
            Ok(())
        };
        object.change("a", &mut { empty }).expect("an object");
        assert_eq!(object.to_text(), r#"{"b":2.0,"é\"":"\u0041"}"#);
        assert_eq!(list(&object, "c").expect("none"), Vec::<Cow<'_, str>>::new());
        assert!(Object::parse("[1]", "it").is_err() && Object::parse("{\"a\":", "it").is_err());
    }
}
