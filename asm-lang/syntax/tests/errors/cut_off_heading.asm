asm //~ L020
