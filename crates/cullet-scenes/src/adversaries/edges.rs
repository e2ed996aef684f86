//! Edges where surfaces should meet: T-junctions, hairline gaps, slivers, fans, doubled triangles,
//! stars.

use glam::DVec3;

use super::draft::{Draft, Screen, ahead, anywhere, beyond, hairline, one};
use crate::Rng;

/// Sheets beside quads whose edge has no corner where theirs have, bent in or out by nothing, an
/// ulp, or more.
pub(super) fn t_junctions(d: &mut Draft, rng: &mut Rng, _: &Screen) {
    for _ in 0..18 {
        let (o, u, v) = (ahead(rng), anywhere(rng, 5.0), anywhere(rng, 5.0));
        d.quad(rng, [o, o + u, o + u + v, o + v]);
        let n = one(rng, &[2_u32, 3, 7]);
        let dent = hairline(rng);
        let mut edge = Vec::new();
        for k in 0..=n {
            let inner = k > 0 && k < n;
            let mut p = o + v + u * (f64::from(k) / f64::from(n));
            if inner {
                p += v * dent;
                if rng.chance(0.3) {
                    p.x = beyond(p.x);
                }
            }
            edge.push([d.point(p), d.point(p + v * rng.range(0.3, 1.0))]);
        }
        for pair in edge.windows(2) {
            d.quad_of(rng.chance(0.5), [pair[0][0], pair[1][0], pair[1][1], pair[0][1]]);
        }
    }
}

/// Rows of walls with less than a pixel between one and the next, an ulp or nothing.
pub(super) fn hairline_gaps(d: &mut Draft, rng: &mut Rng, _: &Screen) {
    for _ in 0..9 {
        let (at, turned) = (ahead(rng), rng.chance(0.3));
        let (wide, high) = (rng.range(0.4, 3.0), rng.range(1.0, 6.0));
        let gap = hairline(rng) * wide;
        let by_ulp = rng.chance(0.3);
        let lean = if turned { rng.range(-0.8, 0.8) } else { 0.0 };
        let mut x = at.x - wide * 2.5;
        for _ in 0..6 {
            let right = x + wide;
            let corner = |x: f64, y: f64| {
                DVec3::new(x, at.y + y * 0.5, at.z + (x - at.x) * lean + y * lean * 0.1)
            };
            d.quad(
                rng,
                [corner(x, -high), corner(right, -high), corner(right, high), corner(x, high)],
            );
            x = if by_ulp { beyond(right) } else { right + gap };
        }
        // A gable over all of them: its lower edge meets all of their upper ones.
        let corner = |x: f64, y: f64| {
            DVec3::new(x, at.y + y * 0.5, at.z + (x - at.x) * lean + y * lean * 0.1)
        };
        let left = at.x - wide * 2.5;
        d.triangle([corner(left, high), corner(x, high), corner((left + x) * 0.5, high * 1.8)]);
    }
    d.turn_some(rng, 0.1);
}

/// Needles, and fans of them that fill an area.
pub(super) fn slivers(d: &mut Draft, rng: &mut Rng, _: &Screen) {
    for _ in 0..40 {
        let (p, along) = (ahead(rng), anywhere(rng, 10.0));
        let thin = one(rng, &[1e-6, 1e-4, 1e-2]);
        d.triangle([p, p + along, p + along + anywhere(rng, thin)]);
    }
    for _ in 0..6 {
        let (apex, from, to) = (ahead(rng), anywhere(rng, 5.0), anywhere(rng, 5.0));
        let n = one(rng, &[30_u32, 300]);
        let top = d.point(apex);
        let rim: Vec<u32> = (0..=n)
            .map(|k| {
                let t = f64::from(k) / f64::from(n);
                d.point(apex + from * (1.0 - t) + to * t)
            })
            .collect();
        d.triangles.extend(rim.windows(2).map(|w| [top, w[0], w[1]]));
    }
    // A surface cut by needles of no area at all.
    let (o, u, v) = (ahead(rng), anywhere(rng, 6.0), anywhere(rng, 6.0));
    let middle = o + (u + v) * 0.5;
    d.triangle([o, o + u, middle]);
    d.triangle([o, middle, o + u * 1.0]);
    d.triangle([o + u, o + u + v, middle]);
    d.triangle([o + u + v, o + v, middle]);
    d.triangle([o + v, o, middle]);
}

/// Three and more triangles at an edge.
pub(super) fn fans(d: &mut Draft, rng: &mut Rng, _: &Screen) {
    for _ in 0..16 {
        let (a, b) = (ahead(rng), ahead(rng));
        let edge = [d.point(a), d.point(b)];
        for _ in 0..rng.below(5) + 3 {
            let tip = d.point((a + b) * 0.5 + anywhere(rng, 4.0));
            let ends = if rng.chance(0.5) { edge } else { [edge[1], edge[0]] };
            d.triangles.push([ends[0], ends[1], tip]);
        }
    }
    // A pile of books: pages that share their spine.
    let (spine, up) = (ahead(rng), DVec3::new(0.1, 3.0, 0.2));
    let (low, high) = (d.point(spine), d.point(spine + up));
    for k in 0..9 {
        let page = DVec3::new(2.0, 0.0, -0.02 * f64::from(k * k));
        let outer = [d.point(spine + page), d.point(spine + page + up)];
        d.quad_of(k % 2 == 0, [low, outer[0], outer[1], high]);
    }
}

/// Triangles twice in the same place, wound alike or the other way, sharing corners or not.
pub(super) fn doubled(d: &mut Draft, rng: &mut Rng, _: &Screen) {
    for _ in 0..9 {
        let (o, u, v) = (ahead(rng), anywhere(rng, 6.0), anywhere(rng, 6.0));
        let cells = [one(rng, &[1, 2, 6]), one(rng, &[1, 2, 6])];
        let bump = one(rng, &[0.0, 0.3]);
        d.sheet(rng, [o, u, v], cells, bump, 0.0);
    }
    for t in d.triangles.clone() {
        match rng.below(5) {
            0 => d.triangles.push(t),
            1 => d.triangles.push([t[0], t[2], t[1]]),
            2 => {
                let corners = t.map(|v| d.positions[v as usize]);
                d.triangle(corners);
            }
            3 => {
                let away = anywhere(rng, 1e-6);
                let corners = t.map(|v| d.positions[v as usize] + away);
                d.triangle(corners);
            }
            _ => {}
        }
    }
}

/// Many triangles around a corner, some missing, some folded over their neighbours.
pub(super) fn stars(d: &mut Draft, rng: &mut Rng, _: &Screen) {
    for _ in 0..12 {
        let (centre, u, v) = (ahead(rng), anywhere(rng, 3.0), anywhere(rng, 3.0));
        let lift = u.cross(v).normalize_or(DVec3::Z) * one(rng, &[0.0, 1e-4, 0.5, 3.0]);
        let n = one(rng, &[3_u32, 8, 60]);
        let tip = d.point(centre + lift);
        let rim: Vec<u32> = (0..n)
            .map(|k| {
                let (s, c) = crate::sin_cos(f64::from(k) / f64::from(n));
                // Where it goes back a triangle lies over the one before.
                let far = if rng.chance(0.1) { 0.05 } else { rng.range(0.7, 1.0) };
                d.point(centre + (u * c + v * s) * far)
            })
            .collect();
        for k in 0..n as usize {
            if !rng.chance(0.05) {
                let next = if rng.chance(0.05) { k + 2 } else { k + 1 };
                d.triangles.push([tip, rim[k], rim[next % n as usize]]);
            }
        }
    }
}
