//! `InheritedVisibility`: Bevy's rules, where what changed is found by a quicker pass.

use std::sync::Mutex;

use bevy_camera::visibility::{InheritedVisibility, Visibility};
use bevy_ecs::change_detection::{ContiguousRef, Tick};
use bevy_ecs::hierarchy::{ChildOf, Children};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemChangeTick;

use crate::bits::slots_of;
use crate::ticks::{MANY, ROWS, RUN, Since};

type All<'w, 's> = Query<
    'w,
    's,
    (Entity, Ref<'static, Visibility>, Option<Ref<'static, ChildOf>>),
    With<InheritedVisibility>,
>;
type Parents<'w, 's> =
    Query<'w, 's, &'static Children, (With<Visibility>, With<InheritedVisibility>)>;

/// Hands visibility down from parents to children, where it or the parent changed.
pub(crate) fn inherit(
    ticks: SystemChangeTick,
    all: All,
    mut inherited: Query<(&Visibility, &mut InheritedVisibility)>,
    children: Parents,
    parents: Query<&ChildOf>,
    mut orphans: RemovedComponents<ChildOf>,
) {
    let mut stack = Vec::new();
    for entity in changed(Since::new(&ticks), &all) {
        let Ok((visibility, _)) = inherited.get(entity) else { continue };
        let parent = || parents.get(entity).ok().and_then(|of| inherited.get(of.parent()).ok());
        // Under no parent, or one without these components, it is visible.
        let is_visible = of(*visibility, || parent().is_none_or(|(_, parent)| parent.get()));
        stack.push((entity, is_visible));
        hand_down(&mut stack, &mut inherited, &children);
    }
    for entity in orphans.read() {
        let Ok((visibility, _)) = inherited.get(entity) else { continue };
        stack.push((entity, of(*visibility, || true)));
        hand_down(&mut stack, &mut inherited, &children);
    }
}

fn of(visibility: Visibility, parent: impl FnOnce() -> bool) -> bool {
    match visibility {
        Visibility::Visible => true,
        Visibility::Hidden => false,
        Visibility::Inherited => parent(),
    }
}

/// Writes what differs, of the entities of a stack and of all below them.
fn hand_down(
    stack: &mut Vec<(Entity, bool)>,
    all: &mut Query<(&Visibility, &mut InheritedVisibility)>,
    children: &Parents,
) {
    while let Some((entity, is_visible)) = stack.pop() {
        let Ok((_, mut inherited)) = all.get_mut(entity) else { continue };
        if inherited.get() == is_visible {
            continue;
        }
        *inherited =
            if is_visible { InheritedVisibility::VISIBLE } else { InheritedVisibility::HIDDEN };
        for &child in children.get(entity).into_iter().flatten() {
            if let Ok((visibility, _)) = all.get(child) {
                stack.push((child, of(*visibility, || is_visible)));
            }
        }
    }
}

/// The entities whose visibility or parent changed.
fn changed(since: Since, all: &All) -> Vec<Entity> {
    let found = Mutex::new(Vec::new());
    let ask = |(entities, visibility, parent): (
        &[Entity],
        ContiguousRef<'_, Visibility>,
        Option<ContiguousRef<'_, ChildOf>>,
    )| {
        let visibility = visibility.changed_ticks_slice();
        let parents = parent.map_or(&[][..], |parent| parent.changed_ticks_slice());
        for start in (0..entities.len()).step_by(RUN) {
            let rows = start..(start + RUN).min(entities.len());
            let parents = parents.get(rows.clone()).unwrap_or_default();
            let visibility = &visibility[rows];
            if !since.any(visibility) && !since.any(parents) {
                continue;
            }
            let Ok(mut found) = found.lock() else { continue };
            for first in (0..visibility.len()).step_by(ROWS) {
                let bits = |ticks: &[Tick]| {
                    since.bits(
                        ticks
                            .get(first..)
                            .unwrap_or_default()
                            .chunks(ROWS)
                            .next()
                            .unwrap_or_default(),
                    )
                };
                let changed = bits(visibility) | bits(parents);
                let rows = slots_of(0, changed).map(|row| entities[start + first + row as usize]);
                found.extend(rows);
            }
        }
    };
    let Ok(tables) = all.contiguous_iter() else { return Vec::new() };
    let most = tables.map(|(entities, ..)| entities.len()).max().unwrap_or(0);
    // Two columns at most are read: a thread more is worth it later than elsewhere.
    if most < 2 * MANY {
        all.contiguous_iter().into_iter().flatten().for_each(ask);
    } else if let Ok(tables) = all.contiguous_par_iter() {
        tables.for_each(ask);
    }
    found.into_inner().unwrap_or_default()
}
