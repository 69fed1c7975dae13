//! Environment variables that choose among the installed drivers, for the case that no driver is found.
//!
//! Comes in: the environment. Goes out: a sentence on each variable that is set, with its value and what is wrong with
//! it.

use std::ffi::{OsStr, OsString};
use std::path::Path;

/// Variables of the Vulkan loader that list driver manifests (or folders of them), in place of the installed ones.
const LISTS: [&str; 2] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];
/// Variables of the Vulkan loader that pick some of the installed drivers by the names of their manifests.
const FILTERS: [&str; 2] = ["VK_LOADER_DRIVERS_SELECT", "VK_LOADER_DRIVERS_DISABLE"];

/// The sentences for the environment that `variable` reads; none where no such variable is set.
pub(super) fn set(variable: impl Fn(&str) -> Option<OsString>) -> Vec<String> {
    let of = |names: &[&'static str]| -> Vec<(&'static str, OsString)> {
        let set = names.iter().filter_map(|&name| Some((name, variable(name)?)));
        set.filter(|(_, value)| !value.is_empty()).collect()
    };
    let lists = of(&LISTS);
    // The first is newer and the loader ignores the other beside it.
    let listed = lists.first().map(|(name, value)| list(name, value));
    let filtered = of(&FILTERS).into_iter().map(|(name, value)| {
        format!("{name}={} leaves no driver that finds a device; unset it to use those installed", value.display())
    });
    listed.into_iter().chain(filtered).collect()
}

/// What a list of files names.
fn list(name: &str, value: &OsStr) -> String {
    let missing: Vec<String> = std::env::split_paths(value)
        .filter(|path| !path.as_os_str().is_empty() && !Path::exists(path))
        .map(|path| path.display().to_string())
        .collect();
    let shown = format!("{name}={}", value.display());
    if missing.is_empty() {
        return format!("{shown} names no driver that finds a device; unset it to use those installed");
    }
    format!("{shown} is set, and there is no file {}; unset it to use the drivers installed", missing.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_variable_and_its_value_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let there = folder.path().join("icd.json");
        std::fs::write(&there, "{}").unwrap();
        let there = there.display().to_string();
        let said = |variables: &[(&str, &str)]| {
            set(|name| variables.iter().find(|(known, _)| *known == name).map(|(_, value)| value.into()))
        };
        assert!(said(&[]).is_empty() && said(&[("VK_DRIVER_FILES", "")]).is_empty());
        for name in LISTS {
            let text = said(&[(name, "/nonexistent.json")]).concat();
            assert!(text.contains(&format!("{name}=/nonexistent.json is set, and there is no file /none")), "{text}");
            let text = said(&[(name, &there)]).concat();
            assert!(text.contains(&format!("{name}={there} names no driver")), "{text}");
        }
        let both = std::env::join_paths([there.as_str(), "/gone.json"]).unwrap();
        let text = said(&[("VK_DRIVER_FILES", both.to_str().unwrap()), ("VK_ICD_FILENAMES", "/older.json")]).concat();
        assert!(text.contains("there is no file /gone.json;") && !text.contains("older"), "{text}");
        for name in FILTERS {
            assert!(said(&[(name, "*nvidia*")]).concat().contains(&format!("{name}=*nvidia* leaves no driver")));
        }
    }
}
