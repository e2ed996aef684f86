//! Real maps: what loads, and what their trees and stored rows say.

use std::collections::BTreeSet;
use std::path::PathBuf;

use cullet_io::bsp::{Bsp, ClusterRows, Version, clusters_of_leafs, with_visibility};
use cullet_io::{LoadOptions, load};
use cullet_testkit::data;

#[test]
fn probe() {
    let Some(libre) = data("quake-libre") else { return };
    let mut files: Vec<PathBuf> = Vec::new();
    for f in [libre, data("quake3-openarena").unwrap(), data("quake-testmaps").unwrap()] {
        files.extend(std::fs::read_dir(f).unwrap().map(|e| e.unwrap().path()).filter(|p| p.extension().is_some_and(|e| e == "bsp")));
    }
    files.sort();
    for f in files {
        let t = std::time::Instant::now();
        let model = load(&f, &LoadOptions::default()).unwrap();
        let ms = t.elapsed().as_secs_f64() * 1e3;
        let map = Bsp::open(&f).unwrap();
        let t = std::time::Instant::now();
        let g = map.cells();
        let cms = t.elapsed().as_secs_f64() * 1e3;
        let own: BTreeSet<[u32; 2]> = g.as_ref().map(|g| g.portals().iter().map(|p| { let [a, b] = p.cells; [a.min(b), a.max(b)] }).collect()).unwrap_or_default();
        println!("{} {} leafs {} cells {} tris {} inst {} meshes {} load {ms:.1} portals {:?} pairs {} cells ms {cms:.1} cams {} {:?}", f.file_name().unwrap().display(), map.version().name(), map.leafs().len(), map.cell_count(), model.scene.triangle_count(), model.scene.slots().count(), model.scene.meshes().len(), g.as_ref().map(|g| g.portals().len()).map_err(|e| e.to_string()), own.len(), model.cameras.len(), model.warnings);
        let prt = f.with_extension("prt");
        if let Ok(text) = std::fs::read_to_string(prt) {
            let mut w = text.split_whitespace();
            assert_eq!(w.next(), Some("PRT2"));
            let n: Vec<usize> = (0..3).map(|_| w.next().unwrap().parse().unwrap()).collect();
            let mut theirs = BTreeSet::new();
            let mut areas = vec![];
            for _ in 0..n[2] {
                let k: usize = w.next().unwrap().parse().unwrap();
                let a: u32 = w.next().unwrap().parse().unwrap();
                let b: u32 = w.next().unwrap().parse().unwrap();
                let mut pts = vec![];
                while pts.len() < 3 * k {
                    let t = w.next().unwrap().trim_matches(|c| c == '(' || c == ')');
                    if !t.is_empty() { pts.push(t.parse::<f64>().unwrap()); }
                }
                theirs.insert([a.min(b), a.max(b)]);
                areas.push(([a.min(b), a.max(b)], pts));
            }
            let rest: Vec<i64> = w.map(|t| t.trim_matches(|c| c == '(' || c == ')')).filter(|t| !t.is_empty()).map(|t| t.parse().unwrap()).collect();
            // their cluster of leaf
            let mut of = vec![u32::MAX; n[0]];
            let mut c = 0;
            for v in rest { if v < 0 { c += 1 } else { of[v as usize] = c; } }
            let mine = clusters_of_leafs(&map);
            let diff = of.iter().zip(&mine).filter(|(a, b)| a != b).count();
            // map theirs->mine
            let mut m = vec![u32::MAX; n[1]];
            for (a, b) in of.iter().zip(&mine) { m[*a as usize] = *b; }
            let theirs: BTreeSet<[u32; 2]> = theirs.iter().map(|[a, b]| { let [a, b] = [m[*a as usize], m[*b as usize]]; [a.min(b), a.max(b)] }).collect();
            println!("   prt {n:?} pairs {} differing numbers {diff}; only theirs {} only mine {}", theirs.len(), theirs.difference(&own).count(), own.difference(&theirs).count());
            if let Ok(g) = &g {
            for d in own.difference(&theirs).take(4) { 
                let p = g.portals().iter().find(|p| [p.cells[0].min(p.cells[1]), p.cells[0].max(p.cells[1])] == *d).unwrap();
                println!("     mine {d:?} {:?}", p.polygon); }
            }
            for d in theirs.difference(&own).take(4) {
                for (c, pts) in &areas { let [a,b] = c.map(|c| m[c as usize]); if [a.min(b), a.max(b)] == *d { println!("     theirs {d:?} {pts:?}"); } }
            }
        }
    }
}
