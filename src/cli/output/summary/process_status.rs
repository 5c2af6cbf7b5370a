//! This process's status, as reported by Linux.

/// The value of a field in `/proc/self/status`; `None` if there is no such file or line.
pub fn process_status(name: &str) -> Option<String> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let mut lines = status.lines().filter_map(|line| line.split_once(':'));
    let (_, value) = lines.find(|(field, _)| *field == name)?;
    Some(value.trim().to_owned())
}
