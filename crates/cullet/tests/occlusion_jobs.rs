//! Surfaces drawn patch by patch: what is passed over as hidden changes no bit.

use cullet::bounds::{Aabb, Boxes};
use cullet::cull::occlusion::{OcclusionBuffer, Patch};
use cullet::{Simd, Transform, View};
use cullet_testkit::views::look;
use cullet_testkit::{Rng, cases};

const SIZE: [u32; 2] = [200, 150];

/// Hills on a grid, steep enough that some hide others, cut into patches.
fn hills(rng: &mut Rng) -> Vec<Patch> {
    let side = 24_u32;
    let mut positions = Vec::new();
    for j in 0..side {
        for i in 0..side {
            let most = if rng.below(5) == 0 { 6.0 } else { 1.0 };
            let height = rng.range(0.0, most);
            positions.push([i as f32, height as f32, j as f32]);
        }
    }
    let quad = |i: u32, j: u32| {
        let a = j * side + i;
        [a, a + side, a + 1, a + 1, a + side, a + side + 1]
    };
    let indices: Vec<u32> =
        (0..side - 1).flat_map(|j| (0..side - 1).flat_map(move |i| quad(i, j))).collect();
    Patch::cut(&positions, &indices, 40, rng.below(2) == 0).unwrap()
}

fn view(rng: &mut Rng) -> View {
    let eye = [rng.range(-4.0, 28.0), rng.range(1.0, 9.0), rng.range(-4.0, 28.0)];
    let target = [rng.range(6.0, 18.0), rng.range(-1.0, 3.0), rng.range(6.0, 18.0)];
    look(eye, target, SIZE)
}

fn pixels(buffer: &OcclusionBuffer) -> Vec<u32> {
    let rows = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
    rows.map(|(x, y)| buffer.nearness(x, y).to_bits()).collect()
}

#[test]
fn patches_that_are_passed_over_change_no_bit() {
    let mut rng = Rng(8);
    let (mut passed_over, mut covered) = (0, 0);
    let rounds = cases(60) as usize;
    for _ in 0..rounds {
        let (patches, view) = (hills(&mut rng), view(&mut rng));
        let bounds: Vec<Aabb> = patches.iter().map(Patch::bounds).collect();
        let boxes = Boxes::from_slice(&bounds);
        let eye = view.eye();
        let distance = |i: &u32| {
            let b = &bounds[*i as usize];
            let of = |a: usize| (f64::from(b.min[a] + b.max[a]) * 0.5 - eye[a] / eye[3]).powi(2);
            of(0) + of(1) + of(2)
        };
        let mut order: Vec<u32> = (0..patches.len() as u32).collect();
        order.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        let level = Simd::best();
        let draw = |buffer: &mut OcclusionBuffer, i: u32| {
            patches[i as usize].draw(level, buffer, &Transform::IDENTITY);
        };
        let mut buffer = OcclusionBuffer::new(SIZE).unwrap();
        buffer.begin(&view, [0.0; 3]);
        order.iter().for_each(|&i| draw(&mut buffer, i));
        let all = pixels(&buffer);
        buffer.begin(&view, [0.0; 3]);
        passed_over +=
            patches.len() - buffer.draw_unless_hidden(level, (&boxes, &[]), &order, draw);
        assert!(pixels(&buffer) == all);
        covered += all.iter().filter(|n| **n != 0).count();
    }
    assert!(passed_over > rounds, "{passed_over}");
    assert!(covered > rounds * 3000, "{covered}");
}
