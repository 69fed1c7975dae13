//! Which device to use.
//!
//! Comes in: the devices there are, and what was asked for. Goes out: one usable device, or an error that lists what
//! there is. Nothing here talks to Vulkan.

use super::device_info::DeviceInfo;
use super::instance::no_driver_message;
use crate::{Error, Result};

/// What was asked for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum DeviceChoice {
    /// The first usable device in the order discrete, integrated, virtual, CPU.
    #[default]
    Auto,
    /// The device of this index, as `texray devices` lists them.
    Index(usize),
    /// The one device whose name contains this text, whatever its case.
    Name(String),
}

impl DeviceChoice {
    /// Picks among `devices`.
    pub(super) fn pick<'a>(&self, devices: &'a [DeviceInfo]) -> Result<&'a DeviceInfo> {
        if devices.is_empty() {
            return Err(Error::NoDevice(no_driver_message()));
        }
        let picked = match self {
            DeviceChoice::Auto => {
                let usable = devices.iter().filter(|device| device.lacks.is_none());
                // `min_by_key` keeps the first of several of one kind, so the loader's order decides among them.
                return usable.min_by_key(|device| device.kind).ok_or_else(|| {
                    let reasons = devices.iter().map(|device| {
                        format!("\n  {}: {}", device.summary(), device.lacks.as_deref().unwrap_or_default())
                    });
                    Error::NoDevice(format!("none of the devices can be used:{}", reasons.collect::<String>()))
                });
            }
            DeviceChoice::Index(index) => devices.get(*index).ok_or_else(|| {
                Error::Usage(format!("there is no device {index}; the devices are:{}", list(devices.iter())))
            })?,
            DeviceChoice::Name(name) => {
                let wanted = name.to_lowercase();
                let matches: Vec<_> =
                    devices.iter().filter(|device| device.name.to_lowercase().contains(&wanted)).collect();
                match matches[..] {
                    [device] => device,
                    [] => {
                        let all = list(devices.iter());
                        return Err(Error::Usage(format!("no device is named `{name}`; the devices are:{all}")));
                    }
                    _ => {
                        let matches = list(matches.into_iter());
                        return Err(Error::Usage(format!(
                            "more than one device is named `{name}`; give more of the name, or the index:{matches}"
                        )));
                    }
                }
            }
        };
        match &picked.lacks {
            None => Ok(picked),
            Some(lacks) => Err(Error::NoDevice(format!("{}: {lacks}", picked.summary()))),
        }
    }
}

fn list<'a>(devices: impl Iterator<Item = &'a DeviceInfo>) -> String {
    devices.map(|device| format!("\n  {}", device.summary())).collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::device_info::{DeviceKind, HeapInfo};
    use super::*;

    /// A device with the least limits that Vulkan allows.
    pub fn device(index: usize, name: &str, kind: DeviceKind) -> DeviceInfo {
        DeviceInfo {
            index,
            name: name.to_string(),
            driver: "driver 1".to_string(),
            api_version: "1.1.0".to_string(),
            kind,
            lacks: None,
            queue_family: 0,
            max_texel_buffer_elements: 65_536,
            max_storage_buffer_range: 1 << 27,
            max_memory_allocation_size: 1 << 30,
            max_compute_work_group_count: [65_535; 3],
            max_compute_work_group_invocations: 128,
            max_compute_work_group_size: [128, 128, 64],
            max_push_constants_bytes: 128,
            max_per_stage_storage_buffers: 4,
            max_per_stage_sampled_images: 16,
            max_per_stage_resources: 128,
            min_storage_buffer_offset_alignment: 256,
            timestamp_period_ns: 1.0,
            timestamp_valid_bits: 64,
            subgroup_size: 8,
            subgroup_vote: true,
            subgroup_ballot: true,
            heaps: vec![HeapInfo { bytes: 1 << 31, device_local: true }],
            shader_float64: false,
            robust_buffer_access: true,
            robust_buffer_access2: false,
            shader_signed_zero_inf_nan_preserve_float32: false,
        }
    }

    fn three() -> Vec<DeviceInfo> {
        vec![
            device(0, "llvmpipe (LLVM 15)", DeviceKind::Cpu),
            device(1, "Card 3000", DeviceKind::Discrete),
            device(2, "Card 3000 Small", DeviceKind::Discrete),
        ]
    }

    #[test]
    fn auto_prefers_the_first_discrete_device_that_is_usable() {
        let mut devices = three();
        assert_eq!(DeviceChoice::Auto.pick(&devices).unwrap().index, 1);
        devices[1].lacks = Some("Vulkan 1.1 needed, 1.0 offered".to_string());
        assert_eq!(DeviceChoice::Auto.pick(&devices).unwrap().index, 2);
        devices[2].lacks = devices[1].lacks.clone();
        assert_eq!(DeviceChoice::Auto.pick(&devices).unwrap().index, 0);
        devices[0].lacks = devices[1].lacks.clone();
        let error = DeviceChoice::Auto.pick(&devices).unwrap_err();
        assert!(matches!(&error, Error::NoDevice(text) if text.contains("1.0 offered")), "{error}");
    }

    #[test]
    fn names_match_in_part_and_must_be_unambiguous() {
        let devices = three();
        let pick = |name: &str| DeviceChoice::Name(name.to_string()).pick(&devices);
        assert_eq!(pick("LLVMPIPE").unwrap().index, 0);
        assert_eq!(pick("small").unwrap().index, 2);
        let error = pick("card").unwrap_err();
        assert!(matches!(&error, Error::Usage(text) if text.contains("1: Card 3000") && text.contains("2: Card")));
        assert!(matches!(pick("other").unwrap_err(), Error::Usage(_)));
    }

    #[test]
    fn an_index_must_exist_and_its_device_be_usable() {
        let mut devices = three();
        assert_eq!(DeviceChoice::Index(2).pick(&devices).unwrap().index, 2);
        assert!(matches!(DeviceChoice::Index(3).pick(&devices).unwrap_err(), Error::Usage(_)));
        devices[2].lacks = Some("a queue with compute needed, none offered".to_string());
        assert!(matches!(DeviceChoice::Index(2).pick(&devices).unwrap_err(), Error::NoDevice(_)));
        assert!(matches!(DeviceChoice::Index(0).pick(&[]).unwrap_err(), Error::NoDevice(_)));
    }
}
