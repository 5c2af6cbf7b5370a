//! The machine that the program runs on.

use phalanx_report::{Cache, Machine};
use std::fs;
use std::thread::available_parallelism;
use sysinfo::{MemoryRefreshKind, System};

/// The machine that runs this program, as far as it can be determined. Takes a few milliseconds.
pub fn this_machine() -> Machine {
    let threads = available_parallelism().map_or(1, |count| count.get() as u32);
    let mut system = System::new();
    system.refresh_memory_specifics(MemoryRefreshKind::nothing().with_ram());
    Machine {
        cpu: cpu::model().unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
        cores: System::physical_core_count().map(|count| count as u32),
        threads,
        smt: cpu::smt(),
        caches: cpu::caches(threads),
        governor: governor(),
        hypervisor: cpu::hypervisor(),
        memory_bytes: Some(system.total_memory()).filter(|&bytes| bytes > 0),
        kernel: kernel(),
    }
}

/// Frequency governor, as reported by Linux; most virtual machines have none.
fn governor() -> Option<String> {
    let text = fs::read_to_string("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor").ok()?;
    Some(text.trim().to_owned()).filter(|name| !name.is_empty())
}

fn kernel() -> Option<String> {
    let version = System::kernel_version()?;
    let system = System::long_os_version();
    let system = system.map_or(String::new(), |name| format!("{name}, "));
    Some(format!("{system}{} {version}", std::env::consts::OS))
}

#[cfg(target_arch = "x86_64")]
mod cpu {
    use super::Cache;
    use phalanx_trace::isa;
    use raw_cpuid::{CacheType, CpuId, Hypervisor, TopologyType};

    pub fn model() -> Option<String> {
        let brand = CpuId::new().get_processor_brand_string()?;
        // Vendors pad the name with spaces, not only at its ends.
        let words: Vec<&str> = brand.as_str().split_whitespace().collect();
        Some(words.join(" ")).filter(|name| !name.is_empty())
    }

    /// Tests if a core has several threads. The first level of the topology is that of a core's
    /// threads.
    pub fn smt() -> Option<bool> {
        let first = CpuId::new().get_extended_topology_info()?.next()?;
        let threads = first.processors();
        (threads > 0 && first.level_type() == TopologyType::SMT).then_some(threads > 1)
    }

    /// Caches of the first core. Hypervisors report the sharing of the physical machine, so the
    /// sharing is limited to the number of threads that exist.
    pub fn caches(threads: u32) -> Vec<Cache> {
        let cpu = CpuId::new();
        let caches = cpu.get_cache_parameters().into_iter().flatten();
        let mut caches: Vec<Cache> = caches
            .filter_map(|c| {
                let kind = match c.cache_type() {
                    CacheType::Data => "data",
                    CacheType::Instruction => "instruction",
                    CacheType::Unified => "unified",
                    CacheType::Null | CacheType::Reserved => return None,
                };
                Some(Cache {
                    level: c.level(),
                    kind: kind.to_owned(),
                    bytes: isa::cache_bytes(&c) as u64,
                    shared_by: (c.max_cores_for_cache() as u32).min(threads),
                })
            })
            .collect();
        caches.sort_by(|a, b| (a.level, &a.kind).cmp(&(b.level, &b.kind)));
        caches
    }

    pub fn hypervisor() -> Option<String> {
        let cpu = CpuId::new();
        if !cpu.get_feature_info()?.has_hypervisor() {
            return Some(String::new());
        }
        let name = match cpu.get_hypervisor_info().map(|info| info.identify()) {
            Some(Hypervisor::Unknown(b, c, d)) => signature([b, c, d]),
            Some(known) => format!("{known:?}"),
            None => String::new(),
        };
        // A hypervisor exists, even if its name is empty.
        let name = if name.is_empty() { "unnamed".to_owned() } else { name };
        Some(name)
    }

    /// The letters of a hypervisor's twelve bytes.
    fn signature(words: [u32; 3]) -> String {
        let bytes = words.into_iter().flat_map(u32::to_le_bytes);
        bytes.filter(u8::is_ascii_graphic).map(char::from).collect()
    }
}

/// For processors that do not describe themselves to programs: asks the system.
#[cfg(not(target_arch = "x86_64"))]
mod cpu {
    use super::Cache;
    use phalanx_trace::cpu_caches::cpu_caches;
    use std::fs::read_to_string;
    use sysinfo::{CpuRefreshKind, System};

    pub fn model() -> Option<String> {
        let mut system = System::new();
        system.refresh_cpu_list(CpuRefreshKind::nothing());
        let brand = system.cpus().first()?.brand().trim().to_owned();
        Some(brand).filter(|name| !name.is_empty())
    }

    pub fn smt() -> Option<bool> {
        let active = read_to_string("/sys/devices/system/cpu/smt/active").ok()?;
        Some(active.trim() == "1")
    }

    pub fn caches(threads: u32) -> Vec<Cache> {
        let caches = cpu_caches().into_iter();
        caches
            .map(|cache| Cache {
                level: cache.level,
                kind: cache.kind,
                bytes: cache.bytes,
                shared_by: cache.shared_by.min(threads),
            })
            .collect()
    }

    /// The hypervisor, if it identifies itself; others remain unknown.
    pub fn hypervisor() -> Option<String> {
        let files = [
            "/sys/hypervisor/type",
            "/proc/device-tree/hypervisor/compatible",
        ];
        let mut named = files.iter().filter_map(|file| read_to_string(file).ok());
        let name = named.next()?;
        Some(name.trim_matches(['\0', '\n']).to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_machine_is_known() {
        let machine = this_machine();
        println!("{machine:#?}");
        assert!(machine.threads >= 1 && !machine.cpu.is_empty());
        assert_eq!(machine, this_machine());
        for cache in &machine.caches {
            assert!((1..=4).contains(&cache.level), "{cache:?}");
            assert!(
                cache.bytes.is_multiple_of(1024) && cache.shared_by >= 1,
                "{cache:?}"
            );
        }
        if cfg!(all(target_arch = "x86_64", target_os = "linux")) {
            assert!(machine.memory_bytes.is_some() && machine.kernel.is_some());
            assert!(machine.hypervisor.is_some());
        }
    }
}
