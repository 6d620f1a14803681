//! An ASM machine as a component: bindings, event frames, faults
