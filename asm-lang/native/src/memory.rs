//! The memory that native code lies in.

#![allow(unsafe_code, reason = "code is made a function, and freed")]

use crate::frame::NativeEntry;
use cranelift_jit::JITModule;
use cranelift_module::FuncId;

/// Owns the code of one module.
pub(crate) struct CodeMemory(Option<JITModule>);

// SAFETY: after `entry` nothing reads or writes the module but `drop`, which has it alone; the code
// itself is only read, and executed.
unsafe impl Sync for CodeMemory {}

impl CodeMemory {
    pub fn new(module: JITModule) -> Self {
        Self(Some(module))
    }

    /// A finished function of the module. It may be called as long as this lives.
    pub fn entry(&self, function: FuncId) -> Option<NativeEntry> {
        let code = self.0.as_ref()?.get_finalized_function(function);
        // SAFETY: the function was defined with the signature of `NativeEntry`: see `emit::entry_signature`.
        Some(unsafe { std::mem::transmute::<*const u8, NativeEntry>(code) })
    }
}

impl Drop for CodeMemory {
    fn drop(&mut self) {
        if let Some(module) = self.0.take() {
            // SAFETY: whoever holds an entry holds this as well, so no code of it runs any more.
            unsafe { module.free_memory() };
        }
    }
}
