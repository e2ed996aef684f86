//! Animations of nodes: read, and sampled at the keys that move a camera.

use std::collections::HashSet;

use glam::{DAffine3, DVec3, DVec4};

use super::accessor::{Accessors, Component};
use super::buffers::Buffers;
use super::extensions;
use super::json::{self, AnimationItem, Root, Sampler};
use super::nodes::Nodes;
use super::notes::Notes;
use super::uri::shorten;
use crate::ErrorKind;
use crate::motion::Clip;
use crate::motion::track::{Interpolation, Local, Property, Track, WeightTrack};

/// A curve of degree three is given by this many straight segments between two of its keys.
const SEGMENTS: usize = 8;

impl Clip {
    /// Reads the tracks of animation `index`; `targets` says how many morph targets a node of the
    /// document has, `None` for a node that is not there. A track that is malformed is left out
    /// with a note. `unplayed` takes a pointer of `KHR_animation_pointer` that leads elsewhere than
    /// to a node's transform or weights.
    ///
    /// # Errors
    /// If the animation itself is malformed.
    pub(super) fn read(
        root: &Root<'_>,
        index: usize,
        accessors: &Accessors,
        buffers: &Buffers<'_>,
        targets: impl Fn(usize) -> Option<usize>,
        unplayed: &mut Option<String>,
        notes: &mut Notes,
    ) -> Result<Self, ErrorKind> {
        let json = json::all(&root.animations)[index];
        let item: AnimationItem<'_> = json::item(json, "animation", index)?;
        let name = match item.name.as_deref() {
            Some(name) if !name.is_empty() => shorten(name),
            _ => format!("animation {index}"),
        };
        let mut clip = Self { name, tracks: Vec::new(), weights: Vec::new() };
        let mut moved = HashSet::new();
        for (c, channel) in item.channels.iter().enumerate() {
            let user = || format!("animation {index}, channel {c}");
            let (node, path) = match &channel.target.pointer {
                None => (channel.target.node.map(json::Integer::index), &*channel.target.path),
                Some(to) => match node_of(&to.pointer) {
                    Some((node, path)) => (Some(node), path),
                    None => {
                        let known = unplayed.as_deref().is_some_and(extensions::may_move);
                        if !known && (unplayed.is_none() || extensions::may_move(&to.pointer)) {
                            *unplayed = Some(shorten(&to.pointer));
                        }
                        continue;
                    }
                },
            };
            let property = match path {
                "translation" => Some(Property::Translation),
                "rotation" => Some(Property::Rotation),
                "scale" => Some(Property::Scale),
                "weights" => None,
                _ => continue,
            };
            let Some(node) = node else { continue };
            let Some(targets) = targets(node).filter(|&n| property.is_some() || n > 0) else {
                continue;
            };
            let node = node as u32;
            if !moved.insert((node, property)) {
                notes.push(user(), "moves what another channel moves, and is left out");
                continue;
            }
            let Some(sampler) = item.samplers.get(channel.sampler.index()) else {
                notes.push(user(), "names a sampler that is not there, and is left out");
                continue;
            };
            let read = match property {
                Some(property) => track(sampler, node, property, accessors, buffers, &user())
                    .map(|track| clip.tracks.push(track)),
                None => weight_track(sampler, node, targets, accessors, buffers, &user())
                    .map(|track| clip.weights.push(track)),
            };
            if let Err(e) = read {
                notes.push(user(), format!("is left out: {e}"));
            }
        }
        Ok(clip)
    }

    /// Whether it moves any of these nodes.
    pub(super) fn moves(&self, chain: &[u32]) -> bool {
        self.tracks.iter().any(|t| chain.contains(&t.node))
    }

    /// How much work it is to sample a chain of nodes.
    pub(super) fn cost(&self, chain: &[u32]) -> u64 {
        let tracks = self.tracks.iter().filter(|t| chain.contains(&t.node));
        let (count, keys) =
            tracks.fold((0u64, 0u64), |(n, k), t| (n + 1, k + (t.times.len() * SEGMENTS) as u64));
        count.saturating_mul(keys)
    }

    /// The transform of the last node of `chain`, which leads there from its root, at every key
    /// time of any track that moves it. Steps get a key just before the jump; curves get keys
    /// between.
    pub(super) fn keys(&self, chain: &[u32], nodes: &Nodes) -> Vec<(f64, DAffine3)> {
        let tracks: Vec<&Track> = self.tracks.iter().filter(|t| chain.contains(&t.node)).collect();
        let mut times: Vec<f64> = tracks.iter().flat_map(|t| t.key_times()).collect();
        times.sort_unstable_by(f64::total_cmp);
        times.dedup();
        // Nodes that stand still are multiplied once.
        let mut links: Vec<Link<'_>> = vec![Link::Still(nodes.base())];
        for &n in chain {
            let local = nodes.all[n as usize].local;
            let moving: Vec<&Track> = tracks.iter().copied().filter(|t| t.node == n).collect();
            match (links.last_mut(), moving.is_empty()) {
                (Some(Link::Still(m)), true) => *m *= local.affine(),
                (_, true) => links.push(Link::Still(local.affine())),
                (_, false) => links.push(Link::Moving(local, moving)),
            }
        }
        let at = |t: f64| links.iter().fold(DAffine3::IDENTITY, |m, link| m * link.at(t));
        times.into_iter().map(|t| (t, at(t))).collect()
    }
}

/// The node that a pointer leads to, and what of it: one that an animation may move without
/// pointers too.
fn node_of(pointer: &str) -> Option<(usize, &str)> {
    let (node, path) = pointer.strip_prefix("/nodes/")?.split_once('/')?;
    let is_known = ["translation", "rotation", "scale", "weights"].contains(&path);
    is_known.then_some(())?;
    Some((node.parse().ok()?, path))
}

enum Link<'a> {
    Still(DAffine3),
    Moving(Local, Vec<&'a Track>),
}

impl Link<'_> {
    fn at(&self, time: f64) -> DAffine3 {
        match self {
            Self::Still(m) => *m,
            Self::Moving(local, tracks) => {
                tracks.iter().fold(*local, |local, track| local.moved(track, time)).affine()
            }
        }
    }
}

impl Track {
    /// The times at which its value must be known for straight lines between them to follow it.
    fn key_times(&self) -> Vec<f64> {
        let pairs = self.times.windows(2);
        let between: Vec<f64> = match self.interpolation {
            Interpolation::Linear => Vec::new(),
            Interpolation::Step => {
                pairs.map(|w| w[1].next_down()).filter(|t| !self.times.contains(t)).collect()
            }
            Interpolation::Cubic => pairs
                .flat_map(|w| {
                    let (a, step) = (w[0], (w[1] - w[0]) / SEGMENTS as f64);
                    (1..SEGMENTS).map(move |i| a + step * i as f64)
                })
                .collect(),
        };
        self.times.iter().copied().chain(between).collect()
    }
}

fn track(
    sampler: &Sampler<'_>,
    node: u32,
    property: Property,
    accessors: &Accessors,
    buffers: &Buffers<'_>,
    user: &str,
) -> Result<Track, ErrorKind> {
    let (interpolation, times) = keys(sampler, accessors, buffers, user)?;
    let output = sampler.output.index();
    let values: Vec<DVec4> = if property == Property::Rotation {
        let v: Vec<[f32; 4]> = accessors.floats(output, buffers, user)?;
        v.into_iter().map(|v| DVec4::from(v.map(f64::from))).collect()
    } else {
        let v: Vec<[f32; 3]> = accessors.floats(output, buffers, user)?;
        v.into_iter().map(|v| DVec3::from(v.map(f64::from)).extend(0.0)).collect()
    };
    check_values(values.len(), times.len(), interpolation.values(), user)?;
    if !values.iter().all(|v| v.is_finite()) {
        return Err(ErrorKind::invalid(user, "has values that are not finite"));
    }
    Ok(Track { node, property, interpolation, times, values })
}

fn weight_track(
    sampler: &Sampler<'_>,
    node: u32,
    targets: usize,
    accessors: &Accessors,
    buffers: &Buffers<'_>,
    user: &str,
) -> Result<WeightTrack, ErrorKind> {
    let (interpolation, times) = keys(sampler, accessors, buffers, user)?;
    let values: Vec<[f32; 1]> = accessors.floats(sampler.output.index(), buffers, user)?;
    let each = targets.saturating_mul(interpolation.values());
    check_values(values.len(), times.len(), each, user)?;
    let values: Vec<f32> = values.into_iter().map(|[v]| v).collect();
    if !values.iter().all(|v| v.is_finite()) {
        return Err(ErrorKind::invalid(user, "has values that are not finite"));
    }
    Ok(WeightTrack { node, interpolation, times, targets, values })
}

fn check_values(values: usize, times: usize, each: usize, user: &str) -> Result<(), ErrorKind> {
    if values == times.saturating_mul(each) {
        return Ok(());
    }
    let message = format!("has {times} times but {values} values; expected {each} for each time");
    Err(ErrorKind::invalid(user, message))
}

/// How a sampler goes from key to key, and when the keys are.
fn keys(
    sampler: &Sampler<'_>,
    accessors: &Accessors,
    buffers: &Buffers<'_>,
    user: &str,
) -> Result<(Interpolation, Vec<f64>), ErrorKind> {
    let wrong = |message: String| Err(ErrorKind::invalid(user, message));
    let interpolation = match sampler.interpolation.as_deref() {
        None | Some("LINEAR") => Interpolation::Linear,
        Some("STEP") => Interpolation::Step,
        Some("CUBICSPLINE") => Interpolation::Cubic,
        Some(other) => return wrong(format!("interpolation {:?} is unknown", shorten(other))),
    };
    let input = sampler.input.index();
    if accessors.get(input, user)?.component != Component::F32 {
        return wrong(format!("its times, accessor {input}, are not floats"));
    }
    let times: Vec<[f32; 1]> = accessors.floats(input, buffers, user)?;
    let times: Vec<f64> = times.into_iter().map(|[t]| f64::from(t)).collect();
    let ascending = times.windows(2).all(|w| w[0] < w[1]);
    if times.is_empty() || !ascending || !times.iter().all(|t| t.is_finite()) {
        return wrong("its times do not ascend".into());
    }
    Ok((interpolation, times))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_lines_between_key_times_follow_the_track() {
        let track = |interpolation| Track {
            node: 0,
            property: Property::Translation,
            interpolation,
            times: vec![1.0, 3.0],
            values: vec![DVec4::ZERO; 6],
        };
        assert_eq!(track(Interpolation::Linear).key_times(), [1.0, 3.0]);
        assert_eq!(track(Interpolation::Step).key_times(), [1.0, 3.0, 3f64.next_down()]);
        assert_eq!(track(Interpolation::Cubic).key_times().len(), 2 + SEGMENTS - 1);
    }
}
