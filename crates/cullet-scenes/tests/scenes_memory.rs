//! The memory that a forest takes; a process of its own, since the peak is the process's.

/// The most resident memory that this process ever had, in bytes; Linux alone tells.
fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? * 1024)
}

#[test]
fn ten_million_plants_would_fit_three_gibibytes() {
    let Some(before) = peak() else {
        cullet_testkit::skip(
            "a process's peak memory, which this system does not tell",
            "use Linux",
        );
        return;
    };
    let model = cullet_scenes::build("forest").unwrap();
    assert_eq!(model.scene.instance_count(), 1_000_001);
    let taken = peak().unwrap() - before;
    // A tenth of the plants must do with a tenth of the memory; growing vectors may leave up to half of
    // theirs unused, but not touched.
    println!("{} MiB for a million", taken >> 20);
    assert!(taken < (3 << 30) / 10, "{taken} bytes");
}
