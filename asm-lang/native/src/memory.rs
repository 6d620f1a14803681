//! Ownership of the executable memory.

#![expect(unsafe_code, reason = "code memory is called as a function, and freed")]

use crate::direct_frame::DirectEntry;
use crate::frame::NativeEntry;
use cranelift_jit::JITModule;
use cranelift_module::FuncId;

/// Owns the code of one module, and frees it when dropped.
pub(crate) struct CodeMemory(Option<JITModule>);

// SAFETY: after `entry`, the module is accessed only by `drop`, which has exclusive access. The
// code itself is read-only and may be executed by several threads.
unsafe impl Sync for CodeMemory {}

impl CodeMemory {
    pub fn new(module: JITModule) -> Self {
        Self(Some(module))
    }

    /// Returns a finished function of the module. It may only be called while this value lives.
    pub fn entry(&self, function: FuncId) -> Option<NativeEntry> {
        let code = self.0.as_ref()?.get_finalized_function(function);
        // SAFETY: the function was defined with the signature of `NativeEntry`, by
        // `emit::entry_signature`.
        Some(unsafe { std::mem::transmute::<*const u8, NativeEntry>(code) })
    }

    /// Returns a finished direct rule of the module. It may only be called while this value lives.
    pub fn direct_entry(&self, function: FuncId) -> Option<DirectEntry> {
        let code = self.0.as_ref()?.get_finalized_function(function);
        // SAFETY: the signature of `DirectEntry` differs from that of `NativeEntry` only in the type that the pointer
        // points to, and the function was compiled for a `DirectFrame`.
        Some(unsafe { std::mem::transmute::<*const u8, DirectEntry>(code) })
    }
}

impl Drop for CodeMemory {
    fn drop(&mut self) {
        if let Some(module) = self.0.take() {
            // SAFETY: an entry is always stored together with its `CodeMemory`, so no code of the
            // module is running.
            unsafe { module.free_memory() };
        }
    }
}
