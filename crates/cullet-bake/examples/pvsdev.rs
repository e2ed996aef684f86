use cullet_bake::pvs::*;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let mut settings = Settings::default();
    let mut names = vec![];
    for a in &args[1..] {
        match a.split_once('=') {
            Some(("stages", v)) => settings.stages = v.parse().unwrap(),
            Some(("local", v)) => settings.local = v.parse().unwrap(),
            Some(("aimed", v)) => settings.aimed = v.parse().unwrap(),
            Some(("tries", v)) => settings.tries = v.parse().unwrap(),
            Some(("threads", v)) => settings.threads = v.parse().unwrap(),
            Some(("tol", v)) => settings.tolerance = v.parse().unwrap(),
            _ => names.push(a.clone()),
        }
    }
    let dir = "/work/shared/data/portals";
    if names.is_empty() {
        names = "gen_small lq_e0m9 lqdm12 lqdm11 lq_e0m4 lq_e0m1 lq_e0m1_nd lq_e0m3 lq_e0m3_nd lq_e1m5 lq_e0m2 lq_e0m2_nd lqdm13".split(' ').map(String::from).collect();
    }
    let (mut gr, mut gp, mut n, mut m) = (0.0, 0.0, 0.0, 0.0);
    for name in names {
        let prt = cullet_io::load_prt(format!("{dir}/{name}.prt").as_ref()).unwrap();
        let stats = std::fs::read_to_string(format!("{dir}/{name}.vis.txt")).unwrap();
        let line = stats.lines().rfind(|l| l.contains(" full t1 wall")).or(stats.lines().rfind(|l| l.contains(" full t2 wall"))).unwrap();
        let cpu: f64 = line.split("user_cpu_s=").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        let begin = std::time::Instant::now();
        let pvs = bake(&prt.graph, &settings);
        let time = begin.elapsed().as_secs_f64();
        let bytes = std::fs::read(format!("{dir}/{name}.pvs")).unwrap();
        let cells = prt.graph.cell_count();
        let r = (cells as usize).div_ceil(8);
        let bit = |a: u32, b: u32| bytes[16 + a as usize * r + b as usize / 8] >> (b % 8) & 1 != 0;
        let (mut sym, mut lost) = (0, 0);
        for a in 0..cells { for b in 0..cells { if bit(a, b) && bit(b, a) { sym += 1; }
            if pvs.proven.has(a, b) && !(bit(a, b) && bit(b, a)) { lost += 1; } } }
        let pairs = pvs.rows.count();
        let und = pairs - pvs.proven.count();
        let ratio = pairs as f64 / sym as f64;
        println!("{name} turned {} time {time:.3} vis {cpu} x{:.2} pairs {pairs} vis {sym} ratio {ratio:.4} undecided {:.2}% proven-not-in-vis {lost}\n    {}", prt.turned, cpu / time, und as f64 / pairs as f64 * 100.0, pvs.work);
        if cpu > 0.05 { gr += (cpu / time).ln(); m += 1.0; }
        gp += ratio.ln(); n += 1.0;
    }
    println!("geomean speed {:.3} pairs {:.5}", (gr / m as f64).exp(), (gp / n as f64).exp());
}
