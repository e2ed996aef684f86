//! The window's controls in words, for readers of a screen: egui knows them all, but in a browser
//! it tells nobody. What it knows becomes text, of which the page makes elements beside the canvas;
//! what is done to those comes back as a request.

use eframe::egui::accesskit::{
    Action, ActionData, ActionRequest, Node, NodeId, Role, Toggled, TreeId, TreeUpdate,
};

/// A line for each text and control, in the order in which they are shown: its number, kind, name,
/// state, value, least and greatest value, between tabs. A kind is `text`, `button`, `checkbox`,
/// `radio` or `number`; a state is empty, `on`, `off` or `disabled`. What cannot be named is left
/// out; a test holds that no control is.
///
/// Cost: each node is looked for among all, which are some hundreds.
#[must_use]
pub fn rows(update: &TreeUpdate) -> String {
    let mut rows = String::new();
    if let Some(tree) = &update.tree {
        add(&mut rows, update, tree.root);
    }
    rows
}

/// Adds a node and what it has in it.
fn add(rows: &mut String, update: &TreeUpdate, id: NodeId) {
    let Some(node) = node(update, id) else { return };
    if let Some(kind) = kind(node) {
        let name = name(update, node);
        // A slider is two controls of one number.
        let above =
            rows.lines().next_back().and_then(|row| row.split_once('\t')).unwrap_or_default().1;
        let is_there = kind == "number" && above.starts_with(&format!("{kind}\t{name}\t"));
        if !name.is_empty() && !is_there {
            let state = match node.toggled() {
                _ if node.is_disabled() => "disabled",
                Some(Toggled::True) => "on",
                Some(_) => "off",
                None => "",
            };
            let number = |value: Option<f64>| value.map_or(String::new(), |v| v.to_string());
            let value = number(node.numeric_value());
            let (min, max) = (number(node.min_numeric_value()), number(node.max_numeric_value()));
            *rows += &format!("{}\t{kind}\t{name}\t{state}\t{value}\t{min}\t{max}\n", id.0);
        }
    }
    for child in node.children() {
        add(rows, update, *child);
    }
}

fn node(update: &TreeUpdate, id: NodeId) -> Option<&Node> {
    update.nodes.iter().find(|(other, _)| *other == id).map(|(_, node)| node)
}

/// Returns the element that a node becomes in the page; none for panes and the like.
fn kind(node: &Node) -> Option<&'static str> {
    match node.role() {
        Role::Label => Some("text"),
        Role::CheckBox => Some("checkbox"),
        Role::RadioButton => Some("radio"),
        Role::Slider | Role::SpinButton => Some("number"),
        Role::Button | Role::Link | Role::ComboBox | Role::DisclosureTriangle => Some("button"),
        _ => None,
    }
}

/// Its own name or that of what labels it, and what it shows. Nothing in it ends a field or line.
fn name(update: &TreeUpdate, node: &Node) -> String {
    let labels = node.labelled_by().iter().filter_map(|id| self::node(update, *id));
    let labels = labels.filter_map(|label| label.label().or(label.value()));
    let own = node.label().into_iter().chain(labels).chain(node.value());
    // The value of a number stands beside its name.
    let own = own.take(if node.numeric_value().is_some() { 1 } else { usize::MAX });
    let words: Vec<&str> = own.flat_map(str::split_whitespace).collect();
    words.join(" ")
}

/// Parses a request to a control: `NUMBER` clicks it, `NUMBER VALUE` sets it.
#[must_use]
pub fn request(order: &str) -> Option<ActionRequest> {
    let (id, value) = order.split_once(' ').map_or((order, None), |(id, value)| (id, Some(value)));
    let data = match value {
        Some(value) => Some(ActionData::NumericValue(value.parse().ok()?)),
        None => None,
    };
    let action = if data.is_some() { Action::SetValue } else { Action::Click };
    let target_node = NodeId(id.parse().ok()?);
    Some(ActionRequest { action, target_tree: TreeId::ROOT, target_node, data })
}
