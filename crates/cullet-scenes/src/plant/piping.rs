//! Equipment of a plant: pipes with elbows, flanges and valves; vessels, pumps, ladders.

use glam::DVec3;

use super::super::rng::{Rng, sin_cos};
use super::super::shapes::Shape;

/// Steps of an elbow.
const ELBOW: u32 = 6;
const SIDES: u32 = 12;

/// A pipe through these points, each straight stretch along an axis, its corners rounded.
fn pipe(points: &[DVec3], radius: f64) -> Shape {
    let along = |i: usize| (points[i + 1] - points[i]).normalize();
    let mut u = along(0);
    let mut n = if u.y.abs() > 0.5 { DVec3::X } else { DVec3::Y };
    let mut frames = vec![(points[0], n, u.cross(n))];
    for i in 1..points.len() - 1 {
        let v = along(i);
        let bend = radius * 2.0;
        let start = points[i] - u * bend;
        let centre = start + v * bend;
        let axis = u.cross(v);
        for k in 0..=ELBOW {
            let (s, c) = sin_cos(0.25 * f64::from(k) / f64::from(ELBOW));
            let turned = |p: DVec3| p * c + axis.cross(p) * s + axis * (axis.dot(p) * (1.0 - c));
            let n = turned(n);
            frames.push((centre + turned(-v) * bend, n, turned(u).cross(n)));
        }
        n = frames.last().map_or(n, |f| f.1);
        u = v;
    }
    frames.push((points[points.len() - 1], n, u.cross(n)));
    let steps = frames.len() as u32 - 1;
    Shape::rod(steps, false, radius, SIDES, |t| frames[(t * f64::from(steps)).round() as usize])
}

/// A round body about the line from `at` along `axis`.
fn collar(at: DVec3, axis: DVec3, profile: &[[f64; 2]], sides: u32) -> Shape {
    let (x, z) = if axis.y.abs() > 0.5 {
        (DVec3::X, -DVec3::Z * axis.y)
    } else {
        (DVec3::Y.cross(axis), DVec3::Y)
    };
    // x × axis = z's side: (x, axis, z) is right-handed.
    let z = if x.cross(axis).dot(z) > 0.0 { z } else { -z };
    Shape::lathe(profile, sides).map(|p| at + x * p.x + axis * p.y + z * p.z)
}

fn flange(at: DVec3, axis: DVec3, radius: f64) -> Shape {
    let r = radius * 1.45;
    let half = radius * 0.25;
    collar(at - axis * half, axis, &[[r, 0.0], [r, half * 2.0]], 16)
}

/// A valve on a pipe: body, stem and handwheel.
fn valve(at: DVec3, axis: DVec3, radius: f64) -> Shape {
    let up = if axis.y.abs() > 0.5 { DVec3::X } else { DVec3::Y };
    let body = [[0.0, -1.7], [1.3, -1.2], [1.6, 0.0], [1.3, 1.2], [0.0, 1.7]];
    let body = body.map(|[r, y]| [r * radius, y * radius]);
    let stem = [[radius * 0.25, 0.0], [radius * 0.25, radius * 3.6]];
    let rim: Vec<[f64; 2]> = (0..6)
        .map(|i| {
            let (s, c) = sin_cos(f64::from(i) / 6.0);
            [radius * (1.5 + 0.18 * c), radius * 0.18 * s]
        })
        .collect();
    let (x, z) = (axis, axis.cross(up));
    let top = at + up * radius * 3.4;
    let wheel = Shape::ring_lathe(&rim, 16).map(|p| top + x * p.x + up * p.y + z * p.z);
    let spoke = |d: DVec3| {
        let e = |s: f64| d * (radius * 1.4 * s);
        let frame = move |t: f64| (top + e(t * 2.0 - 1.0), up, d.cross(up));
        Shape::rod(1, false, radius * 0.12, 6, frame)
    };
    collar(at, axis, &body, 12)
        .and(&collar(at, up, &stem, 8))
        .and(&wheel)
        .and(&spoke(x))
        .and(&spoke(z))
}

/// A rack of pipes that fills a bay of `size` from the corner at the origin: level above level,
/// risers between them, flanges and valves. Gives the pipes and, apart, their valves.
pub(super) fn rack(size: DVec3, pipes: u32, rng: &mut Rng) -> [Shape; 2] {
    let [mut lines, mut valves] = [Shape::default(), Shape::default()];
    for i in 0..pipes {
        let radius = [0.06, 0.09, 0.14, 0.22][rng.below(4)];
        let lane = |rng: &mut Rng, length: f64| rng.range(0.5, length - 0.5);
        // From one side of the bay to the other, by way of two risers.
        let low = size.y * (0.45 + 0.5 * f64::from(i) / f64::from(pipes)) - 0.1;
        let high =
            if rng.chance(0.5) { low - rng.range(0.7, 2.0) } else { (low + 0.9).min(size.y - 0.3) };
        let (across, length) = if i % 2 == 0 { (size.z, size.x) } else { (size.x, size.z) };
        let (z0, z1) = (lane(rng, across), lane(rng, across));
        let mut stops = [rng.range(0.15, 0.3), rng.range(0.42, 0.55), rng.range(0.68, 0.85)];
        stops.iter_mut().for_each(|s| *s *= length);
        // A sidestep that is too short for two elbows is none.
        let z1 = if (z1 - z0).abs() < radius * 5.0 {
            z0 + radius * 5.0 * if z0 > across * 0.5 { -1.0 } else { 1.0 }
        } else {
            z1
        };
        let route = [
            [0.0, low, z0],
            [stops[0], low, z0],
            [stops[0], high, z0],
            [stops[1], high, z0],
            [stops[1], high, z1],
            [stops[2], high, z1],
            [stops[2], low, z1],
            [length, low, z1],
        ];
        let points: Vec<DVec3> = route
            .iter()
            .map(|p| if i % 2 == 0 { DVec3::from(*p) } else { DVec3::new(p[2], p[1], p[0]) })
            .collect();
        lines = lines.and(&pipe(&points, radius));
        for (k, pair) in points.windows(2).enumerate() {
            let (span, axis) = (pair[1] - pair[0], (pair[1] - pair[0]).normalize());
            if span.length() < radius * 9.0 {
                continue;
            }
            for end in [pair[0] + axis * radius * 3.0, pair[1] - axis * radius * 3.0] {
                lines = lines.and(&flange(end, axis, radius));
            }
            if span.length() > radius * 14.0 && (k == 3 || rng.chance(0.2)) {
                valves = valves.and(&valve(pair[0] + span * 0.5, axis, radius));
            }
        }
    }
    [lines, valves]
}

/// A round-ended tank, upright, with a skirt and nozzles; its foot at the origin.
pub(super) fn tank(radius: f64, height: f64, sides: u32, rng: &mut Rng) -> Shape {
    let dome = radius * 0.45;
    let mut profile = vec![[0.0, 0.3]];
    profile.extend((1..8).map(|i| {
        let (s, c) = sin_cos(f64::from(i) / 32.0);
        [radius * s, 0.3 + dome * (1.0 - c)]
    }));
    let bands = (height / 1.5).ceil().max(2.0) as u32;
    for i in 0..=bands {
        let y = 0.3 + dome + (height - 2.0 * dome - 0.3) * f64::from(i) / f64::from(bands);
        let weld = radius * 0.012;
        profile.extend([[radius, y], [radius + weld, y + 0.04], [radius, y + 0.08]]);
    }
    profile.extend((1..8).rev().map(|i| {
        let (s, c) = sin_cos(f64::from(i) / 32.0);
        [radius * s, height + 0.08 - dome * (1.0 - c)]
    }));
    profile.push([0.0, height + 0.1]);
    let mut s = Shape::lathe(&profile, sides);
    s = s.and(&Shape::lathe(&[[radius * 0.82, 0.0], [radius * 0.8, dome * 0.7 + 0.3]], sides));
    for _ in 0..5 {
        let (sin, cos) = sin_cos(rng.unit());
        let out = DVec3::new(cos, 0.0, sin);
        let at = out * radius * 0.93 + DVec3::Y * rng.range(dome + 0.6, height - dome);
        let r = radius * rng.range(0.07, 0.14);
        let frame =
            move |t: f64| (at + out * (radius * 0.07 + 0.35) * t, DVec3::Y, out.cross(DVec3::Y));
        s = s.and(&Shape::rod(1, false, r, SIDES, frame));
        let end = at + out * (radius * 0.07 + 0.33);
        let frame = move |t: f64| (end + out * 0.07 * t, DVec3::Y, out.cross(DVec3::Y));
        s = s.and(&Shape::rod(1, false, r * 1.4, 16, frame));
    }
    s
}

/// A pump with its motor on a plinth; its foot at the origin, along x.
pub(super) fn pump(size: f64) -> [Shape; 2] {
    let plinth =
        Shape::cuboid([-1.3 * size, 0.0, -0.5 * size], [1.3 * size, 0.25 * size, 0.5 * size]);
    let axis = |x: f64| DVec3::new(x * size, 0.75 * size, 0.0);
    let round = |x: f64, profile: &[[f64; 2]], sides: u32| {
        let profile: Vec<[f64; 2]> = profile.iter().map(|p| p.map(|v| v * size)).collect();
        collar(axis(x), DVec3::X, &profile, sides)
    };
    let volute = round(
        -1.1,
        &[[0.0, 0.0], [0.3, 0.0], [0.45, 0.1], [0.45, 0.4], [0.25, 0.55], [0.0, 0.55]],
        24,
    );
    let shaft = round(-0.6, &[[0.07, 0.0], [0.07, 0.8]], 10);
    let mut motor = round(0.05, &[[0.0, 0.0], [0.34, 0.02], [0.34, 1.1], [0.0, 1.15]], 24);
    // Cooling fins.
    for i in 0..9 {
        let x = 0.14 + 0.1 * f64::from(i);
        motor = motor.and(&round(x, &[[0.4, 0.0], [0.4, 0.03]], 24));
    }
    let spout =
        collar(axis(-0.85), DVec3::Y, &[[0.16 * size, 0.1], [0.16 * size, 0.9 * size]], SIDES);
    let foot = |x: f64| {
        let (a, b) = (x - 0.12, x + 0.12);
        Shape::cuboid([a * size, 0.2 * size, -0.2 * size], [b * size, 0.7 * size, 0.2 * size])
    };
    [plinth.and(&foot(-0.8)).and(&foot(0.6)), volute.and(&shaft).and(&motor).and(&spout)]
}

/// A ladder with a safety cage, its foot at the origin, climbing along y and facing +z.
pub(super) fn ladder(height: f64) -> Shape {
    let mut s = Shape::default();
    for x in [-0.25, 0.25] {
        s = s.and(&Shape::cuboid([x - 0.02, 0.0, -0.03], [x + 0.02, height, 0.03]));
    }
    let rungs = (height / 0.3) as u32;
    for i in 1..rungs {
        let y = 0.3 * f64::from(i);
        let frame = move |t: f64| (DVec3::new(0.5 * t - 0.25, y, 0.0), DVec3::Y, DVec3::Z);
        s = s.and(&Shape::rod(1, false, 0.015, 6, frame));
    }
    // Hoops, from above a person's head.
    let hoops = ((height - 2.2) / 0.9).max(0.0) as u32;
    for i in 0..hoops {
        let y = 2.2 + 0.9 * f64::from(i);
        let frame = move |t: f64| {
            let (sin, cos) = sin_cos(0.5 * t);
            let out = DVec3::new(cos, 0.0, sin);
            (DVec3::new(0.0, y, 0.03) + out * DVec3::new(0.38, 0.0, 0.7), out, DVec3::Y)
        };
        s = s.and(&Shape::rod(10, false, 0.02, 6, frame));
    }
    s
}

/// A railing along x from 0 to `length`: posts, two rails and a toe board.
pub(super) fn railing(length: f64) -> Shape {
    let mut s = Shape::default();
    let posts = (length / 1.3).ceil() as u32;
    for i in 0..=posts {
        let x = 0.03 + (length - 0.06) * f64::from(i) / f64::from(posts);
        let frame = move |t: f64| (DVec3::new(x, 1.08 * t, 0.0), DVec3::Z, DVec3::X);
        s = s.and(&Shape::rod(1, false, 0.022, 8, frame));
    }
    for y in [0.55, 1.1] {
        let frame = move |t: f64| (DVec3::new(length * t, y, 0.0), DVec3::Y, DVec3::Z);
        s = s.and(&Shape::rod(1, false, 0.028, 8, frame));
    }
    s.and(&Shape::cuboid([0.0, 0.01, -0.01], [length, 0.12, 0.01]))
}

/// A cable tray along x from 0 to `length`, with cables on it.
pub(super) fn tray(length: f64) -> Shape {
    let mut s = Shape::default();
    for z in [-0.3, 0.3] {
        s = s.and(&Shape::cuboid([0.0, 0.0, z - 0.015], [length, 0.12, z + 0.015]));
    }
    for i in 0..(length / 0.35) as u32 {
        let x = 0.1 + 0.35 * f64::from(i);
        s = s.and(&Shape::cuboid([x, 0.01, -0.31], [x + 0.05, 0.04, 0.31]));
    }
    for k in 0..6 {
        let z = -0.24 + 0.09 * f64::from(k);
        let frame = move |t: f64| {
            (DVec3::new(length * t, 0.08 + 0.012 * sin_cos(t * 3.0 + z).0, z), DVec3::Y, DVec3::Z)
        };
        s = s.and(&Shape::rod(16, false, 0.035, 6, frame));
    }
    s
}

/// A lattice girder along z from 0 to `length`, `depth` high, its top at y = 0.
pub(super) fn girder(length: f64, depth: f64) -> Shape {
    let bar = |a: DVec3, b: DVec3, r: f64| {
        let u = (b - a).normalize();
        let frame = move |t: f64| (a + (b - a) * t, DVec3::X, u.cross(DVec3::X));
        Shape::rod(1, false, r, 6, frame)
    };
    let mut s = Shape::default();
    for x in [-0.35, 0.35] {
        for y in [0.0, -depth] {
            s = s.and(&bar(DVec3::new(x, y, 0.0), DVec3::new(x, y, length), 0.09));
        }
        let panels = (length / depth).round().max(1.0) as u32;
        for i in 0..panels {
            // Bars end short of each other, or they would share corners.
            let at = |k: u32, gap: f64| length * f64::from(k) / f64::from(panels) + gap;
            let (low, high) = if i % 2 == 0 { (-depth, 0.0) } else { (0.0, -depth) };
            s = s.and(&bar(
                DVec3::new(x, low, at(i, 0.01)),
                DVec3::new(x, high, at(i + 1, -0.01)),
                0.05,
            ));
        }
    }
    s
}
