//! Functions of numbers, and the signs that proofs stand on.

use std::hint::black_box;

use cullet::View;
use cullet::exact::{determinant_sign, plane_sign};
use cullet::math;
use cullet_scenes::Rng;

use crate::hash::line;

const VALUES: usize = 20_000;
const SIGNS: usize = 1_000_000;

/// A function, and the range that it is tried on.
type Tried = (&'static str, [f64; 2], fn(f64) -> f64);

const ONE: &[Tried] = &[
    ("sin", [-700.0, 700.0], math::sin),
    ("cos", [-700.0, 700.0], math::cos),
    ("sin and cos", [-7.0, 7.0], |v| {
        let (s, c) = math::sin_cos(v);
        s + 3.0 * c
    }),
    ("tan", [-1.5, 1.5], math::tan),
    ("acos", [-1.0, 1.0], math::acos),
    ("exp", [-9.0, 9.0], math::exp),
    ("exp2", [-9.0, 9.0], math::exp2),
    ("ln", [0.0, 9.0], math::ln),
    ("log2", [0.0, 9.0], math::log2),
    ("cbrt", [-9.0, 9.0], math::cbrt),
    ("pow 2.4", [0.0, 9.0], |v| math::pow(v, 2.4)),
    ("pow 1/2.4", [0.0, 9.0], |v| math::pow(v, 1.0 / 2.4)),
    ("sqrt", [0.0, 9.0], f64::sqrt),
    ("sqrt of f32", [0.0, 9.0], |v| f64::from((v as f32).sqrt())),
    ("powi", [-9.0, 9.0], |v| v.powi(black_box(7))),
    ("remainder", [-9.0, 9.0], |v| v % 0.7),
    ("whole", [-9.0, 9.0], |v| v.round() + v.floor() * 3.0 + v.ceil() * 7.0 + v.trunc() * 11.0),
];

/// Fails if a sign is wrong.
pub(crate) fn run() -> Result<(), String> {
    for &(name, [low, high], function) in ONE {
        let mut rng = Rng::new(1, 1);
        line(name, |hash| {
            (0..VALUES).for_each(|_| hash.number(function(black_box(rng.range(low, high)))));
        });
    }
    let two: [(&str, fn(f64, f64) -> f64); 3] = [
        ("hypot", math::hypot),
        ("atan2", math::atan2),
        ("error of a product", |a, b| math::two_product(a, b).1),
    ];
    for (name, function) in two {
        let mut rng = Rng::new(1, 2);
        let mut next = || black_box(rng.range(-5.0, 5.0));
        line(name, |hash| (0..VALUES).for_each(|_| hash.number(function(next(), next()))));
    }
    let mut rng = Rng::new(1, 3);
    line("2,000 views", |hash| {
        for _ in 0..2_000 {
            let fov = rng.range(0.1, 3.0);
            hash.value(&View::perspective([1.0, 2.0, 3.0], [0.0; 3], fov, 0.1, 100.0, [640, 400]));
        }
    });
    signs()
}

/// Signs of planes through points but for the last bit, against whole numbers.
fn signs() -> Result<(), String> {
    let mut rng = Rng::new(1, 4);
    let mut wrong = 0;
    for _ in 0..SIGNS {
        let mut whole = || (rng.next_u64() >> 11) as i64;
        let [a, b, c, d] = [whole(), whole(), whole(), whole()];
        // a·b + c·e − d, where e is such that what is left is small.
        let e = -((i128::from(a) * i128::from(b)) / i128::from(c.max(1)));
        let e = (e as f64) as i64;
        let exact = i128::from(a) * i128::from(b) + i128::from(c) * i128::from(e) - i128::from(d);
        let (normal, point) = ([a as f64, c as f64, 0.0], [b as f64, e as f64, 1.0]);
        wrong += u32::from(plane_sign(normal, d as f64, point) != exact.signum() as i32);
    }
    line("signs of planes", |hash| {
        for _ in 0..VALUES {
            let mut unit = || rng.range(-1.0, 1.0) as f32;
            let [x, y] = [[unit(), unit(), unit()], [unit(), unit(), unit()]];
            let z = [0, 1, 2].map(|k| x[k] * 0.5 + y[k] * 0.25);
            hash.value(&determinant_sign(&[x, y, z]));
        }
    });
    if wrong > 0 { Err(format!("{wrong} of {SIGNS} signs of planes are wrong")) } else { Ok(()) }
}
