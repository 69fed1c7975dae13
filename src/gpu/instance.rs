//! The Vulkan instance: loader, layers, extensions, debug messenger.
//!
//! Comes in: whether to validate. Goes out: an [`Instance`] of Vulkan 1.1, or an error that names the package to
//! install. The loader is opened at run time, so the program starts, and explains itself, where there is none.

use std::ffi::{CStr, c_char};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ash::{Entry, ext, khr, vk};

use super::address_space;
use super::driver_variables;
use super::failure::failed;
use super::messages::{MessageLog, messenger_info};
use crate::{Error, Result};

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Held while an instance or device is made or destroyed: loader, layers and drivers keep process-wide tables of both,
/// and tests make contexts on several threads.
static LIFECYCLE: Mutex<()> = Mutex::new(());

/// Enters the section in which instances and devices are made and destroyed.
pub(super) fn lifecycle() -> MutexGuard<'static, ()> {
    LIFECYCLE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// An instance, its messenger, and the loader it came from.
pub(super) struct Instance {
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    raw: ash::Instance,
    /// Whether `VK_EXT_debug_utils` is on, so that objects can be named.
    pub(super) names_objects: bool,
    /// Where messages go; alive as long as the instance, which holds a plain pointer to it.
    pub(super) log: Arc<MessageLog>,
    /// The loaded library: unloaded last.
    _entry: Entry,
}

impl Instance {
    /// Loads the loader and makes an instance, under the validation layers if `validation`.
    pub(super) fn new(validation: bool) -> Result<Arc<Instance>> {
        address_space::check_loader()?;
        // SAFETY: loading runs the library's initialisers; the loader is the system's own and keeps to Vulkan's rules.
        let entry = unsafe { Entry::load() }.map_err(|error| {
            Error::NoDevice(format!(
                "the Vulkan loader cannot be opened; install it (`libvulkan1` on Debian and Ubuntu, `vulkan-loader` on \
                 Fedora, `vulkan-icd-loader` on Arch): {error}"
            ))
        })?;
        // SAFETY: a global command, valid before there is an instance.
        let loader_version = unsafe { entry.try_enumerate_instance_version() }.map_err(no_driver)?;
        // A loader without this command is a 1.0 loader, whose vkCreateInstance refuses to be asked for more.
        let loader_version = loader_version.unwrap_or(vk::API_VERSION_1_0);
        if loader_version < vk::API_VERSION_1_1 {
            return Err(Error::NoDevice("Vulkan 1.1 is needed, the loader has 1.0".to_string()));
        }

        // SAFETY: global commands, valid before there is an instance.
        let mut offered = unsafe { entry.enumerate_instance_extension_properties(None) }.map_err(no_driver)?;
        let mut layers: Vec<*const c_char> = Vec::new();
        if validation {
            // SAFETY: as above.
            let installed = unsafe { entry.enumerate_instance_layer_properties() }.map_err(no_driver)?;
            if !installed.iter().any(|layer| layer.layer_name_as_c_str() == Ok(VALIDATION_LAYER)) {
                return Err(Error::NoDevice(
                    "validation was asked for and the layer VK_LAYER_KHRONOS_validation is not installed (package \
                     `vulkan-validationlayers` on Debian and Ubuntu, `vulkan-validation-layers` on Fedora and Arch)"
                        .to_string(),
                ));
            }
            layers.push(VALIDATION_LAYER.as_ptr());
            // SAFETY: as above; the layer's name is a NUL-terminated constant.
            offered.extend(
                unsafe { entry.enumerate_instance_extension_properties(Some(VALIDATION_LAYER)) }.map_err(no_driver)?,
            );
        }
        let is_offered = |name: &CStr| offered.iter().any(|found| found.extension_name_as_c_str() == Ok(name));

        let mut extensions: Vec<*const c_char> = Vec::new();
        let mut flags = vk::InstanceCreateFlags::empty();
        // Without this extension and flag a loader hides drivers that do not implement all of Vulkan (MoltenVK).
        if is_offered(khr::portability_enumeration::NAME) {
            extensions.push(khr::portability_enumeration::NAME.as_ptr());
            flags |= vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR;
        }
        // Names for objects, in validation messages and in capture tools; and the messenger.
        let names_objects = is_offered(ext::debug_utils::NAME);
        if names_objects {
            extensions.push(ext::debug_utils::NAME.as_ptr());
        }
        if validation {
            for needed in [ext::debug_utils::NAME, ext::validation_features::NAME] {
                if !is_offered(needed) {
                    let name = needed.to_string_lossy();
                    return Err(Error::NoDevice(format!("validation needs {name}, which is not offered")));
                }
            }
            extensions.push(ext::validation_features::NAME.as_ptr());
        }

        let log = Arc::new(MessageLog::default());
        let application = vk::ApplicationInfo::default()
            .application_name(c"texray")
            .engine_name(c"texray")
            // All that is used is core in 1.1 or an extension asked for by name, also where the device has more.
            .api_version(vk::API_VERSION_1_1);
        // Synchronisation validation is off by default. It finds missing barriers inside a command buffer.
        let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
        let mut messenger = messenger_info(&log);
        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&application)
            .enabled_layer_names(&layers)
            .enabled_extension_names(&extensions)
            .flags(flags);
        if validation {
            info = info.push_next(&mut features).push_next(&mut messenger);
        }
        let created = {
            let _lifecycle = lifecycle();
            // SAFETY: the arrays that `info` points to live until the call returns; layers and extensions were found
            // above; the messenger's log lives in the `Instance` below, and for a failed call until this function ends.
            unsafe { entry.create_instance(&info, None) }
        };
        let raw = created.map_err(no_driver)?;
        // From here on the instance is owned: an error below destroys it.
        let mut instance = Instance { messenger: None, raw, names_objects, log, _entry: entry };
        if validation {
            let debug_utils = ext::debug_utils::Instance::new(&instance._entry, &instance.raw);
            // SAFETY: VK_EXT_debug_utils is on; the log outlives the messenger, which `Drop` destroys.
            let handle = unsafe { debug_utils.create_debug_utils_messenger(&messenger_info(&instance.log), None) }
                .map_err(failed("vkCreateDebugUtilsMessengerEXT"))?;
            instance.messenger = Some((debug_utils, handle));
        }
        Ok(Arc::new(instance))
    }

    /// The instance's functions.
    pub(super) fn raw(&self) -> &ash::Instance {
        &self.raw
    }

    /// Whether the validation layers are on.
    pub(super) fn validates(&self) -> bool {
        self.messenger.is_some()
    }

    /// Every physical device, in the loader's order. There may be none.
    pub(super) fn physical_devices(&self) -> Result<Vec<vk::PhysicalDevice>> {
        // SAFETY: the instance is alive. No lock is needed: the call changes no state.
        unsafe { self.raw.enumerate_physical_devices() }.map_err(no_driver)
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        let _lifecycle = lifecycle();
        // SAFETY: every device holds an `Arc` of its instance, so none is left; `&mut self` makes this the only use.
        // The messenger goes first, as a child of the instance. The log (a field) outlives both calls.
        unsafe {
            if let Some((debug_utils, messenger)) = self.messenger.take() {
                debug_utils.destroy_debug_utils_messenger(messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

/// A failure of a global command: a missing driver is told apart from the rest.
fn no_driver(code: vk::Result) -> Error {
    match code {
        vk::Result::ERROR_INCOMPATIBLE_DRIVER => Error::NoDevice(no_driver_message()),
        code => failed("making a Vulkan instance")(code),
    }
}

/// What to do where there is a loader and no driver that finds a device: a variable that hides the installed ones is
/// named.
pub(super) fn no_driver_message() -> String {
    const INSTALL: &str = "install one, for example `mesa-vulkan-drivers` (Debian, Ubuntu, Fedora) or `vulkan-swrast` \
                           (Arch), which includes lavapipe for CPUs";
    match driver_variables::set(|name| std::env::var_os(name)).join("; ") {
        set if set.is_empty() => format!("no Vulkan driver is installed or none found a device; {INSTALL}"),
        set => format!("{set}; if none is installed, {INSTALL}"),
    }
}
