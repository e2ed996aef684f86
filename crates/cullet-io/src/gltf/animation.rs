//! Animations of nodes, as far as they move a camera.

use glam::{DAffine3, DQuat, DVec3, DVec4};

use super::accessor::{Accessors, Component};
use super::buffers::Buffers;
use super::json::{self, AnimationItem, Root, Sampler};
use super::nodes::{Local, Nodes};
use super::notes::Notes;
use super::uri::shorten;
use crate::ErrorKind;

/// A curve of degree three is given by this many straight pieces between two of its keys.
const PIECES: usize = 8;

/// What of a node a track moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Property {
    Translation,
    Rotation,
    Scale,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Interpolation {
    Linear,
    Step,
    /// Each key has three values: tangent in, value, tangent out.
    Cubic,
}

/// The values of one property of one node over time.
#[derive(Debug)]
struct Track {
    node: u32,
    property: Property,
    interpolation: Interpolation,
    /// Seconds, ascending, at least one.
    times: Vec<f64>,
    /// One value a time, or three.
    values: Vec<DVec4>,
}

/// The tracks of an animation that move given nodes.
#[derive(Debug)]
pub(super) struct Clip {
    pub(super) name: String,
    tracks: Vec<Track>,
}

impl Clip {
    /// Reads the tracks of animation `index` for which `wanted` says yes to the node. A track that is
    /// malformed is left out with a note: no geometry hangs on it.
    ///
    /// # Errors
    /// If the animation itself is malformed.
    pub(super) fn read(
        root: &Root<'_>,
        index: usize,
        accessors: &Accessors,
        buffers: &Buffers<'_>,
        wanted: impl Fn(usize) -> bool,
        notes: &mut Notes,
    ) -> Result<Self, ErrorKind> {
        let raw = &root.animations.as_deref().unwrap_or_default()[index];
        let item: AnimationItem<'_> = json::item(raw, "animation", index)?;
        let name = match item.name.as_deref() {
            Some(name) if !name.is_empty() => shorten(name),
            _ => format!("animation {index}"),
        };
        let mut tracks: Vec<Track> = Vec::new();
        for (c, channel) in item.channels.iter().enumerate() {
            let user = || format!("animation {index}, channel {c}");
            let property = match channel.target.path.as_str() {
                "translation" => Property::Translation,
                "rotation" => Property::Rotation,
                "scale" => Property::Scale,
                _ => continue,
            };
            let Some(node) = channel.target.node.map(json::Integer::index).filter(|&n| wanted(n))
            else {
                continue;
            };
            let node = node as u32;
            if tracks.iter().any(|t| t.node == node && t.property == property) {
                notes.push(user(), "moves what another channel moves, and is left out");
                continue;
            }
            let Some(sampler) = item.samplers.get(channel.sampler.index()) else {
                notes.push(user(), "names a sampler that is not there, and is left out");
                continue;
            };
            match track(sampler, node, property, accessors, buffers, &user()) {
                Ok(track) => tracks.push(track),
                Err(e) => notes.push(user(), format!("is left out: {e}")),
            }
        }
        Ok(Self { name, tracks })
    }

    /// Whether it moves any of these nodes.
    pub(super) fn moves(&self, chain: &[u32]) -> bool {
        self.tracks.iter().any(|t| chain.contains(&t.node))
    }

    /// How much work it is to sample a chain of nodes.
    pub(super) fn cost(&self, chain: &[u32]) -> u64 {
        let tracks = self.tracks.iter().filter(|t| chain.contains(&t.node));
        let (count, keys) =
            tracks.fold((0u64, 0u64), |(n, k), t| (n + 1, k + (t.times.len() * PIECES) as u64));
        count.saturating_mul(keys)
    }

    /// The transform of the last node of `chain`, which leads there from its root, at every key time
    /// of any track that moves it. Steps get a key just before the jump; curves get keys between.
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

enum Link<'a> {
    Still(DAffine3),
    Moving(Local, Vec<&'a Track>),
}

impl Link<'_> {
    fn at(&self, time: f64) -> DAffine3 {
        match self {
            Self::Still(m) => *m,
            Self::Moving(local, tracks) => {
                let (mut scale, mut rotation, mut translation) = match *local {
                    Local::Parts { translation, rotation, scale } => (scale, rotation, translation),
                    // Not allowed; the parts that no track gives are then those of the identity.
                    Local::Matrix(_) => (DVec3::ONE, DQuat::IDENTITY, DVec3::ZERO),
                };
                for track in tracks {
                    let v = track.at(time);
                    match track.property {
                        Property::Translation => translation = v.truncate(),
                        Property::Rotation => rotation = unit(v),
                        Property::Scale => scale = v.truncate(),
                    }
                }
                DAffine3::from_scale_rotation_translation(scale, rotation, translation)
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
                    let (a, step) = (w[0], (w[1] - w[0]) / PIECES as f64);
                    (1..PIECES).map(move |i| a + step * i as f64)
                })
                .collect(),
        };
        self.times.iter().copied().chain(between).collect()
    }

    /// The value at a time; before the first key and after the last it stays.
    fn at(&self, time: f64) -> DVec4 {
        let value = |i: usize| match self.interpolation {
            Interpolation::Cubic => self.values[i * 3 + 1],
            _ => self.values[i],
        };
        let after = self.times.partition_point(|&t| t <= time);
        if after == 0 {
            return value(0);
        }
        let i = after - 1;
        if after == self.times.len() {
            return value(i);
        }
        let span = self.times[after] - self.times[i];
        let s = (time - self.times[i]) / span;
        match self.interpolation {
            Interpolation::Step => value(i),
            Interpolation::Linear if self.property == Property::Rotation => {
                let (a, b) = (unit(value(i)), unit(value(after)));
                let v = a.slerp(b, s);
                DVec4::new(v.x, v.y, v.z, v.w)
            }
            Interpolation::Linear => value(i).lerp(value(after), s),
            Interpolation::Cubic => {
                // Hermite, as appendix C of the specification has it.
                let (out, into) = (self.values[i * 3 + 2] * span, self.values[after * 3] * span);
                let (s2, s3) = (s * s, s * s * s);
                value(i) * (2.0 * s3 - 3.0 * s2 + 1.0)
                    + out * (s3 - 2.0 * s2 + s)
                    + value(after) * (3.0 * s2 - 2.0 * s3)
                    + into * (s3 - s2)
            }
        }
    }
}

fn unit(v: DVec4) -> DQuat {
    // A quaternion of zeros turns nothing.
    v.try_normalize().map_or(DQuat::IDENTITY, |v| DQuat::from_array(v.to_array()))
}

fn track(
    sampler: &Sampler,
    node: u32,
    property: Property,
    accessors: &Accessors,
    buffers: &Buffers<'_>,
    user: &str,
) -> Result<Track, ErrorKind> {
    let wrong = |message: String| Err(ErrorKind::invalid(user, message));
    let interpolation = match sampler.interpolation.as_deref() {
        None | Some("LINEAR") => Interpolation::Linear,
        Some("STEP") => Interpolation::Step,
        Some("CUBICSPLINE") => Interpolation::Cubic,
        Some(other) => return wrong(format!("interpolation {:?} is unknown", shorten(other))),
    };
    let (input, output) = (sampler.input.index(), sampler.output.index());
    if accessors.get(input, user)?.component != Component::F32 {
        return wrong(format!("its times, accessor {input}, are not floats"));
    }
    let times: Vec<[f32; 1]> = accessors.floats(input, buffers, user)?;
    let times: Vec<f64> = times.into_iter().map(|[t]| f64::from(t)).collect();
    let ascending = times.windows(2).all(|w| w[0] < w[1]);
    if !ascending || !times.iter().all(|t| t.is_finite()) {
        return wrong("its times do not ascend".into());
    }
    let values: Vec<DVec4> = if property == Property::Rotation {
        let v: Vec<[f32; 4]> = accessors.floats(output, buffers, user)?;
        v.into_iter().map(|v| DVec4::from(v.map(f64::from))).collect()
    } else {
        let v: Vec<[f32; 3]> = accessors.floats(output, buffers, user)?;
        v.into_iter().map(|v| DVec3::from(v.map(f64::from)).extend(0.0)).collect()
    };
    let each = if interpolation == Interpolation::Cubic { 3 } else { 1 };
    if values.len() != times.len().saturating_mul(each) {
        return wrong(format!("has {} times but {} values", times.len(), values.len()));
    }
    if !values.iter().all(|v| v.is_finite()) {
        return wrong("has values that are not finite".into());
    }
    Ok(Track { node, property, interpolation, times, values })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(interpolation: Interpolation, times: &[f64], xs: &[f64]) -> Track {
        Track {
            node: 0,
            property: Property::Translation,
            interpolation,
            times: times.to_vec(),
            values: xs.iter().map(|&x| DVec4::new(x, 0.0, 0.0, 0.0)).collect(),
        }
    }

    #[test]
    fn linear_and_step_and_beyond_the_ends() {
        let linear = track(Interpolation::Linear, &[1.0, 3.0], &[10.0, 20.0]);
        let x = |t: &Track, time| t.at(time).x;
        assert_eq!(
            [0.0, 1.0, 2.0, 3.0, 9.0].map(|t| x(&linear, t)),
            [10.0, 10.0, 15.0, 20.0, 20.0]
        );
        let step = track(Interpolation::Step, &[1.0, 3.0], &[10.0, 20.0]);
        let before = 3f64.next_down();
        assert_eq!([1.0, 2.9, before, 3.0].map(|t| x(&step, t)), [10.0, 10.0, 10.0, 20.0]);
        assert_eq!(step.key_times(), [1.0, 3.0, before]);
    }

    #[test]
    fn a_cubic_with_the_tangents_of_a_line_is_that_line() {
        // Slope 5: tangents are per second.
        let values = [5.0, 10.0, 5.0, 5.0, 20.0, 5.0];
        let cubic = track(Interpolation::Cubic, &[1.0, 3.0], &values);
        for time in cubic.key_times() {
            assert!((cubic.at(time).x - (5.0 * time + 5.0)).abs() < 1e-12, "{time}");
        }
        assert_eq!(cubic.key_times().len(), 2 + PIECES - 1);
    }

    #[test]
    fn rotations_take_the_shorter_way() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let rotation = Track {
            property: Property::Rotation,
            values: vec![DVec4::new(0.0, 0.0, 0.0, 1.0), DVec4::new(0.0, -half, 0.0, -half)],
            ..track(Interpolation::Linear, &[0.0, 1.0], &[])
        };
        let turned = unit(rotation.at(0.5)) * DVec3::X;
        assert!(turned.abs_diff_eq(DVec3::new(half, 0.0, -half), 1e-12), "{turned}");
    }
}
