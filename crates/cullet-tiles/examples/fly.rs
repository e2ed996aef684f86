//! Flies through a city of any size within a budget, and says what that took.
//!
//! ```sh
//! cargo run --release --example fly -p cullet-tiles -- 1e7 1e8          # at 100 m/s, along a street and then above the roofs
//! ```
//!
//! `PIXELS=4` asks for finer tiles. Every 200th frame is held against a picture that culls nothing, on another thread's time.

use std::time::{Duration, Instant};

use cullet::{Camera, Culler, Depth, Projection, View, ViewState, Visible};
use cullet_draw::{VerifyOptions, verify};
use cullet_tiles::{CityTiles, Settings, World};

const FRAMES: u32 = 1800;
const FRAME: f64 = 1.0 / 60.0;
const SPEED: f64 = 100.0;
const CHECKED: u32 = 200;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sizes: Vec<f64> = std::env::args().skip(1).filter_map(|a| a.parse().ok()).collect();
    let sizes = if sizes.is_empty() { vec![1e7, 1e8] } else { sizes };
    for size in sizes {
        fly(size as u64)?;
    }
    Ok(())
}

fn fly(size: u64) -> Result<(), Box<dyn std::error::Error>> {
    let pixels = std::env::var("PIXELS").ok().and_then(|p| p.parse().ok());
    let settings = Settings::default();
    let settings = pixels.map_or(settings, |pixels| settings.with_pixels(pixels));
    let mut world = World::new(CityTiles::new(size, 1), &settings)?;
    let city = CityTiles::new(size, 1);
    let mut culls = [Vec::new(), Vec::new()];
    let mut looks = Vec::new();
    let (mut state, mut visible) = (ViewState::default(), Visible::default());
    let culler = Culler::balanced();
    let projection = Projection::Perspective {
        fov_y_radians: 60_f64.to_radians(),
        aspect: 1.78,
        near: 0.3,
        far: f64::INFINITY,
    };
    let (mut bytes, mut resident, mut wrong, mut checked, mut build) = (0, 0, 0, 0, 0.0_f64);
    let mut shown = [0, 0];
    for frame in 0..FRAMES {
        let begin = Instant::now();
        let seconds = f64::from(frame) * FRAME;
        // Half of the way along a street, half above the roofs.
        let high = frame >= FRAMES / 2;
        let eye = [seconds * SPEED - 1500.0, if high { 80.0 } else { 1.7 }, 0.0];
        let looked = Instant::now();
        world.look(eye, [SPEED, 0.0, 0.0]);
        looks.push(looked.elapsed());
        let turn = (seconds * 0.3).sin() * 0.8;
        let target = [eye[0] + turn.cos(), eye[1] - if high { 0.2 } else { 0.0 }, turn.sin()];
        let view =
            View::new(&Camera::look_at(eye, target, projection), Depth::Reversed, [1920, 1080])?;
        let start = Instant::now();
        culler.cull_one(world.scene(), &view, &mut state, &mut visible);
        culls[usize::from(high)].push(start.elapsed());
        shown[usize::from(high)] += visible.slots().count() * 2 / FRAMES as usize;
        let status = world.status();
        bytes = bytes.max(status.bytes);
        build = build.max(status.build_seconds);
        resident = resident.max(world.scene().instance_count());
        assert!(status.failed.is_empty() && status.bytes <= settings.budget);
        if frame % CHECKED == 0 {
            let small =
                View::new(&Camera::look_at(eye, target, projection), Depth::Reversed, [320, 180])?;
            let options = VerifyOptions::default();
            let proof = verify(world.scene(), &small, &culler, &mut ViewState::default(), &options);
            wrong += proof.false_culls.len();
            checked += 1;
        }
        let left = Duration::from_secs_f64(FRAME).saturating_sub(begin.elapsed());
        std::thread::sleep(left);
    }
    let status = world.status().clone();
    let ms = |times: &mut Vec<Duration>, share: f64| {
        times.sort_unstable();
        let at = ((times.len() - 1) as f64 * share) as usize;
        times[at].as_secs_f64() * 1e3
    };
    let [street, roofs] = culls.each_mut().map(|culls| [0.5, 0.99, 1.0].map(|s| ms(culls, s)));
    println!(
        "{:>10} instances: {} tiles and {resident} instances at the most in the scene, {} MiB of {} MiB, {} MiB of memory",
        u64::from(city.city().side()).pow(2) * 11,
        world.tiles().len(),
        bytes >> 20,
        settings.budget >> 20,
        peak_mebibytes(),
    );
    println!(
        "  {} tiles were loaded, {} scenes built, in {build:.2} s at the most; look took {:.3} ms at the most",
        status.loaded,
        status.built,
        ms(&mut looks, 1.0)
    );
    for (name, [median, p99, most], shown) in
        [("street", street, shown[0]), ("roofs", roofs, shown[1])]
    {
        println!(
            "  {name:<7} cull {median:.2} ms median, {p99:.2} p99, {most:.2} most; {shown} visible in the mean"
        );
    }
    println!("  {wrong} wrong in {checked} pictures");
    Ok(())
}

/// The most memory that the process has had, where the system tells.
fn peak_mebibytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let number = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
    number.unwrap_or(0) / 1024
}
