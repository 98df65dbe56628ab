//! Which of the machine's vector instructions the kernels use.

use std::sync::LazyLock;

use fearless_simd::Level;

/// The best for lanes of eight, found out once.
///
/// AVX-512 saves a tenth by its many registers on Intel's processors. On AMD's (measured on an EPYC of Zen 4 or later) the same lanes took
/// a quarter longer with it than with AVX2.
pub(super) fn best() -> Level {
    static BEST: LazyLock<Level> = LazyLock::new(find);
    *BEST
}

#[cfg(target_arch = "x86_64")]
fn find() -> Level {
    let best = Level::new();
    match best.as_avx2() {
        Some(avx2) if is_amd() => Level::Avx2(avx2),
        _ => best,
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn find() -> Level {
    Level::new()
}

/// Vendor `AuthenticAMD`, by CPUID leaf 0 (AMD64 Architecture Programmer's Manual, volume 3, appendix E.3.1).
#[cfg(target_arch = "x86_64")]
fn is_amd() -> bool {
    let vendor = core::arch::x86_64::__cpuid(0);
    [vendor.ebx, vendor.edx, vendor.ecx].map(u32::to_le_bytes).as_flattened() == b"AuthenticAMD"
}
