//! Caches of the first CPU as reported by Linux, for processors that do not describe their own. On
//! other systems the list is empty.

use std::fs;
use std::path::Path;

/// A cache of the first CPU.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CpuCache {
    /// Distance from the core, from 1.
    pub level: u8,
    /// Contents: `data`, `instruction` or `unified`.
    pub kind: String,
    /// Size in bytes.
    pub bytes: u64,
    /// CPUs that share it.
    pub shared_by: u32,
}

/// The caches reported by the system, by level and kind.
pub fn cpu_caches() -> Vec<CpuCache> {
    let folder = Path::new("/sys/devices/system/cpu/cpu0/cache");
    let caches = (0..16).map_while(|k| read_cache(&folder.join(format!("index{k}"))));
    let mut caches: Vec<CpuCache> = caches.collect();
    caches.sort_by(|a, b| (a.level, &a.kind).cmp(&(b.level, &b.kind)));
    caches
}

/// Size in bytes of the data cache nearest to the first CPU. x86-64 processors report it
/// themselves.
#[cfg(any(test, not(target_arch = "x86_64")))]
pub(crate) fn nearest_data_cache() -> Option<usize> {
    let mut caches = cpu_caches().into_iter();
    let nearest = caches.find(|cache| cache.kind != "instruction")?;
    usize::try_from(nearest.bytes).ok()
}

fn read_cache(folder: &Path) -> Option<CpuCache> {
    let text = |name: &str| {
        let text = fs::read_to_string(folder.join(name)).ok()?;
        Some(text.trim().to_owned())
    };
    Some(CpuCache {
        level: text("level")?.parse().ok()?,
        kind: text("type")?.to_ascii_lowercase(),
        bytes: parse_size(&text("size")?)?,
        shared_by: text("shared_cpu_list").map_or(1, |list| count_cpus(&list)),
    })
}

/// A number of bytes, in the system's units of 1024 bytes, or of 1024 times as many.
fn parse_size(text: &str) -> Option<u64> {
    let digits = text.trim_end_matches(['K', 'M', 'G']);
    let shift = match &text[digits.len()..] {
        "" => 0,
        "K" => 10,
        "M" => 20,
        "G" => 30,
        _ => return None,
    };
    digits.parse::<u64>().ok()?.checked_shl(shift)
}

/// Number of CPUs in a list of numbers and ranges, such as `0-3,8`; at least 1.
fn count_cpus(list: &str) -> u32 {
    let count = |part: &str| {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        let [first, last] = [first, last].map(|number| number.trim().parse::<u32>().ok());
        last?.checked_sub(first?)?.checked_add(1)
    };
    let counts = list.split(',').filter_map(count);
    counts.fold(0, u32::saturating_add).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_lists_are_read() {
        assert_eq!(parse_size("48K"), Some(48 << 10));
        assert_eq!(parse_size("2M"), Some(2 << 20));
        assert_eq!(parse_size("512"), Some(512));
        for wrong in ["", "K", "48KK", "48k", "-1K"] {
            assert_eq!(parse_size(wrong), None, "{wrong}");
        }
        let lists = ["0", "0-1", "0-3,8", "0,32", "", "3-1", "x"].map(count_cpus);
        assert_eq!(lists, [1, 2, 5, 2, 1, 1, 1]);
    }

    #[test]
    fn this_machine_has_sensible_caches_or_none() {
        let caches = cpu_caches();
        for cache in &caches {
            assert!((1..=4).contains(&cache.level), "{cache:?}");
            assert!(cache.bytes > 0 && cache.shared_by > 0, "{cache:?}");
        }
        let data = caches.iter().find(|cache| cache.kind != "instruction");
        assert_eq!(
            nearest_data_cache().map(|bytes| bytes as u64),
            data.map(|cache| cache.bytes)
        );
    }
}
