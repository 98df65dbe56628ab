//! The table.

use bevy::diagnostic::{DiagnosticPath, DiagnosticsStore};

use super::{
    counts::Counts,
    flags::Way,
    meter::{CPU, FRAME, PARTS, median},
};

/// What was measured of one crowd.
pub(crate) struct Row {
    pub(crate) way: Way,
    pub(crate) count: usize,
    /// Milliseconds of every measured frame.
    pub(crate) frames: Vec<f64>,
    /// Milliseconds of a frame: the median.
    pub(crate) frame: f64,
    /// The processor's time for it, all threads together.
    pub(crate) cpu: f64,
    /// Milliseconds of its parts.
    pub(crate) parts: [f64; PARTS.len()],
    /// Milliseconds on the GPU by render pass, as the engine's diagnostics have them.
    passes: Vec<(String, f64)>,
    counts: Counts,
    /// Triangles of all characters in view.
    triangles: usize,
    /// Pipelines, bind groups and buffers that were made while measuring.
    remade: [Option<u32>; 3],
}

impl Row {
    pub(crate) fn new(
        way: Way,
        count: usize,
        triangles: usize,
        store: &DiagnosticsStore,
        (before, counts): (&Counts, Counts),
    ) -> Self {
        let of = |path: &DiagnosticPath| median(store, path).unwrap_or(f64::NAN);
        let gpu = |path: &str| Some(path.strip_prefix("render/")?.strip_suffix("/elapsed_gpu")?.to_owned());
        let mut passes: Vec<(String, f64)> = store
            .iter()
            .filter_map(|diagnostic| Some((gpu(diagnostic.path().as_str())?, of(diagnostic.path()))))
            .collect();
        passes.sort_by(|a, b| b.1.total_cmp(&a.1));
        let since = |after: Option<u32>, before: Option<u32>| Some(after? - before?);
        Self {
            way,
            count,
            frames: store.get(&FRAME).map(|frame| frame.values().copied().collect()).unwrap_or_default(),
            frame: of(&FRAME),
            cpu: of(&CPU),
            parts: PARTS.map(|(path, _)| of(&DiagnosticPath::const_new(path))),
            passes,
            remade: [
                u32::try_from(counts.pipelines - before.pipelines).ok(),
                since(counts.bind_groups, before.bind_groups),
                since(counts.buffers, before.buffers),
            ],
            counts,
            triangles,
        }
    }
}

/// The last word of a diagnostic's path.
pub(crate) fn part_name(index: usize) -> &'static str {
    PARTS[index].0.rsplit('/').next().unwrap_or_default()
}

/// Names of the columns.
pub(crate) fn head() {
    let parts: String = (0..PARTS.len()).map(|part| format!("{:>9}", part_name(part))).collect();
    println!("milliseconds, medians:");
    println!(
        "{:>6} {:>9} {:>9} {:>9} |{parts} | {:>5} {:>8} {:>9} {:>9} | remade: pipelines, bind groups, buffers",
        "N", "way", "frame", "cpu", "draws", "shadows", "triangles", "bytes"
    );
}

/// One crowd.
pub(crate) fn line(row: &Row) {
    let parts: String = row.parts.iter().map(|part| format!("{part:>9.2}")).collect();
    let shadows: Vec<_> = row.counts.shadow_draws.iter().map(ToString::to_string).collect();
    let remade = row.remade.map(|count| count.map_or_else(|| "-".to_owned(), |count| count.to_string())).join(", ");
    println!(
        "{:>6} {:>9} {:>9.2} {:>9.2} |{parts} | {:>5} {:>8} {:>9} {:>9} | {remade}",
        row.count,
        row.way.name(),
        row.frame,
        row.cpu,
        row.counts.draws,
        shadows.join("+"),
        row.triangles,
        row.counts.bytes,
    );
}

/// What the columns mean, GPU time by pass, and frames beside the engine's.
pub(crate) fn tail(rows: &[Row]) {
    println!();
    for (index, (_, meaning)) in PARTS.iter().enumerate() {
        println!("{:>9}: {meaning}", part_name(index));
    }
    println!("\nGPU time by pass, ms:");
    for row in rows {
        let passes: Vec<_> = row.passes.iter().take(6).map(|(name, time)| format!("{name} {time:.2}")).collect();
        println!("{:>6} {:>9}  {}", row.count, row.way.name(), passes.join(", "));
    }
    println!("\nframe time and the processor's time over the engine's:");
    for row in rows.iter().filter(|row| row.way != Way::BuiltIn) {
        let engine = rows.iter().find(|other| other.way == Way::BuiltIn && other.count == row.count);
        if let Some(engine) = engine {
            let (frame, cpu) = (row.frame / engine.frame, row.cpu / engine.cpu);
            println!("{:>6} {:>9}  {frame:.2} {cpu:.2}", row.count, row.way.name());
        }
    }
}
