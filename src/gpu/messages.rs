//! What the validation layers say: counted by severity, the first texts kept.
//!
//! Comes in: calls of the debug messenger, on any thread, from instance creation to instance destruction, and what
//! `Drop` of the device finds leaked. Goes out: [`ValidationReport`]. Performance advice and the loader's own notes on
//! drivers it tried are not counted: a machine with drivers for absent hardware gets such notes and is in order.

use std::ffi::{CStr, c_char, c_void};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ash::vk;

/// Texts kept; later ones are only counted.
const TEXTS_KEPT: usize = 32;

/// Validation messages so far.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ValidationReport {
    /// Messages of severity error, and leaks found at the end.
    pub errors: u64,
    /// Messages of severity warning.
    pub warnings: u64,
    /// The first texts, each beginning with severity and message id.
    pub messages: Vec<String>,
}

impl ValidationReport {
    /// Whether nothing was reported.
    pub fn is_clean(&self) -> bool {
        self.errors == 0 && self.warnings == 0
    }
}

/// A view of a context's messages that outlives the context, so that what its destruction reports can be read too.
#[derive(Clone)]
pub struct ValidationWatch(pub(super) Arc<MessageLog>);

impl ValidationWatch {
    /// The messages so far.
    pub fn report(&self) -> ValidationReport {
        self.0.report()
    }
}

/// Where the messenger and `Drop` leave their messages.
#[derive(Default)]
pub(super) struct MessageLog(Mutex<ValidationReport>);

impl MessageLog {
    pub(super) fn report(&self) -> ValidationReport {
        self.locked().clone()
    }

    /// Counts a text as an error.
    pub(super) fn error(&self, text: &str) {
        self.add(true, text);
    }

    fn add(&self, is_error: bool, text: &str) {
        let mut report = self.locked();
        match is_error {
            true => report.errors += 1,
            false => report.warnings += 1,
        }
        if report.messages.len() < TEXTS_KEPT {
            let severity = if is_error { "error" } else { "warning" };
            report.messages.push(format!("{severity}: {text}"));
        }
    }

    fn locked(&self) -> MutexGuard<'_, ValidationReport> {
        // A panic cannot leave the counters half changed, so a poisoned lock is as good as any.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Create info of the messenger that reports to `log`. It is given twice: to `vkCreateInstance` through `pNext`, for
/// messages about the instance's own creation and destruction, and to the messenger for all between.
///
/// The result holds a plain pointer to `log`: whoever uses it keeps `log` alive until the instance is destroyed.
pub(super) fn messenger_info(log: &Arc<MessageLog>) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        // Info and verbose would report each loaded library.
        .message_severity(vk::DebugUtilsMessageSeverityFlagsEXT::ERROR | vk::DebugUtilsMessageSeverityFlagsEXT::WARNING)
        // Not PERFORMANCE: it is advice for real-time graphics and would hide errors among opinions.
        .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION | vk::DebugUtilsMessageTypeFlagsEXT::GENERAL)
        .pfn_user_callback(Some(receive))
        .user_data(Arc::as_ptr(log).cast_mut().cast())
}

/// The messenger's callback. Returns `FALSE`: the call that caused the message goes on, as it would without layers.
///
/// # Safety
///
/// For Vulkan to call: `data` is valid during the call, and `user_data` that of [`messenger_info`], whose log is alive.
unsafe extern "system" fn receive(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user_data: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: Vulkan passes data that is valid during the call, and the `user_data` of `messenger_info`: a log that
    // its `Instance` keeps alive until after vkDestroyInstance. The log is shared, never borrowed mutably.
    let (log, id, text) = unsafe {
        let log = user_data.cast::<MessageLog>().as_ref();
        let data = data.as_ref();
        (log, data.map(|data| text_at(data.p_message_id_name)), data.map(|data| text_at(data.p_message)))
    };
    let (Some(log), Some(id), Some(text)) = (log, id, text) else { return vk::FALSE };
    if id != "Loader Message" {
        let is_error = severity.contains(vk::DebugUtilsMessageSeverityFlagsEXT::ERROR);
        log.add(is_error, &format!("{id}: {text}"));
    }
    vk::FALSE
}

/// The text at `pointer`; empty for null.
///
/// # Safety
/// `pointer` is null or points to a NUL-terminated string that lives during the call.
unsafe fn text_at(pointer: *const c_char) -> String {
    match pointer.is_null() {
        true => String::new(),
        // SAFETY: not null, so the caller promises a NUL-terminated string.
        false => unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned(),
    }
}
