//! What measurements depend on besides the program: processor, compiler, memory.

use std::fs;

/// The processor's name for itself, where the system tells.
pub fn processor() -> String {
    let information = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    information
        .lines()
        .find_map(|line| line.strip_prefix("model name")?.split_once(':'))
        .map_or_else(
            || "not told by the system".to_owned(),
            |(_, model)| model.trim().to_owned(),
        )
}

/// Operating system and architecture.
pub fn target() -> String {
    format!("{} {}", std::env::consts::OS, std::env::consts::ARCH)
}

/// The instruction sets that the program was compiled for, of those that make a difference.
pub fn target_features() -> String {
    let features: Vec<&str> = [
        ("sse2", cfg!(target_feature = "sse2")),
        ("sse4.2", cfg!(target_feature = "sse4.2")),
        ("avx", cfg!(target_feature = "avx")),
        ("avx2", cfg!(target_feature = "avx2")),
        ("fma", cfg!(target_feature = "fma")),
        ("avx512bw", cfg!(target_feature = "avx512bw")),
        ("neon", cfg!(target_feature = "neon")),
        ("sve", cfg!(target_feature = "sve")),
    ]
    .into_iter()
    .filter_map(|(name, present)| present.then_some(name))
    .collect();
    features.join(", ")
}

/// Memory that work takes at most beyond what there is when it begins, where the system tells (Linux).
#[derive(Debug)]
pub struct PeakMemory {
    before: Option<u64>,
}

impl PeakMemory {
    /// Begins to watch.
    pub fn watch() -> Self {
        // Sets the highest resident size back to the present one; proc(5).
        let reset = fs::write("/proc/self/clear_refs", "5").is_ok();
        Self {
            before: reset.then(|| resident("VmRSS:")).flatten(),
        }
    }

    /// The most that was added since, in bytes.
    pub fn added(&self) -> Option<u64> {
        Some(resident("VmHWM:")?.saturating_sub(self.before?))
    }
}

/// The size called `name` in the process's status, in bytes.
fn resident(name: &str) -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_that_is_touched_is_seen_where_the_system_tells() {
        let watch = PeakMemory::watch();
        let touched = vec![1_u8; 64 << 20];
        assert!(std::hint::black_box(&touched).iter().all(|&byte| byte == 1));
        if let Some(added) = watch.added() {
            assert!(added > 32 << 20, "{added}");
        }
    }
}
