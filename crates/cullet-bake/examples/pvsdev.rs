use cullet_bake::pvs::*;
fn cpu() -> f64 { std::fs::read_to_string("/proc/thread-self/schedstat").unwrap().split(' ').next().unwrap().parse::<f64>().unwrap() * 1e-9 }
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let mut settings = PvsSettings::default();
    let mut names = vec![];
    let mut threads = 1;
    for a in &args[1..] {
        match a.split_once('=') {
            Some(("local", v)) => settings.local_lines = v.parse().unwrap(),
            Some(("aimed", v)) => settings.aimed_lines = v.parse().unwrap(),
            Some(("tries", v)) => settings.chain_lines = v.parse().unwrap(),
            Some(("splits", v)) => settings.splits = v.parse().unwrap(),
            Some(("threads", v)) => threads = v.parse().unwrap(),
            Some(("tol", v)) => settings.tolerance = v.parse().unwrap(),
            _ => names.push(a.clone()),
        }
    }
    let dir = "/work/shared/data/portals";
    if names.is_empty() {
        names = "gen_small lq_e0m9 lqdm12 lqdm11 lq_e0m4 lq_e0m1 lq_e0m1_nd lq_e0m3 lq_e0m3_nd lq_e1m5 lq_e0m2 lq_e0m2_nd lqdm13".split(' ').map(String::from).collect();
    }
    let mut gw = 0.0;
    let (mut gr, mut gp, mut n, mut m) = (0.0, 0.0, 0.0, 0.0);
    for name in names {
        let prt = cullet_io::load_prt(format!("{dir}/{name}.prt").as_ref()).unwrap();
        let stats = std::fs::read_to_string(format!("{dir}/{name}.vis.txt")).unwrap();
        let line = stats.lines().rfind(|l| l.contains(" full t1 wall")).or(stats.lines().rfind(|l| l.contains(" full t2 wall"))).unwrap();
        let viscpu: f64 = line.split("user_cpu_s=").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        let begin = cpu();
        let mut b = Bake::new(&prt.graph, &settings, threads);
        let mut laps = String::new();
        let mut t = cpu();
        laps += &format!("new {:.3} ", t - begin);
        while b.round() < b.rounds() {
            let r: Vec<_> = (0..b.units()).map(|u| b.run_unit(u, threads, &|| true).unwrap()).collect();
            b.merge(&r);
            laps += &format!("{:.3} ", cpu() - t);
            t = cpu();
        }
        let mem = b.bytes();
        let pvs = b.finish();
        let time = cpu() - begin;
        assert_eq!(&pvs.prove_again(&prt.graph).unwrap(), pvs.proven());
        let bytes = std::fs::read(format!("{dir}/{name}.pvs")).unwrap();
        let cells = prt.graph.cell_count();
        let r = (cells as usize).div_ceil(8);
        let bit = |a: u32, b: u32| bytes[16 + a as usize * r + b as usize / 8] >> (b % 8) & 1 != 0;
        let (mut sym, mut lost, mut raw) = (0, 0, 0);
        for a in 0..cells { for b in 0..cells { raw += u32::from(bit(a, b)); if bit(a, b) && bit(b, a) { sym += 1; }
            if pvs.proven().has(a, b) && !(bit(a, b) && bit(b, a)) { lost += 1; } } }
        let pairs = pvs.visible().count();
        let und = pvs.undecided();
        let ratio = pairs as f64 / sym as f64;
        println!("{name} turned {} time {time:.3} vis {viscpu} x{:.2} pairs {pairs} vis {sym} ratio {ratio:.4} undecided {:.2}% proven-not-in-vis {lost} mem {mem} lines {} hash {:x}\n    {laps}", prt.turned, viscpu / time, und as f64 / pairs as f64 * 100.0, pvs.witnesses().len(), pvs.rows_hash());
        if viscpu > 0.05 { gr += (viscpu / time).ln(); m += 1.0; }
        gp += ratio.ln(); gw += (pairs as f64 / raw as f64).ln(); n += 1.0;
    }
    println!("geomean speed {:.3} pairs {:.5} raw {:.5}", (gr / m as f64).exp(), (gp / n as f64).exp(), (gw / n as f64).exp());
}
